// SPDX-License-Identifier: GPL-3.0-or-later
// Places of the scene to places in the picture: the inverse of CameraRays::through. Pixels, (0, 0) the upper
// left corner, y down.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "common/scene/camera.h"

namespace pim {

// Unit vectors of the picture. An `up` along the viewing direction gets any `right` across it; an eye on its
// target looks along -z.
struct ViewAxes {
    Vec3d right, up, forward;
};
ViewAxes view_axes(const Camera& camera);

class Projection {
  public:
    Projection(const Camera& camera, const Imath::V2i& size);

    // None for places behind the eye. Places beside the picture have pixels outside of it.
    std::optional<Vec2> pixel(const Vec3d& point) const;

    // What is left of a line or of a convex polygon in front of the eye and within three times the picture's
    // width and height about its middle; empty if nothing is.
    std::vector<Vec2> line(const Vec3d& from, const Vec3d& to) const;
    std::vector<Vec2> polygon(const std::vector<Vec3d>& corners) const;

    // Length that one pixel spans across the view at the place's depth, m; none behind the eye.
    std::optional<double> pixel_length(const Vec3d& point) const;

  private:
    Vec3d to_camera(
        const Vec3d& point) const;  // right and down in halves of the picture at depth 1; depth, m
    Vec2 to_pixel(const Vec3d& in_camera) const;
    std::vector<Vec2> clipped(std::vector<Vec3d> points, bool closed) const;

    Vec3d eye_, right_, down_, forward_;
    double half_height_;  // of the picture at distance 1
    Imath::V2i size_;
};

// One place; Projection::pixel.
std::optional<Vec2> project(const Camera& camera, const Imath::V2i& size, const Vec3& point);

// The edges of a lamp's domain as the picture sees them, clipped as in Projection::line: up to 12, 4 of a
// flat domain, 1 of a line, none of a point.
using Edge = std::array<Vec2, 2>;
std::vector<Edge> domain_edges(const Camera& camera, const Imath::V2i& size, const Box3& domain);

}  // namespace pim
