// SPDX-License-Identifier: GPL-3.0-or-later
// Recursive ray tracing (Whitted: An Improved Illumination Model for Shaded Display, 1980): direct light by
// shadow rays at diffuse surfaces, mirrors and glass followed, nothing else. Glass casts shadows.
#pragma once

#include "common/render/path_radiance.h"

namespace pim {

// Radiance along the ray, W/(m² sr). Rectangular lamps take `shadow_samples` shadow rays per hit; 0: no
// light but that of lamps shown.
Rgb whitted_radiance(const PathScene& scene, const Ray& ray, int shadow_samples, RandomStream& random);

}  // namespace pim
