// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/geometry_check.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/intersections.h>
#include <fmt/format.h>

#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "common/core/float_traps.h"

namespace pim {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Mesh = CGAL::Surface_mesh<Point>;
using Inside = CGAL::Side_of_triangle_mesh<Mesh, Kernel>;
namespace pmp = CGAL::Polygon_mesh_processing;

Point to_point(const Vec3& p) { return {p.x, p.y, p.z}; }
bool finite(const Vec3& p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }
std::array<float, 3> key(const Vec3& p) { return {p.x + 0.0f, p.y + 0.0f, p.z + 0.0f}; }  // -0 becomes 0

std::size_t drop_unreferenced(Geometry& g) {
    std::vector<uint32_t> new_index(g.positions.size(), 0);
    for (const Triangle& t : g.triangles)
        for (const uint32_t v : t.vertices) new_index[v] = 1;
    uint32_t kept = 0;
    for (std::size_t v = 0; v < new_index.size(); ++v) {
        if (!new_index[v]) continue;
        g.positions[kept] = g.positions[v];
        g.normals[kept] = g.normals[v];
        g.texture_coordinates[kept] = g.texture_coordinates[v];
        new_index[v] = kept++;
    }
    const std::size_t dropped = g.positions.size() - kept;
    g.positions.resize(kept);
    g.normals.resize(kept);
    g.texture_coordinates.resize(kept);
    for (Triangle& t : g.triangles)
        for (uint32_t& v : t.vertices) v = new_index[v];
    return dropped;
}

// Triangles that touch through shared corner positions, whatever their vertex indices.
std::vector<std::vector<uint32_t>> components(const Geometry& g) {
    std::map<std::array<float, 3>, uint32_t> first_at;
    std::vector<uint32_t> parent(g.triangles.size());
    std::iota(parent.begin(), parent.end(), 0u);
    const auto root = [&](uint32_t t) {
        while (parent[t] != t) t = parent[t] = parent[parent[t]];
        return t;
    };
    for (uint32_t t = 0; t < g.triangles.size(); ++t)
        for (const Vec3& corner : g.corners(t)) {
            const auto [known, is_new] = first_at.try_emplace(key(corner), t);
            if (!is_new) parent[root(t)] = root(known->second);
        }
    std::map<uint32_t, std::vector<uint32_t>> by_root;
    for (uint32_t t = 0; t < g.triangles.size(); ++t) by_root[root(t)].push_back(t);
    std::vector<std::vector<uint32_t>> all;
    for (auto& [_, triangles] : by_root) all.push_back(std::move(triangles));
    return all;
}

Mesh to_mesh(const Geometry& g, const std::vector<uint32_t>& triangles) {
    std::vector<Point> points;
    std::vector<std::array<std::size_t, 3>> faces;
    std::map<std::array<float, 3>, std::size_t> index;
    for (const uint32_t t : triangles) {
        std::array<std::size_t, 3> face;
        const auto corners = g.corners(t);
        for (int i = 0; i < 3; ++i) {
            const auto [known, is_new] = index.try_emplace(key(corners[i]), points.size());
            if (is_new) points.push_back(to_point(corners[i]));
            face[i] = known->second;
        }
        faces.push_back(face);
    }
    Mesh mesh;
    if (pmp::orient_polygon_soup(points, faces)) pmp::polygon_soup_to_polygon_mesh(points, faces, mesh);
    return mesh;
}

}  // namespace

std::string Mended::text() const {
    std::string text;
    const auto add = [&](std::size_t count, const char* what) {
        if (count) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, what);
    };
    add(non_finite, "triangles with a vertex that is no number");
    add(degenerate, "triangles without area");
    add(duplicate, "duplicate triangles");
    add(unreferenced, "unreferenced vertices");
    return text.empty() ? text : "removed " + text;
}

Mended mend(Geometry& g) {
    Mended mended;
    std::set<std::array<std::array<float, 3>, 3>> seen;
    std::vector<Triangle> kept;
    for (uint32_t t = 0; t < g.triangles.size(); ++t) {
        const auto corners = g.corners(t);
        if (!finite(corners[0]) || !finite(corners[1]) || !finite(corners[2])) {
            ++mended.non_finite;
            continue;
        }
        if (CGAL::collinear(to_point(corners[0]), to_point(corners[1]), to_point(corners[2])) ||
            !(area(corners) > 0)) {
            ++mended.degenerate;
            continue;
        }
        std::array<std::array<float, 3>, 3> corner_keys{key(corners[0]), key(corners[1]), key(corners[2])};
        std::ranges::sort(corner_keys);
        if (!seen.insert(corner_keys).second) {
            ++mended.duplicate;
            continue;
        }
        kept.push_back(g.triangles[t]);
    }
    g.triangles = std::move(kept);
    mended.unreferenced = drop_unreferenced(g);
    return mended;
}

struct Solids::Implementation {
    struct Solid {
        Mesh mesh;
        Box3 box;
        std::string name;
        std::unique_ptr<Inside> inside;  // refers to `mesh`

        bool contains(const Vec3& p) const {
            return box.intersects(p) && (*inside)(to_point(p)) == CGAL::ON_BOUNDED_SIDE;
        }
    };
    std::vector<std::unique_ptr<Solid>> solids;
    std::vector<Box3> boxes;  // of the solids: a scene may have thousands, and hardly any holds a point
};

Solids::Solids(const Geometry& g, const std::vector<Vec3>& rooms_seen_from)
    : implementation_(std::make_unique<Implementation>()) {
    const auto all = components(g);
    std::vector<Vec3> one_point_of_each;
    for (const auto& triangles : all) one_point_of_each.push_back(g.corners(triangles[0])[0]);
    for (std::size_t i = 0; i < all.size(); ++i) {
        auto solid = std::make_unique<Implementation::Solid>();
        solid->mesh = to_mesh(g, all[i]);
        if (solid->mesh.is_empty() || !CGAL::is_closed(solid->mesh)) continue;
        for (const uint32_t t : all[i])
            for (const Vec3& corner : g.corners(t)) solid->box.extendBy(corner);
        solid->name = g.objects[g.triangles[all[i][0]].object];
        if (solid->name.empty()) solid->name = "unnamed";
        solid->inside = std::make_unique<Inside>(solid->mesh);
        const auto inside = [&](const Vec3& p) { return solid->contains(p); };
        if (std::ranges::any_of(rooms_seen_from, inside) || std::ranges::any_of(one_point_of_each, inside))
            continue;
        implementation_->boxes.push_back(solid->box);
        implementation_->solids.push_back(std::move(solid));
    }
}

Solids::~Solids() = default;

std::string Solids::containing(const Vec3& point) const {
    for (std::size_t i = 0; i < implementation_->boxes.size(); ++i) {
        if (!implementation_->boxes[i].intersects(point)) continue;
        const FloatTraps library(FloatTraps::off);
        const auto& solid = *implementation_->solids[i];
        if (solid.contains(point)) return solid.name;
    }
    return {};
}

std::vector<std::string> Solids::names() const {
    std::vector<std::string> names;
    for (const auto& solid : implementation_->solids) names.push_back(solid->name);
    return names;
}

bool triangle_meets_box(const std::array<Vec3, 3>& c, const Box3d& box) {
    const FloatTraps library(FloatTraps::off);
    const Kernel::Triangle_3 triangle(to_point(c[0]), to_point(c[1]), to_point(c[2]));
    return CGAL::do_intersect(triangle,
                              CGAL::Bbox_3(box.min.x, box.min.y, box.min.z, box.max.x, box.max.y, box.max.z));
}

}  // namespace pim
