// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/render/camera_rays.h"

#include <gtest/gtest.h>

#include <cmath>

namespace pim {
namespace {

Camera camera_at(const Vec3& eye, const Vec3& target, float fov) {
    Camera camera;
    camera.eye = eye, camera.target = target, camera.vertical_fov = fov;
    return camera;
}

constexpr float kRounding = 1e-6f;  // a dozen float roundings of unit vectors

TEST(CameraRays, TheMiddleLooksAtTheTarget) {
    const Camera camera = camera_at({1, 2, 3}, {4, 0, -2}, 50);
    const Ray ray = CameraRays(camera, {640, 480}).through(320, 240);
    EXPECT_EQ(ray.origin, camera.eye);
    EXPECT_NEAR((ray.direction - (camera.target - camera.eye).normalized()).length(), 0, kRounding);
}

TEST(CameraRays, FieldOfViewIsVertical) {
    const CameraRays rays(camera_at({0, 0, 5}, {0, 0, 0}, 60), {800, 400});
    const auto degrees = [](const Vec3& a, const Vec3& b) { return std::acos(a.dot(b)) * 180 / kPi; };
    EXPECT_NEAR(degrees(rays.through(400, 0).direction, rays.through(400, 400).direction), 60, 1e-3);
    const float half_width = 2 * std::tan(30 * kPi / 180);
    EXPECT_NEAR(degrees(rays.through(0, 200).direction, rays.through(800, 200).direction),
                2 * std::atan(half_width) * 180 / kPi, 1e-3);
}

TEST(CameraRays, UpIsUpAndRightIsRight) {  // looking along -z with y up, +x is to the right
    const CameraRays rays(camera_at({0, 0, 5}, {0, 0, 0}, 60), {100, 100});
    EXPECT_GT(rays.through(50, 0).direction.y, 0.1f);
    EXPECT_LT(rays.through(50, 100).direction.y, -0.1f);
    EXPECT_GT(rays.through(100, 50).direction.x, 0.1f);
    EXPECT_LT(rays.through(0, 50).direction.x, -0.1f);
    for (const float x : {0.0f, 33.0f, 100.0f})
        EXPECT_NEAR(rays.through(x, 7).direction.length(), 1, kRounding);
}

TEST(CameraRays, PixelsAreSquare) {
    const CameraRays rays(camera_at({0, 0, 5}, {0, 0, 0}, 40), {300, 200});
    const Vec3 middle = rays.through(150, 100).direction;
    const auto slope = [&](const Vec3& d) { return (d / d.dot(middle) - middle).length(); };
    EXPECT_NEAR(slope(rays.through(160, 100).direction), slope(rays.through(150, 110).direction), kRounding);
}

}  // namespace
}  // namespace pim
