// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/cells.h"

namespace pim {
namespace {

constexpr double kLeastArea = 1e-6;         // of a cell's face: smaller patches would hold nothing but noise

struct PatchSum {
    double area = 0;
    Vec3d moment{0};   // area × centroid
};

// Patches of each cell from its fragments, those left out excepted.
template <class Keep>
std::vector<Patch> patches_of(const CellGrid& grid, const std::vector<Fragment>& fragments, Keep keep) {
    std::vector<Patch> patches;
    for (std::size_t begin = 0; begin < fragments.size();) {
        std::size_t end = begin;
        std::array<PatchSum, kFacingCount> sums{};
        for (; end < fragments.size() && fragments[end].key.cell == fragments[begin].key.cell; ++end)
            for (int f = 0; keep(end) && f < kFacingCount; ++f) {
                sums[f].area += fragments[end].facing_area[f];
                sums[f].moment += Vec3d(fragments[end].centre) * double(fragments[end].facing_area[f]);
            }
        const Index3 cell = cell_of(grid, fragments[begin].key);
        for (int f = 0; f < kFacingCount; ++f)
            if (sums[f].area > kLeastArea * grid.cell_size * grid.cell_size)
                patches.push_back({cell, f, float(sums[f].area), Vec3(sums[f].moment / sums[f].area - grid.centre(cell))});
        begin = end;
    }
    return patches;
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
        cells.patches = patches_of(cells.grid, fragments, keep);
        for (std::size_t i = 0; i < fragments.size(); ++i)
            if (!keep(i)) cells.left_out.push_back(fragments[i].key);
        cells.moved_area = reach.moved_area;
        cells.deciding_photons = reach.photons;
    } else {
        cells.patches = patches_of(cells.grid, fragments, [](std::size_t) { return true; });
    }
    for (const Patch& p : cells.patches) cells.counted_area += p.area;
    cells.index = PatchIndex(cells.grid, cells.patches);
    return cells;
}

}  // namespace pim
