// SPDX-License-Identifier: GPL-3.0-or-later
// Which fragments of surface light can reach, found by photons from lamps all over their domains.
//
// Regions on which nothing lands are found first (unlit_regions.h). Else a fragment is dark when its
// irradiance lies below kDarkShare of that of the rest of its cell and facing, with error probability kDoubt.
// Small fragments gather few photons, so the test is put to unions first: all of an object's side in the
// cell, a triangle's side, an eighth of the cell, a fine cell, the fragment alone. What no test decides stays
// lit.
#pragma once

#include <functional>

#include "bake/fragments.h"
#include "common/transport/ray_caster.h"

namespace pim {

inline constexpr double kDarkShare = 0.05;
inline constexpr double kDoubt = 1e-4;

// Lamp positions must not lie inside solids: says of a position whether it may be used.
using PositionFilter = std::function<bool(const Vec3&)>;

// Uniform in the lamp's domain.
Vec3 random_lamp_position(const Light& light, const PositionFilter& allowed, RandomStream& random);

inline constexpr uint64_t kNoLanding = ~uint64_t{0};

struct Reach {
    std::vector<bool> dark;                                 // per fragment
    std::vector<uint32_t> hits;                             // per fragment: photons that landed
    std::vector<std::array<uint64_t, kQuarters>> landings;  // ... where one did in each quarter (pack_place)
    uint64_t photons = 0;
    double moved_area = 0;  // m², whose verdict the last doubling of the photons changed
};

// Doubles the photons until that changes the verdict on less than a thousandth of the area and nearly all of
// it has either seen photons or is dark; at most `most_photons`.
Reach find_reach(const Scene& scene, const RayCaster& caster, const SurfaceCells& surface,
                 const std::vector<Fragment>& fragments, const PositionFilter& allowed,
                 uint64_t most_photons);

}  // namespace pim
