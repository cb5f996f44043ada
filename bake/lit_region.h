// SPDX-License-Identifier: GPL-3.0-or-later
// The part of a scene that lamps light, where it is much smaller than the geometry (a room on a wide plane).
#pragma once

#include <optional>

#include "bake/reach.h"

namespace pim {

// Bounds that hold all surface with at least kDimmest of the irradiance that a landed photon meets on
// average; local, m. None where leaving out the rest would save little.
inline constexpr double kDimmest = 0.01;
std::optional<Box3> lit_region(const Scene& scene, const RayCaster& caster, const PositionFilter& allowed);

}  // namespace pim
