// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/cells.h"

#include <atomic>
#include <boost/math/special_functions/beta.hpp>
#include <cmath>

#include "common/core/log.h"
#include "common/core/parallel.h"
#include "common/core/progress.h"
#include "common/transport/photon.h"

namespace pim {
namespace {

constexpr uint64_t kFirstPhotons = uint64_t{1} << 18;
constexpr uint64_t kPhotonBlock = 4096;
constexpr double kUndecidedShare = 0.002;   // of the area: few enough to stop
constexpr double kLeastArea = 1e-6;         // of a cell's face: smaller patches would hold nothing but noise
constexpr double kBlackShare = 0.01;        // of the mean irradiance: below, a whole patch counts as unreached

enum class Verdict : uint8_t { undecided, lit, dark };

// Fragments of one cell stand together; this finds them by cell.
class FragmentTable {
  public:
    FragmentTable(const CellGrid& grid, const std::vector<Fragment>& fragments) : fragments_(fragments) {
        std::vector<Patch> cells;
        for (std::size_t i = 0; i < fragments.size(); ++i)
            if (i == 0 || fragments[i].key.cell != fragments[i - 1].key.cell) {
                cells.push_back({cell_of(grid, fragments[i].key), 0, 0});
                start_.push_back(i);
            }
        start_.push_back(fragments.size());
        index_ = PatchIndex(grid, cells);
    }
    std::size_t cell_count() const { return start_.size() - 1; }
    std::size_t begin_of(std::size_t cell) const { return start_[cell]; }
    std::size_t end_of(std::size_t cell) const { return start_[cell + 1]; }

    // Number of the fragment; fragments.size() if there is none.
    std::size_t find(const Index3& cell, const FragmentKey& key) const {
        const int number = index_.find(cell, 0);
        if (number < 0) return fragments_.size();
        const auto begin = fragments_.begin() + std::ptrdiff_t(start_[number]);
        const auto end = fragments_.begin() + std::ptrdiff_t(start_[number + 1]);
        const auto found = std::ranges::lower_bound(begin, end, key, {}, &Fragment::key);
        return found != end && found->key == key ? std::size_t(found - fragments_.begin()) : fragments_.size();
    }

  private:
    const std::vector<Fragment>& fragments_;
    std::vector<std::size_t> start_;
    PatchIndex index_;
};

int main_facing(const Fragment& fragment) {
    return int(std::ranges::max_element(fragment.facing_area) - fragment.facing_area.begin());
}

class Reach {
  public:
    Reach(const Scene& scene, const RayCaster& caster, const SurfaceCells& surface, const PositionFilter& allowed,
          const std::vector<Fragment>& fragments)
        : scene_(scene), caster_(caster), surface_(surface), allowed_(allowed), fragments_(fragments),
          table_(surface.grid(), fragments), hits_(fragments.size()), verdicts_(fragments.size(), Verdict::undecided) {}

    // Photons from lamps at random places of their domains, counted per fragment. More photons until all but
    // kUndecidedShare of the area is decided.
    void decide(uint64_t most_photons) {
        for (uint64_t until = std::min(kFirstPhotons, most_photons);; until = std::min(2 * until, most_photons)) {
            shoot(until);
            judge();
            if (undecided_area_ <= kUndecidedShare * total_area_ || until == most_photons) return;
        }
    }

    Verdict verdict(std::size_t fragment) const { return verdicts_[fragment]; }
    uint32_t hits(std::size_t fragment) const { return hits_[fragment]; }
    uint64_t photons() const { return photons_; }
    double undecided_area() const { return undecided_area_; }

  private:
    Vec3 lamp_position(const Light& light, uint64_t photon) const {
        RandomStream random(scene_.bake.seed, RandomPurpose::reach_lamp, 0, photon);
        Vec3 position = light.position;
        for (int attempt = 0; attempt < 64; ++attempt) {
            const Vec3 size = light.domain.max - light.domain.min;
            for (int axis = 0; axis < 3; ++axis) position[axis] = light.domain.min[axis] + size[axis] * random.next();
            if (allowed_(position)) return position;
        }
        return position;
    }

    void shoot(uint64_t until) {
        Progress progress("looking where light reaches", until);
        const uint64_t first = photons_ / kPhotonBlock, blocks = until / kPhotonBlock - first;
        parallel_for(blocks, [&](std::size_t block) {
            EnergyAccount ignored;
            for (uint64_t photon = (first + block) * kPhotonBlock; photon < (first + block + 1) * kPhotonBlock; ++photon) {
                const Light& light = scene_.lights[photon % scene_.lights.size()];
                RandomStream random(scene_.bake.seed, RandomPurpose::reach, 0, photon);
                trace_photon(scene_, caster_, light, lamp_position(light, photon), random,
                             [&](const Landing& landing) { count(landing.surface); }, ignored);
            }
            progress.advance(kPhotonBlock);
        });
        photons_ = until;
    }

    void count(const SurfacePoint& s) {
        const auto fine = surface_.fine_cell(s.triangle, s.side, s.position);
        if (!fine) return;
        const std::size_t f = table_.find(cell_of_fine(*fine), fragment_key(surface_.grid(), s.triangle, s.side, *fine));
        if (f < hits_.size()) std::atomic_ref(hits_[f]).fetch_add(1, std::memory_order_relaxed);
    }

    void judge() {
        std::atomic<double> undecided = 0;
        total_area_ = 0;
        for (const Fragment& f : fragments_) total_area_ += f.area;
        parallel_for(table_.cell_count(), [&](std::size_t cell) {
            double own = 0;
            judge_cell(table_.begin_of(cell), table_.end_of(cell));
            for (std::size_t f = table_.begin_of(cell); f < table_.end_of(cell); ++f)
                if (verdicts_[f] == Verdict::undecided) own += fragments_[f].area;
            // Rounded, so that the sum is exact in any order.
            if (own > 0) undecided.fetch_add(std::round(own / total_area_ * 0x1p40) * 0x1p-40);
        });
        undecided_area_ = undecided * total_area_;
    }

    void judge_cell(std::size_t begin, std::size_t end) {
        std::array<double, kFacingCount> hits{}, area{};
        for (std::size_t f = begin; f < end; ++f) {
            hits[main_facing(fragments_[f])] += hits_[f];
            area[main_facing(fragments_[f])] += fragments_[f].area;
        }
        for (std::size_t f = begin; f < end; ++f) {
            const int facing = main_facing(fragments_[f]);
            verdicts_[f] = judge_fragment(hits_[f], fragments_[f].area, hits[facing], area[facing] - fragments_[f].area);
        }
    }

    // Given n hits on fragment and rest together, those on the fragment are binomial; at the border of darkness each
    // falls on it with probability p. Exact tests to both sides.
    static Verdict judge_fragment(double own, double area, double n, double rest_area) {
        if (n == 0 || rest_area <= 0) return Verdict::lit;   // nothing brighter in the cell: nothing to leave out
        const double p = kDarkShare * area / (kDarkShare * area + rest_area);
        const bool dark = own < n && boost::math::ibetac(own + 1, n - own, p) < kDoubt;   // P(X <= own)
        const bool lit = own > 0 && boost::math::ibeta(own, n - own + 1, p) < kDoubt;     // P(X >= own)
        return dark ? Verdict::dark : lit ? Verdict::lit : Verdict::undecided;
    }

    const Scene& scene_;
    const RayCaster& caster_;
    const SurfaceCells& surface_;
    const PositionFilter& allowed_;
    const std::vector<Fragment>& fragments_;
    FragmentTable table_;
    std::vector<uint32_t> hits_;
    std::vector<Verdict> verdicts_;
    uint64_t photons_ = 0;
    double total_area_ = 0, undecided_area_ = 0;
};

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
        if (reach.verdict(i) == Verdict::dark) continue;
        for (int f = 0; f < kFacingCount; ++f)
            if (const int p = index.find(cell_of(grid, fragments[i].key), f); p >= 0 && fragments[i].facing_area[f] > 0)
                hits[p] += reach.hits(i);
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
        Reach reach(scene, caster, surface, allowed, fragments);
        reach.decide(options.most_photons);
        const auto keep = [&](std::size_t i) { return reach.verdict(i) != Verdict::dark; };
        add_patches(cells.grid, fragments, keep, cells.patches);
        cells.patches = drop_unreached(cells.grid, cells.patches,
                                       hits_of_patches(cells.grid, cells.patches, fragments, reach));
        for (std::size_t i = 0; i < fragments.size(); ++i)
            if (!keep(i)) cells.left_out.push_back(fragments[i].key);
        cells.undecided_area = reach.undecided_area();
        cells.deciding_photons = reach.photons();
    } else {
        add_patches(cells.grid, fragments, [](std::size_t) { return true; }, cells.patches);
    }
    for (const Patch& p : cells.patches) cells.counted_area += p.area;
    cells.index = PatchIndex(cells.grid, cells.patches);
    return cells;
}

}  // namespace pim
