// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/look_up_means.h"

#include <algorithm>

#include "bake/cells.h"
#include "bake/fragments.h"
#include "common/core/parallel.h"
#include "common/map/irradiance.h"

namespace pim {
namespace {

constexpr std::size_t kBlock = 64;  // cells

using Row = LookUpMeans::Row;

void add(Row& row, uint32_t patch, float weight) {
    const auto known = std::ranges::find(row, patch, &LookUpMeans::Share::patch);
    if (known != row.end())
        known->weight += weight;
    else
        row.push_back({patch, weight});
}

class Adder {
  public:
    Adder(const Scene& scene, const Cells& cells)
        : scene_(scene), cells_(cells), map_(map_without_lights(cells)) {}

    // What is looked up at a fragment, to the rows of the patches that it belongs to.
    void add_fragment(const Fragment& f, std::vector<Row>& rows) const {
        const Index3 cell = cell_of(cells_.grid, f.key);
        const auto* own = cells_.index.find_cell(cell);
        if (!own) return;
        const Vec3 from_centre(Vec3d(f.centre) - cells_.grid.centre(cell));
        thread_local std::vector<PatchShare> shares;
        look_up(map_, f.centre, normal_at_centre(scene_.geometry, f), shares);
        for (int k = 0; k < kFacingCount; ++k) {
            const int patch = f.facing_area[k] > 0 ? cells_.patch_at(*own, k, from_centre) : -1;
            if (patch < 0) continue;
            for (const PatchShare& s : shares)
                if (s.weight > 0) add(rows[std::size_t(patch)], s.patch, s.weight * f.facing_area[k]);
        }
    }

  private:
    const Scene& scene_;
    const Cells& cells_;
    IlluminationMap map_;
};

// Of each row; of an empty one the patch itself counts.
std::vector<Row> with_sum_one(std::vector<Row> rows) {
    for (std::size_t p = 0; p < rows.size(); ++p) {
        float sum = 0;
        for (const auto& s : rows[p]) sum += s.weight;
        for (auto& s : rows[p]) s.weight /= sum;
        if (!(sum > 0)) rows[p] = {{uint32_t(p), 1}};
    }
    return rows;
}

}  // namespace

LookUpMeans::LookUpMeans(const std::vector<Row>& rows) {
    first_.push_back(0);
    for (const Row& row : rows) {
        shares_.insert(shares_.end(), row.begin(), row.end());
        first_.push_back(shares_.size());
    }
}

LookUpMeans LookUpMeans::part(const std::vector<uint32_t>& patches) const {
    if (empty()) return {};
    std::vector<Row> rows;
    for (const uint32_t patch : patches) {
        Row& row = rows.emplace_back();
        for (const Share& s : of(patch))
            if (const auto found = std::ranges::lower_bound(patches, s.patch);
                found != patches.end() && *found == s.patch)
                row.push_back({uint32_t(found - patches.begin()), s.weight});
    }
    return LookUpMeans(with_sum_one(std::move(rows)));
}

LookUpMeans find_look_up_means(const Scene& scene, const Cells& cells,
                               const std::vector<Fragment>& fragments) {
    const std::vector<std::size_t> begins = begins_of_cells(fragments);
    const Adder adder(scene, cells);
    std::vector<Row> rows(cells.patches.size());
    const std::size_t count = begins.size() - 1;
    parallel_for((count + kBlock - 1) / kBlock, [&](std::size_t block) {
        for (std::size_t c = block * kBlock; c < std::min(count, (block + 1) * kBlock); ++c)
            for (std::size_t i = begins[c]; i < begins[c + 1]; ++i) adder.add_fragment(fragments[i], rows);
    });
    return LookUpMeans(with_sum_one(std::move(rows)));
}

std::vector<Rgb> sharpened(const std::vector<Rgb>& values, const LookUpMeans& means) {
    if (means.empty()) return values;
    std::vector<Rgb> sharp(values.size());
    for (std::size_t p = 0; p < values.size(); ++p) {
        Rgb mean(0);
        for (const auto& s : means.of(p)) mean += values[s.patch] * s.weight;
        sharp[p] = values[p] + (values[p] - mean);
    }
    return sharp;
}

}  // namespace pim
