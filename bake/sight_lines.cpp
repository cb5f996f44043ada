// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/sight_lines.h"

#include <cmath>

#include "bake/places.h"
#include "common/core/parallel.h"

namespace pim {
namespace {

constexpr int kLanes = RayPacket::kSize;
constexpr int kClear =
    4;  // of a packet's segments: fewer of one kind than this decide without another packet
constexpr std::size_t kBlock = 64;

struct PartPlace {
    Vec3 position;  // above the surface
    float area;
    int part;
};

class SightFinder {
  public:
    SightFinder(const Scene& scene, const RayCaster& caster, const Cells& cells,
                const std::vector<Fragment>& fragments)
        : caster_(caster), cells_(cells), places_(cells.patches.size()), all_(cells.patches.size()) {
        std::vector<Vec3> above(fragments.size());
        parallel_for((fragments.size() + kBlock - 1) / kBlock, [&](std::size_t block) {
            for (std::size_t f = block * kBlock; f < std::min(fragments.size(), (block + 1) * kBlock); ++f)
                above[f] = lifted_centre(scene, caster, cells.grid, fragments[f]);
        });
        for (std::size_t f = 0; f < fragments.size(); ++f) add(fragments[f], above[f]);
        for (std::size_t p = 0; p < places_.size(); ++p)
            for (const PartPlace& place : places_[p]) all_[p].add(place.position, place.area);
    }

    PatchSight find() const {
        const std::size_t count = cells_.patches.size(), blocks = (count + kBlock - 1) / kBlock;
        const auto for_each_patch = [&](auto body) {
            parallel_for(blocks, [&](std::size_t block) {
                for (std::size_t p = block * kBlock; p < std::min(count, (block + 1) * kBlock); ++p)
                    body(uint32_t(p), block);
            });
        };
        std::vector<std::vector<PatchSight::Entry>> found(blocks);
        std::vector<SeenAround> seen(count);
        for_each_patch([&](uint32_t p, std::size_t) { seen[p] = seen_of_later(p); });
        for_each_patch([&](uint32_t p, std::size_t block) { look_around(p, seen, found[block]); });
        std::vector<PatchSight::Entry> entries;
        for (const auto& part : found) entries.insert(entries.end(), part.begin(), part.end());
        return {count, std::move(entries)};
    }

  private:
    void add(const Fragment& f, const Vec3& above) {
        const Index3 cell = cell_of(cells_.grid, f.key);
        const auto* own = cells_.index.find_cell(cell);
        if (!own) return;
        const Vec3 from_centre(Vec3d(f.centre) - cells_.grid.centre(cell));
        const int fine = f.key.place / 2;  // z fastest
        const int part = fine >> 4 | (fine >> 2 & 3) << 2 | (fine & 3) << 4;
        for (int k = 0; k < kFacingCount; ++k) {
            const int patch = f.facing_area[k] > 0 ? cells_.patch_at(*own, k, from_centre) : -1;
            if (patch >= 0) places_[std::size_t(patch)].push_back({above, f.facing_area[k], part});
        }
    }

    // Whether a patch sees all, none or some of those of its facing in the 27 cells around.
    enum class Seen : uint8_t { all, none, some };
    using SeenAround = std::array<Seen, 54>;  // cell + 27 · (is behind)

    int patch_around(uint32_t patch, int i) const {
        const Patch& home = cells_.patches[patch];
        const Index3 cell = home.cell + Index3(i % 3 - 1, i / 3 % 3 - 1, i / 9 % 3 - 1);
        return cells_.index.find(cell, home.slot % kFacingCount + (i < 27 ? 0 : kFacingCount));
    }

    // Of those with its own or a higher number: of two patches one looks.
    SeenAround seen_of_later(uint32_t patch) const {
        SeenAround seen;
        seen.fill(Seen::all);
        for (int i = 0; i < 54; ++i) {
            const int other = patch_around(patch, i);
            if (other < int(patch) || all_[patch].empty() || all_[std::size_t(other)].empty()) continue;
            seen[std::size_t(i)] = seen_of(all_[patch], all_[std::size_t(other)]);
        }
        return seen;
    }

    Seen seen_of(const Places& from, const Places& to) const {
        const int free = free_segments(from, to, 0);
        if (free != 0 && free != kLanes) return Seen::some;
        if (free_segments(from, to, 1) != free) return Seen::some;
        return free == 0 ? Seen::none : Seen::all;
    }

    struct Around {
        std::array<int, 54> patch;  // -1: none
        SeenAround seen;
    };
    Around around(uint32_t patch, const std::vector<SeenAround>& of_later) const {
        Around a{{}, of_later[patch]};
        const int own_layer = cells_.patches[patch].slot >= kFacingCount ? 27 : 0;
        for (int i = 0; i < 54; ++i) {
            const int other = a.patch[std::size_t(i)] = patch_around(patch, i);
            if (other >= 0 && other < int(patch))
                a.seen[std::size_t(i)] = of_later[std::size_t(other)][std::size_t(26 - i % 27 + own_layer)];
        }
        return a;
    }

    void look_around(uint32_t patch, const std::vector<SeenAround>& of_later,
                     std::vector<PatchSight::Entry>& found) const {
        const Around others = around(patch, of_later);
        if (std::ranges::all_of(others.seen, [](Seen s) { return s == Seen::all; })) return;
        std::array<Places, kPartCount> parts;
        for (const PartPlace& p : places_[patch]) parts[std::size_t(p.part)].add(p.position, p.area);
        for (int part = 0; part < kPartCount; ++part) {
            const Places& from = parts[std::size_t(part)];
            if (from.empty()) continue;
            const Index3 low = lowest_around(part) + Index3(1);
            Unseen unseen = 0;
            for (int k = 0; k < 2 * kCornerCount; ++k) {
                const int cell = low.x + (k & 1) + 3 * (low.y + (k >> 1 & 1)) + 9 * (low.z + (k >> 2 & 1));
                const auto i = std::size_t(cell + (k < kCornerCount ? 0 : 27));
                const bool hidden =
                    others.seen[i] == Seen::none ||
                    (others.seen[i] == Seen::some && !sees(from, all_[std::size_t(others.patch[i])]));
                unseen |= Unseen(hidden << k);
            }
            found.push_back({patch, part, unseen});
        }
    }

    bool sees(const Places& from, const Places& to) const {
        const RayPacket packet = lines_between(from, to, 0);
        int free = free_of(packet, 0, kLanes / 2);
        if (free == 0 || free == kLanes / 2) return free > 0;
        free += free_of(packet, kLanes / 2, kLanes);
        if (free < kClear || free > kLanes - kClear) return 2 * free >= kLanes;
        free += free_segments(from, to, 1);
        return free >= kLanes;
    }

    // Of kLanes segments.
    int free_segments(const Places& from, const Places& to, int packet_number) const {
        return free_of(lines_between(from, to, packet_number), 0, kLanes);
    }

    int free_of(RayPacket packet, int first, int last) const {
        for (int lane = 0; lane < kLanes; ++lane)
            if (lane < first || lane >= last) packet.length[lane] = -1;
        caster_.occluded(packet);
        int free = 0;
        for (int lane = first; lane < last; ++lane) free += !(packet.length[lane] < 0);
        return free;
    }

    const RayCaster& caster_;
    const Cells& cells_;
    std::vector<std::vector<PartPlace>> places_;  // [patch]
    std::vector<Places> all_;                     // [patch]
};

}  // namespace

PatchSight find_sight(const Scene& scene, const RayCaster& caster, const Cells& cells,
                      const std::vector<Fragment>& fragments) {
    return SightFinder(scene, caster, cells, fragments).find();
}

}  // namespace pim
