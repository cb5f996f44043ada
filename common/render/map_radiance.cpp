// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/render/map_radiance.h"

#include "common/map/irradiance.h"
#include "common/render/specular_walk.h"

namespace pim {
namespace {

// The nearest shining rectangle along the ray before `limit`, if lamps are shown.
std::optional<Rgb> visible_lamp(const Moment& m, const Ray& ray, float limit) {
    std::optional<Rgb> radiance;
    for (std::size_t l = 0; m.show_lamps && l < m.lights.size(); ++l) {
        const RectangleShape* shape = m.scene.lights[l].rectangle();
        if (!shape) continue;
        const auto distance = intersect(*shape, m.lights[l].position, ray.origin, ray.direction);
        if (!distance || *distance >= limit) continue;
        limit = *distance;
        radiance = emitted_radiance(*shape, m.lights[l].power);
    }
    return radiance;
}

Rgb traced_direct(const Moment& m, const SurfacePoint& surface, RandomStream& random) {
    Rgb sum(0);
    if (m.direct != DirectLight::traced) return sum;
    for (std::size_t l = 0; l < m.lights.size(); ++l)
        sum += direct_irradiance(m.caster, m.scene.lights[l], m.lights[l], surface, m.shadow_samples, random);
    return sum;
}

struct Radiance {
    const Moment& moment;
    RandomStream& random;
    Rgb sum{0};

    bool segment(const Ray& ray, float until, const Rgb& throughput) {
        const auto lamp = visible_lamp(moment, ray, until);
        if (lamp) sum += *lamp * throughput;
        return lamp.has_value();
    }
    void diffuse(const SurfacePoint& surface, const Rgb& throughput) {
        sum += throughput * surface.diffuse / kPi *
               surface_irradiance(moment, surface, random);  // L = rho E / pi
    }
};

}  // namespace

void evaluate_patches(Moment& moment) {
    std::vector<Component> baked;
    if (moment.indirect) baked.push_back(Component::indirect);
    if (moment.direct == DirectLight::baked) baked.push_back(Component::direct);
    moment.patch_values = patch_irradiance(moment.map, baked, moment.lights);
}

Rgb surface_irradiance(const Moment& moment, const SurfacePoint& surface, RandomStream& random) {
    return irradiance_at(moment.map, moment.patch_values, surface.position, surface.shading_normal) +
           traced_direct(moment, surface, random);
}

Rgb map_radiance(const Moment& moment, const Ray& ray, RandomStream& random) {
    Radiance radiance{moment, random};
    SpecularWalk<Radiance>(moment.scene, moment.caster, radiance).follow(ray, Rgb(1));
    return radiance.sum;
}

}  // namespace pim
