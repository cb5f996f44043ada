// SPDX-License-Identifier: GPL-3.0-or-later
// Insides of solids and backs of walls, found from few photons: on them no photon lands at all, and not in
// one cell only.
#pragma once

#include "bake/fragments.h"

namespace pim {

// The facing that a fragment has most of.
int main_facing(const Fragment& fragment);

// Regions are cubes of 1, 2, 4, ... cells along each axis, the largest holds the whole grid. In each, the
// fragments of an object's side that face one way stand or fall together: where none of them has been hit,
// but at kUnlitShare of the irradiance of what is lit, in the region as in the scene, some would have been
// with error probability kDoubt, all are unlit.
class UnlitRegions {
  public:
    UnlitRegions(const Scene& scene, const CellGrid& grid, const std::vector<Fragment>& fragments);
    // Per fragment. `hits`: photons that landed, likewise.
    std::vector<uint8_t> judge(const std::vector<uint32_t>& hits);

  private:
    struct Group {  // what stands or falls together
        Index3 region;
        uint64_t kind;  // object, side and facing
        double area = 0, hits = 0;
        bool unlit = false;
        uint32_t parent = 0;  // of the next level
    };
    using Level = std::vector<Group>;  // sorted by region, then kind

    static Level coarser(Level& fine);
    static void judge_level(Level& level, double scene_irradiance);  // photons per m²

    std::vector<Level> levels_;
    std::vector<uint32_t> group_of_;  // per fragment, of the finest level
};

}  // namespace pim
