// SPDX-License-Identifier: GPL-3.0-or-later
// The surfaces of a scene: one indexed triangle list. Positions are metres, relative to `origin` in world
// space, so that a scene far from the world's origin keeps its precision. "Local" below means relative to
// `origin`.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/core/vector.h"

namespace pim {

struct Triangle {
    std::array<uint32_t, 3> vertices;
    uint32_t material;
    uint32_t object;
};

struct Geometry {
    Vec3d origin{0};              // world space, m
    std::vector<Vec3> positions;  // local, m
    std::vector<Vec3> normals;    // per vertex, unit; zero where the file has none: flat
    std::vector<Vec2> texture_coordinates;
    std::vector<Triangle> triangles;
    std::vector<std::string> objects;  // names

    std::array<Vec3, 3> corners(uint32_t triangle) const {
        const auto& v = triangles[triangle].vertices;
        return {positions[v[0]], positions[v[1]], positions[v[2]]};
    }
    Vec3 to_local(const Vec3d& world) const { return Vec3(world - origin); }
    Vec3d to_world(const Vec3& local) const { return Vec3d(local) + origin; }
};

// Side of a triangle: front is where its corners are seen counter-clockwise.
enum class Side : uint8_t { front, back };

Box3 bounds(const Geometry& geometry);
Vec3 geometric_normal(const std::array<Vec3, 3>& corners);  // unit, towards the front; zero if degenerate
double area(const std::array<Vec3, 3>& corners);            // m²

// Interpolated normal at barycentric weights (1-b1-b2, b1, b2), on the given side of the triangle; the
// geometric normal where the file has none, or where the interpolated one points away from that side. Unit.
Vec3 shading_normal(const Geometry& geometry, uint32_t triangle, Side side, float b1, float b2);

}  // namespace pim
