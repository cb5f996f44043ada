// SPDX-License-Identifier: GPL-3.0-or-later
// The first half of a bake that chooses for itself: bounds, cells, and photons per lamp position.
#pragma once

#include "bake/goal.h"
#include "bake/grid_search.h"
#include "common/scene/scene_file.h"

namespace pim {

struct CellChoice {
    std::vector<Setting> settings;
    GridFigures grid;
    std::optional<Cells> cells;  // as found, if they were searched for
};

// Settings that are given stay as they are. `photon_seconds`: what a photon costs; looked at with a time
// budget only.
CellChoice choose_cells(const Scene& scene, const Goal& goal, const RayCaster& caster,
                        const PositionFilter& allowed, HeldOut& held_out, double photon_seconds);

}  // namespace pim
