// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/interaction/gizmo.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "common/render/camera_rays.h"
#include "viewer/interaction/gizmo_drag.h"

namespace pim {
namespace {

using Kind = Handle::Kind;

const Imath::V2i kSize(960, 600);
const Box3 kDomain(Vec3(-2, 0, -3), Vec3(2, 3, 3));
const Vec3 kLamp(0.5f, 1.5f, -0.25f);

Camera test_camera() {
    Camera camera;
    camera.eye = Vec3(4, 3, 6), camera.target = Vec3(0.2f, 1.2f, 0), camera.up = Vec3(0, 1, 0);
    camera.vertical_fov = 55;
    return camera;
}

Camera camera_along(const Vec3& eye, const Vec3& up) {
    Camera camera;
    camera.eye = eye, camera.target = Vec3(0), camera.up = up;
    return camera;
}

Vec2 seen(const Vec3& point) { return *project(test_camera(), kSize, point); }
void expect_near(const Vec3& a, const Vec3& b, float tolerance) {
    EXPECT_NEAR((a - b).length(), 0, tolerance) << a << " against " << b;
}

GizmoDrag drag(const Handle& handle, const Vec2& mouse, const Box3& domain = kDomain) {
    return GizmoDrag(test_camera(), kSize, {handle, kLamp, domain, Vec3d(0), mouse});
}

// ---- projection

TEST(Projection, IsTheInverseOfCameraRays) {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> x(-200, 1200), y(-200, 800), depth(0.1f, 50);
    for (int i = 0; i < 200; ++i) {
        Camera camera = test_camera();
        camera.vertical_fov = 20 + float(i) / 2;
        camera.up = Vec3(0.3f, 2, 0.1f);
        const Vec2 pixel(x(random), y(random));
        const Ray ray = CameraRays(camera, kSize).through(pixel.x, pixel.y);
        const std::optional<Vec2> back = project(camera, kSize, ray.origin + ray.direction * depth(random));
        ASSERT_TRUE(back);
        EXPECT_NEAR((*back - pixel).length(), 0, 0.02);
    }
}

TEST(Projection, NothingBehindTheEye) {
    const Camera camera = test_camera();
    EXPECT_FALSE(project(camera, kSize, camera.eye - (camera.target - camera.eye)));
    EXPECT_FALSE(project(camera, kSize, camera.eye));
}

TEST(Projection, LinesThroughTheEyesPlaneAreClipped) {
    const Camera camera = camera_along({0, 0, 4}, {0, 1, 0});
    const Projection projection(camera, kSize);
    const std::vector<Vec2> line = projection.line({1, 0, 0}, {1, 0, 20});  // ends behind the eye
    ASSERT_EQ(line.size(), 2u);
    const Vec2 start = *project(camera, kSize, {1, 0, 0});
    EXPECT_NEAR((line[0] - start).length(), 0, 1e-3);
    EXPECT_GT(line[1].x, 960);              // leaves the picture on the right ...
    EXPECT_NEAR(line[1].y, start.y, 1e-2);  // ... along the horizon, no further than is drawn well
    EXPECT_LT(line[1].x, 3 * 960);
    EXPECT_TRUE(projection.line({1, 0, 5}, {1, 0, 20}).empty());
    const std::vector<Vec2> polygon = projection.polygon({{-1, -1, 0}, {1, -1, 0}, {1, -1, 9}, {-1, -1, 9}});
    EXPECT_GE(polygon.size(), 4u);
    for (const Vec2& p : polygon) EXPECT_GT(p.y, 300);  // below the horizon
}

TEST(DomainEdges, TwelveOfABoxFewerOfFlatOnes) {
    const auto count = [](const Vec3& extent) {
        return domain_edges(test_camera(), kSize, Box3(kLamp, kLamp + extent)).size();
    };
    EXPECT_EQ(count({1, 1, 1}), 12u);
    EXPECT_EQ(count({1, 0, 1}), 4u);
    EXPECT_EQ(count({0, 1, 1}), 4u);
    EXPECT_EQ(count({0, 0, 1}), 1u);
    EXPECT_EQ(count({0, 0, 0}), 0u);
}

TEST(DomainEdges, JoinTheCorners) {
    std::vector<Vec2> corners;
    for (int i = 0; i < 8; ++i)
        corners.push_back(seen({i & 1 ? 1.0f : 0.0f, i & 2 ? 1.0f : 0.0f, i & 4 ? 1.0f : 0.0f}));
    std::vector<int> met(8, 0);
    for (const Edge& edge : domain_edges(test_camera(), kSize, Box3(Vec3(0), Vec3(1))))
        for (const Vec2& end : edge)
            for (std::size_t i = 0; i < 8; ++i) met[i] += (corners[i] - end).length() < 1e-2f;
    EXPECT_EQ(met, std::vector<int>(8, 3));
}

TEST(DomainEdges, FromInsideTheBoxAreFinite) {
    Camera camera = test_camera();
    camera.eye = Vec3(0, 1, 0), camera.target = Vec3(1, 1, 0.3f);
    const std::vector<Edge> edges = domain_edges(camera, kSize, kDomain);
    EXPECT_FALSE(edges.empty());
    EXPECT_LT(edges.size(), 12u);
    for (const Edge& edge : edges)
        for (const Vec2& end : edge) {
            EXPECT_LE(std::abs(end.x - 480), 3 * 480 + 1);
            EXPECT_LE(std::abs(end.y - 300), 3 * 300 + 1);
        }
}

// ---- shape

std::vector<Handle> handles(const Camera& camera, const Box3& domain, const Vec3& position) {
    std::vector<Handle> found;
    for (const HandleShape& shape : gizmo_shape(camera, kSize, position, domain).handles)
        found.push_back(shape.handle);
    return found;
}

bool holds(const std::vector<Handle>& all, const Handle& one) { return std::ranges::count(all, one) == 1; }

TEST(GizmoShape, HandlesOnlyWhereTheDomainHasExtent) {
    EXPECT_EQ(handles(test_camera(), kDomain, kLamp).size(), 7u);
    const std::vector<Handle> flat =
        handles(test_camera(), Box3(Vec3(-2, 1.5f, -3), Vec3(2, 1.5f, 3)), kLamp);
    EXPECT_EQ(flat.size(), 4u);
    EXPECT_TRUE(holds(flat, {Kind::axis, 0}) && holds(flat, {Kind::axis, 2}));
    EXPECT_TRUE(holds(flat, {Kind::plane, 1}) && holds(flat, {Kind::centre, 0}));
    const std::vector<Handle> line = handles(test_camera(), Box3(kLamp, kLamp + Vec3(0, 1, 0)), kLamp);
    EXPECT_EQ(line.size(), 2u);
    EXPECT_TRUE(holds(line, {Kind::axis, 1}) && holds(line, {Kind::centre, 0}));
    EXPECT_TRUE(handles(test_camera(), Box3(kLamp, kLamp), kLamp).empty());
}

TEST(GizmoShape, ArrowsAcrossTheViewAreNinetyPixelsAtAnyDistance) {
    for (const float distance : {0.5f, 4.0f, 300.0f})
        for (const float fov : {10.0f, 40.0f, 120.0f}) {
            Camera camera = camera_along({0, 0, distance}, {0, 1, 0});
            camera.vertical_fov = fov;
            const GizmoShape gizmo = gizmo_shape(camera, kSize, Vec3(0), kDomain);
            for (const HandleShape& shape : gizmo.handles) {
                if (shape.handle.kind != Kind::axis) continue;
                EXPECT_NEAR((shape.line[1] - Vec2(480, 300)).length(), 90, 0.01) << distance << " m " << fov;
            }
        }
}

TEST(GizmoShape, ArrowsPointAlongTheirAxes) {  // seen from +z with y up: x right, y up, z at the eye
    const Camera camera = camera_along({0, 0, 5}, {0, 1, 0});
    const GizmoShape gizmo = gizmo_shape(camera, kSize, Vec3(0), kDomain);
    for (const HandleShape& shape : gizmo.handles) {
        EXPECT_FALSE(shape.handle == (Handle{Kind::axis, 2}));  // along the view: nothing could be moved
        if (shape.handle == Handle{Kind::axis, 0}) {
            EXPECT_GT(shape.line[1].x, 560);
        }
        if (shape.handle == Handle{Kind::axis, 1}) {
            EXPECT_LT(shape.line[1].y, 220);
        }
        if (shape.handle.kind == Kind::plane) {
            EXPECT_EQ(shape.handle.axis, 2);  // the others are edge-on
        }
    }
}

TEST(GizmoShape, NothingOfALampBehindTheEye) {
    Camera camera = test_camera();
    camera.target = camera.eye * 2 - kLamp;
    EXPECT_TRUE(gizmo_shape(camera, kSize, kLamp, kDomain).handles.empty());
    EXPECT_FALSE(pick(camera, kSize, kLamp, kDomain, Vec2(480, 300)));
}

TEST(GizmoShape, ArrowsThatReachBehindTheEyeAreFinite) {
    Camera camera = camera_along({0.3f, 0.2f, 0.5f}, {0, 1, 0});
    camera.vertical_fov = 150;
    for (const HandleShape& shape : gizmo_shape(camera, kSize, Vec3(0), kDomain).handles)
        for (const auto& points : {shape.line, shape.area})
            for (const Vec2& p : points) EXPECT_LT((p - Vec2(480, 300)).length(), 3 * 960);
}

TEST(GizmoShape, HighlightsTheOneAskedFor) {
    const Handle wanted{Kind::plane, 1};
    for (const HandleShape& shape : gizmo_shape(test_camera(), kSize, kLamp, kDomain, wanted).handles)
        EXPECT_EQ(shape.highlighted, shape.handle == wanted);
}

// ---- pick

std::optional<Handle> pick_at(const Vec2& mouse) { return pick(test_camera(), kSize, kLamp, kDomain, mouse); }

TEST(Pick, FindsEachHandleOnItsShape) {
    for (const HandleShape& shape : gizmo_shape(test_camera(), kSize, kLamp, kDomain).handles) {
        Vec2 middle(0);
        for (const Vec2& p : shape.area) middle += p / float(shape.area.size());
        EXPECT_EQ(pick_at(middle), shape.handle) << int(shape.handle.kind) << shape.handle.axis;
        if (shape.line.size() == 2) {
            EXPECT_EQ(pick_at(shape.line[1]), shape.handle);
        }
    }
    EXPECT_EQ(pick_at(seen(kLamp)), (Handle{Kind::centre, 0}));
}

TEST(Pick, ReachesEightPixels) {
    const Camera camera = camera_along({0, 0, 5}, {0, 1, 0});
    const Box3 line(Vec3(-1, 0, 0), Vec3(1, 0, 0));  // its arrow points to the right of (480, 300)
    const auto at = [&](float x, float y) { return pick(camera, kSize, Vec3(0), line, Vec2(x, y)); };
    EXPECT_EQ(at(530, 300), (Handle{Kind::axis, 0}));
    EXPECT_EQ(at(530, 307.5f), (Handle{Kind::axis, 0}));
    EXPECT_EQ(at(530, 292.5f), (Handle{Kind::axis, 0}));
    EXPECT_FALSE(at(530, 308.5f));
    EXPECT_EQ(at(577, 300), (Handle{Kind::axis, 0}));
    EXPECT_FALSE(at(579, 300));
    EXPECT_FALSE(at(440, 300));
}

// ---- drag

TEST(GizmoDrag, BeginsWithoutAJump) {
    for (const HandleShape& shape : gizmo_shape(test_camera(), kSize, kLamp, kDomain).handles) {
        const Vec2 mouse = shape.area[0] + Vec2(3, -2);
        EXPECT_EQ(drag(shape.handle, mouse).move(mouse), kLamp);
    }
}

TEST(GizmoDrag, AnArrowFollowsTheMouseAlongItsAxis) {
    for (int axis = 0; axis < 3; ++axis)
        for (const float grasped : {0.0f, 0.2f}) {  // m up the arrow
            Vec3 along(0);
            along[axis] = 1;
            GizmoDrag held = drag({Kind::axis, axis}, seen(kLamp + along * grasped));
            for (const float way : {0.1f, 0.6f, -0.3f, 1.2f, -1.1f}) {
                expect_near(held.move(seen(kLamp + along * (grasped + way))), kLamp + along * way, 1e-4f);
                EXPECT_FALSE(held.stopped().at_domain);
                EXPECT_EQ(held.stopped().text, "");
            }
        }
}

TEST(GizmoDrag, AnArrowMovesOnlyAlongItsAxisAndToTheNearestPlaceOfIt) {
    GizmoDrag held = drag({Kind::axis, 0}, seen(kLamp));
    const Vec2 mouse = seen(kLamp + Vec3(0.5f, 0.3f, 0.1f));
    const Vec3 moved = held.move(mouse);
    EXPECT_EQ(moved.y, kLamp.y);
    EXPECT_EQ(moved.z, kLamp.z);
    // no other place of the axis is nearer to the ray
    const Ray ray = CameraRays(test_camera(), kSize).through(mouse.x, mouse.y);
    const auto distance = [&](const Vec3& p) {
        return Vec3d(p - ray.origin).cross(Vec3d(ray.direction)).length();
    };
    for (const float aside : {-0.05f, 0.05f}) EXPECT_GT(distance(moved + Vec3(aside, 0, 0)), distance(moved));
}

TEST(GizmoDrag, ASquareFollowsTheMouseInItsPlane) {
    for (int normal = 0; normal < 3; ++normal) {
        Vec3 a(0), b(0);
        a[(normal + 1) % 3] = 1, b[(normal + 2) % 3] = 1;
        const Vec3 grasped = kLamp + (a + b) * 0.3f;
        GizmoDrag held = drag({Kind::plane, normal}, seen(grasped));
        for (const Vec2& way : {Vec2(0.2f, 0.1f), Vec2(-0.5f, 0.4f), Vec2(1, -0.9f)}) {
            const Vec3 path = a * way.x + b * way.y;
            const Vec3 moved = held.move(seen(grasped + path));
            expect_near(moved, kLamp + path, 1e-4f);
            EXPECT_EQ(moved[normal], kLamp[normal]);
        }
    }
}

TEST(GizmoDrag, TheDotKeepsItsDepthAndStaysUnderTheMouse) {
    const Camera camera = test_camera();
    const Vec3 forward = (camera.target - camera.eye).normalized();
    GizmoDrag held = drag({Kind::centre, 0}, seen(kLamp));
    const Vec2 mouse = seen(kLamp) + Vec2(60, -45);
    const Vec3 moved = held.move(mouse);
    EXPECT_NEAR((moved - kLamp).dot(forward), 0, 1e-5);
    EXPECT_NEAR((seen(moved) - mouse).length(), 0, 0.02);
}

TEST(GizmoDrag, TheDotStaysUnderTheMouseInFlatDomainsToo) {
    const Box3 flat(Vec3(-2, kLamp.y, -3), Vec3(2, kLamp.y, 3));
    const Vec3 there(-0.7f, kLamp.y, 1.1f);
    expect_near(drag({Kind::centre, 0}, seen(kLamp), flat).move(seen(there)), there, 1e-4f);
    const Box3 line(Vec3(-2, kLamp.y, kLamp.z), Vec3(2, kLamp.y, kLamp.z));
    const Vec3 beside(-0.7f, kLamp.y, kLamp.z);
    expect_near(drag({Kind::centre, 0}, seen(kLamp), line).move(seen(beside)), beside, 1e-4f);
}

TEST(GizmoDrag, StopsAtTheDomainAndSaysWhere) {
    Grip grip{{Kind::axis, 0}, kLamp, kDomain, Vec3d(1.2, 0, 1000), seen(kLamp)};
    GizmoDrag held(test_camera(), kSize, grip);
    EXPECT_EQ(held.move(seen(kLamp + Vec3(2.5f, 0, 0))), Vec3(2, kLamp.y, kLamp.z));
    EXPECT_TRUE(held.stopped().at_domain);
    EXPECT_EQ(held.stopped().text, "x stops at 3.20 m: the map was baked up to there");
    expect_near(held.move(seen(kLamp + Vec3(1, 0, 0))), kLamp + Vec3(1, 0, 0), 1e-4f);  // and comes back
    EXPECT_FALSE(held.stopped().at_domain);

    grip.handle = {Kind::plane, 1};
    GizmoDrag flat(test_camera(), kSize, grip);
    EXPECT_EQ(flat.move(seen(kLamp + Vec3(-3, 0, -4))), Vec3(-2, kLamp.y, -3));
    EXPECT_EQ(flat.stopped().text, "x stops at -0.80 m, z stops at 997.00 m: the map was baked up to there");
}

TEST(GizmoDrag, NeverLeavesTheDomain) {
    std::mt19937 random(2);
    std::uniform_real_distribution<float> x(-3000, 4000), y(-3000, 4000);
    for (const HandleShape& shape : gizmo_shape(test_camera(), kSize, kLamp, kDomain).handles) {
        GizmoDrag held = drag(shape.handle, shape.area[0]);
        for (int i = 0; i < 300; ++i) EXPECT_TRUE(kDomain.intersects(held.move({x(random), y(random)})));
    }
}

TEST(GizmoDrag, AnAxisAlongTheRayDoesNotMove) {
    const Camera camera = camera_along({0, 0, 5}, {0, 1, 0});
    GizmoDrag held(camera, kSize, {{Kind::axis, 2}, Vec3(0), kDomain, Vec3d(0), Vec2(480, 300)});
    for (const float x : {480.0f, 481.0f, 484.0f}) EXPECT_EQ(held.move({x, 300}), Vec3(0));
    GizmoDrag edge_on(camera, kSize, {{Kind::plane, 1}, Vec3(0), kDomain, Vec3d(0), Vec2(480, 300)});
    for (const float y : {300.0f, 299.0f, 303.0f}) EXPECT_EQ(edge_on.move({500, y}), Vec3(0));
}

TEST(GizmoDrag, BeyondItsVanishingPointAnAxisLetsGo) {  // the ray then parts from the far side of the axis
    const Camera camera = test_camera();
    GizmoDrag held = drag({Kind::axis, 2}, seen(kLamp));
    const Vec3 moved = held.move(seen(kLamp + Vec3(0, 0, -1)));
    const Vec2 vanishing = seen(camera.eye + Vec3(0, 0, -1));
    const Vec2 beyond = vanishing + (vanishing - seen(kLamp)).normalized() * 100;
    EXPECT_EQ(held.move(beyond), moved);
}

TEST(GizmoDrag, BeyondTheHorizonThePlaneLetsGo) {  // the ray then meets the floor behind the eye
    const Camera camera = test_camera();
    GizmoDrag held = drag({Kind::plane, 1}, seen(kLamp));
    const Vec3 moved = held.move(seen(kLamp + Vec3(-0.5f, 0, -0.5f)));
    const Vec3 above_horizon = camera.eye + Vec3(-4, 2, -6);
    EXPECT_EQ(held.move(seen(above_horizon)), moved);
    const Vec3 back = kLamp + Vec3(0.3f, 0, 0);
    expect_near(held.move(seen(back)), back, 1e-4f);
}

}  // namespace
}  // namespace pim
