// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/render/frame.h"

#include <cmath>
#include <optional>

#include "common/core/low_discrepancy.h"
#include "common/core/parallel.h"
#include "common/core/progress.h"

namespace pim {
namespace {

constexpr uint64_t kScramble = ~uint64_t{0};  // of a pixel's samples, in place of one's number

// Columns of a grid of that many strata, all of the same size and none left over: a part of a row would shift
// the picture.
int strata_across(int samples) {
    int across = int(std::sqrt(float(samples)));
    while (samples % across != 0) --across;
    return across;
}

}  // namespace

Image render_frame(const Camera& camera, const FrameOptions& options, const PixelFunction& radiance) {
    constexpr int kTile = 16;
    const CameraRays rays(camera, options.size);
    Image image(options.size.x, options.size.y);
    const int columns = (image.width + kTile - 1) / kTile, rows = (image.height + kTile - 1) / kTile;
    const int across = strata_across(options.samples), down = options.samples / across;
    std::optional<Progress> progress;
    if (options.progress) progress.emplace(options.progress, uint64_t(columns) * rows);
    const auto pixel = [&](int x, int y) {
        Rgb sum(0);
        const auto number = uint32_t(y * image.width + x) & 0x3ffffff;
        const auto scramble = RandomStream(options.seed, options.purpose, number, kScramble).next_block();
        for (int i = 0; i < options.samples; ++i) {
            RandomStream random(options.seed, options.purpose, number, uint64_t(i));
            const bool jitter = options.samples > 1;
            const float u = jitter ? random.next() : 0.5f, v = jitter ? random.next() : 0.5f;
            const float dx = (float(i % across) + u) / float(across),
                        dy = (float(i / across) + v) / float(down);
            random.begin_with(scrambled_sobol_point(uint32_t(i), scramble));
            sum += radiance(rays.through(float(x) + dx, float(y) + (jitter ? dy : 0.5f)), random);
        }
        return sum / float(options.samples);
    };
    parallel_for(std::size_t(columns) * rows, [&](std::size_t tile) {
        const int x0 = int(tile) % columns * kTile, y0 = int(tile) / columns * kTile;
        for (int y = y0; y < std::min(y0 + kTile, image.height); ++y)
            for (int x = x0; x < std::min(x0 + kTile, image.width); ++x) image.at(x, y) = pixel(x, y);
        if (progress) progress->advance();
    });
    return image;
}

}  // namespace pim
