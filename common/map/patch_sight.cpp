// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/map/patch_sight.h"

#include <algorithm>
#include <bit>
#include <tuple>

namespace pim {
namespace {

constexpr float kShift = 0.01f;  // cells, as SurfaceCells ties what lies on a border

// Across the middle of the cell other cells lie around: of those known, the cell's own layer is left, and
// stands for both. `upper`: that layer is the lower one of the eight.
Unseen of_own_layer(Unseen unseen, int axis, bool upper) {
    Unseen moved = 0;
    for (int k = 0; k < 2 * kCornerCount; ++k) {
        const int known = upper ? k & ~(1 << axis) : k | 1 << axis;
        moved |= Unseen((unseen >> known & 1) << k);
    }
    return moved;
}

}  // namespace

PatchSight::PatchSight(std::size_t patches, std::vector<Entry> entries) {
    if (entries.empty()) return;
    std::ranges::sort(entries, {}, [](const Entry& e) { return std::tuple(e.patch, e.part); });
    patches_.resize(patches);
    for (const Entry& e : entries) {
        Parts& parts = patches_[e.patch];
        if (parts.parts == 0) parts.first = uint32_t(unseen_.size());
        parts.parts |= uint64_t{1} << e.part;
        unseen_.push_back(e.unseen);
    }
}

const Unseen* PatchSight::find(std::size_t patch, int part) const {
    const Parts& own = patches_[patch];
    const uint64_t bit = uint64_t{1} << part;
    if (!(own.parts & bit)) return nullptr;
    return &unseen_[own.first + std::size_t(std::popcount(own.parts & (bit - 1)))];
}

Unseen PatchSight::unseen(std::size_t patch, int part, int facing) const {
    if (sees_all(patch)) return 0;
    if (const Unseen* own = find(patch, part)) return *own;
    const int axis = facing / 2, fine = part >> 2 * axis & (kFinePerCell - 1);
    const int behind = facing % 2 ? 1 : -1;  // the surface was left along its normal, so it lies there
    for (const int step : {behind, -behind}) {
        if (fine + step < 0 || fine + step >= kFinePerCell) continue;
        const Unseen* next = find(patch, part + step * (1 << 2 * axis));
        if (!next) continue;
        const bool upper = fine >= kFinePerCell / 2, next_upper = fine + step >= kFinePerCell / 2;
        return upper == next_upper ? *next : of_own_layer(*next, axis, next_upper);
    }
    return 0;
}

int PatchSight::owner(int patch, int other, int part) const {
    if (sees_all(std::size_t(patch)) || sees_all(std::size_t(other))) return -1;
    const bool one = find(std::size_t(patch), part), two = find(std::size_t(other), part);
    return one == two ? -1 : one ? patch : other;
}

std::vector<PatchSight::Entry> PatchSight::entries() const {
    std::vector<Entry> all;
    for (uint32_t p = 0; p < patches_.size(); ++p)
        for (int part = 0; part < kPartCount; ++part)
            if (const Unseen* u = find(p, part)) all.push_back({p, part, *u});
    return all;
}

Home home_of(const Vec3& place, const Vec3& normal) {
    Home home{0, 0};
    for (int axis = 0; axis < 3; ++axis) {
        const float from_corner =  // positive
            place[axis] + 0.5f + kShift * normal[axis];
        const int upper = from_corner >= 1;
        const int fine = int(from_corner * kFinePerCell) - kFinePerCell * upper;
        // The half of the cell that lies towards the other seven.
        const int half = kFinePerCell / 2, first = upper ? 0 : half;
        home.corner |= upper << axis;
        home.part += std::clamp(fine, first, first + half - 1) << 2 * axis;
    }
    return home;
}

Index3 lowest_around(int part) { return {(part >> 1 & 1) - 1, (part >> 3 & 1) - 1, (part >> 5) - 1}; }

}  // namespace pim
