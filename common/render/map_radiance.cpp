// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/render/map_radiance.h"

#include "common/map/irradiance.h"
#include "common/render/seen_radiance.h"

namespace pim {

void evaluate_patches(Moment& moment) {
    std::vector<Component> baked;
    if (moment.indirect) baked.push_back(Component::indirect);
    if (moment.direct == DirectLight::baked) baked.push_back(Component::direct);
    moment.patch_values = patch_irradiance(moment.map, baked, moment.lights, &moment.cut_values);
}

Rgb surface_irradiance(const Moment& m, const SurfacePoint& surface, RandomStream& random) {
    Rgb sum = irradiance_at(m.map, m.patch_values, surface.position, surface.shading_normal);
    if (m.direct == DirectLight::traced)
        sum += direct_irradiance(m.caster, m.scene.lights, m.lights, surface, m.shadow_samples, random);
    return sum;
}

Rgb map_radiance(const Moment& moment, const Ray& ray, RandomStream& random) {
    return seen_radiance(moment, ray, [&](const SurfacePoint& surface) {
        return surface_irradiance(moment, surface, random);
    });
}

}  // namespace pim
