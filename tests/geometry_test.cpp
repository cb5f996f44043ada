// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/geometry.h"

#include "statistics.h"
#include "test_scenes.h"

namespace pim {
namespace {

constexpr float kRounding = 1e-6f;  // some ten float roundings of unit vectors

TEST(Area, OfKnownTriangles) {
    EXPECT_DOUBLE_EQ(area({Vec3(0), Vec3(3, 0, 0), Vec3(0, 4, 0)}), 6);
    EXPECT_DOUBLE_EQ(area({Vec3(1), Vec3(1), Vec3(2)}), 0);
    const float s = 1e-10f;  // products of tiny edges do not vanish
    EXPECT_NEAR(area({Vec3(0), Vec3(s, 0, 0), Vec3(0, s, 0)}) / (0.5 * double(s) * s), 1, 1e-12);
}

TEST(GeometricNormal, LooksWhereCornersTurnCounterClockwise) {
    EXPECT_EQ(geometric_normal({Vec3(0), Vec3(1, 0, 0), Vec3(0, 1, 0)}), Vec3(0, 0, 1));
    EXPECT_EQ(geometric_normal({Vec3(0), Vec3(0, 1, 0), Vec3(1, 0, 0)}), Vec3(0, 0, -1));
    EXPECT_EQ(geometric_normal({Vec3(0), Vec3(1), Vec3(2)}), Vec3(0));
    // A sliver far from the origin: edges are subtracted in double.
    const Vec3 n = geometric_normal({Vec3(100, 0, 0), Vec3(101, 0, 0), Vec3(100, 1e-5f, 0)});
    EXPECT_NEAR(n.z, 1, kRounding);
}

TEST(Bounds, OfTrianglesOnly) {
    Scene scene = plane_under_lamp(2, 1);
    add_vertex(scene, Vec3(100));  // of no triangle
    EXPECT_EQ(bounds(scene.geometry).min, Vec3(-1, 0, -1));
    EXPECT_EQ(bounds(scene.geometry).max, Vec3(1, 0, 1));
}

TEST(Origin, LocalAndWorldAreInverse) {
    Geometry g;
    g.origin = {1e6, -2e6, 3e6};
    const Vec3d world(1e6 + 0.125, -2e6 + 0.25, 3e6);
    EXPECT_EQ(g.to_local(world), Vec3(0.125f, 0.25f, 0));
    EXPECT_EQ(g.to_world(g.to_local(world)), world);
}

Scene sphere_scene(bool smooth) {
    Scene scene = empty_scene();
    add_sphere(scene, Vec3(0), 1, 2, false, smooth);
    return scene;
}

TEST(ShadingNormal, FlatWhereTheFileHasNone) {
    const Scene scene = sphere_scene(false);
    for (uint32_t t = 0; t < scene.geometry.triangles.size(); ++t) {
        const Vec3 flat = geometric_normal(scene.geometry.corners(t));
        EXPECT_EQ(shading_normal(scene.geometry, t, Side::front, 0.2f, 0.3f), flat);
        EXPECT_EQ(shading_normal(scene.geometry, t, Side::back, 0.2f, 0.3f), -flat);
    }
}

TEST(ShadingNormal, InterpolatesBetweenCorners) {
    const Geometry g = sphere_scene(true).geometry;
    for (uint32_t t = 0; t < g.triangles.size(); ++t) {
        const auto c = g.corners(t);
        EXPECT_NEAR((shading_normal(g, t, Side::front, 0, 0) - c[0]).length(), 0, kRounding);
        EXPECT_NEAR((shading_normal(g, t, Side::front, 1, 0) - c[1]).length(), 0, kRounding);
        EXPECT_NEAR((shading_normal(g, t, Side::back, 0, 1) + c[2]).length(), 0, kRounding);
        const Vec3 middle = ((c[0] + c[1] + c[2]) / 3).normalized();
        EXPECT_NEAR((shading_normal(g, t, Side::front, 1 / 3.0f, 1 / 3.0f) - middle).length(), 0, kRounding);
    }
}

TEST(ShadingNormal, StaysOnTheSideThatTheRayMet) {
    Scene scene = plane_under_lamp(2, 1);
    for (Vec3& n : scene.geometry.normals) n = Vec3(0.6f, -0.8f, 0);  // against the winding
    EXPECT_GT(shading_normal(scene.geometry, 0, Side::front, 0.2f, 0.2f).y, 0);
    EXPECT_LT(shading_normal(scene.geometry, 0, Side::back, 0.2f, 0.2f).y, 0);
    for (std::size_t i = 0; i < scene.geometry.normals.size(); ++i)  // opposite ones cancel: flat
        scene.geometry.normals[i] = Vec3(i % 2 ? 1.0f : -1.0f, 0, 0);
    EXPECT_EQ(shading_normal(scene.geometry, 0, Side::front, 0.5f, 0), Vec3(0, 1, 0));
}

}  // namespace
}  // namespace pim
