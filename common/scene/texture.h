// SPDX-License-Identifier: GPL-3.0-or-later
// Reflectance that varies over a surface.
#pragma once

#include "common/core/image.h"

namespace pim {

// Bilinear, repeated in both directions; uv (0,0) is the lower left corner of the picture. Linear RGB.
Rgb sample_texture(const Image& texture, const Vec2& uv);

}  // namespace pim
