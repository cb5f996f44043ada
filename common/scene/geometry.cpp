// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/geometry.h"

namespace pim {

Box3 bounds(const Geometry& geometry) {
    Box3 box;
    for (const Triangle& t : geometry.triangles)
        for (const uint32_t v : t.vertices) box.extendBy(geometry.positions[v]);
    return box;
}

Vec3 geometric_normal(const std::array<Vec3, 3>& corners) {
    const Vec3d e1 = Vec3d(corners[1]) - Vec3d(corners[0]), e2 = Vec3d(corners[2]) - Vec3d(corners[0]);
    return Vec3(e1.cross(e2).normalized());
}

double area(const std::array<Vec3, 3>& corners) {
    const Vec3d e1 = Vec3d(corners[1]) - Vec3d(corners[0]), e2 = Vec3d(corners[2]) - Vec3d(corners[0]);
    return 0.5 * e1.cross(e2).length();
}

Vec3 shading_normal(const Geometry& geometry, uint32_t triangle, Side side, float b1, float b2) {
    const float sign = side == Side::front ? 1.0f : -1.0f;
    const Vec3 flat = geometric_normal(geometry.corners(triangle)) * sign;
    const auto& v = geometry.triangles[triangle].vertices;
    const Vec3& n0 = geometry.normals[v[0]];
    if (n0 == Vec3(0)) return flat;
    const Vec3 smooth =
        (n0 * (1 - b1 - b2) + geometry.normals[v[1]] * b1 + geometry.normals[v[2]] * b2) * sign;
    const float length = smooth.length();
    if (!(length > 0)) return flat;
    const Vec3 n = smooth / length;
    return n.dot(flat) > 0 ? n : (n.dot(flat) < 0 ? -n : flat);
}

}  // namespace pim
