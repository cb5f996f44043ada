// SPDX-License-Identifier: GPL-3.0-or-later
// Irradiance at a point of a surface from the patches around it.
#pragma once

#include "common/map/illumination_map.h"

namespace pim {

inline constexpr float kUnseenFactor = 4e-3f;  // of the weight of a patch that the place does not see

struct PatchShare {
    uint32_t patch;
    int facing;
    float weight;
};

// Which patches make the irradiance at a point, and how much of each: around `position` (local) stand eight
// cell centres; for each facing f of `normal`,
//     E_f = sum_i t_i A_i g_i E_i / sum_i t_i A_i g_i,
// t_i the trilinear weight of cell i, A_i the area of its patch of facing f, and g_i a factor that falls from
// 1 to nearly 0 as the patch's centroid lies farther in front of or behind the tangent plane: surfaces one
// behind the other do not mix; of two layers in one cell the nearer counts. Then E = sum_f w_f E_f / sum_f
// w_f over the facings that exist here, w_f from facing_weights(normal). Cells without surface never count;
// no shares if all of the eight are such. Else the weights add to 1.
void look_up(const IlluminationMap& map, const Vec3& position, const Vec3& normal,
             std::vector<PatchShare>& shares);

// Orders the two patches of a cell and facing by how near a place's tangent plane and then the place itself
// lies to their centroids. `to_centroid`: from the place.
inline float layer_distance(const Vec3& to_centroid, const Vec3& normal) {
    const float off_plane = normal.dot(to_centroid);
    return off_plane * off_plane + 0.01f * to_centroid.length2();
}

// The patches that a place itself lies on, by facing, and what it does not see of those around it. `low`,
// `place`: the lowest of the eight cells around it, and where it stands from that one's centre, in cells;
// `facings`: a bit for each that counts there, others are -1 or see all. Of two layers the one whose surface
// the place's part of the cell holds, or else the nearer.
std::array<int, kFacingCount> patches_at(const IlluminationMap& map, const Index3& low, const Vec3& place,
                                         const Vec3& normal, int facings);
std::array<Unseen, kFacingCount> unseen_from(const IlluminationMap& map, const Index3& low, const Vec3& place,
                                             const Vec3& normal, int facings);

// The shares' sum; `values` holds one colour per patch.
Rgb irradiance_at(const IlluminationMap& map, const std::vector<Rgb>& values, const Vec3& position,
                  const Vec3& normal);

}  // namespace pim
