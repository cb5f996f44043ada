// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/cells.h"

#include <cmath>

namespace pim {
namespace {

constexpr double kLeastArea = 1e-6;         // of a cell's face: smaller patches would hold nothing but noise
constexpr double kBlackShare = 0.01;        // of the mean irradiance: below, a whole patch counts as unreached

struct PatchSum {
    std::array<double, kFacingCount> area{}, hits{};
};

// Patches of one cell from its fragments, those judged dark left out.
template <class Keep>
void add_patches(const CellGrid& grid, const std::vector<Fragment>& fragments, Keep keep, std::vector<Patch>& patches) {
    for (std::size_t begin = 0; begin < fragments.size();) {
        std::size_t end = begin;
        PatchSum sum;
        for (; end < fragments.size() && fragments[end].key.cell == fragments[begin].key.cell; ++end)
            if (keep(end))
                for (int f = 0; f < kFacingCount; ++f) sum.area[f] += fragments[end].facing_area[f];
        for (int f = 0; f < kFacingCount; ++f)
            if (sum.area[f] > kLeastArea * grid.cell_size * grid.cell_size) patches.push_back({cell_of(grid, fragments[begin].key), f, float(sum.area[f])});
        begin = end;
    }
}

// Drops patches that no photon reached, where many would have at kBlackShare of the mean, unless one of the 26
// cells around holds a lit patch of that facing: its light must not be spread over the dark.
std::vector<Patch> drop_unreached(const CellGrid& grid, const std::vector<Patch>& patches,
                                  const std::vector<double>& hits) {
    const PatchIndex index(grid, patches);
    double all_hits = 0, lit_area = 0;
    for (std::size_t p = 0; p < patches.size(); ++p)
        if (hits[p] > 0) all_hits += hits[p], lit_area += patches[p].area;
    const double enough = lit_area > 0 ? -std::log(kDoubt) / (kBlackShare * all_hits / lit_area) : INFINITY;   // m²
    const auto lit = [&](const Index3& cell, int facing) {
        const int p = index.find(cell, facing);
        return p >= 0 && hits[p] > 0;
    };
    const auto beside_lit = [&](const Patch& patch) {
        for (int x = -1; x <= 1; ++x)
            for (int y = -1; y <= 1; ++y)
                for (int z = -1; z <= 1; ++z)
                    if (lit(patch.cell + Index3(x, y, z), patch.facing)) return true;
        return false;
    };
    std::vector<Patch> kept;
    for (std::size_t p = 0; p < patches.size(); ++p)
        if (hits[p] > 0 || patches[p].area < enough || beside_lit(patches[p])) kept.push_back(patches[p]);
    return kept;
}

std::vector<double> hits_of_patches(const CellGrid& grid, const std::vector<Patch>& patches,
                                    const std::vector<Fragment>& fragments, const Reach& reach) {
    const PatchIndex index(grid, patches);
    std::vector<double> hits(patches.size(), 0);
    for (std::size_t i = 0; i < fragments.size(); ++i) {
        if (reach.dark[i]) continue;
        for (int f = 0; f < kFacingCount; ++f)
            if (const int p = index.find(cell_of(grid, fragments[i].key), f); p >= 0 && fragments[i].facing_area[f] > 0)
                hits[p] += reach.hits[i];
    }
    return hits;
}

}  // namespace

bool Cells::is_left_out(const FragmentKey& key) const { return std::ranges::binary_search(left_out, key); }

Cells find_cells(const Scene& scene, const RayCaster& caster, const PositionFilter& allowed, const CellOptions& options) {
    Cells cells;
    cells.grid = make_grid(scene);
    const SurfaceCells surface(cells.grid, scene.geometry);
    const std::vector<Fragment> fragments = cut_into_fragments(scene, surface);
    for (const Fragment& f : fragments) cells.surface_area += f.area;
    if (scene.grid.reachable_area_only) {
        const Reach reach = find_reach(scene, caster, surface, fragments, allowed, options.most_photons);
        const auto keep = [&](std::size_t i) { return !reach.dark[i]; };
        add_patches(cells.grid, fragments, keep, cells.patches);
        cells.patches = drop_unreached(cells.grid, cells.patches,
                                       hits_of_patches(cells.grid, cells.patches, fragments, reach));
        for (std::size_t i = 0; i < fragments.size(); ++i)
            if (!keep(i)) cells.left_out.push_back(fragments[i].key);
        cells.moved_area = reach.moved_area;
        cells.deciding_photons = reach.photons;
    } else {
        add_patches(cells.grid, fragments, [](std::size_t) { return true; }, cells.patches);
    }
    for (const Patch& p : cells.patches) cells.counted_area += p.area;
    cells.index = PatchIndex(cells.grid, cells.patches);
    return cells;
}

}  // namespace pim
