// SPDX-License-Identifier: GPL-3.0-or-later
// Radiance along a ray where the irradiance of diffuse surfaces is known.
#pragma once

#include "common/map/illumination_map.h"
#include "common/render/specular_walk.h"

namespace pim {

// The nearest shining rectangle along the ray before `limit`: its radiance.
inline std::optional<Rgb> lamp_met(const std::vector<Light>& lights, const std::vector<LightState>& states,
                                   const Ray& ray, float limit) {
    std::optional<Rgb> radiance;
    for (std::size_t l = 0; l < lights.size(); ++l) {
        const RectangleShape* shape = lights[l].rectangle();
        if (!shape) continue;
        const auto distance = intersect(*shape, states[l].position, ray.origin, ray.direction);
        if (!distance || *distance >= limit) continue;
        limit = *distance;
        radiance = emitted_radiance(*shape, states[l].power);
    }
    return radiance;
}

// W/(m² sr): L = rho E / pi with E = irradiance(surface) at diffuse surfaces, seen straight and by way of
// mirrors and glass; 0 where the ray meets nothing. `lit` has scene, caster, lights (their states) and
// show_lamps.
template <class Lit, class Irradiance>
Rgb seen_radiance(const Lit& lit, const Ray& ray, const Irradiance& irradiance) {
    struct Visitor {
        const Lit& lit;
        const Irradiance& irradiance;
        Rgb sum{0};

        bool segment(const Ray& along, float until, const Rgb& throughput) {
            if (!lit.show_lamps) return false;
            const auto lamp = lamp_met(lit.scene.lights, lit.lights, along, until);
            if (lamp) sum += *lamp * throughput;
            return lamp.has_value();
        }
        void diffuse(const SurfacePoint& surface, const Rgb& throughput) {
            sum += throughput * surface.diffuse / kPi * irradiance(surface);
        }
    };
    Visitor visitor{lit, irradiance};
    SpecularWalk<Visitor>(lit.scene, lit.caster, visitor).follow(ray, Rgb(1));
    return visitor.sum;
}

}  // namespace pim
