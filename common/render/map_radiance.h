// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures from a map: radiance along a ray with the map's irradiance at diffuse surfaces, and recursion at
// mirrors and glass.
#pragma once

#include "common/map/illumination_map.h"
#include "common/render/direct_light.h"

namespace pim {

enum class DirectLight { none, traced, baked };

// One moment of a scene: lamps in place, patches evaluated.
struct Moment {
    const Scene& scene;
    const RayCaster& caster;
    const IlluminationMap& map;
    std::vector<LightState> lights;
    DirectLight direct = DirectLight::traced;
    bool indirect = true;
    bool show_lamps = false;
    static constexpr int kShadowSamples = 16;
    int shadow_samples = kShadowSamples;  // per rectangular lamp and hit
    std::vector<Rgb> patch_values;        // from evaluate_patches
    std::size_t cut_values = 0;           // ... of which so many were negative, over channels
};

// Fills patch_values with the irradiance of the components that come from the map.
void evaluate_patches(Moment& moment);

// Irradiance at a surface, W/m²: from the map and from shadow rays.
Rgb surface_irradiance(const Moment& moment, const SurfacePoint& surface, RandomStream& random);

// Radiance along the ray, W/(m² sr); 0 where it meets nothing.
Rgb map_radiance(const Moment& moment, const Ray& ray, RandomStream& random);

}  // namespace pim
