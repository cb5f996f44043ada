// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/interaction/projection.h"

#include <cmath>

namespace pim {
namespace {

constexpr double kNearest = 1e-4;     // m: nothing nearer is drawn
constexpr double kBesidePicture = 3;  // pictures across: keeps pixels in the range where floats draw well
constexpr double kParallel = 1e-7;    // sine

Vec3d across(const Vec3d& direction) {
    const Vec3d magnitude(std::abs(direction.x), std::abs(direction.y), std::abs(direction.z));
    Vec3d axis(0);
    axis[magnitude.x <= magnitude.y && magnitude.x <= magnitude.z ? 0
         : magnitude.y <= magnitude.z                             ? 1
                                                                  : 2] = 1;
    return direction.cross(axis).normalized();
}

// Signed distance, up to a factor, of a point in camera coordinates from the k-th side of the drawn region.
double inside(int side, const Vec3d& p) {
    if (side == 4) return p.z - kNearest;
    const double coordinate = side < 2 ? p.x : p.y;
    return kBesidePicture * p.z + (side % 2 == 0 ? coordinate : -coordinate);
}

// Sutherland and Hodgman 1974: one side of the region after the other; a line is a polygon without its last
// edge.
std::vector<Vec3d> clip(const std::vector<Vec3d>& points, int side, bool closed) {
    std::vector<Vec3d> kept;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Vec3d &p = points[i], &next = points[(i + 1) % points.size()];
        const double a = inside(side, p), b = inside(side, next);
        if (a >= 0) kept.push_back(p);
        const bool edge = closed || i + 1 < points.size();
        if (edge && (a >= 0) != (b >= 0)) kept.push_back(p + (next - p) * (a / (a - b)));
    }
    return kept;
}

}  // namespace

ViewAxes view_axes(const Camera& camera) {
    const Vec3d path = Vec3d(camera.target) - Vec3d(camera.eye), up(camera.up);
    const Vec3d forward = path.length() > 0 ? path.normalized() : Vec3d(0, 0, -1);
    const Vec3d sideways = forward.cross(up);
    const Vec3d right = sideways.length() > kParallel * up.length() ? sideways.normalized() : across(forward);
    return {right, right.cross(forward), forward};
}

Projection::Projection(const Camera& camera, const Imath::V2i& size)
    : eye_(camera.eye), half_height_(std::tan(double(camera.vertical_fov) * M_PI / 360)), size_(size) {
    const ViewAxes axes = view_axes(camera);
    forward_ = axes.forward;
    right_ = axes.right / (half_height_ * size.x / size.y);
    down_ = axes.up / -half_height_;
}

Vec3d Projection::to_camera(const Vec3d& point) const {
    const Vec3d path = point - eye_;
    return {path.dot(right_), path.dot(down_), path.dot(forward_)};
}

Vec2 Projection::to_pixel(const Vec3d& in_camera) const {
    return {float(0.5 * (in_camera.x / in_camera.z + 1) * size_.x),
            float(0.5 * (in_camera.y / in_camera.z + 1) * size_.y)};
}

std::vector<Vec2> Projection::clipped(std::vector<Vec3d> points, bool closed) const {
    for (Vec3d& p : points) p = to_camera(p);
    for (int side = 0; side < 5; ++side) points = clip(points, side, closed);
    std::vector<Vec2> pixels;
    for (const Vec3d& p : points) pixels.push_back(to_pixel(p));
    return pixels;
}

std::optional<Vec2> Projection::pixel(const Vec3d& point) const {
    const Vec3d p = to_camera(point);
    if (!(p.z >= kNearest)) return std::nullopt;
    return to_pixel(p);
}

std::vector<Vec2> Projection::line(const Vec3d& from, const Vec3d& to) const {
    return clipped({from, to}, false);
}

std::vector<Vec2> Projection::polygon(const std::vector<Vec3d>& corners) const {
    return clipped(corners, true);
}

std::optional<double> Projection::pixel_length(const Vec3d& point) const {
    const double depth = to_camera(point).z;
    if (!(depth >= kNearest)) return std::nullopt;
    return 2 * half_height_ * depth / size_.y;
}

std::optional<Vec2> project(const Camera& camera, const Imath::V2i& size, const Vec3& point) {
    return Projection(camera, size).pixel(Vec3d(point));
}

std::vector<Edge> domain_edges(const Camera& camera, const Imath::V2i& size, const Box3& domain) {
    const Projection projection(camera, size);
    const Vec3d extent = Vec3d(domain.max) - Vec3d(domain.min);
    std::vector<Edge> edges;
    for (int axis = 0; axis < 3; ++axis) {
        if (!(extent[axis] > 0)) continue;
        const int a = (axis + 1) % 3, b = (axis + 2) % 3;
        for (int corner = 0; corner < 4; ++corner) {
            const int at_a = corner & 1, at_b = corner >> 1;
            if ((at_a && !(extent[a] > 0)) || (at_b && !(extent[b] > 0))) continue;  // the same edge again
            Vec3d from(domain.min);
            if (at_a) from[a] = domain.max[a];
            if (at_b) from[b] = domain.max[b];
            Vec3d to = from;
            to[axis] = domain.max[axis];
            const std::vector<Vec2> line = projection.line(from, to);
            if (line.size() == 2) edges.push_back({line[0], line[1]});
        }
    }
    return edges;
}

}  // namespace pim
