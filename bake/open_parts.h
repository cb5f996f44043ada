// SPDX-License-Identifier: GPL-3.0-or-later
// How much of a fragment lies open. Where a box stands on a floor, its foot parts fragments of the floor: one
// part is lit, the other lies under the box, and both would count as surface.
#pragma once

#include "bake/reach.h"

namespace pim {

// A place of a fragment is open if it sees a place where a photon landed, on the same triangle's side in the
// same cell, closely above the surface, or sees a place that does; glass does not hide. Area and centre
// become those of the open part; what has none is dark. Returns open places of each fragment that is not
// wholly open.
std::vector<std::vector<Vec3>> keep_open_parts(const Scene& scene, const RayCaster& caster,
                                               const CellGrid& grid, std::vector<Fragment>& fragments,
                                               Reach& reach);

}  // namespace pim
