// SPDX-License-Identifier: GPL-3.0-or-later
// A lamp that the mouse holds by one of its handles.
#pragma once

#include <optional>
#include <string>

#include "common/render/camera_rays.h"
#include "viewer/interaction/gizmo.h"

namespace pim {

// Where the drag began.
struct Grip {
    Handle handle;
    Vec3 position{0};  // of the lamp, local, m
    Box3 domain;       // local, m
    Vec3d origin{0};   // the geometry's: local + origin = world
    Vec2 mouse{0};     // pixels
};

// Which sides of the domain hold the lamp back although the mouse went on.
struct Stopped {
    bool at_domain = false;
    std::string text;  // in world coordinates, such as "x stops at 3.20 m: the map was baked up to there"
};

// The line or plane through the lamp's position on which a handle keeps it.
struct Constraint {
    enum class Kind { line, plane } kind;
    Vec3d direction;  // unit: along the line, or the plane's normal
};
Constraint constraint(const Camera& camera, const Handle& handle, const Box3& domain);

// Arrows: to the place of the axis nearest to the mouse's ray. Squares: to where the ray meets their plane.
// The dot: the plane through the lamp that faces the camera; of a domain with two axes or one that plane or
// line, so that the lamp stays under the mouse. Always relative to where the mouse grasped, and inside the
// domain. Where the ray runs within 2° of the plane or axis, or meets it behind the eye, the lamp stays where
// it is.
class GizmoDrag {
  public:
    GizmoDrag(const Camera& camera, const Imath::V2i& size, const Grip& grip);

    Vec3 move(const Vec2& mouse);  // the lamp's new position, local, m
    const Stopped& stopped() const { return stopped_; }
    const Handle& handle() const { return grip_.handle; }

  private:
    std::optional<Vec3d> grasped(const Vec2& mouse) const;  // where the mouse holds line or plane
    void note_sides(const Vec3d& wanted);

    CameraRays rays_;
    Grip grip_;
    Constraint constraint_;
    std::optional<Vec3d> grasp_;  // under the mouse at the beginning
    Vec3 position_;
    Stopped stopped_;
};

}  // namespace pim
