// SPDX-License-Identifier: GPL-3.0-or-later
// What happens to light at a surface: diffuse reflection, mirror reflection, refraction, absorption.
// Shading normals follow Veach, Robust Monte Carlo Methods for Light Transport Simulation, 1997, section 5.3:
// what is sent from the lamp and what is gathered from the eye agree.
#pragma once

#include <optional>

#include "common/transport/surface.h"

namespace pim {

enum class Transport { from_eye, from_lamp };
enum class Event { diffuse, specular };

struct Scattered {
    Event event;
    Vec3 direction;    // unit
    Rgb weight;        // reflectance / probability
    float correction;  // for shading normals, and radiance in glass; the throughput takes weight · correction
};

// Share of unreflected light at a smooth boundary (Fresnel); cosine of the incident angle in (0,1], relative
// index of refraction of the far side to the near side; 1 beyond the critical angle.
float fresnel_reflectance(float cosine, float relative_ior);

// How a ray along `incoming` (unit, towards the surface) goes on through glass: both ways, shares adding
// to 1.
struct GlassSplit {
    float reflected_share;
    Vec3 reflected, refracted;  // refracted counts only where reflected_share < 1
    float relative_ior;
};
GlassSplit split_at_glass(const SurfacePoint& surface, const Vec3& incoming);

Vec3 mirror(const Vec3& incoming, const Vec3& normal);

// Flux that lands, as seen by the shading normal: |w·ns| / |w·ng|, 0 where the shading normal faces away.
float landing_factor(const SurfacePoint& surface, const Vec3& incoming);

// Probability that keeps the largest channel of `throughput` constant under roulette; 1 for glass.
float survival_probability(const SurfacePoint& surface, const Rgb& throughput);

// One random continuation; none: absorbed. For Transport::from_lamp the throughput has landing_factor in it
// already where the surface is not glass.
std::optional<Scattered> scatter(const SurfacePoint& surface, const Vec3& incoming, const Rgb& throughput,
                                 float survival, Transport transport, RandomStream& random);

}  // namespace pim
