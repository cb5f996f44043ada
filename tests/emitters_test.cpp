// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/emitters.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/scene/light.h"

namespace pim {
namespace {

using Triangles = std::vector<std::array<Vec3d, 3>>;

void add_quad(Triangles& triangles, const Vec3d& corner, const Vec3d& u, const Vec3d& v) {
    triangles.push_back({corner, corner + u, corner + u + v});
    triangles.push_back({corner, corner + u + v, corner + v});
}

// A grid of n × n quads over u and v, each triangle with corners of its own.
Triangles grid(int n, const Vec3d& corner, const Vec3d& u, const Vec3d& v) {
    Triangles triangles;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j)
            add_quad(triangles, corner + u * (double(i) / n) + v * (double(j) / n), u / n, v / n);
    return triangles;
}

TEST(FindEmitters, AFineMeshIsOnePanel) {
    const auto emitters = find_emitters(grid(60, {5, 2, 1}, {3, 0, 0}, {0, 0, 2}));
    ASSERT_EQ(emitters.size(), 1u);
    EXPECT_NEAR(emitters[0].area, 6, 1e-9);
    EXPECT_NEAR((emitters[0].centroid - Vec3d(6.5, 2, 2)).length(), 0, 1e-9);
    ASSERT_TRUE(emitters[0].panel);
    EXPECT_EQ(emitters[0].panel->normal, Vec3(0, -1, 0));
    EXPECT_NEAR(emitters[0].panel->width * emitters[0].panel->height, 6, 1e-9);
    EXPECT_NEAR(emitters[0].panel->centre.y, 2 - 1e-3 * std::sqrt(6.0), 1e-9);
}

TEST(FindEmitters, PartsConnectByPlaceDespiteRounding) {
    Triangles triangles;
    add_quad(triangles, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    add_quad(triangles, {1 + 1e-9, -1e-9, 0}, {1, 0, 0}, {0, 1, 0});
    add_quad(triangles, {2.01, 0, 0}, {1, 0, 0}, {0, 1, 0});
    const auto emitters = find_emitters(triangles);
    ASSERT_EQ(emitters.size(), 2u);
    EXPECT_NEAR(emitters[0].area, 2, 1e-6);
    EXPECT_NEAR(emitters[1].area, 1, 1e-9);
}

TEST(FindEmitters, TiltedRectanglesKeepTheirSides) {
    const Vec3 normal = Vec3(1, -2, 0.5f).normalized();
    const RectangleShape shape({1.5f, 0.25f}, normal);
    const Vec3d u = Vec3d(shape.axes[0]) * 1.5, v = Vec3d(shape.axes[1]) * 0.25;
    const auto emitters = find_emitters(grid(3, Vec3d(4, 5, 6) - (u + v) / 2, u, v));
    ASSERT_EQ(emitters.size(), 1u);
    ASSERT_TRUE(emitters[0].panel);
    EXPECT_NEAR(emitters[0].panel->width, 1.5, 1e-5);
    EXPECT_NEAR(emitters[0].panel->height, 0.25, 1e-5);
    EXPECT_NEAR((emitters[0].panel->normal - normal).length(), 0, 1e-6);
}

TEST(FindEmitters, OtherShapesKeepTheirArea) {  // a square on its corner: 2 × 2 around an area of 2
    Triangles triangles;
    add_quad(triangles, {0, -1, 0}, {1, 1, 0}, {-1, 1, 0});
    const auto emitters = find_emitters(triangles);
    ASSERT_EQ(emitters.size(), 1u);
    ASSERT_TRUE(emitters[0].panel);
    EXPECT_NEAR(emitters[0].panel->width, std::sqrt(2.0), 1e-9);
    EXPECT_NEAR(emitters[0].panel->height, std::sqrt(2.0), 1e-9);
}

TEST(FindEmitters, TheRectangleStandsInFrontOfABulge) {  // a low pyramid
    Triangles triangles;
    const Vec3d top(0, 0, 0.2), c[] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    for (int i = 0; i < 4; ++i) triangles.push_back({c[i], c[(i + 1) % 4], top});
    const auto emitters = find_emitters(triangles);
    ASSERT_EQ(emitters.size(), 1u);
    ASSERT_TRUE(emitters[0].panel);
    EXPECT_GT(emitters[0].panel->centre.z, 0.2);
}

TEST(FindEmitters, FoldedSurfacesAreNoPanels) {  // two walls at a right angle
    Triangles triangles;
    add_quad(triangles, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    add_quad(triangles, {0, 0, 0}, {0, 1, 0}, {0, 0, 1});
    const auto emitters = find_emitters(triangles);
    ASSERT_EQ(emitters.size(), 1u);
    EXPECT_FALSE(emitters[0].panel);
    EXPECT_NEAR((emitters[0].centroid - Vec3d(0.25, 0.5, 0.25)).length(), 0, 1e-12);
}

TEST(FindEmitters, TrianglesWithoutAreaDoNotCount) {
    EXPECT_TRUE(find_emitters({}).empty());
    EXPECT_TRUE(
        find_emitters({{Vec3d(0), Vec3d(1), Vec3d(2)}, {Vec3d(0), Vec3d(NAN), Vec3d(1, 0, 0)}}).empty());
}

TEST(LightLines, APointLamp) {
    const std::string lines = light_lines({2, {1, 2, 3}, {}}, Rgb(1, 0, 0.5f), "bulb \"x\"");
    for (const char* part : {"[[light]]", "name = \"bulb \\\"x\\\"\"", "type = \"point\"",
                             "power = [6.28318531, 0, 3.14159265]", "position = [1, 2, 3]"})
        EXPECT_NE(lines.find(part), std::string::npos) << lines;
}

}  // namespace
}  // namespace pim
