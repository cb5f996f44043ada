// SPDX-License-Identifier: GPL-3.0-or-later
// Photons: light sent from a lamp, followed until it is absorbed, escapes or is cut off (Jensen: Realistic
// Image Synthesis Using Photon Mapping, 2001, chapter 5).
#pragma once

#include <functional>
#include <span>

#include "common/scene/light.h"
#include "common/transport/scattering.h"

namespace pim {

// A photon is cut off after so many surfaces; what that loses is in the account.
inline constexpr int kMaxPhotonBounces = 1000;

// Where the light went. Flux is per emitted watt and channel, times the number of photons.
struct EnergyAccount {
    uint64_t emitted = 0, absorbed = 0, escaped = 0, cut_off = 0;  // photons: emitted = the sum of the others
    Vec3d absorbed_flux{0}, escaped_flux{0}, cut_off_flux{0};
    Vec3d normals_flux{0};  // taken (+) or given (-) by shading normals
    Vec3d squared_flux{0};  // sum over photons of the square of all four

    void add(const EnergyAccount& other);
    Vec3d total_flux() const { return absorbed_flux + escaped_flux + cut_off_flux + normals_flux; }
    // Standard error of total_flux() / emitted, per channel, about its expectation 1.
    Vec3d standard_error() const;
};

// A photon at a surface that is not glass.
struct Landing {
    SurfacePoint surface;
    Vec3 direction;        // travelled along, unit
    Rgb flux;              // that lands, as the shading normal sees it; the photon started with 1 per channel
    bool straight;         // it has met nothing before
    int surfaces_met;      // before this one
    bool begins_specular;  // the first of those was a mirror or glass,
    bool caustic;          // all of them were, and there are some
    bool ends;             // absorbed here,
    float chance_of_ending;  // which had this probability
};

// Calls landed(landing) wherever the photon meets a surface other than glass. One photon's share of the
// account is added to it; what is left after `most_surfaces` counts as cut off.
using LandingFunction = std::function<void(const Landing&)>;
void trace_photon(const Scene& scene, const RayCaster& caster, const Light& light, const Vec3& light_position,
                  RandomStream& random, const LandingFunction& landed, EnergyAccount& account,
                  int most_surfaces = kMaxPhotonBounces);

// Photons that leave the lamp along one way, one for each random stream, and go their own ways from the first
// surface on. Each by itself is like any other photon; together they cost less rays, for the noise of what
// they bring later nearly as many photons.
void trace_photons(const Scene& scene, const RayCaster& caster, const Emission& start,
                   std::span<RandomStream> random, const LandingFunction& landed, EnergyAccount& account,
                   int most_surfaces = kMaxPhotonBounces);

}  // namespace pim
