// SPDX-License-Identifier: GPL-3.0-or-later
// Which patches see each other: segments between places of both, three tenths of a cell above the surfaces,
// so that smooth convex bodies do not part into facets.
#pragma once

#include "bake/cells.h"

namespace pim {

// `fragments`: those that count. A part of a patch sees another if at least half of the segments between them
// are free. Same answer at any thread count.
PatchSight find_sight(const Scene& scene, const RayCaster& caster, const Cells& cells,
                      const std::vector<Fragment>& fragments);

}  // namespace pim
