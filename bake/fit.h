// SPDX-License-Identifier: GPL-3.0-or-later
// Density volumes to polynomials: one least-squares design for all patches of a box, volumes streamed.
#pragma once

#include <functional>

#include "bake/light_samples.h"
#include "common/map/illumination_map.h"

namespace pim {

// Values of all patches for sample i, [patch][channel].
using VolumeReader = std::function<std::vector<float>(std::size_t sample)>;

struct BoxFit {
    Polynomials polynomials;
    FitStatistics statistics;
};

// Fits a polynomial of at most `degree` in the box's normalised coordinates to the samples at `positions` (local, all
// inside the box). Terms that the samples do not determine are 0. Memory grows with the patches, not with the samples.
BoxFit fit_box(const MapBox& box, const std::vector<Vec3>& positions, int degree, std::size_t patch_count,
               const VolumeReader& read_volume);

}  // namespace pim
