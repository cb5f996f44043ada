// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/reach.h"

#include <atomic>
#include <boost/math/special_functions/beta.hpp>
#include <numeric>
#include <span>

#include "bake/fragment_index.h"
#include "bake/unlit_regions.h"
#include "common/core/float_traps.h"
#include "common/core/log.h"
#include "common/core/parallel.h"
#include "common/core/progress.h"
#include "common/transport/photon.h"

namespace pim {
namespace {

constexpr uint64_t kFirstPhotons = uint64_t{1} << 17;
constexpr uint64_t kFirstShare = 8;  // one in so many of those that may look, if that is more
constexpr uint64_t kPhotonBlock = 4096;
constexpr int kFarEnough = 32;  // surfaces: by then a photon has seen what it will, also between white walls
constexpr double kMovedShare = 1e-3;  // of the area: the verdicts have settled when a doubling moves less
constexpr double kLitShare = 0.1;     // of the mean irradiance: darker cells need not settle
constexpr double kOpenShare = 5e-3;  // of the area: ... and less than this has seen no photon and is not dark

FragmentIndex index_of(const std::vector<Fragment>& fragments) {
    std::vector<FragmentKey> keys;
    for (const Fragment& f : fragments) keys.push_back(f.key);
    return FragmentIndex(std::move(keys));
}

class Pass {
  public:
    Pass(const Scene& scene, const RayCaster& caster, const SurfaceCells& surface,
         const std::vector<Fragment>& fragments, const PositionFilter& allowed)
        : scene_(scene),
          caster_(caster),
          surface_(surface),
          fragments_(fragments),
          allowed_(allowed),
          index_(index_of(fragments)),
          begins_(begins_of_cells(fragments)),
          regions_(scene, surface.grid(), fragments),
          hits_(fragments.size()),
          landings_(fragments.size()),
          dark_(fragments.size()) {
        for (auto& quarters : landings_) quarters.fill(kNoLanding);
        for (const Fragment& f : fragments) facing_.push_back(uint8_t(main_facing(f)));
    }

    Reach run(uint64_t most_photons) {
        double area = 0;
        for (const Fragment& f : fragments_) area += f.area;
        Reach reach;
        const uint64_t few = std::max<uint64_t>(1, most_photons / kPhotonBlock) * kPhotonBlock;
        const uint64_t first = few / kFirstShare / kPhotonBlock * kPhotonBlock;
        for (uint64_t until = std::min(few, std::max(first, kFirstPhotons));; until *= 2) {
            shoot(until);
            const std::vector<uint8_t> before = dark_;
            open_.assign(begins_.size() - 1, 0.0);
            dark_ = regions_.judge(hits_);
            mean_hits_ = std::accumulate(hits_.begin(), hits_.end(), 0.0) / area;
            parallel_for(open_.size(), [&](std::size_t cell) { judge_cell(cell); });
            reach.moved_area = 0;
            for (std::size_t f = 0; f < dark_.size(); ++f)
                if (dark_[f] != before[f]) reach.moved_area += fragments_[f].area;
            const double open = std::accumulate(open_.begin(), open_.end(), 0.0);
            log_debug(fmt::format(
                "reach: {} photons, {:.3g} % of the area moved, {:.3g} % unseen beside lit surface", until,
                100 * reach.moved_area / area, 100 * open / area));
            const bool settled = reach.moved_area < kMovedShare * area && open < kOpenShare * area;
            if (settled || 2 * until > most_photons) break;
        }
        reach.dark.assign(dark_.begin(), dark_.end());
        reach.hits = std::move(hits_);
        reach.landings = std::move(landings_);
        reach.photons = photons_;
        return reach;
    }

  private:
    void shoot(uint64_t until) {
        Progress progress("looking where light reaches", until - photons_);
        const uint64_t first = photons_ / kPhotonBlock, blocks = until / kPhotonBlock - first;
        parallel_for(blocks, [&](std::size_t block) {
            EnergyAccount ignored;
            for (uint64_t photon = (first + block) * kPhotonBlock;
                 photon < (first + block + 1) * kPhotonBlock; ++photon) {
                const Light& light = scene_.lights[photon % scene_.lights.size()];
                RandomStream random(scene_.bake.seed, RandomPurpose::reach, 0, photon),
                    places(scene_.bake.seed, RandomPurpose::reach_lamp, 0, photon);
                trace_photon(
                    scene_, caster_, light, random_lamp_position(light, allowed_, places), random,
                    [&](const Landing& landing) { count(landing.surface, photon); }, ignored, kFarEnough);
            }
            progress.advance(kPhotonBlock);
        });
        photons_ = until;
    }

    void count(const SurfacePoint& s, uint64_t photon) {
        const auto fine = surface_.fine_cell(s.triangle, s.side, s.position);
        if (!fine) return;
        const auto f = index_.find(fragment_key(surface_.grid(), s.triangle, s.side, *fine));
        if (!f) return;
        std::atomic_ref(hits_[*f]).fetch_add(1, std::memory_order_relaxed);
        const uint64_t place = pack_place(fragments_[*f], s.position);
        draw(landings_[*f][std::size_t(quarter_of(place, PlaneAxes(s.geometric_normal)))], place, photon);
    }

    // One landing of all, the same whatever thread comes first: that of the lowest random number.
    void draw(uint64_t& kept, uint64_t place, uint64_t photon) const {
        const uint32_t lot = philox4x32(
            {uint32_t(photon), uint32_t(photon >> 32), uint32_t(place), uint32_t(place >> 32)}, {0, 0})[0];
        const uint64_t drawn = uint64_t(lot >> 16) << 48 | place;
        const std::atomic_ref landing(kept);
        uint64_t before = landing.load(std::memory_order_relaxed);
        while (drawn < before && !landing.compare_exchange_weak(before, drawn, std::memory_order_relaxed)) {
        }
    }

    // What a fragment shares with others of its cell and facing at each level, coarse to fine.
    static constexpr int kLevels = 5;
    uint64_t union_of(std::size_t f, int level) const {
        const FragmentKey& key = fragments_[f].key;
        const uint64_t object = scene_.geometry.triangles[key.triangle].object, side = key.place & 1;
        const int in = key.place >> 1, x = in / (kFinePerCell * kFinePerCell),
                  y = in / kFinePerCell % kFinePerCell, z = in % kFinePerCell, half = kFinePerCell / 2;
        const auto octant = uint64_t((x / half * 2 + y / half) * 2 + z / half);
        switch (level) {
            case 0:
                return object << 8 | side;
            case 1:
                return uint64_t(key.triangle) << 8 | side;
            case 2:
                return object << 8 | octant << 1 | side;
            case 3:
                return object << 8 | key.place;
            default:
                return uint64_t(key.triangle) << 8 | key.place;
        }
    }

    struct Member {
        uint8_t facing;
        uint64_t in_union;
        std::size_t fragment;
        auto operator<=>(const Member&) const = default;
        bool is_beside(const Member& m) const { return facing == m.facing && in_union == m.in_union; }
    };

    void judge_cell(std::size_t cell) {
        const std::size_t begin = begins_[cell], end = begins_[cell + 1];
        std::array<double, kFacingCount> hits{}, area{};
        std::vector<std::size_t> open;  // those not dark before
        for (std::size_t f = begin; f < end; ++f) {
            if (dark_[f]) continue;
            hits[facing_[f]] += hits_[f];
            area[facing_[f]] += fragments_[f].area;
            open.push_back(f);
        }
        std::vector<Member> members;
        for (int level = 0; level < kLevels; ++level) {
            members.clear();
            for (const std::size_t f : open) members.push_back({facing_[f], union_of(f, level), f});
            std::ranges::sort(members);
            for (auto first = members.begin(); first != members.end();) {
                const auto last = std::find_if_not(first, members.end(),
                                                   [&](const Member& m) { return m.is_beside(*first); });
                judge_union({first, last}, hits[first->facing], area[first->facing]);
                first = last;
            }
        }
        for (std::size_t f = begin; f < end; ++f)
            if (!dark_[f] && hits_[f] == 0 && hits[facing_[f]] > kLitShare * mean_hits_ * area[facing_[f]])
                open_[cell] += fragments_[f].area;
    }

    // Given n hits in the cell, those on the union are binomial; at the border of darkness each falls on it
    // with probability p.
    void judge_union(std::span<const Member> members, double n, double whole_area) {
        double own = 0, area = 0;
        for (const Member& m : members) own += hits_[m.fragment], area += fragments_[m.fragment].area;
        const double rest = whole_area - area;
        if (own >= n || rest <= 1e-6 * whole_area)
            return;  // nothing brighter in the cell: nothing to leave out
        const double p = kDarkShare * area / (kDarkShare * area + rest);
        if (!(own < n * p)) return;
        const FloatTraps library(FloatTraps::off);
        if (boost::math::ibetac(own + 1, n - own, p) < kDoubt)  // P(X <= own)
            for (const Member& m : members) dark_[m.fragment] = 1;
    }

    const Scene& scene_;
    const RayCaster& caster_;
    const SurfaceCells& surface_;
    const std::vector<Fragment>& fragments_;
    const PositionFilter& allowed_;
    FragmentIndex index_;
    std::vector<std::size_t> begins_;
    UnlitRegions regions_;
    std::vector<uint32_t> hits_;
    std::vector<std::array<uint64_t, kQuarters>> landings_;  // per fragment: lot and place
    std::vector<uint8_t> dark_, facing_;                     // bytes: written by several threads
    std::vector<double> open_;  // per cell, m² that beside lit surface has seen no photon yet
    double mean_hits_ = 0;      // per m²
    uint64_t photons_ = 0;
};

}  // namespace

Vec3 random_lamp_position(const Light& light, const PositionFilter& allowed, RandomStream& random) {
    Vec3 position = light.position;
    for (int attempt = 0; attempt < 64; ++attempt) {
        const Vec3 size = light.domain.max - light.domain.min;
        for (int axis = 0; axis < 3; ++axis)
            position[axis] = light.domain.min[axis] + size[axis] * random.next();
        if (allowed(position)) break;
    }
    return position;
}

Reach find_reach(const Scene& scene, const RayCaster& caster, const SurfaceCells& surface,
                 const std::vector<Fragment>& fragments, const PositionFilter& allowed,
                 uint64_t most_photons) {
    return Pass(scene, caster, surface, fragments, allowed).run(most_photons);
}

}  // namespace pim
