// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/open_parts.h"

#include <algorithm>
#include <bitset>
#include <numeric>
#include <span>

#include "bake/places.h"
#include "common/core/parallel.h"

namespace pim {
namespace {

constexpr float kLift = 0.002f;   // cells
constexpr float kSmall = 0.125f;  // cells: fragments no larger are open or closed nearly as a whole
constexpr int kWitnesses = 16;
constexpr int kSpreads = 3;                // times that open places vouch for others
constexpr float kMostOfScene = 1 / 48.0f;  // of its longest side: what closes a place in is no room
constexpr float kCover = 0.5f;             // what hangs lower may cover a place; of the way looked around
constexpr int kCoverRays = 16, kCoverRaysAtOnce = 4;
constexpr int kSpeaksFor = 4;       // places below something, of which one is tested
constexpr double kLitShare = 0.25;  // of the mean irradiance: what gets more is lit, say a lamp's housing

float longest(const Box3& box) {
    const Vec3 size = box.size();
    return std::max({size.x, size.y, size.z});
}

// Of a fragment: the first packet decides alone where all of it is open.
struct Tests {
    int places_at_once, packets;
};
constexpr Tests kTestsOfLarge{RayPacket::kSize, 4}, kTestsOfSmall{2, 4};

using Lanes = std::bitset<RayPacket::kSize>;

// What light does not pass: all but glass.
class Blockers {
  public:
    Blockers(const Scene& scene, const RayCaster& rays)
        : caster(rays), scene_(scene), glass_(std::ranges::any_of(scene.materials, &Material::glass)) {}

    const RayCaster& caster;

    Lanes blocked(const RayPacket& rays) const {
        HitPacket packet;
        packet.rays = rays;
        Lanes blocked;
        glass_ ? caster.intersect(packet) : caster.occluded(packet.rays);
        for (int lane = 0; lane < RayPacket::kSize; ++lane)
            blocked[std::size_t(lane)] = !(rays.length[lane] < 0) &&
                                         (glass_ ? hits_solid(packet, lane) : packet.rays.length[lane] < 0);
        return blocked;
    }

  private:
    bool hits_solid(const HitPacket& packet, int lane) const {
        if (!packet.is_hit(lane)) return false;
        const Triangle& hit = scene_.geometry.triangles[packet.triangle[lane]];
        return !scene_.materials[hit.material].glass;
    }

    const Scene& scene_;
    bool glass_;
};

class Opening {
  public:
    // `around`, m: what closes a place in does so within that.
    Opening(const Geometry& geometry, const Blockers& blockers, const CellGrid& grid, float around,
            const Fragment& fragment)
        : plane(geometry, fragment),
          tests(longest(fragment.box) > kSmall * float(grid.cell_size) ? kTestsOfLarge : kTestsOfSmall),
          blockers_(blockers),
          around_(around) {
        up_ = fragment.key.place % 2 ? -plane.normal() : plane.normal();
        lift_ = up_ * std::max(kLift * float(grid.cell_size), 4 * blockers.caster.surface_offset());
    }

    const FragmentPlane plane;
    const Tests tests;

    // Those that see one of the witnesses, or one of these in turn, all where there is no witness; but none
    // that is covered.
    std::vector<bool> open(const std::vector<Vec3>& places, std::span<const Vec3> witnesses) const {
        std::vector<bool> open(places.size(), witnesses.empty());
        for (const Vec3& witness : witnesses) look(places, open, [&](std::size_t) { return &witness; });
        for (int spread = 0; spread < kSpreads; ++spread) {
            const std::vector<bool> before = open;
            look(places, open, [&](std::size_t i) { return nearest(places, before, places[i]); });
            if (open == before) break;
        }
        close_covered(places, open);
        return open;
    }

  private:
    template <class WitnessOf>
    void look(const std::vector<Vec3>& places, std::vector<bool>& open, WitnessOf witness_of) const {
        RayPacket packet;
        Lanes looking;
        for (std::size_t i = 0; i < places.size(); ++i) {
            const Vec3* witness = open[i] ? nullptr : witness_of(i);
            if (!witness) continue;
            packet.set(int(i), places[i] + lift_, *witness - places[i], 1);
            looking[i] = true;
        }
        if (looking.none()) return;
        const Lanes blocked = blockers_.blocked(packet);
        for (std::size_t i = 0; i < places.size(); ++i)
            if (looking[i] && !blocked[i]) open[i] = true;
    }

    // A sheet of paper before a board lets lines pass behind it, but hardly any light; nor does a tube let
    // any in. Of places with something close above, one in kSpeaksFor is tested and speaks for those around
    // it.
    void close_covered(const std::vector<Vec3>& places, std::vector<bool>& open) const {
        RayPacket upwards;
        for (std::size_t i = 0; i < places.size(); ++i)
            if (open[i]) upwards.set(int(i), from(places[i]), up_, kCover * around_);
        const Lanes below_something = blockers_.blocked(upwards);
        if (below_something.none()) return;
        std::vector<bool> covered(places.size(), false), free(places.size(), false);
        int below = 0;
        for (std::size_t i = 0; i < places.size(); ++i)
            if (below_something[i] && below++ % kSpeaksFor == 0)
                (is_covered(places[i]) ? covered : free)[i] = true;
        for (std::size_t i = 0; i < places.size(); ++i) {
            if (!below_something[i]) continue;
            const Vec3 *in = nearest(places, covered, places[i]), *out = nearest(places, free, places[i]);
            open[i] = !in || (out && (*out - places[i]).length2() < (*in - places[i]).length2());
        }
    }

    bool is_covered(const Vec3& place) const {
        const Frame frame(up_);
        for (int first = 0; first < kCoverRays; first += kCoverRaysAtOnce) {
            RayPacket packet;
            for (int lane = 0; lane < kCoverRaysAtOnce; ++lane) {
                const Imath::V2d share = golden_place(first + lane);
                const Vec3 towards = frame.to_world(sample_cosine_hemisphere(float(share.x), float(share.y)));
                packet.set(lane, from(place), towards, around_);
            }
            if (blockers_.blocked(packet).count() < kCoverRaysAtOnce) return false;
        }
        return true;
    }

    Vec3 from(const Vec3& place) const { return place + up_ * blockers_.caster.surface_offset(); }

    static const Vec3* nearest(const std::vector<Vec3>& places, const std::vector<bool>& open,
                               const Vec3& to) {
        const Vec3* found = nullptr;
        for (std::size_t i = 0; i < places.size(); ++i)
            if (open[i] && (!found || (places[i] - to).length2() < (*found - to).length2()))
                found = &places[i];
        return found;
    }

    const Blockers& blockers_;
    Vec3 up_, lift_;
    float around_;
};

// Places on a fragment's triangle and side, in its cell, where photons landed: its own first, then the
// nearest.
std::vector<Vec3> witnesses_of(std::size_t f, const std::vector<Fragment>& fragments, const Reach& reach) {
    const FragmentKey& key = fragments[f].key;
    std::vector<std::pair<float, Vec3>> found;  // by squared distance
    const auto gather = [&](std::size_t i) {
        const FragmentKey& k = fragments[i].key;
        if (k.cell != key.cell || k.triangle != key.triangle) return false;
        if (k.place % 2 != key.place % 2 || reach.dark[i]) return true;
        for (const uint64_t landing : reach.landings[i]) {
            if (landing == kNoLanding) continue;
            const Vec3 place = unpack_place(fragments[i], landing);
            found.emplace_back(i == f ? -1.0f : (place - fragments[f].centre).length2(), place);
        }
        return true;
    };
    gather(f);
    for (std::size_t i = f; i > 0 && gather(i - 1); --i) {
    }
    for (std::size_t i = f + 1; i < fragments.size() && gather(i); ++i) {
    }
    std::stable_sort(found.begin(), found.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<Vec3> places;
    for (std::size_t i = 0; i < std::min<std::size_t>(found.size(), kWitnesses); ++i)
        places.push_back(found[i].second);
    return places;
}

struct OpenPart {
    float share = 1;
    std::vector<Vec3> places;  // that are open, unless all is
};

OpenPart open_part(const Opening& opening, const std::vector<Vec3>& witnesses) {
    OpenPart part;
    std::size_t all = 0;
    for (int packet = 0; packet < opening.tests.packets; ++packet) {
        const std::vector<Vec3> places = opening.plane.places(packet, opening.tests.places_at_once);
        const std::vector<bool> open = opening.open(places, witnesses);
        for (std::size_t i = 0; i < places.size(); ++i)
            if (open[i]) part.places.push_back(places[i]);
        all += places.size();
        if (packet == 0 && part.places.size() == all) return {};  // also where no place was found
        if (part.places.empty() && witnesses.empty()) break;      // covered, and no photon came either
    }
    part.share = float(part.places.size()) / float(all);
    return part;
}

// Photons per m² of what is lit.
double mean_hits_of(const std::vector<Fragment>& fragments, const Reach& reach) {
    double hits = 0, area = 0;
    for (std::size_t f = 0; f < fragments.size(); ++f)
        if (!reach.dark[f]) hits += reach.hits[f], area += double(fragments[f].area);
    return area > 0 ? hits / area : 0;
}

}  // namespace

std::vector<std::vector<Vec3>> keep_open_parts(const Scene& scene, const RayCaster& caster,
                                               const CellGrid& grid, std::vector<Fragment>& fragments,
                                               Reach& reach) {
    const Blockers blockers(scene, caster);
    std::vector<OpenPart> parts(fragments.size());
    const double mean_hits = mean_hits_of(fragments, reach);
    const float around = std::min(float(grid.cell_size), kMostOfScene * longest(bounds(scene.geometry)));
    constexpr std::size_t kBlock = 1024;
    parallel_for((fragments.size() + kBlock - 1) / kBlock, [&](std::size_t block) {
        for (std::size_t f = block * kBlock; f < std::min(fragments.size(), (block + 1) * kBlock); ++f) {
            if (reach.dark[f]) continue;
            const Opening opening(scene.geometry, blockers, grid, around, fragments[f]);
            if (opening.plane.is_degenerate()) continue;
            std::vector<Vec3> witnesses = witnesses_of(f, fragments, reach);
            for (Vec3& w : witnesses) w = opening.plane.flat(w);
            parts[f] = open_part(opening, witnesses);
        }
    });
    std::vector<std::vector<Vec3>> open(fragments.size());
    for (std::size_t f = 0; f < fragments.size(); ++f) {
        if (parts[f].share == 1) continue;
        if (parts[f].share == 0) {  // but for a sliver, if it was hit
            if (reach.hits[f] > kLitShare * mean_hits * double(fragments[f].area)) continue;
            reach.dark[f] = true;
            continue;
        }
        open[f] = std::move(parts[f].places);
        fragments[f].centre =
            std::accumulate(open[f].begin(), open[f].end(), Vec3(0)) / float(open[f].size());
        fragments[f].area *= parts[f].share;
        for (float& area : fragments[f].facing_area) area *= parts[f].share;
    }
    return open;
}

}  // namespace pim
