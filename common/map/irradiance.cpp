// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/map/irradiance.h"

#include <cmath>

namespace pim {
namespace {

// 1 up to a quarter of a cell from the tangent plane, kLeast from three quarters on, smooth between.
float plane_factor(float distance_in_cells) {
    constexpr float kLeast = 1e-4f;
    const float t = std::clamp((0.75f - std::abs(distance_in_cells)) * 2, 0.0f, 1.0f);
    return std::max(kLeast, t * t * (3 - 2 * t));
}

// Of the patches in front and behind, where there are both.
int own_layer(const IlluminationMap& map, int front, int behind, int part, const Vec3& from_centre,
              const Vec3& normal) {
    if (front < 0 || behind < 0) return std::max(front, behind);
    if (const int owner = map.sight.owner(front, behind, part); owner >= 0) return owner;
    const auto distance = [&](int patch) {
        const Vec3 d = map.patches[std::size_t(patch)].centre - from_centre;
        return layer_distance(d, normal);
    };
    return distance(front) <= distance(behind) ? front : behind;
}

}  // namespace

std::array<int, kFacingCount> patches_at(const IlluminationMap& map, const Index3& low, const Vec3& place,
                                         const Vec3& normal, int facings) {
    std::array<int, kFacingCount> own;
    own.fill(-1);
    const Home home = home_of(place, normal);
    const Index3 step = home.step();
    const auto* patches = map.index.find_cell(low + step);
    if (!patches) return own;
    const Vec3 from_centre = (place - Vec3(step)) * float(map.grid.cell_size);
    for (std::size_t k = 0; k < kFacingCount; ++k)
        if (facings >> k & 1)
            own[k] =
                own_layer(map, (*patches)[k], (*patches)[k + kFacingCount], home.part, from_centre, normal);
    return own;
}

std::array<Unseen, kFacingCount> unseen_from(const IlluminationMap& map, const Index3& low, const Vec3& place,
                                             const Vec3& normal, int facings) {
    std::array<Unseen, kFacingCount> unseen{};
    if (map.sight.sees_all()) return unseen;
    const auto own = patches_at(map, low, place, normal, facings);
    const int part = home_of(place, normal).part;
    for (std::size_t k = 0; k < kFacingCount; ++k)
        if (own[k] >= 0) unseen[k] = map.sight.unseen(std::size_t(own[k]), part, int(k));
    return unseen;
}

void look_up(const IlluminationMap& map, const Vec3& position, const Vec3& normal,
             std::vector<PatchShare>& shares) {
    const FacingWeights facing = facing_weights(map.grid, normal);
    const Vec3d place = (Vec3d(position) - map.grid.origin) / map.grid.cell_size - Vec3d(0.5);
    const Index3 low(int(std::floor(place.x)), int(std::floor(place.y)), int(std::floor(place.z)));
    const Vec3 f(place - Vec3d(low));
    shares.clear();
    std::array<float, kFacingCount> area{};
    int facings = 0;
    for (int k = 0; k < kFacingCount; ++k) facings |= int(facing.weight[k] > 0) << k;
    const std::array<Unseen, kFacingCount> unseen = unseen_from(map, low, f, normal, facings);
    for (int corner = 0; corner < 8; ++corner) {
        const Index3 step(corner & 1, corner >> 1 & 1, corner >> 2);
        const auto* patches = map.index.find_cell(low + step);
        if (!patches) continue;
        const Vec3 from_centre = (f - Vec3(step)) * float(map.grid.cell_size);
        const float t = (step.x ? f.x : 1 - f.x) * (step.y ? f.y : 1 - f.y) * (step.z ? f.z : 1 - f.z);
        for (int k = 0; k < kFacingCount; ++k) {
            if (!(facing.weight[k] > 0)) continue;
            const int front = (*patches)[k], behind = (*patches)[k + kFacingCount];
            if (front < 0 && behind < 0) continue;
            const auto distance = [&](int patch) {
                return normal.dot(map.patches[patch].centre - from_centre) / float(map.grid.cell_size);
            };
            const auto add = [&](int patch, float share) {
                float weight = t * share * map.patches[patch].area * plane_factor(distance(patch));
                if (unseen[k] >> (corner + (patch == front ? 0 : kCornerCount)) & 1) weight *= kUnseenFactor;
                area[k] += weight;
                shares.push_back({uint32_t(patch), k, weight});
            };
            if (front < 0 || behind < 0) {
                add(std::max(front, behind), 1);
                continue;
            }
            // Of two layers the nearer counts: shares by the squared distances from the tangent plane.
            const float a = distance(front) * distance(front) + 1e-6f,
                        b = distance(behind) * distance(behind) + 1e-6f;
            add(front, b / (a + b));
            add(behind, a / (a + b));
        }
    }
    float weights = 0;
    for (int k = 0; k < kFacingCount; ++k)
        if (area[k] > 0) weights += facing.weight[k];
    for (PatchShare& share : shares)
        share.weight = area[share.facing] > 0
                           ? share.weight / area[share.facing] * facing.weight[share.facing] / weights
                           : 0;
}

Rgb irradiance_at(const IlluminationMap& map, const std::vector<Rgb>& values, const Vec3& position,
                  const Vec3& normal) {
    thread_local std::vector<PatchShare> shares;
    look_up(map, position, normal, shares);
    Rgb sum(0);
    for (const PatchShare& share : shares) sum += values[share.patch] * share.weight;
    return sum;
}

}  // namespace pim
