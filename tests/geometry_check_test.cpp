// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/geometry_check.h"

#include "statistics.h"
#include "test_scenes.h"

namespace pim {
namespace {

TEST(Mend, LeavesCleanGeometryAlone) {
    Scene scene = room(Rgb(0.5f));
    const std::size_t triangles = scene.geometry.triangles.size(), vertices = scene.geometry.positions.size();
    const Mended mended = mend(scene.geometry);
    EXPECT_EQ(mended.text(), "");
    EXPECT_EQ(scene.geometry.triangles.size(), triangles);
    EXPECT_EQ(scene.geometry.positions.size(), vertices);
}

TEST(Mend, CountsAndRemoves) {
    Scene scene = empty_scene();
    scene.materials.push_back(diffuse_material(Rgb(0.1f)));
    add_triangle(scene, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 1);   // kept
    add_triangle(scene, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});      // the same again
    add_triangle(scene, {0, 1, 0}, {1, 0, 0}, {0, 0, -0.0f});  // and the other way round
    add_triangle(scene, {0, 0, 0}, {1, 1, 1}, {2, 2, 2});      // on a line
    add_triangle(scene, {5, 5, 5}, {5, 5, 5}, {6, 6, 7});      // two corners alike
    add_triangle(scene, {0, 0, std::nanf("")}, {1, 0, 0}, {0, 1, 0});
    add_triangle(scene, {0, 0, INFINITY}, {1, 0, 0}, {0, 1, 0});
    add_triangle(scene, {0, 0, 1}, {1, 0, 1}, {0, 1, 1});  // kept
    add_vertex(scene, {7, 7, 7});
    scene.geometry.texture_coordinates[21] = {0.25f, 0.75f};  // first corner of the last triangle
    scene.geometry.normals[21] = {0, 0, 1};
    const Mended mended = mend(scene.geometry);
    EXPECT_EQ(mended.duplicate, 2u);
    EXPECT_EQ(mended.degenerate, 2u);
    EXPECT_EQ(mended.non_finite, 2u);
    EXPECT_EQ(mended.unreferenced, 6u * 3 + 1);
    for (const char* number :
         {"2 triangles with a vertex", "2 triangles without area", "2 duplicate", "19 unreferenced"})
        EXPECT_NE(mended.text().find(number), std::string::npos) << mended.text();
    const Geometry& g = scene.geometry;
    ASSERT_EQ(g.triangles.size(), 2u);
    EXPECT_EQ(g.triangles[0].material, 1u);
    EXPECT_EQ(g.triangles[1].material, 0u);
    EXPECT_EQ(g.corners(1)[1], Vec3(1, 0, 1));
    EXPECT_EQ(g.texture_coordinates[g.triangles[1].vertices[0]], Vec2(0.25f, 0.75f));
    EXPECT_EQ(g.normals[g.triangles[1].vertices[0]], Vec3(0, 0, 1));
    EXPECT_EQ(mend(scene.geometry).text(), "");  // once is enough
}

// --- solids ---

Scene furnished_room() {
    Scene scene = room(Rgb(0.5f), Vec3(4));
    scene.geometry.objects.push_back("cupboard");
    add_box(scene, {1, 0.5f, 1}, {2, 1.5f, 2}, false);
    return scene;
}

TEST(Solids, ALampInsideAClosedBoxIsFound) {
    const Solids solids(furnished_room().geometry, {});
    EXPECT_EQ(solids.containing({1.5f, 1, 1.5f}), "cupboard");
    EXPECT_EQ(solids.containing({3, 1, 3}), "");  // in the room, which encloses the cupboard
    EXPECT_EQ(solids.containing({9, 9, 9}), "");
    EXPECT_EQ(solids.containing({1.01f, 0.51f, 1.01f}), "cupboard");
    EXPECT_EQ(solids.containing({0.99f, 0.51f, 1.01f}), "");
}

TEST(Solids, OrientationDoesNotMatter) {
    Scene scene = empty_scene();
    add_box(scene, Vec3(0), Vec3(1), true);
    add_sphere(scene, Vec3(5), 1, 2, false, false);
    const Solids solids(scene.geometry, {});
    EXPECT_EQ(solids.containing(Vec3(0.5f)), "object");
    EXPECT_EQ(solids.containing(Vec3(5)), "object");
}

TEST(Solids, ACameraMakesItARoom) {
    Scene scene = empty_scene();
    add_box(scene, Vec3(0), Vec3(1), false);
    EXPECT_EQ(Solids(scene.geometry, {}).containing(Vec3(0.5f)), "object");
    EXPECT_EQ(Solids(scene.geometry, {Vec3(0.2f)}).containing(Vec3(0.5f)), "");
    EXPECT_EQ(Solids(scene.geometry, {Vec3(2)}).containing(Vec3(0.5f)), "object");
}

TEST(Solids, OpenObjectsHoldNothing) {
    Scene scene = empty_scene();
    add_box(scene, Vec3(0), Vec3(1), false);
    scene.geometry.triangles.pop_back();
    EXPECT_EQ(Solids(scene.geometry, {}).containing(Vec3(0.5f)), "");
}

// --- the exact test that others rest on ---

TEST(TriangleMeetsBox, ClosedOnBothSides) {
    const Box3d box(Vec3d(0), Vec3d(1));
    const auto meets = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
        return triangle_meets_box({a, b, c}, box);
    };
    EXPECT_TRUE(meets({0.2f, 0.2f, 0.2f}, {0.3f, 0.2f, 0.2f}, {0.2f, 0.3f, 0.2f}));  // inside
    EXPECT_TRUE(meets({-9, -9, 0.5f}, {9, -9, 0.5f}, {0, 20, 0.5f}));                // all corners outside
    EXPECT_TRUE(meets({1, 1, 1}, {2, 1, 1}, {1, 2, 1}));                             // touches a corner
    EXPECT_FALSE(meets({1.0001f, 0, 0}, {2, 0, 0}, {2, 1, 0}));
    EXPECT_FALSE(meets({2.1f, 0, 0}, {0, 2.1f, 0}, {2.1f, 2.1f, 0}));  // boxes overlap, they do not
}

}  // namespace
}  // namespace pim
