// SPDX-License-Identifier: GPL-3.0-or-later
// Pixels in parallel, each with random numbers of its own: the same picture at any thread count.
#pragma once

#include <functional>

#include "common/core/image.h"
#include "common/core/random.h"
#include "common/render/camera_rays.h"

namespace pim {

struct FrameOptions {
    Imath::V2i size{0};
    int samples = 4;  // per pixel, stratified; 1: through its middle
    uint64_t seed = 1;
    RandomPurpose purpose = RandomPurpose::render;
    const char* progress = nullptr;  // what to call it while it takes long
};

using PixelFunction = std::function<Rgb(const Ray&, RandomStream&)>;
Image render_frame(const Camera& camera, const FrameOptions& options, const PixelFunction& radiance);

}  // namespace pim
