// SPDX-License-Identifier: GPL-3.0-or-later
// The handles by which a lamp is moved: an arrow per axis, a square per pair of axes, a dot in the middle.
// They have the same size on the screen however far the lamp is, and exist only where the lamp's domain has
// extent. Nothing is drawn here: the shapes are pixels as in projection.h. Positions and domains are local,
// m.
#pragma once

#include <optional>
#include <vector>

#include "viewer/interaction/projection.h"

namespace pim {

// What a handle moves the lamp along. `axis`: the arrow's own; of a square the one that stays; 0 of the dot.
struct Handle {
    enum class Kind { plane, axis, centre };  // in the order of drawing; the later ones are grasped first
    Kind kind = Kind::centre;
    int axis = 0;
    bool operator==(const Handle&) const = default;
};

inline constexpr float kHandlePixels = 90;  // length of an arrow that lies across the view
inline constexpr float kReachPixels = 8;    // how far from a handle the mouse still grasps it

// Axes along which the domain has extent.
std::vector<int> free_axes(const Box3& domain);

struct HandleShape {
    Handle handle;
    std::vector<Vec2> line;  // an arrow's shaft, two points; else empty
    std::vector<Vec2> area;  // convex: an arrow's head, the square, the dot
    bool highlighted = false;
};

// In the order of drawing. Empty where the lamp is behind the eye or cannot move. Arrows along the view and
// squares seen edge-on are left out: nothing could be moved by them.
struct GizmoShape {
    std::vector<HandleShape> handles;
};

GizmoShape gizmo_shape(const Camera& camera, const Imath::V2i& size, const Vec3& position, const Box3& domain,
                       const std::optional<Handle>& highlighted = std::nullopt);

// The handle under the mouse, else the nearest within kReachPixels.
std::optional<Handle> pick(const Camera& camera, const Imath::V2i& size, const Vec3& position,
                           const Box3& domain, const Vec2& mouse);

}  // namespace pim
