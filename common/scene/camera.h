// SPDX-License-Identifier: GPL-3.0-or-later
// A pinhole camera; positions local, m.
#pragma once

#include <string>

#include "common/core/vector.h"

namespace pim {

struct Camera {
    std::string name = "default";
    Vec3 eye{0, 0, 1}, target{0}, up{0, 1, 0};
    float vertical_fov = 40;    // degrees
    Imath::V2i size{640, 480};  // pixels
    bool operator==(const Camera&) const = default;
};

}  // namespace pim
