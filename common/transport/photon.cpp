// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/transport/photon.h"

#include <cmath>

namespace pim {
namespace {

enum class Fate { absorbed, escaped, cut_off };

struct Photon {
    Ray ray;
    Rgb flux{1};
    EnergyAccount lost;
};

std::optional<SurfacePoint> next_surface(const Scene& scene, const RayCaster& caster, const Ray& ray) {
    const auto hit = caster.intersect(ray);
    return hit ? std::optional(surface_at(scene, *hit)) : std::nullopt;
}

// From the first surface on; none: it met nothing.
Fate follow(const Scene& scene, const RayCaster& caster, std::optional<SurfacePoint> next, Photon& photon,
            RandomStream& random, const LandingFunction& landed, int most_surfaces) {
    bool begins_specular = false, all_specular = true;
    for (int met = 0; met < most_surfaces; ++met) {
        if (met > 0) next = next_surface(scene, caster, photon.ray);
        if (!next) return Fate::escaped;
        const SurfacePoint& surface = *next;
        const Vec3 in = photon.ray.direction;
        if (!surface.material->glass) {
            const Rgb flux = photon.flux * landing_factor(surface, in);
            photon.lost.normals_flux += Vec3d(photon.flux - flux);
            photon.lost.absorbed_flux += Vec3d(flux * (Rgb(1) - surface.diffuse - surface.specular));
            photon.flux = flux;
        }
        const float survival = survival_probability(surface, photon.flux);
        const auto scattered = scatter(surface, in, photon.flux, survival, Transport::from_lamp, random);
        if (!surface.material->glass)
            landed({surface, in, photon.flux, met == 0, met, begins_specular, met > 0 && all_specular,
                    !scattered, 1 - survival});
        if (!scattered) return Fate::absorbed;
        photon.lost.normals_flux += Vec3d(photon.flux * scattered->weight * (1 - scattered->correction));
        if (!(scattered->correction > 0)) return Fate::absorbed;
        if (met == 0) begins_specular = scattered->event == Event::specular;
        all_specular = all_specular && scattered->event == Event::specular;
        photon.flux *= scattered->weight * scattered->correction;
        photon.ray = {surface.leave(scattered->direction, caster.surface_offset()), scattered->direction};
    }
    return Fate::cut_off;
}

void add_to(EnergyAccount& account, Photon& photon, Fate fate) {
    EnergyAccount& own = photon.lost;
    own.emitted = 1;
    own.absorbed = fate == Fate::absorbed;
    own.escaped = fate == Fate::escaped;
    own.cut_off = fate == Fate::cut_off;
    if (fate == Fate::escaped) own.escaped_flux = Vec3d(photon.flux);
    if (fate == Fate::cut_off) own.cut_off_flux = Vec3d(photon.flux);
    const Vec3d total = own.total_flux();
    own.squared_flux = total * total;
    account.add(own);
}

}  // namespace

void EnergyAccount::add(const EnergyAccount& o) {
    emitted += o.emitted, absorbed += o.absorbed, escaped += o.escaped, cut_off += o.cut_off;
    absorbed_flux += o.absorbed_flux, escaped_flux += o.escaped_flux, cut_off_flux += o.cut_off_flux;
    normals_flux += o.normals_flux, squared_flux += o.squared_flux;
}

Vec3d EnergyAccount::standard_error() const {
    if (emitted < 2) return Vec3d(1);
    const Vec3d mean = total_flux() / double(emitted);
    const Vec3d variance = squared_flux / double(emitted) - mean * mean;
    Vec3d error;
    for (int c = 0; c < 3; ++c) error[c] = std::sqrt(std::max(0.0, variance[c]) / double(emitted));
    return error;
}

void trace_photon(const Scene& scene, const RayCaster& caster, const Light& light, const Vec3& light_position,
                  RandomStream& random, const LandingFunction& landed, EnergyAccount& account,
                  int most_surfaces) {
    const Emission start = sample_emission(light, light_position, random);
    trace_photons(scene, caster, start, {&random, 1}, landed, account, most_surfaces);
}

void trace_photons(const Scene& scene, const RayCaster& caster, const Emission& start,
                   std::span<RandomStream> random, const LandingFunction& landed, EnergyAccount& account,
                   int most_surfaces) {
    const Ray ray{start.origin, start.direction};
    const auto first = next_surface(scene, caster, ray);
    for (RandomStream& own : random) {
        Photon photon{.ray = ray, .lost = {}};
        add_to(account, photon, follow(scene, caster, first, photon, own, landed, most_surfaces));
    }
}

}  // namespace pim
