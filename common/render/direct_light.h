// SPDX-License-Identifier: GPL-3.0-or-later
// Light that comes straight from a lamp, found by shadow rays.
#pragma once

#include "common/map/illumination_map.h"
#include "common/transport/surface.h"

namespace pim {

// Irradiance at `surface` from one lamp, as its shading normal sees it, W/m². A rectangular lamp takes
// `samples` stratified shadow rays, jittered by `random`; a point lamp one.
Rgb direct_irradiance(const RayCaster& caster, const Light& light, const LightState& state,
                      const SurfacePoint& surface, int samples, RandomStream& random);

// From all of them.
Rgb direct_irradiance(const RayCaster& caster, const std::vector<Light>& lights,
                      const std::vector<LightState>& states, const SurfacePoint& surface, int samples,
                      RandomStream& random);

}  // namespace pim
