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

// What a photon costs: one of a bake, and one by itself.
struct PhotonSeconds {
    double baked = 0, alone = 0;
};

// Settings that are given stay as they are. Times are looked at with a time budget only.
CellChoice choose_cells(const Scene& scene, const Goal& goal, const RayCaster& caster,
                        const PositionFilter& allowed, HeldOut& held_out,
                        const PhotonSeconds& photon_seconds);

}  // namespace pim
