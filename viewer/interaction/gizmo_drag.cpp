// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/interaction/gizmo_drag.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace pim {
namespace {

constexpr double kLeastSine = 0.035;  // 2°: between ray and plane or axis
constexpr double kRounding = 1e-6;    // of the domain's extent

// The place on the line p + t a nearest to the ray o + s d (a, d unit), from (p + t a − o − s d) ⊥ a, d.
std::optional<Vec3d> nearest_on_line(const Vec3d& p, const Vec3d& a, const Vec3d& o, const Vec3d& d) {
    const Vec3d w = p - o;
    const double cosine = a.dot(d), sine2 = 1 - cosine * cosine;
    if (!(sine2 > kLeastSine * kLeastSine)) return std::nullopt;
    const double t = (cosine * d.dot(w) - a.dot(w)) / sine2, s = (d.dot(w) - cosine * a.dot(w)) / sine2;
    if (!(s > 0)) return std::nullopt;
    return p + a * t;
}

std::optional<Vec3d> meet_plane(const Vec3d& p, const Vec3d& normal, const Vec3d& o, const Vec3d& d) {
    const double slope = normal.dot(d);
    if (!(std::abs(slope) > kLeastSine)) return std::nullopt;
    const double s = normal.dot(p - o) / slope;
    if (!(s > 0)) return std::nullopt;
    return o + d * s;
}

Vec3d unit(int axis) {
    Vec3d v(0);
    v[axis] = 1;
    return v;
}

Vec3 clamped(const Vec3d& position, const Box3& domain) {
    Vec3 inside(0);
    for (int axis = 0; axis < 3; ++axis)
        inside[axis] = std::max(domain.min[axis], std::min(domain.max[axis], float(position[axis])));
    return inside;
}

// As a person reads it: no "-0.00".
std::string metres(double length, int decimals) {
    const double unit = std::pow(10.0, -decimals);
    return fmt::format("{:.{}f} m", std::round(length / unit) * unit + 0.0, decimals);
}

}  // namespace

Constraint constraint(const Camera& camera, const Handle& handle, const Box3& domain) {
    const std::vector<int> axes = free_axes(domain);
    if (handle.kind == Handle::Kind::axis) return {Constraint::Kind::line, unit(handle.axis)};
    if (handle.kind == Handle::Kind::plane) return {Constraint::Kind::plane, unit(handle.axis)};
    if (axes.size() == 1) return {Constraint::Kind::line, unit(axes[0])};
    if (axes.size() == 2) return {Constraint::Kind::plane, unit(3 - axes[0] - axes[1])};
    return {Constraint::Kind::plane, view_axes(camera).forward};
}

GizmoDrag::GizmoDrag(const Camera& camera, const Imath::V2i& size, const Grip& grip)
    : rays_(camera, size),
      grip_(grip),
      constraint_(constraint(camera, grip.handle, grip.domain)),
      grasp_(grasped(grip.mouse)),
      position_(clamped(Vec3d(grip.position), grip.domain)) {}

std::optional<Vec3d> GizmoDrag::grasped(const Vec2& mouse) const {
    const Ray ray = rays_.through(mouse.x, mouse.y);
    const auto meet = constraint_.kind == Constraint::Kind::line ? nearest_on_line : meet_plane;
    return meet(Vec3d(grip_.position), constraint_.direction, Vec3d(ray.origin),
                Vec3d(ray.direction).normalized());
}

Vec3 GizmoDrag::move(const Vec2& mouse) {
    const std::optional<Vec3d> place = grasped(mouse);
    if (!place) return position_;
    if (!grasp_) grasp_ = place;  // begun where the mouse could not hold anything
    const Vec3d wanted = Vec3d(grip_.position) + (*place - *grasp_);
    position_ = clamped(wanted, grip_.domain);
    note_sides(wanted);
    return position_;
}

void GizmoDrag::note_sides(const Vec3d& wanted) {
    std::string sides;
    for (const int axis : free_axes(grip_.domain)) {
        const double low = grip_.domain.min[axis], high = grip_.domain.max[axis];
        const double rounding = kRounding * (high - low + std::abs(low) + std::abs(high));
        if (wanted[axis] >= low - rounding && wanted[axis] <= high + rounding) continue;
        const double side = (wanted[axis] < low ? low : high) + grip_.origin[axis];
        sides += fmt::format("{}{} stops at {}", sides.empty() ? "" : ", ", "xyz"[axis],
                             metres(side, high - low < 1 ? 3 : 2));
    }
    stopped_ = {!sides.empty(), sides.empty() ? "" : sides + ": the map was baked up to there"};
}

}  // namespace pim
