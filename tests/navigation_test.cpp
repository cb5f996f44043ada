// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/interaction/navigation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/render/camera_rays.h"
#include "viewer/interaction/projection.h"

namespace pim {
namespace {

const Imath::V2i kSize(800, 500);

Camera tilted_camera() {
    Camera camera;
    camera.eye = Vec3(3, 2, 5), camera.target = Vec3(-1, 0.5f, 0.2f), camera.up = Vec3(0.1f, 2, -0.2f);
    camera.vertical_fov = 50;
    return camera;
}

Camera level_camera() {  // 4 m before the origin on the z axis
    Camera camera;
    camera.eye = Vec3(0, 0, 4), camera.target = Vec3(0), camera.up = Vec3(0, 1, 0);
    return camera;
}

double distance(const Camera& c) { return (Vec3d(c.eye) - Vec3d(c.target)).length(); }
double degrees_from_up(const Camera& c) {
    const Vec3d up(c.up), arm = Vec3d(c.eye) - Vec3d(c.target);
    return std::atan2(up.cross(arm).length(), up.dot(arm)) * 180 / M_PI;
}
void expect_near(const Vec3& a, const Vec3& b, float tolerance) {
    EXPECT_NEAR((a - b).length(), 0, tolerance) << a << " against " << b;
}
bool sees(const Camera& camera) {
    const Vec3 d = CameraRays(camera, kSize).through(10, 20).direction;
    return std::abs(d.length() - 1) < 1e-5f && CameraRays(camera, kSize).through(700, 20).direction != d;
}

TEST(Orbit, KeepsDistanceTargetAndUp) {
    Camera camera = tilted_camera();
    const Camera before = camera;
    for (int i = 0; i < 1000; ++i) orbit(camera, 0.037f, i % 2 ? 0.11f : -0.107f);
    EXPECT_NEAR(distance(camera), distance(before), 2e-4);  // a thousand roundings of floats
    EXPECT_EQ(camera.target, before.target);
    EXPECT_EQ(camera.up, before.up);
}

TEST(Orbit, HalfAPictureIsAQuarterTurn) {
    Camera camera = level_camera();
    orbit(camera, 0.5f, 0);
    expect_near(camera.eye, {-4, 0, 0}, 1e-6f);  // the scene turns right, so the eye goes left
    orbit(camera, -1, 0);
    expect_near(camera.eye, {4, 0, 0}, 2e-6f);
    orbit(camera, 0, 0.25f);
    expect_near(camera.eye, {4 * std::sqrt(0.5f), 4 * std::sqrt(0.5f), 0}, 2e-6f);
}

TEST(Orbit, WhatIsBeforeTheTargetFollowsTheMouse) {
    Camera camera = tilted_camera();
    const Vec3 point = camera.target + (camera.eye - camera.target) * 0.2f;
    const Vec2 before = *project(camera, kSize, point);
    orbit(camera, 0.05f, 0.03f);
    const Vec2 after = *project(camera, kSize, point);
    EXPECT_GT(after.x, before.x + 1);
    EXPECT_GT(after.y, before.y + 1);
}

TEST(Orbit, StopsADegreeBeforeThePoles) {
    Camera camera = tilted_camera();
    for (int i = 0; i < 5; ++i) orbit(camera, 0.01f, 0.7f);
    EXPECT_NEAR(degrees_from_up(camera), 1, 1e-3);
    EXPECT_TRUE(sees(camera));
    for (int i = 0; i < 5; ++i) orbit(camera, 0.01f, -0.7f);
    EXPECT_NEAR(degrees_from_up(camera), 179, 1e-3);
    EXPECT_TRUE(sees(camera));
}

TEST(Orbit, ThereAndBackIsWhereItBegan) {
    Camera camera = tilted_camera();
    const Vec3 eye = camera.eye;
    orbit(camera, 0.2f, -0.1f);
    orbit(camera, -0.2f, 0.1f);
    expect_near(camera.eye, eye, 2e-6f);
}

TEST(Pan, ThePointAtTheTargetsDistanceStaysUnderTheMouse) {
    for (const float fov : {5.0f, 50.0f, 150.0f}) {
        Camera camera = tilted_camera();
        camera.vertical_fov = fov;
        // any point of the plane through the target across the view
        const CameraRays rays(camera, kSize);
        const Vec3 forward = (camera.target - camera.eye).normalized();
        const Ray ray = rays.through(300, 140);
        const Vec3 point =
            camera.eye + ray.direction * ((camera.target - camera.eye).length() / ray.direction.dot(forward));
        const Vec2 before = *project(camera, kSize, point);
        const double length = distance(camera);
        pan(camera, 0.25f, -0.125f);
        const Vec2 after = *project(camera, kSize, point);
        EXPECT_NEAR(after.x - before.x, 0.25 * 500, 0.02) << fov;
        EXPECT_NEAR(after.y - before.y, -0.125 * 500, 0.02) << fov;
        EXPECT_NEAR(distance(camera), length, 1e-5);
    }
}

TEST(Zoom, GoesTowardsTheTargetGeometrically) {
    Camera camera = tilted_camera();
    const Vec3 forward = (camera.target - camera.eye).normalized();
    const double begin = distance(camera);
    zoom(camera, 1);
    const double ratio = distance(camera) / begin;
    EXPECT_LT(ratio, 1);
    zoom(camera, 1);
    EXPECT_NEAR(distance(camera) / begin, ratio * ratio, 1e-6);
    zoom(camera, -2);
    EXPECT_NEAR(distance(camera), begin, 1e-5);
    expect_near((camera.target - camera.eye).normalized(), forward, 1e-6f);
    EXPECT_EQ(camera.target, tilted_camera().target);
}

TEST(Zoom, NeverThroughTheTarget) {
    Camera camera = tilted_camera();
    const Vec3 forward = (camera.target - camera.eye).normalized();
    for (const float steps : {3.0f, 100.0f, 1e4f, std::numeric_limits<float>::infinity()}) {
        zoom(camera, steps);
        EXPECT_GT(distance(camera), 5e-4);
        expect_near((camera.target - camera.eye).normalized(), forward, 2e-3f);
    }
    zoom(camera, -1e6f);
    EXPECT_TRUE(std::isfinite(camera.eye.x));
    EXPECT_LT(distance(camera), 2e6);
}

TEST(Zoom, FarFromTheOriginTheViewDoesNotTear) {
    Camera camera = tilted_camera();
    const Vec3 far(5000, -3000, 200), forward = (camera.target - camera.eye).normalized();
    camera.eye += far, camera.target += far;
    for (int i = 0; i < 300; ++i) zoom(camera, 1);
    expect_near((camera.target - camera.eye).normalized(), forward, 5e-3f);
}

TEST(Look, TheEdgeOfThePictureComesToTheMiddle) {  // half a picture turns by half the field of view
    Camera camera = level_camera();
    const Vec3 below = CameraRays(camera, kSize).through(400, 500).direction;
    look(camera, 0, 0.5f);
    EXPECT_EQ(camera.eye, level_camera().eye);
    expect_near((camera.target - camera.eye).normalized(), below, 1e-6f);
    EXPECT_NEAR(distance(camera), 4, 1e-5);
}

TEST(Look, RightIsRightAndPolesStopIt) {
    Camera camera = tilted_camera();
    const Vec3 point = camera.target;
    look(camera, 0.1f, 0);
    EXPECT_LT(project(camera, kSize, point)->x, 400);  // what was in the middle is left of it
    look(camera, 0, -100);
    EXPECT_NEAR(degrees_from_up(camera), 179, 1e-3);  // upwards: the eye is below the target
    look(camera, 0, 100);
    EXPECT_NEAR(degrees_from_up(camera), 1, 1e-3);
    EXPECT_EQ(camera.eye, tilted_camera().eye);
    EXPECT_TRUE(sees(camera));
}

TEST(Walk, MovesEyeAndTargetAlike) {
    Camera camera = level_camera();
    walk(camera, {1, 2, 3});  // looking along -z: right is x, up is y
    expect_near(camera.eye, {1, 2, 1}, 1e-6f);
    expect_near(camera.target, {1, 2, -3}, 1e-6f);
}

TEST(Walk, ForwardIsTheViewingDirection) {
    Camera camera = tilted_camera();
    const Vec3 towards = camera.target;
    walk(camera, {0, 0, float(distance(camera))});
    expect_near(camera.eye, towards, 2e-6f);
    EXPECT_TRUE(sees(camera));
}

TEST(Navigation, FieldOfViewIsClamped) {
    Camera camera;
    set_fov(camera, 1);
    EXPECT_EQ(camera.vertical_fov, 5);
    set_fov(camera, 170);
    EXPECT_EQ(camera.vertical_fov, 150);
    set_fov(camera, std::nanf(""));
    EXPECT_EQ(camera.vertical_fov, 150);
    set_fov(camera, 33);
    EXPECT_EQ(camera.vertical_fov, 33);
}

TEST(Navigation, WalkSpeedIsATenthOfTheDiagonal) {
    EXPECT_NEAR(walk_speed(Box3(Vec3(0), Vec3(2, 3, 6))), 0.7f, 1e-6);
    EXPECT_EQ(walk_speed(Box3()), 1);
    EXPECT_EQ(walk_speed(Box3(Vec3(4), Vec3(4))), 1);
}

TEST(Navigation, CamerasThatCannotBeTurnedArePutRight) {
    const Vec3 ups[] = {Vec3(0), Vec3(0, 0, 1), Vec3(0, 0, -3), Vec3(std::nanf(""), 1, 0)};
    for (const Vec3& up : ups)
        for (const Vec3& eye : {Vec3(0, 0, 4), Vec3(0, 0, -4), Vec3(0)}) {
            const auto after = [&](auto action) {
                Camera camera = level_camera();
                camera.up = up, camera.eye = eye;
                action(camera);
                return camera;
            };
            EXPECT_TRUE(sees(after([](Camera& c) { orbit(c, 0.1f, 0.1f); }))) << up << eye;
            EXPECT_TRUE(sees(after([](Camera& c) { look(c, 0.1f, 0.1f); }))) << up << eye;
            EXPECT_TRUE(sees(after([](Camera& c) { pan(c, 0.1f, 0.1f); }))) << up << eye;
            EXPECT_TRUE(sees(after([](Camera& c) { zoom(c, 1); }))) << up << eye;
            EXPECT_TRUE(sees(after([](Camera& c) { walk(c, Vec3(1)); }))) << up << eye;
        }
}

}  // namespace
}  // namespace pim
