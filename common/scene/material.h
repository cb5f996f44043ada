// SPDX-License-Identifier: GPL-3.0-or-later
// How a surface reflects: diffuse and mirror reflectance together, or clear glass. Both sides alike.
#pragma once

#include <optional>
#include <string>

#include "common/core/vector.h"

namespace pim {

struct Material {
    std::string name;
    Rgb diffuse{0.5f};                    // reflectance per channel; times the texture where there is one
    Rgb specular{0};                      // mirror reflectance; diffuse + specular <= 1, channel by channel
    std::optional<int> texture;           // index into Scene::textures
    bool texture_tints_specular = false;  // the texture multiplies specular as well
    bool glass = false;                   // then diffuse and specular do not count
    float ior = 1.5f;                     // index of refraction of the solid behind the surface, > 1

    bool receives() const {
        return !glass && (is_black(specular) || !is_black(diffuse));
    }  // holds irradiance
};

}  // namespace pim
