// SPDX-License-Identifier: GPL-3.0-or-later
// What path_radiance cannot find: light of point lamps that has passed mirrors or glass before its first
// diffuse surface. Photons from the lamp, each connected to the camera wherever it lands (light tracing:
// Dutre, Lafortune, Willems: Monte Carlo light tracing with direct computation of pixel intensities, 1993).
// Such light seen in mirrors or through glass stays missing: no connection finds it.
#pragma once

#include "common/core/image.h"
#include "common/render/camera_rays.h"
#include "common/render/path_radiance.h"

namespace pim {

// Mean radiance over each pixel, W/(m² sr), to be added to path_radiance's. Same bytes at any thread count.
// `stream` tells independent images apart.
Image light_image(const PathScene& scene, const Camera& camera, const Imath::V2i& size,
                  uint64_t photons_per_lamp, uint64_t seed, uint32_t stream);

}  // namespace pim
