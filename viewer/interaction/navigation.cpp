// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/interaction/navigation.h"

#include <algorithm>
#include <cmath>

#include "viewer/interaction/projection.h"

namespace pim {
namespace {

constexpr double kFromPole = M_PI / 180;            // the view stays so far from `up`
constexpr double kNearest = 1e-3, kFarthest = 1e6;  // m, of the target
constexpr double kCoarseness = 0x1p-14;             // nearer than this times the coordinates, floats tear
constexpr double kStep = 0.9;                       // of the distance, per step of the wheel
constexpr double kAlongUp = 1e-4;                   // sine of the angle below which CameraRays has no right

bool usable(const Vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z) && v.length() > 0;
}

// `arm` turned about `up` by `azimuth` and moved away from `up` by `down`; radians.
Vec3d turned(const Vec3d& arm, const Vec3d& up, const Vec3d& right, double azimuth, double down) {
    const Vec3d across = arm - up * arm.dot(up);
    const double length = arm.length(), angle = std::atan2(across.length(), arm.dot(up));
    // a camera that came nearer to the pole is not thrown off it
    const double polar =
        std::clamp(angle + down, std::min(kFromPole, angle), std::max(M_PI - kFromPole, angle));
    const Vec3d level = across.length() > kAlongUp * length ? across.normalized() : up.cross(right);
    const Vec3d heading = level * std::cos(azimuth) + up.cross(level) * std::sin(azimuth);
    return (up * std::cos(polar) + heading * std::sin(polar)) * length;
}

void put_right(Camera& camera) {
    if (!usable(camera.up)) camera.up = Vec3(0, 1, 0);
    const ViewAxes axes = view_axes(camera);
    if (camera.eye == camera.target) camera.target = Vec3(Vec3d(camera.eye) + axes.forward);
    const Vec3d up = Vec3d(camera.up).normalized(), arm = Vec3d(camera.eye) - Vec3d(camera.target);
    if (up.cross(arm).length() > kAlongUp * arm.length()) return;
    const double away = arm.dot(up) > 0 ? kFromPole : -kFromPole;
    camera.eye = Vec3(Vec3d(camera.target) + turned(arm, up, axes.right, 0, away));
}

void move(Camera& camera, const Vec3d& path) {
    camera.eye = Vec3(Vec3d(camera.eye) + path);
    camera.target = Vec3(Vec3d(camera.target) + path);
}

double degrees_to_radians(double degrees) { return degrees * M_PI / 180; }

}  // namespace

void orbit(Camera& camera, float dx, float dy) {
    put_right(camera);
    const Vec3d arm = Vec3d(camera.eye) - Vec3d(camera.target);
    const Vec3d moved =
        turned(arm, Vec3d(camera.up).normalized(), view_axes(camera).right, -M_PI * dx, -M_PI * dy);
    camera.eye = Vec3(Vec3d(camera.target) + moved);
}

void look(Camera& camera, float dx, float dy) {
    put_right(camera);
    const Vec3d arm = Vec3d(camera.target) - Vec3d(camera.eye);
    const double turn = degrees_to_radians(camera.vertical_fov);
    const Vec3d moved =
        turned(arm, Vec3d(camera.up).normalized(), view_axes(camera).right, -turn * dx, turn * dy);
    camera.target = Vec3(Vec3d(camera.eye) + moved);
}

void pan(Camera& camera, float dx, float dy) {
    put_right(camera);
    const ViewAxes axes = view_axes(camera);
    const double distance = (Vec3d(camera.target) - Vec3d(camera.eye)).length();
    const double height = 2 * distance * std::tan(degrees_to_radians(camera.vertical_fov) / 2);
    move(camera, (axes.up * dy - axes.right * dx) * height);
}

void zoom(Camera& camera, float steps) {
    put_right(camera);
    const Vec3d arm = Vec3d(camera.eye) - Vec3d(camera.target);
    const double distance = arm.length();
    const double nearest = std::max(kNearest, kCoarseness * Vec3d(camera.target).length());
    const double wanted = std::clamp(distance * std::pow(kStep, double(steps)), std::min(nearest, distance),
                                     std::max(kFarthest, distance));
    camera.eye = Vec3(Vec3d(camera.target) + arm * (wanted / distance));
}

void walk(Camera& camera, const Vec3& right_up_forward) {
    put_right(camera);
    const ViewAxes axes = view_axes(camera);
    move(camera, axes.right * right_up_forward.x + Vec3d(camera.up).normalized() * right_up_forward.y +
                     axes.forward * right_up_forward.z);
}

void set_fov(Camera& camera, float degrees) {
    if (!std::isnan(degrees)) camera.vertical_fov = std::clamp(degrees, 5.0f, 150.0f);
}

float walk_speed(const Box3& bounds) {
    if (bounds.isEmpty()) return 1;
    const float diagonal = (bounds.max - bounds.min).length();
    return diagonal > 0 && std::isfinite(diagonal) ? 0.1f * diagonal : 1;
}

}  // namespace pim
