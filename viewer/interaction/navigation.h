// SPDX-License-Identifier: GPL-3.0-or-later
// What mouse and keys do to the camera. Mouse travel `dx` (right) and `dy` (down) is in fractions of the
// picture's height, so that windows of all sizes feel alike; positions are local, m. `up` is the vertical and
// stays as it is, and the view keeps 1° away from it.
//
// A camera that cannot be turned is first put right: no `up` becomes y, an eye on its target gets a target 1
// m ahead, a view exactly along `up` is tilted by 1°.
#pragma once

#include "common/scene/camera.h"

namespace pim {

// The eye goes round the target, 180° per height of the picture; the scene turns with the mouse: the eye goes
// left for dx > 0 and up for dy > 0.
void orbit(Camera& camera, float dx, float dy);

// Eye and target move in parallel so that what lies at the target's distance stays under the mouse.
void pan(Camera& camera, float dx, float dy);

// Each step takes a tenth off the distance to the target, each negative step puts it back. Stops 1 mm before
// the target (earlier far from the origin, where floats are coarser) and 1000 km away from it.
void zoom(Camera& camera, float steps);

// The target goes round the eye, one vertical field of view per height of the picture: where the mouse goes
// is where one looks.
void look(Camera& camera, float dx, float dy);

// Eye and target move by these lengths, m, to the right, along `up`, and along the viewing direction.
void walk(Camera& camera, const Vec3& right_up_forward);

// Degrees, clamped to 5..150; NaN changes nothing.
void set_fov(Camera& camera, float degrees);

// m/s: a tenth of the scene's diagonal per second; 1 where there is no scene.
float walk_speed(const Box3& bounds);

}  // namespace pim
