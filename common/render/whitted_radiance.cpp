// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/render/whitted_radiance.h"

#include "common/render/direct_light.h"
#include "common/render/seen_radiance.h"

namespace pim {

Rgb whitted_radiance(const PathScene& s, const Ray& ray, int shadow_samples, RandomStream& random) {
    return seen_radiance(s, ray, [&](const SurfacePoint& surface) {
        if (shadow_samples == 0) return Rgb(0);
        return direct_irradiance(s.caster, s.scene.lights, s.lights, surface, shadow_samples, random);
    });
}

}  // namespace pim
