// SPDX-License-Identifier: GPL-3.0-or-later
// Surfaces that shine. They are no lamps here; what is found are the lamps that come nearest to them.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/core/vector.h"

namespace pim {

// Where a rectangle would shine like a surface that faces one way.
struct EmitterPanel {
    Vec3 normal;           // unit, the mean over the surface
    double width, height;  // m, along the axes that RectangleShape gives to the normal
    Vec3d centre;          // m, a little in front of the whole surface
};

struct Emitter {
    double area = 0;                    // m²
    Vec3d centroid{0};                  // m, of the surface
    std::optional<EmitterPanel> panel;  // absent: it shines in many directions
};

// The parts of a surface (triangles, world space, m) that are connected by shared corners, largest first.
// Triangles without a finite area > 0 do not count.
std::vector<Emitter> find_emitters(const std::vector<std::array<Vec3d, 3>>& triangles);

// Lines of a description: the lamp, rectangle or point, of the power that the surface has at this radiance,
// W/(m² sr).
std::string light_lines(const Emitter& emitter, const Rgb& radiance, const std::string& name);

}  // namespace pim
