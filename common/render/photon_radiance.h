// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures from photon maps (Jensen 2001, chapters 7 to 9): direct light by shadow rays, caustics from a map
// of their own, the rest from a second map, at the surface itself or gathered.
#pragma once

#include "common/render/map_radiance.h"
#include "common/render/photon_map.h"

namespace pim {

struct PhotonMapOptions {
    uint64_t photons_per_lamp = 40000;
    int nearest = 50;  // photons per estimate, 2 or more
    int gather = 0;    // rays of final gathering per diffuse surface seen, rounded up to a product of two
                       // like factors; 0: the map is seen itself
    DirectLight direct = DirectLight::traced;  // baked: from photons too
    bool indirect = true;
    int shadow_samples = Moment::kShadowSamples;  // per rectangular lamp and hit
    uint64_t seed = 1;
};

// A moment with its photons shot.
struct PhotonScene {
    PathScene lit;
    PhotonMapOptions options;
    PhotonMap global;   // indirect light that caustics do not hold, or that gathering rays meet
    PhotonMap caustic;  // mirrors and glass alone between lamp and surface
};

// Builds the trees of what has been shot. Final gathering needs direct light traced, or none.
PhotonScene build_photon_maps(PathScene lit, ShotPhotons photons, const PhotonMapOptions& options);

// Radiance along the ray, W/(m² sr).
Rgb photon_radiance(const PhotonScene& scene, const Ray& ray, RandomStream& random);

}  // namespace pim
