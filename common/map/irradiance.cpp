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

}  // namespace

Rgb irradiance_at(const IlluminationMap& map, const std::vector<Rgb>& values, const Vec3& position,
                  const Vec3& normal) {
    const FacingWeights facing = facing_weights(map.grid, normal);
    const Vec3d place = (Vec3d(position) - map.grid.origin) / map.grid.cell_size - Vec3d(0.5);
    const Index3 low(int(std::floor(place.x)), int(std::floor(place.y)), int(std::floor(place.z)));
    const Vec3 f(place - Vec3d(low));
    std::array<Rgb, kFacingCount> flux;
    flux.fill(Rgb(0));
    std::array<float, kFacingCount> area{};
    for (int corner = 0; corner < 8; ++corner) {
        const Index3 step(corner & 1, corner >> 1 & 1, corner >> 2);
        const auto* patches = map.index.find_cell(low + step);
        if (!patches) continue;
        const Vec3 from_centre(Vec3d(position) - map.grid.centre(low + step));
        const float t = (step.x ? f.x : 1 - f.x) * (step.y ? f.y : 1 - f.y) * (step.z ? f.z : 1 - f.z);
        for (int k = 0; k < kFacingCount; ++k) {
            if (!(facing.weight[k] > 0)) continue;
            const int front = (*patches)[k], behind = (*patches)[k + kFacingCount];
            if (front < 0 && behind < 0) continue;
            const auto distance = [&](int patch) {
                return normal.dot(map.patches[patch].centre - from_centre) / float(map.grid.cell_size);
            };
            const auto add = [&](int patch, float share) {
                const float weighted = t * share * map.patches[patch].area * plane_factor(distance(patch));
                area[k] += weighted;
                flux[k] += values[patch] * weighted;
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
    Rgb sum(0);
    float weights = 0;
    for (int k = 0; k < kFacingCount; ++k) {
        if (!(area[k] > 0)) continue;
        sum += flux[k] / area[k] * facing.weight[k];
        weights += facing.weight[k];
    }
    return weights > 0 ? sum / weights : Rgb(0);
}

}  // namespace pim
