// SPDX-License-Identifier: GPL-3.0-or-later
// Which cells hold surface that light can reach, and how much. A stage of its own before tracing.
//
// Fragments that light does not reach (see reach.h) are left out, together with the photons that land on
// them, and so are whole patches that no photon finds.
#pragma once

#include "bake/fragment_index.h"
#include "bake/look_up_means.h"
#include "bake/patch_split.h"
#include "bake/reach.h"
#include "common/map/illumination_map.h"

namespace pim {

struct Cells {
    CellGrid grid;
    std::vector<Patch> patches;  // sorted by patch_before
    PatchIndex index;
    std::vector<PatchSplit> split;  // per patch, the same for the one in front and the one behind
    PatchSight sight;               // everything without facings
    LookUpMeans means;              // empty for spheres, which reach into other cells
    FragmentIndex left_out;         // in order
    double surface_area = 0;        // m², both sides of all surface in the grid
    double counted_area = 0;        // m², what the patches hold
    double moved_area = 0;          // m², whose verdict the last doubling of photons changed
    uint64_t deciding_photons = 0;

    // Patch of a facing for a place given from the cell's centre, among the cell's patches; -1 if there is
    // none.
    int patch_at(const std::array<int32_t, kSlotCount>& patches, int facing, const Vec3& from_centre) const;
};

// A map of these cells that no lamp lights yet, enough for look_up.
IlluminationMap map_without_lights(const Cells& cells);

Cells find_cells(const Scene& scene, const RayCaster& caster, const PositionFilter& allowed);

}  // namespace pim
