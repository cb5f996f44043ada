// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/unlit_regions.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "bake/reach.h"

namespace pim {
namespace {

constexpr double kUnlitShare = 0.01;
const double kFew = -std::log(kDoubt);  // photons: where so many are expected, none comes with kDoubt

auto place(const Index3& region) { return std::tuple(region.x, region.y, region.z); }

}  // namespace

int main_facing(const Fragment& fragment) {
    return int(std::ranges::max_element(fragment.facing_area) - fragment.facing_area.begin());
}

UnlitRegions::UnlitRegions(const Scene& scene, const CellGrid& grid, const std::vector<Fragment>& fragments)
    : group_of_(fragments.size()) {
    Level single;  // a group for each fragment
    single.reserve(fragments.size());
    for (const Fragment& f : fragments) {
        const uint64_t object = scene.geometry.triangles[f.key.triangle].object;
        const uint64_t kind = object << 4 | uint64_t(f.key.place & 1) << 3 | uint64_t(main_facing(f));
        single.push_back({cell_of(grid, f.key) * 2, kind, double(f.area)});
    }
    levels_.push_back(coarser(single));
    for (std::size_t f = 0; f < fragments.size(); ++f) group_of_[f] = single[f].parent;
    for (int size = 1; size < std::max({grid.size.x, grid.size.y, grid.size.z}); size *= 2)
        levels_.push_back(coarser(levels_.back()));
}

// Groups of regions twice as large.
UnlitRegions::Level UnlitRegions::coarser(Level& fine) {
    std::vector<uint32_t> order(fine.size());
    std::iota(order.begin(), order.end(), 0u);
    const auto key = [&](uint32_t i) { return std::tuple(place(fine[i].region / 2), fine[i].kind); };
    std::ranges::sort(order, {}, key);
    Level level;
    for (std::size_t i = 0; i < order.size(); ++i) {
        Group& group = fine[order[i]];
        if (i == 0 || key(order[i]) != key(order[i - 1])) level.push_back({group.region / 2, group.kind});
        level.back().area += group.area;
        group.parent = uint32_t(level.size() - 1);
    }
    return level;
}

// At a share of the irradiance of what is lit, the next photon of both would land on the group with
// probability q = a / (a + b), a the group's area times the share, b that of what is lit; that none of n did
// has probability (1 - q)^n.
void UnlitRegions::judge_level(Level& level, double scene_irradiance) {
    for (std::size_t begin = 0; begin < level.size();) {
        std::size_t end = begin;
        double hits = 0, lit_area = 0;
        for (; end < level.size() && level[end].region == level[begin].region; ++end)
            if (level[end].hits > 0) hits += level[end].hits, lit_area += level[end].area;
        for (; begin < end; ++begin) {
            Group& group = level[begin];
            const double area = kUnlitShare * group.area;
            group.unlit = group.hits == 0 && lit_area > 0 && area * scene_irradiance > kFew &&
                          hits * std::log1p(area / lit_area) > kFew;
        }
    }
}

std::vector<uint8_t> UnlitRegions::judge(const std::vector<uint32_t>& hits) {
    for (Level& level : levels_)
        for (Group& group : level) group.hits = 0;
    for (std::size_t f = 0; f < hits.size(); ++f) levels_[0][group_of_[f]].hits += hits[f];
    for (std::size_t l = 0; l + 1 < levels_.size(); ++l)
        for (const Group& group : levels_[l]) levels_[l + 1][group.parent].hits += group.hits;
    double all_hits = 0, lit_area = 0;
    for (const Group& group : levels_.back())
        if (group.hits > 0) all_hits += group.hits, lit_area += group.area;
    const double irradiance = lit_area > 0 ? all_hits / lit_area : 0;  // photons per m²
    for (Level& level : levels_) judge_level(level, irradiance);
    for (std::size_t l = levels_.size() - 1; l-- > 0;)
        for (Group& group : levels_[l]) group.unlit = group.unlit || levels_[l + 1][group.parent].unlit;
    std::vector<uint8_t> unlit(hits.size());
    for (std::size_t f = 0; f < hits.size(); ++f) unlit[f] = levels_[0][group_of_[f]].unlit;
    return unlit;
}

}  // namespace pim
