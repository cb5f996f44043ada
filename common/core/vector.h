// SPDX-License-Identifier: GPL-3.0-or-later
// Vectors, colours and boxes: Imath's types under the names of this project.
#pragma once

#include <ImathBox.h>
#include <ImathVec.h>

#include <algorithm>

namespace pim {

using Vec3 = Imath::V3f;  // position, m, or direction
using Vec3d = Imath::V3d;
using Vec2 = Imath::V2f;
using Index3 = Imath::V3i;
using Rgb = Imath::V3f;  // linear, Rec. 709 primaries
using Box3 = Imath::Box3f;
using Box3d = Imath::Box3d;

inline constexpr float kPi = 3.14159265358979323846f;

inline float max_channel(const Rgb& c) { return std::max({c.x, c.y, c.z}); }
inline float mean_channel(const Rgb& c) { return (c.x + c.y + c.z) / 3.0f; }
inline float luminance(const Rgb& c) { return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z; }
inline bool is_black(const Rgb& c) { return c.x == 0 && c.y == 0 && c.z == 0; }

}  // namespace pim
