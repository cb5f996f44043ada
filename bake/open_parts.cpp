// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/open_parts.h"

#include <algorithm>
#include <numeric>
#include <span>

#include "bake/places.h"
#include "common/core/parallel.h"

namespace pim {
namespace {

constexpr float kLift = 0.002f;  // cells
constexpr int kPackets = 4;
constexpr int kWitnesses = 8;
constexpr int kSpreads = 3;  // times that open places vouch for others

class Opening {
  public:
    Opening(const Scene& scene, const RayCaster& caster, const CellGrid& grid, const Fragment& fragment)
        : plane(scene.geometry, fragment), scene_(scene), caster_(caster) {
        const float height = std::max(kLift * float(grid.cell_size), 4 * caster.surface_offset());
        lift_ = plane.normal() * (fragment.key.place % 2 ? -height : height);
    }

    const FragmentPlane plane;

    // Marks those that see one of the witnesses, then those that see one of these.
    std::vector<bool> open(const std::vector<Vec3>& places, std::span<const Vec3> witnesses) const {
        std::vector<bool> open(places.size(), false);
        for (const Vec3& witness : witnesses) look(places, open, [&](std::size_t) { return &witness; });
        for (int spread = 0; spread < kSpreads; ++spread) {
            const std::vector<bool> before = open;
            look(places, open, [&](std::size_t i) { return nearest(places, before, places[i]); });
            if (open == before) break;
        }
        return open;
    }

  private:
    template <class WitnessOf>
    void look(const std::vector<Vec3>& places, std::vector<bool>& open, WitnessOf witness_of) const {
        HitPacket packet;
        bool any = false;
        for (std::size_t i = 0; i < places.size(); ++i) {
            const Vec3* witness = open[i] ? nullptr : witness_of(i);
            if (!witness) continue;
            packet.rays.set(int(i), places[i] + lift_, *witness - places[i], 1);
            any = true;
        }
        if (!any) return;
        const RayPacket looked = packet.rays;
        caster_.intersect(packet);
        for (std::size_t i = 0; i < places.size(); ++i)
            if (!(looked.length[i] < 0) && !is_blocked(packet, int(i))) open[i] = true;
    }

    bool is_blocked(const HitPacket& packet, int lane) const {
        if (!packet.is_hit(lane)) return false;
        const Triangle& hit = scene_.geometry.triangles[packet.triangle[lane]];
        return !scene_.materials[hit.material].glass;
    }

    static const Vec3* nearest(const std::vector<Vec3>& places, const std::vector<bool>& open,
                               const Vec3& to) {
        const Vec3* found = nullptr;
        for (std::size_t i = 0; i < places.size(); ++i)
            if (open[i] && (!found || (places[i] - to).length2() < (*found - to).length2()))
                found = &places[i];
        return found;
    }

    const Scene& scene_;
    const RayCaster& caster_;
    Vec3 lift_;
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
    for (int packet = 0; packet < kPackets; ++packet) {
        const std::vector<Vec3> places = opening.plane.places(packet);
        const std::vector<bool> open = opening.open(places, witnesses);
        for (std::size_t i = 0; i < places.size(); ++i)
            if (open[i]) part.places.push_back(places[i]);
        all += places.size();
        if (packet == 0 && part.places.size() == all) return {};  // also where no place was found
    }
    part.share = float(part.places.size()) / float(all);
    return part;
}

}  // namespace

std::vector<std::vector<Vec3>> keep_open_parts(const Scene& scene, const RayCaster& caster,
                                               const CellGrid& grid, std::vector<Fragment>& fragments,
                                               Reach& reach) {
    std::vector<OpenPart> parts(fragments.size());
    constexpr std::size_t kBlock = 1024;
    parallel_for((fragments.size() + kBlock - 1) / kBlock, [&](std::size_t block) {
        for (std::size_t f = block * kBlock; f < std::min(fragments.size(), (block + 1) * kBlock); ++f) {
            if (reach.dark[f]) continue;
            const Opening opening(scene, caster, grid, fragments[f]);
            if (opening.plane.is_degenerate()) continue;
            std::vector<Vec3> witnesses = witnesses_of(f, fragments, reach);
            for (Vec3& w : witnesses) w = opening.plane.flat(w);
            if (!witnesses.empty()) parts[f] = open_part(opening, witnesses);
        }
    });
    std::vector<std::vector<Vec3>> open(fragments.size());
    for (std::size_t f = 0; f < fragments.size(); ++f) {
        if (parts[f].share == 1) continue;
        if (parts[f].share == 0) {  // but for a sliver, if it was hit
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
