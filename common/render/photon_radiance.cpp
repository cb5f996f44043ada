// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/render/photon_radiance.h"

#include <cassert>

#include "common/core/sampling.h"
#include "common/render/seen_radiance.h"

namespace pim {
namespace {

void append(std::vector<StoredPhoton>& to, const std::vector<StoredPhoton>& more) {
    to.insert(to.end(), more.begin(), more.end());
}

Rgb traced_direct(const PhotonScene& s, const SurfacePoint& surface, int samples, RandomStream& random) {
    return direct_irradiance(s.lit.caster, s.lit.scene.lights, s.lit.lights, surface, samples, random);
}

// Light that a gathering ray finds: rho E / pi of the diffuse surfaces it meets. Lamps that it meets,
// straight or by way of mirrors and glass, are in the direct part and in the caustic map already.
Rgb gathered_radiance(const PhotonScene& s, const Ray& ray, RandomStream& random) {
    const PathScene& lit = s.lit;
    struct {
        const Scene& scene;
        const RayCaster& caster;
        const std::vector<LightState>& lights;
        bool show_lamps = false;
    } const dark_lamps{lit.scene, lit.caster, lit.lights};
    return seen_radiance(dark_lamps, ray, [&](const SurfacePoint& met) {
        return traced_direct(s, met, 1, random) +
               s.global.nearby_irradiance(met.position, met.geometric_normal);
    });
}

// E = pi mean(L) over directions of cosine density, stratified.
Rgb gathered_irradiance(const PhotonScene& s, const SurfacePoint& surface, RandomStream& random) {
    const int rows = std::max(1, int(std::sqrt(float(s.options.gather)))),
              columns = (s.options.gather + rows - 1) / rows, count = rows * columns;
    const Frame frame(surface.shading_normal);
    Rgb sum(0);
    for (int i = 0; i < count; ++i) {
        const int row = i / columns, column = i % columns;
        const float a = random.next(), b = random.next();
        const float u = (float(row) + a) / float(rows), v = (float(column) + b) / float(columns);
        const Vec3 out = frame.to_world(sample_cosine_hemisphere(u, v));
        if (out.dot(surface.geometric_normal) <= 0) continue;
        sum += gathered_radiance(s, {surface.leave(out, s.lit.caster.surface_offset()), out}, random);
    }
    return sum * (kPi / float(count));
}

Rgb irradiance(const PhotonScene& s, const SurfacePoint& surface, RandomStream& random) {
    Rgb sum(0);
    if (s.options.direct == DirectLight::traced)
        sum += traced_direct(s, surface, s.options.shadow_samples, random);
    if (s.options.indirect) sum += s.caustic.irradiance(surface.position, surface.geometric_normal);
    if (s.options.gather == 0)
        sum += s.global.irradiance(surface.position, surface.geometric_normal);
    else if (s.options.indirect)
        sum += gathered_irradiance(s, surface, random);
    return sum;
}

}  // namespace

PhotonScene build_photon_maps(PathScene lit, ShotPhotons photons, const PhotonMapOptions& options) {
    assert(options.gather == 0 || options.direct != DirectLight::baked);
    std::vector<StoredPhoton> global;
    if (options.indirect) global = std::move(photons.diffuse);
    if (options.indirect && options.gather > 0) append(global, photons.caustic);
    if (options.direct == DirectLight::baked) append(global, photons.straight);
    if (!options.indirect) photons.caustic.clear();
    PhotonScene scene{std::move(lit), options, PhotonMap(global, options.nearest, Filter::none),
                      PhotonMap(photons.caustic, options.nearest, Filter::cone)};
    if (options.gather > 0) scene.global.precompute_irradiance();
    return scene;
}

Rgb photon_radiance(const PhotonScene& scene, const Ray& ray, RandomStream& random) {
    return seen_radiance(scene.lit, ray,
                         [&](const SurfacePoint& surface) { return irradiance(scene, surface, random); });
}

}  // namespace pim
