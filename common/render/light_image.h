// SPDX-License-Identifier: GPL-3.0-or-later
// What path_radiance cannot find, or by chance only: light that has passed mirrors or glass before its first
// diffuse surface. Photons from the lamp, each connected to the camera wherever it lands (light tracing:
// Dutre, Lafortune, Willems: Monte Carlo light tracing with direct computation of pixel intensities, 1993).
// Of rectangles a share (light_image_share), if PathScene::image_photons says that an image is added. What is
// seen in mirrors or through glass no connection finds: such light of point lamps stays missing.
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
