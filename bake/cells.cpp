// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/cells.h"

#include <cmath>
#include <limits>

#include "bake/open_parts.h"
#include "bake/sight_lines.h"

namespace pim {
namespace {

constexpr double kLeastArea = 1e-6;  // of a cell's face: smaller patches would hold nothing but noise

constexpr double kLayerGap = 0.1;  // in cells: surfaces parted by more are two layers

struct PatchSum {
    double area = 0;
    Vec3d moment{0};  // area × centroid

    void add(const Fragment& fragment, int facing) {
        area += fragment.facing_area[facing];
        moment += Vec3d(fragment.centre) * double(fragment.facing_area[facing]);
    }
};

// How far a place lies along a facing.
double along(int facing, const Vec3d& place) { return facing % 2 ? -place[facing / 2] : place[facing / 2]; }

class PatchBuilder {
  public:
    PatchBuilder(const CellGrid& grid, const std::vector<Fragment>& fragments, Cells& cells)
        : grid_(grid), fragments_(fragments), cells_(cells) {}

    // Patches of one cell from its kept fragments.
    void add_cell(const Index3& cell, const std::vector<std::size_t>& kept) {
        std::array<double, kFacingCount> split;
        std::array<PatchSum, kSlotCount> sums{};
        const Vec3d centre = grid_.centre(cell);
        for (int f = 0; f < kFacingCount; ++f) {
            split[f] = find_split(kept, f, centre);
            for (const std::size_t i : kept) {
                const bool behind = along(f, Vec3d(fragments_[i].centre) - centre) < split[f];
                sums[f + kFacingCount * behind].add(fragments_[i], f);
            }
        }
        for (int slot = 0; slot < kSlotCount; ++slot) {
            if (!(sums[slot].area > kLeastArea * grid_.cell_size * grid_.cell_size)) continue;
            cells_.patches.push_back(
                {cell, slot, float(sums[slot].area), Vec3(sums[slot].moment / sums[slot].area - centre)});
            cells_.split.push_back(float(split[slot % kFacingCount]));
        }
    }

  private:
    // Middle of the widest gap between surfaces one behind the other; -inf where none is wide enough.
    double find_split(const std::vector<std::size_t>& kept, int facing, const Vec3d& centre) const {
        constexpr double kNone = -std::numeric_limits<double>::infinity();
        std::vector<std::pair<double, double>> extents;  // from, to
        for (const std::size_t i : kept) {
            if (!(fragments_[i].facing_area[facing] > 0.5f * fragments_[i].area)) continue;
            const double a = along(facing, Vec3d(fragments_[i].box.min) - centre),
                         b = along(facing, Vec3d(fragments_[i].box.max) - centre);
            extents.push_back(std::minmax(a, b));
        }
        std::ranges::sort(extents);
        double widest = kLayerGap * grid_.cell_size, split = kNone, reached = kNone;
        for (const auto& [from, to] : extents) {
            if (reached != kNone && from - reached > widest)
                widest = from - reached, split = 0.5 * (from + reached);
            reached = std::max(reached, to);
        }
        return grid_.facings ? split : kNone;
    }

    const CellGrid& grid_;
    const std::vector<Fragment>& fragments_;
    Cells& cells_;
};

template <class Keep>
void build_patches(const std::vector<Fragment>& fragments, Keep keep, Cells& cells) {
    PatchBuilder builder(cells.grid, fragments, cells);
    for (std::size_t begin = 0; begin < fragments.size();) {
        std::size_t end = begin;
        std::vector<std::size_t> kept;
        for (; end < fragments.size() && fragments[end].key.cell == fragments[begin].key.cell; ++end)
            if (keep(end)) kept.push_back(end);
        builder.add_cell(cell_of(cells.grid, fragments[begin].key), kept);
        begin = end;
    }
}

// Photons that landed on each patch.
std::vector<double> hits_of_patches(const std::vector<Fragment>& fragments, const Reach& reach,
                                    const Cells& cells, const PatchIndex& index) {
    std::vector<double> hits(cells.patches.size(), 0);
    for (std::size_t i = 0; i < fragments.size(); ++i) {
        const auto* patches = index.find_cell(cell_of(cells.grid, fragments[i].key));
        for (int slot = 0; patches && slot < kSlotCount; ++slot)
            if ((*patches)[slot] >= 0 && fragments[i].facing_area[slot % kFacingCount] > 0)
                hits[(*patches)[slot]] += reach.hits[i];
    }
    return hits;
}

// The connected unlit patches of one slot around `start`, each marked as seen.
std::vector<uint32_t> dark_region(uint32_t start, const Cells& cells, const PatchIndex& index,
                                  const std::vector<double>& hits, std::vector<bool>& seen) {
    std::vector<uint32_t> region{start};
    seen[start] = true;
    for (std::size_t next = 0; next < region.size(); ++next) {
        const Patch& patch = cells.patches[region[next]];
        for (int n = 0; n < 27; ++n) {
            const int p = index.find(patch.cell + Index3(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1), patch.slot);
            if (p < 0 || seen[p] || hits[p] > 0) continue;
            seen[p] = true;
            region.push_back(uint32_t(p));
        }
    }
    return region;
}

// Drops regions of patches on which no photon landed, from whatever lamp and by whatever way, where more than
// a few would have at kDarkShare of the mean irradiance.
void drop_unreached(const std::vector<Fragment>& fragments, const Reach& reach, Cells& cells) {
    const PatchIndex index(cells.grid, cells.patches);
    const std::vector<double> hits = hits_of_patches(fragments, reach, cells, index);
    double all_hits = 0, lit_area = 0;
    for (std::size_t p = 0; p < hits.size(); ++p)
        if (hits[p] > 0) all_hits += hits[p], lit_area += cells.patches[p].area;
    if (!(all_hits > 0)) return;
    const double enough = -std::log(kDoubt) / (kDarkShare * all_hits / lit_area);  // m²
    std::vector<bool> seen(hits.size(), false), dropped(hits.size(), false);
    for (std::size_t p = 0; p < hits.size(); ++p) {
        if (seen[p] || hits[p] > 0) continue;
        const auto region = dark_region(uint32_t(p), cells, index, hits, seen);
        double area = 0;
        for (const uint32_t member : region) area += cells.patches[member].area;
        for (const uint32_t member : region) dropped[member] = area > enough;
    }
    std::size_t kept = 0;
    for (std::size_t p = 0; p < hits.size(); ++p) {
        if (dropped[p]) continue;
        cells.patches[kept] = cells.patches[p];
        cells.split[kept++] = cells.split[p];
    }
    cells.patches.resize(kept);
    cells.split.resize(kept);
}

// Does other surface make a patch of one of its facings? Else what lands on it goes nowhere anyhow.
bool has_patch(const Fragment& fragment, const Cells& cells) {
    const auto* patches = cells.index.find_cell(cell_of(cells.grid, fragment.key));
    for (int f = 0; patches && f < kFacingCount; ++f)
        if (fragment.facing_area[f] > 0 && ((*patches)[f] >= 0 || (*patches)[f + kFacingCount] >= 0))
            return true;
    return false;
}

std::vector<Fragment> counted_fragments(const Cells& cells, const std::vector<Fragment>& fragments) {
    std::vector<Fragment> counted;
    std::ranges::copy_if(fragments, std::back_inserter(counted),
                         [&](const Fragment& f) { return !cells.is_left_out(f.key); });
    return counted;
}

}  // namespace

bool Cells::is_left_out(const FragmentKey& key) const { return std::ranges::binary_search(left_out, key); }

int Cells::patch_at(const std::array<int32_t, kSlotCount>& own, int facing, const Vec3& from_centre) const {
    const int front = own[facing], behind = own[facing + kFacingCount];
    if (front < 0 || behind < 0) return std::max(front, behind);
    return along(facing, Vec3d(from_centre)) < split[front] ? behind : front;
}

IlluminationMap map_without_lights(const Cells& cells) {
    IlluminationMap map;
    map.grid = cells.grid;
    map.patches = cells.patches;
    map.index = cells.index;
    map.sight = cells.sight;
    return map;
}

Cells find_cells(const Scene& scene, const RayCaster& caster, const PositionFilter& allowed) {
    Cells cells;
    cells.grid = make_grid(scene);
    const SurfaceCells surface(cells.grid, scene.geometry);
    std::vector<Fragment> fragments = cut_into_fragments(scene, surface);
    for (const Fragment& f : fragments) cells.surface_area += f.area;
    if (scene.grid.reachable_area_only) {
        Reach reach = find_reach(scene, caster, surface, fragments, allowed, scene.grid.reach_photons);
        keep_open_parts(scene, caster, cells.grid, fragments, reach);
        const auto keep = [&](std::size_t i) { return !reach.dark[i]; };
        build_patches(fragments, keep, cells);
        drop_unreached(fragments, reach, cells);
        cells.index = PatchIndex(cells.grid, cells.patches);
        const bool spheres = scene.grid.estimator == Estimator::sphere;  // reach into other cells
        for (std::size_t i = 0; i < fragments.size(); ++i)
            if (!keep(i) && (spheres || has_patch(fragments[i], cells)))
                cells.left_out.push_back(fragments[i].key);
        cells.moved_area = reach.moved_area;
        cells.deciding_photons = reach.photons;
    } else {
        build_patches(
            fragments, [](std::size_t) { return true; }, cells);
        cells.index = PatchIndex(cells.grid, cells.patches);
    }
    for (const Patch& p : cells.patches) cells.counted_area += p.area;
    if (cells.grid.facings)
        cells.sight = find_sight(scene, caster, cells, counted_fragments(cells, fragments));
    return cells;
}

}  // namespace pim
