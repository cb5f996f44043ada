// SPDX-License-Identifier: GPL-3.0-or-later
// A lamp's domain split into overlapping boxes, each with polynomials of its own, blended where they overlap.
#pragma once

#include <array>
#include <vector>

#include "common/core/vector.h"

namespace pim {

struct MapBox {
    Vec3d centre{0}, half{0};  // local, m; half includes the overlap; 0 on an axis without movement
    Vec3d overlap_low{0}, overlap_high{0};  // width shared with the neighbour there; 0 at an outer border

    Vec3d normalised(const Vec3d& light_position) const;  // u in [-1,1]³
    bool contains(const Vec3d& light_position) const;     // up to a rounding of 1e-6 of half
    // Product over the axes of smoothstep ramps (C¹) across the overlaps; 1 inside, 0 outside.
    double weight(const Vec3d& light_position) const;
    std::array<bool, 3> moves() const { return {half.x > 0, half.y > 0, half.z > 0}; }
};

// The regular split of a domain; neighbours share kOverlap of a division's width.
inline constexpr double kOverlap = 0.25;
std::vector<MapBox> split_domain(const Box3& domain, const Index3& divisions);

// Weights of all boxes at a position, adding to 1.
std::vector<double> box_weights(const std::vector<MapBox>& boxes, const Vec3d& light_position);

}  // namespace pim
