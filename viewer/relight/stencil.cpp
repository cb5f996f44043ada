// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/relight/stencil.h"

#include <cmath>

#include "common/map/irradiance.h"

namespace pim {

static_assert(kUnseenWeight == kUnseenFactor);

Stencil::Stencil(const IlluminationMap& map, const Index3& low, int mask) : low_(low), mask_(mask) {
    for (int k = 0; k < kFacingCount; ++k) {
        if (!(mask >> k & 1)) continue;
        const std::size_t before = entries_.size();
        for (int corner = 0; corner < kCornerCount; ++corner) add_cell(map, corner, k);
        if (entries_.size() > before) entries_.back().ends_facing = true;
    }
}

void Stencil::add_cell(const IlluminationMap& map, int corner, int facing) {
    const Index3 step(corner & 1, corner >> 1 & 1, corner >> 2);
    const auto* patches = map.index.find_cell(low_ + step);
    if (!patches) return;
    const int front = (*patches)[facing], behind = (*patches)[facing + kFacingCount];
    if (front >= 0) add(map, front, step, facing, behind >= 0, corner);
    if (behind >= 0) add(map, behind, step, facing, false, corner + kCornerCount);
    if (front >= 0 && behind >= 0) layered_ |= uint8_t(1 << corner);
}

void Stencil::add(const IlluminationMap& map, int patch, const Index3& step, int facing, bool is_paired,
                  int bit) {
    const Patch& p = map.patches[std::size_t(patch)];
    sees_all_ = sees_all_ && map.sight.sees_all(std::size_t(patch));
    const Vec3 centre = p.centre / float(map.grid.cell_size) + Vec3(step);
    entries_.push_back({{float(step.x), float(step.y), float(step.z)},
                        {centre.x, centre.y, centre.z},
                        p.area,
                        map.grid.facings ? facing / 2 : -1,
                        false,
                        is_paired,
                        bit});
    patches_.push_back(uint32_t(patch));
}

UnseenByAxis Stencil::unseen_at(const IlluminationMap& map, int home, const Vec3& place, const Vec3& normal) {
    if (const UnseenByAxis* known = known_unseen(home)) return *known;
    if (layered_ >> (home % kCornerCount) & 1) return layers_of(map, home).at(place, normal);
    const auto by_facing = unseen_from(map, low_, place, normal, mask_);
    UnseenByAxis unseen{};
    for (std::size_t k = 0; k < kFacingCount; ++k) unseen[k / 2] |= by_facing[k];
    unseen_.resize(kCornerCount * kCornerCount);
    unseen_[std::size_t(home)] = unseen;
    known_ |= uint64_t{1} << home;
    return unseen;
}

const Stencil::LayeredSight& Stencil::layers_of(const IlluminationMap& map, int home) {
    const auto known = std::ranges::find(layers_, home, [](const auto& l) { return l.first; });
    if (known != layers_.end()) return known->second;
    const Index3 step(home & 1, home >> 1 & 1, home >> 2 & 1);
    int part = 0;  // the half of the cell towards the other seven, and which of its two fine cells
    for (int axis = 0; axis < 3; ++axis)
        part |= ((step[axis] ? 0 : kFinePerCell / 2) + (home >> (3 + axis) & 1)) << 2 * axis;
    const auto* patches = map.index.find_cell(low_ + step);
    LayeredSight sight;
    for (int k = 0; k < kFacingCount && patches; ++k) {
        if (!(mask_ >> k & 1)) continue;
        const auto axis = std::size_t(k / 2);
        std::size_t layers = 0;
        const int front = (*patches)[std::size_t(k)], behind = (*patches)[std::size_t(k + kFacingCount)];
        const int owner = front >= 0 && behind >= 0 ? map.sight.owner(front, behind, part) : -1;
        for (const int patch : {front, behind}) {
            if (patch < 0 || (owner >= 0 && patch != owner)) continue;
            sight.unseen[axis][layers] = map.sight.unseen(std::size_t(patch), part, k);
            sight.centre[axis][layers++] =
                map.patches[std::size_t(patch)].centre / float(map.grid.cell_size) + Vec3(step);
        }
        if (layers == 2) sight.two |= uint8_t(1 << axis);
    }
    return layers_.emplace_back(home, sight).second;
}

UnseenByAxis Stencil::LayeredSight::at(const Vec3& place, const Vec3& normal) const {
    UnseenByAxis nearer{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto distance = [&](std::size_t layer) {
            return layer_distance(centre[axis][layer] - place, normal);
        };
        const bool behind = (two >> axis & 1) && distance(1) < distance(0);
        nearer[axis] = unseen[axis][behind];
    }
    return nearer;
}

}  // namespace pim
