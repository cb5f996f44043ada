// SPDX-License-Identifier: GPL-3.0-or-later
// The reference: unbiased path tracing with multiple importance sampling (Veach 1997, chapters 9 and 10) over
// the same scene, lamps and materials. Shares with the map only rays, scattering and lamps.
#pragma once

#include "common/map/illumination_map.h"
#include "common/transport/surface.h"

namespace pim {

struct PathScene {
    const Scene& scene;
    const RayCaster& caster;
    std::vector<LightState> lights;
    bool show_lamps = false;  // to camera rays that meet nothing diffuse before
    // Where a light image (light_image.h) is added: its photons of one lamp for each path of a pixel, times a
    // pixel's solid angle, sr. 0: there is none.
    float image_photons = 0;
};

struct Seen {
    Rgb total{0};          // radiance, W/(m² sr)
    Rgb indirect{0};       // the part of it that the indirect component makes
    bool surface = false;  // the ray meets one
};

// One random path. Each of its diffuse surfaces is lit by samples of the lamps, and by where light sent from
// the lamps lands first; rays that go on from it find the same light, and the three share it by the power
// heuristic. The first eight numbers of `random` decide most: spread them evenly over the paths of a pixel.
// `indirect` is all that has not come straight from a lamp to the first diffuse surface.
// Light of a point lamp that has passed glass or mirrors before its first diffuse surface cannot be found
// from the eye and is missing here; of a rectangle's, which rays find by chance, the light image's share is:
// see light_image.h.
Seen path_radiance(const PathScene& scene, const Ray& ray, RandomStream& random);

// What a light image has of the light that left a lamp by way of mirrors and glass and comes to the eye from
// a diffuse surface that it sees itself; paths have the rest. Distance and cosine are those of the eye from
// there. Light keeps its etendue at mirrors and glass, and diffuse surfaces scatter alike both ways, so that
// of the ratio of both densities (Veach 1997, chapter 9) all else cancels.
float light_image_share(const PathScene& scene, std::size_t light, float distance, float cosine);

// Is a light image worth while?
bool lamps_meet_specular(const Scene& scene);
// Does path_radiance miss what a light image does not have either?
bool point_lamps_meet_specular(const Scene& scene);

}  // namespace pim
