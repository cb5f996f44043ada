// SPDX-License-Identifier: GPL-3.0-or-later
// Which cells hold surface that light can reach, and how much. A stage of its own before tracing.
//
// A fragment of surface is left out, together with the photons that land on it, when its irradiance over all lamp
// positions lies below kDarkShare of that of the rest of its cell and facing, with error probability kDoubt. What
// cannot be decided stays. Whole patches that nothing reaches are left out too, unless a lit one stands beside them.
#pragma once

#include <functional>
#include <set>
#include <unordered_set>

#include "bake/fragments.h"
#include "common/transport/ray_caster.h"

namespace pim {

inline constexpr double kDarkShare = 0.05;
inline constexpr double kDoubt = 1e-4;

struct Cells {
    CellGrid grid;
    std::vector<Patch> patches;             // sorted by patch_before
    PatchIndex index;
    std::vector<FragmentKey> left_out;      // sorted; only of cells that keep other surface
    double surface_area = 0;                // m², both sides of all surface in the grid
    double counted_area = 0;                // m², what the patches hold
    double undecided_area = 0;              // m², kept because the photons were too few to tell
    uint64_t deciding_photons = 0;

    bool is_left_out(const FragmentKey& key) const;
};

// Lamp positions must not lie inside solids: `allowed` says of a position whether it may be used.
using PositionFilter = std::function<bool(const Vec3&)>;

struct CellOptions {
    uint64_t most_photons = uint64_t{1} << 24;
};
Cells find_cells(const Scene& scene, const RayCaster& caster, const PositionFilter& allowed,
                 const CellOptions& options = {});

}  // namespace pim
