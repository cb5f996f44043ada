// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/interaction/gizmo.h"

#include <algorithm>
#include <cmath>

namespace pim {
namespace {

// Fractions of an arrow's length.
constexpr double kShaftStart = 0.12, kSquareStart = 0.35, kSquareEnd = 0.6;
constexpr float kHeadLength = 14, kHeadWidth = 10, kDotRadius = 5;  // pixels
constexpr float kDrawnHalfWidth = 3;                                // of lines, as the mouse feels it, pixels
constexpr int kDotCorners = 16;
constexpr double kLeastSine = 0.07;  // 4°: between the view and what a handle moves along

Vec3d unit(int axis) {
    Vec3d v(0);
    v[axis] = 1;
    return v;
}

struct Lamp {
    Projection projection;
    Vec3d position, view;  // unit, from the eye
    double arrow;          // length, m
};

HandleShape arrow_shape(const Lamp& lamp, int axis) {
    HandleShape shape{{Handle::Kind::axis, axis}, {}, {}};
    const Vec3d arm = unit(axis) * lamp.arrow;
    shape.line = lamp.projection.line(lamp.position + arm * kShaftStart, lamp.position + arm);
    const std::optional<Vec2> tip = lamp.projection.pixel(lamp.position + arm);
    if (shape.line.size() != 2 || !tip) return shape;
    const Vec2 shaft = shape.line[1] - shape.line[0];
    if (!(shaft.length() > 0)) return shape;
    const Vec2 along = shaft.normalized(), across(-along.y, along.x);
    const Vec2 base = *tip - along * std::min(kHeadLength, shaft.length());
    shape.area = {*tip, base + across * (kHeadWidth / 2), base - across * (kHeadWidth / 2)};
    return shape;
}

HandleShape square_shape(const Lamp& lamp, int normal) {
    const Vec3d a = unit((normal + 1) % 3) * lamp.arrow, b = unit((normal + 2) % 3) * lamp.arrow;
    const auto corner = [&](double s, double t) { return lamp.position + a * s + b * t; };
    return {{Handle::Kind::plane, normal},
            {},
            lamp.projection.polygon({corner(kSquareStart, kSquareStart), corner(kSquareEnd, kSquareStart),
                                     corner(kSquareEnd, kSquareEnd), corner(kSquareStart, kSquareEnd)})};
}

HandleShape dot_shape(const Lamp& lamp) {
    HandleShape shape{{Handle::Kind::centre, 0}, {}, {}};
    const Vec2 middle = *lamp.projection.pixel(lamp.position);
    for (int i = 0; i < kDotCorners; ++i) {
        const float angle = 2 * kPi * float(i) / kDotCorners;
        shape.area.push_back(middle + Vec2(std::cos(angle), std::sin(angle)) * kDotRadius);
    }
    return shape;
}

float distance_to_line(const Vec2& p, const Vec2& from, const Vec2& to) {
    const Vec2 path = to - from;
    const float length2 = path.length2();
    const float t = length2 > 0 ? std::clamp((p - from).dot(path) / length2, 0.0f, 1.0f) : 0.0f;
    return (p - (from + path * t)).length();
}

bool contains(const std::vector<Vec2>& convex, const Vec2& p) {
    bool left = false, right = false;
    for (std::size_t i = 0; i < convex.size(); ++i) {
        const Vec2 edge = convex[(i + 1) % convex.size()] - convex[i];
        const float turn = edge.cross(p - convex[i]);
        left |= turn > 0, right |= turn < 0;
    }
    return convex.size() > 2 && !(left && right);
}

// 0 on what is drawn.
float distance_to(const HandleShape& shape, const Vec2& mouse) {
    if (contains(shape.area, mouse)) return 0;
    float distance = INFINITY;
    for (std::size_t i = 0; i < shape.area.size(); ++i)
        distance = std::min(distance,
                            distance_to_line(mouse, shape.area[i], shape.area[(i + 1) % shape.area.size()]));
    if (shape.line.size() == 2) {
        const float to_shaft = distance_to_line(mouse, shape.line[0], shape.line[1]);
        distance = std::min(distance, to_shaft <= kDrawnHalfWidth ? 0 : to_shaft);
    }
    return distance;
}

}  // namespace

std::vector<int> free_axes(const Box3& domain) {
    std::vector<int> axes;
    for (int axis = 0; axis < 3; ++axis)
        if (domain.max[axis] > domain.min[axis]) axes.push_back(axis);
    return axes;
}

GizmoShape gizmo_shape(const Camera& camera, const Imath::V2i& size, const Vec3& position, const Box3& domain,
                       const std::optional<Handle>& highlighted) {
    const Projection projection(camera, size);
    const Vec3d place(position);
    const std::optional<double> pixel = projection.pixel_length(place);
    const std::vector<int> axes = free_axes(domain);
    if (!pixel || axes.empty()) return {};
    const Lamp lamp{projection, place, (place - Vec3d(camera.eye)).normalized(), *pixel * kHandlePixels};
    GizmoShape gizmo;
    for (int normal = 0; normal < 3; ++normal)
        if (std::ranges::count(axes, normal) == (axes.size() == 3 ? 1 : 0) && axes.size() > 1 &&
            std::abs(lamp.view[normal]) > kLeastSine)
            gizmo.handles.push_back(square_shape(lamp, normal));
    for (const int axis : axes)
        if (lamp.view.cross(unit(axis)).length() > kLeastSine)
            gizmo.handles.push_back(arrow_shape(lamp, axis));
    gizmo.handles.push_back(dot_shape(lamp));
    std::erase_if(gizmo.handles, [](const HandleShape& h) { return h.line.empty() && h.area.empty(); });
    for (HandleShape& shape : gizmo.handles) shape.highlighted = shape.handle == highlighted;
    return gizmo;
}

std::optional<Handle> pick(const Camera& camera, const Imath::V2i& size, const Vec3& position,
                           const Box3& domain, const Vec2& mouse) {
    std::optional<Handle> nearest;
    float best = kReachPixels;
    for (const HandleShape& shape : gizmo_shape(camera, size, position, domain).handles)
        if (const float distance = distance_to(shape, mouse); distance <= best) {
            best = distance;
            nearest = shape.handle;
        }
    return nearest;
}

}  // namespace pim
