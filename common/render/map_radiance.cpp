// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/render/map_radiance.h"

#include "common/map/irradiance.h"
#include "common/transport/scattering.h"

namespace pim {
namespace {

constexpr int kDeepestReflection = 12;
constexpr float kLeastShare = 1e-3f;  // reflections that contribute less are not followed

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

struct Walk {
    const Moment& moment;
    RandomStream& random;
    Rgb radiance{0};

    void follow(const Ray& ray, const Rgb& throughput, int depth) {
        const auto hit = moment.caster.intersect(ray);
        const float limit = hit ? hit->distance : std::numeric_limits<float>::infinity();
        if (const auto lamp = visible_lamp(moment, ray, limit)) {
            radiance += *lamp * throughput;
            return;
        }
        if (!hit) return;
        const SurfacePoint surface = surface_at(moment.scene, *hit);
        if (!is_black(surface.diffuse)) add_diffuse(surface, throughput);
        if (depth == kDeepestReflection) return;
        if (surface.material->glass)
            follow_glass(surface, ray.direction, throughput, depth);
        else
            go_on(surface, mirror(ray.direction, surface.shading_normal), throughput * surface.specular,
                  depth);
    }

    void add_diffuse(const SurfacePoint& surface, const Rgb& throughput) {
        const Rgb share = throughput * surface.diffuse / kPi;  // L = rho E / pi
        const Rgb baked =
            irradiance_at(moment.map, moment.patch_values, surface.position, surface.shading_normal);
        radiance += share * (baked + traced_direct(moment, surface, random));
    }

    void follow_glass(const SurfacePoint& surface, const Vec3& in, const Rgb& throughput, int depth) {
        const GlassSplit split = split_at_glass(surface, in);
        go_on(surface, split.reflected, throughput * split.reflected_share, depth);
        const float scale = 1 / (split.relative_ior * split.relative_ior);
        if (split.reflected_share < 1)
            go_on(surface, split.refracted, throughput * ((1 - split.reflected_share) * scale), depth);
    }

    void go_on(const SurfacePoint& surface, const Vec3& direction, const Rgb& throughput, int depth) {
        if (max_channel(throughput) < kLeastShare) return;
        follow({surface.leave(direction, moment.caster.surface_offset()), direction}, throughput, depth + 1);
    }
};

}  // namespace

void evaluate_patches(Moment& moment) {
    moment.patch_values.assign(moment.map.patches.size(), Rgb(0));
    const auto add = [&](Component component) {
        const auto values = patch_irradiance(moment.map, component, moment.lights);
        for (std::size_t p = 0; p < values.size(); ++p) moment.patch_values[p] += values[p];
    };
    if (moment.indirect) add(Component::indirect);
    if (moment.direct == DirectLight::baked) add(Component::direct);
}

Rgb surface_irradiance(const Moment& moment, const SurfacePoint& surface, RandomStream& random) {
    return irradiance_at(moment.map, moment.patch_values, surface.position, surface.shading_normal) +
           traced_direct(moment, surface, random);
}

Rgb map_radiance(const Moment& moment, const Ray& ray, RandomStream& random) {
    Walk walk{moment, random};
    walk.follow(ray, Rgb(1), 0);
    return walk.radiance;
}

}  // namespace pim
