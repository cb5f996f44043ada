// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/render/frame.h"

#include <gtest/gtest.h>

#include <cmath>

namespace pim {
namespace {

// The mean place of the samples inside their pixels, and its standard error.
TEST(Frame, SamplesAreEvenInThePixelAtAnyNumber) {
    const Camera camera{.name = "", .eye = {0, 0, 0}, .target = {0, 0, -1}, .vertical_fov = 90};
    const Imath::V2i size(40, 40);
    for (const int samples : {2, 3, 4, 5, 6, 7, 8, 12, 13, 18, 30, 512}) {
        const auto place = [&](const Ray& ray, RandomStream&) {
            const float x = 20 * (1 - ray.direction.x / ray.direction.z),
                        y = 20 * (1 + ray.direction.y / ray.direction.z);
            return Rgb(x - std::floor(x), y - std::floor(y), 0);
        };
        const Image image = render_frame(camera, {.size = size, .samples = samples}, place);
        double x = 0, y = 0;
        for (const Rgb& pixel : image.pixels) x += pixel.x, y += pixel.y;
        const double count = double(image.pixels.size());
        const double error =
            std::sqrt(1 / 12.0 / (count * samples));  // of independent samples: an upper bound
        EXPECT_NEAR(x / count, 0.5, 4 * error) << samples;
        EXPECT_NEAR(y / count, 0.5, 4 * error) << samples;
    }
}

}  // namespace
}  // namespace pim
