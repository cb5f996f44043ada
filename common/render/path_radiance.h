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
// from the eye and is missing here: see light_image.h.
Seen path_radiance(const PathScene& scene, const Ray& ray, RandomStream& random);

// Does the scene need what path_radiance misses?
bool point_lamps_meet_specular(const Scene& scene);

}  // namespace pim
