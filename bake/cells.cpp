// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/cells.h"

#include <cmath>

#include "bake/open_parts.h"
#include "bake/places.h"
#include "bake/sight_lines.h"
#include "bake/unlit_regions.h"
#include "common/core/parallel.h"

namespace pim {
namespace {

constexpr int kCutPackets = 4;       // of places that say how a split cuts a fragment
constexpr double kLeastArea = 1e-6;  // of a cell's face: smaller patches would hold nothing but noise

struct PatchSum {
    double area = 0;
    Vec3d moment{0};  // area × centroid

    void add(const Fragment& fragment, int facing) {
        area += fragment.facing_area[facing];
        moment += Vec3d(fragment.centre) * double(fragment.facing_area[facing]);
    }
};

// What a cell's kept fragments make.
struct CellPatches {
    std::vector<Patch> patches;
    std::vector<PatchSplit> split;
    std::vector<Fragment> pieces;  // fragments, cut where a split goes through them
};

class PatchBuilder {
  public:
    // `open`: places of the fragments that are not wholly open; empty: all are. The arguments must outlive
    // the builder.
    PatchBuilder(const Scene& scene, const RayCaster& caster, const CellGrid& grid,
                 const std::vector<Fragment>& fragments, const std::vector<std::vector<Vec3>>& open)
        : scene_(scene),
          grid_(grid),
          fragments_(fragments),
          open_(open),
          splitter_(scene, caster, grid, fragments) {}

    CellPatches build(const Index3& cell, const std::vector<std::size_t>& kept) const {
        CellPatches built;
        const Vec3d centre = grid_.centre(cell);
        std::array<PatchSplit, kFacingCount> split;
        for (int f = 0; f < kFacingCount; ++f) split[f] = splitter_.find(kept, f, centre);
        for (const std::size_t i : kept) cut(i, split[main_facing(fragments_[i])], centre, built.pieces);
        std::array<PatchSum, kSlotCount> sums{};
        for (const Fragment& piece : built.pieces)
            for (int f = 0; f < kFacingCount; ++f)
                sums[f + kFacingCount * split[f].is_behind(from(centre, piece.centre))].add(piece, f);
        for (int slot = 0; slot < kSlotCount; ++slot) {
            if (!(sums[slot].area > kLeastArea * grid_.cell_size * grid_.cell_size)) continue;
            built.patches.push_back(
                {cell, slot, float(sums[slot].area), Vec3(sums[slot].moment / sums[slot].area - centre)});
            built.split.push_back(split[slot % kFacingCount]);
        }
        return built;
    }

  private:
    static Vec3 from(const Vec3d& centre, const Vec3& place) { return Vec3(Vec3d(place) - centre); }

    // Two pieces where the split goes through the fragment, else one.
    void cut(std::size_t f, const PatchSplit& split, const Vec3d& centre,
             std::vector<Fragment>& pieces) const {
        const Fragment& whole = fragments_[f];
        std::array<Vec3, 2> sum{Vec3(0), Vec3(0)};
        std::array<int, 2> count{};
        const auto add = [&](const std::vector<Vec3>& places) {
            for (const Vec3& place : places) {
                const bool behind = split.is_behind(from(centre, place));
                sum[behind] += place;
                ++count[behind];
            }
        };
        if (split.passes(whole.box, centre)) {
            if (!open_.empty() && !open_[f].empty())
                add(open_[f]);
            else if (const FragmentPlane plane(scene_.geometry, whole); !plane.is_degenerate())
                for (int number = 0; number < kCutPackets; ++number) add(plane.places(number));
        }
        if (count[0] == 0 || count[1] == 0) {
            pieces.push_back(whole);
            return;
        }
        for (std::size_t side = 0; side < 2; ++side) {
            Fragment piece = whole;
            const float share = float(count[side]) / float(count[0] + count[1]);
            piece.centre = sum[side] / float(count[side]);
            piece.area *= share;
            for (float& area : piece.facing_area) area *= share;
            pieces.push_back(piece);
        }
    }

    const Scene& scene_;
    const CellGrid& grid_;
    const std::vector<Fragment>& fragments_;
    const std::vector<std::vector<Vec3>>& open_;
    PatchSplitter splitter_;
};

// Adds the patches to the cells; returns all pieces.
template <class Keep>
std::vector<Fragment> build_patches(const PatchBuilder& builder, const std::vector<Fragment>& fragments,
                                    Keep keep, Cells& cells) {
    const std::vector<std::size_t> begins = begins_of_cells(fragments);
    std::vector<CellPatches> built(begins.size() - 1);
    parallel_for(built.size(), [&](std::size_t c) {
        std::vector<std::size_t> kept;
        for (std::size_t i = begins[c]; i < begins[c + 1]; ++i)
            if (keep(i)) kept.push_back(i);
        built[c] = builder.build(cell_of(cells.grid, fragments[begins[c]].key), kept);
    });
    std::vector<Fragment> pieces;
    for (const CellPatches& cell : built) {
        cells.patches.insert(cells.patches.end(), cell.patches.begin(), cell.patches.end());
        cells.split.insert(cells.split.end(), cell.split.begin(), cell.split.end());
        pieces.insert(pieces.end(), cell.pieces.begin(), cell.pieces.end());
    }
    cells.index = PatchIndex(cells.grid, cells.patches);
    return pieces;
}

// Photons that landed on each patch.
std::vector<double> hits_of_patches(const std::vector<Fragment>& fragments, const Reach& reach,
                                    const Cells& cells) {
    std::vector<double> hits(cells.patches.size(), 0);
    for (std::size_t i = 0; i < fragments.size(); ++i) {
        const Index3 cell = cell_of(cells.grid, fragments[i].key);
        const auto* patches = cells.index.find_cell(cell);
        const Vec3 from_centre(Vec3d(fragments[i].centre) - cells.grid.centre(cell));
        for (int f = 0; patches && f < kFacingCount; ++f) {
            const int patch = fragments[i].facing_area[f] > 0 ? cells.patch_at(*patches, f, from_centre) : -1;
            if (patch >= 0) hits[std::size_t(patch)] += reach.hits[i];
        }
    }
    return hits;
}

// The connected unlit patches of one slot around `start`, each marked as seen.
std::vector<uint32_t> dark_region(uint32_t start, const Cells& cells, const std::vector<double>& hits,
                                  std::vector<bool>& seen) {
    std::vector<uint32_t> region{start};
    seen[start] = true;
    for (std::size_t next = 0; next < region.size(); ++next) {
        const Patch& patch = cells.patches[region[next]];
        for (int n = 0; n < 27; ++n) {
            const int p =
                cells.index.find(patch.cell + Index3(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1), patch.slot);
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
    const std::vector<double> hits = hits_of_patches(fragments, reach, cells);
    double all_hits = 0, lit_area = 0;
    for (std::size_t p = 0; p < hits.size(); ++p)
        if (hits[p] > 0) all_hits += hits[p], lit_area += cells.patches[p].area;
    if (!(all_hits > 0)) return;
    const double enough = -std::log(kDoubt) / (kDarkShare * all_hits / lit_area);  // m²
    std::vector<bool> seen(hits.size(), false), dropped(hits.size(), false);
    for (std::size_t p = 0; p < hits.size(); ++p) {
        if (seen[p] || hits[p] > 0) continue;
        const auto region = dark_region(uint32_t(p), cells, hits, seen);
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

}  // namespace

int Cells::patch_at(const std::array<int32_t, kSlotCount>& own, int facing, const Vec3& from_centre) const {
    const int front = own[facing], behind = own[facing + kFacingCount];
    if (front < 0 || behind < 0) return std::max(front, behind);
    return split[std::size_t(front)].is_behind(from_centre) ? behind : front;
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
    std::vector<Fragment> pieces;
    if (scene.grid.reachable_area_only) {
        Reach reach = find_reach(scene, caster, surface, fragments, allowed, scene.grid.reach_photons);
        const auto open = keep_open_parts(scene, caster, cells.grid, fragments, reach);
        const PatchBuilder builder(scene, caster, cells.grid, fragments, open);
        const auto keep = [&](std::size_t i) { return !reach.dark[i]; };
        pieces = build_patches(builder, fragments, keep, cells);
        drop_unreached(fragments, reach, cells);
        cells.index = PatchIndex(cells.grid, cells.patches);
        const bool spheres = scene.grid.estimator == Estimator::sphere;  // reach into other cells
        std::vector<FragmentKey> left_out;
        for (std::size_t i = 0; i < fragments.size(); ++i)
            if (!keep(i) && (spheres || has_patch(fragments[i], cells))) left_out.push_back(fragments[i].key);
        cells.left_out = FragmentIndex(std::move(left_out));
        cells.moved_area = reach.moved_area;
        cells.deciding_photons = reach.photons;
    } else {
        const std::vector<std::vector<Vec3>> all_open;
        const PatchBuilder builder(scene, caster, cells.grid, fragments, all_open);
        pieces = build_patches(
            builder, fragments, [](std::size_t) { return true; }, cells);
    }
    for (const Patch& p : cells.patches) cells.counted_area += p.area;
    if (cells.grid.facings) cells.sight = find_sight(scene, caster, cells, pieces);
    if (scene.grid.estimator == Estimator::area) cells.means = find_look_up_means(scene, cells, pieces);
    return cells;
}

}  // namespace pim
