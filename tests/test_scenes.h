// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes built in memory, small enough that their light is known.
#pragma once

#include <cmath>
#include <map>
#include <utility>

#include "common/scene/scene.h"
#include "common/transport/photon.h"
#include "common/transport/ray_caster.h"
#include "common/transport/surface.h"

namespace pim {

inline Material diffuse_material(const Rgb& albedo) {
    Material m;
    m.name = "diffuse";
    m.diffuse = albedo;
    return m;
}

inline Material mirror_material(const Rgb& reflectance) {
    Material m;
    m.name = "mirror";
    m.diffuse = Rgb(0);
    m.specular = reflectance;
    return m;
}

inline Material glass_material(float ior) {
    Material m;
    m.name = "glass";
    m.glass = true;
    m.ior = ior;
    return m;
}

// No surface yet; material 0 is diffuse.
inline Scene empty_scene(const Rgb& albedo = Rgb(0.5f)) {
    Scene scene;
    scene.description_file = "test.toml";
    scene.materials.push_back(diffuse_material(albedo));
    scene.geometry.objects.push_back("object");
    return scene;
}

inline uint32_t add_vertex(Scene& scene, const Vec3& position, const Vec3& normal = Vec3(0)) {
    scene.geometry.positions.push_back(position);
    scene.geometry.normals.push_back(normal);
    scene.geometry.texture_coordinates.push_back(Vec2(0));
    return uint32_t(scene.geometry.positions.size() - 1);
}

inline void add_triangle(Scene& scene, const Vec3& a, const Vec3& b, const Vec3& c, uint32_t material = 0) {
    const uint32_t first = add_vertex(scene, a);
    add_vertex(scene, b);
    add_vertex(scene, c);
    scene.geometry.triangles.push_back(
        {{first, first + 1, first + 2}, material, uint32_t(scene.geometry.objects.size() - 1)});
}

// Parallelogram; its front looks along edge1 × edge2.
inline void add_quad(Scene& scene, const Vec3& corner, const Vec3& edge1, const Vec3& edge2,
                     uint32_t material = 0) {
    add_triangle(scene, corner, corner + edge1, corner + edge1 + edge2, material);
    add_triangle(scene, corner, corner + edge1 + edge2, corner + edge2, material);
}

// Six walls whose fronts look inwards (a room) or outwards (a solid).
inline void add_box(Scene& scene, const Vec3& low, const Vec3& high, bool inwards, uint32_t material = 0) {
    const Vec3 d = high - low, x(d.x, 0, 0), y(0, d.y, 0), z(0, 0, d.z);
    const auto wall = [&](const Vec3& corner, const Vec3& a, const Vec3& b) {
        inwards ? add_quad(scene, corner, a, b, material) : add_quad(scene, corner, b, a, material);
    };
    wall(low, y, z), wall(low, z, x), wall(low, x, y);
    wall(high, -z, -y), wall(high, -x, -z), wall(high, -y, -x);
}

// Icosahedron with its triangles split in four so many times, corners on the sphere.
inline void add_sphere(Scene& scene, const Vec3& centre, float radius, int subdivisions, bool inwards,
                       bool smooth, uint32_t material = 0) {
    const double g = 0.5 * (1 + std::sqrt(5.0));
    std::vector<Vec3d> points = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                                 {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
    for (Vec3d& p : points) p.normalize();
    std::vector<std::array<uint32_t, 3>> faces = {
        {0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
        {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
        {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
    for (int level = 0; level < subdivisions; ++level) {
        std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
        const auto middle = [&](uint32_t a, uint32_t b) {
            const auto [known, is_new] = middles.try_emplace(std::minmax(a, b), uint32_t(points.size()));
            if (is_new) points.push_back((points[a] + points[b]).normalized());
            return known->second;
        };
        std::vector<std::array<uint32_t, 3>> finer;
        for (const auto& [a, b, c] : faces) {
            const uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
        }
        faces = std::move(finer);
    }
    const auto first = uint32_t(scene.geometry.positions.size());
    for (const Vec3d& p : points)
        add_vertex(scene, centre + Vec3(p * double(radius)), smooth ? Vec3(inwards ? -p : p) : Vec3(0));
    for (auto [a, b, c] : faces) {
        if (inwards) std::swap(b, c);
        scene.geometry.triangles.push_back(
            {{first + a, first + b, first + c}, material, uint32_t(scene.geometry.objects.size() - 1)});
    }
}

inline Light point_lamp(const Vec3& position, const Rgb& power = Rgb(1)) {
    Light light;
    light.name = "lamp";
    light.power = power;
    light.position = position;
    light.domain = Box3(position);
    light.samples = 1;
    return light;
}

inline Light rectangle_lamp(const Vec3& position, const Vec2& size, const Vec3& normal,
                            const Rgb& power = Rgb(1)) {
    Light light = point_lamp(position, power);
    light.shape = RectangleShape(size, normal);
    return light;
}

// A closed room of one albedo, [0,1]³ × size, a lamp in it.
inline Scene room(const Rgb& albedo, const Vec3& size = Vec3(1), const Vec3& lamp = Vec3(0.4f, 0.6f, 0.3f)) {
    Scene scene = empty_scene(albedo);
    add_box(scene, Vec3(0), size, true);
    scene.lights.push_back(point_lamp(lamp * size));
    return scene;
}

// A horizontal square of that side about the origin, its front up, under a point lamp.
inline Scene plane_under_lamp(float side, float height, const Rgb& albedo = Rgb(0.5f)) {
    Scene scene = empty_scene(albedo);
    add_quad(scene, {-side / 2, 0, -side / 2}, {0, 0, side}, {side, 0, 0});
    scene.lights.push_back(point_lamp({0, height, 0}));
    return scene;
}

inline double total_area(const Geometry& geometry) {
    double sum = 0;
    for (uint32_t t = 0; t < geometry.triangles.size(); ++t) sum += area(geometry.corners(t));
    return sum;
}

// Photons of the scene's first lamp, one after the other. `each(landing)` sees every landing; `done()`
// follows each photon.
template <class Each, class Done>
EnergyAccount shoot(const Scene& scene, uint64_t photons, Each each, Done done, uint64_t seed = 1) {
    const RayCaster caster(scene.geometry, InstructionSet::pinned);
    EnergyAccount account;
    for (uint64_t i = 0; i < photons; ++i) {
        RandomStream random(seed, RandomPurpose::photons, 0, i);
        trace_photon(scene, caster, scene.lights[0], scene.lights[0].position, random, each, account);
        done();
    }
    return account;
}

// The surface that a ray meets; it must meet one.
inline SurfacePoint surface_seen(const Scene& scene, const RayCaster& caster, const Vec3& from,
                                 const Vec3& towards) {
    return surface_at(scene, caster.intersect({from, (towards - from).normalized()}).value());
}

}  // namespace pim
