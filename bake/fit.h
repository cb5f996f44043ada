// SPDX-License-Identifier: GPL-3.0-or-later
// Density volumes to polynomials: one least-squares design for all patches of a box, volumes streamed.
#pragma once

#include <functional>

#include "bake/light_samples.h"
#include "common/map/illumination_map.h"

namespace pim {

// Values of all patches for sample i, [patch][3 channels].
using VolumeReader = std::function<std::vector<float>(std::size_t sample)>;

struct BoxFit {
    Polynomials polynomials;
    FitStatistics statistics;
};

// The patches whose signal a patch shares: for each, its neighbours' numbers, itself among them, and all
// areas.
struct Neighbourhoods {
    std::vector<std::vector<uint32_t>> of;  // empty: no shrinkage
    std::vector<float> area;
};
// Patches of the same slot in the 27 cells around each.
Neighbourhoods neighbourhoods(const PatchIndex& index, const std::vector<Patch>& patches);

// Fits a polynomial of at most `degree` in the box's normalised coordinates to the samples at `positions`
// (local, all inside the box). Terms that the samples do not determine are 0.
//
// With neighbourhoods, the parts of each degree 1, 2, 3 that are orthogonal to lower degrees are shrunk by
// tau²/(tau² + sigma²) (empirical Bayes, after James and Stein 1961): sigma² is the patch's own residual
// variance, tau² the variance of the signal in that degree, estimated over the neighbourhood. Memory grows
// with the patches, not with the samples.
BoxFit fit_box(const MapBox& box, const std::vector<Vec3>& positions, int degree, std::size_t patch_count,
               const VolumeReader& read_volume, const Neighbourhoods& shared);

// Variance of the fit at lamp positions `at` for variance 1 of each sample, without shrinkage: the sum of
// squares of what each sample counts for there.
std::vector<double> leverages(const MapBox& box, const std::vector<Vec3>& positions, int degree,
                              const std::vector<Vec3d>& at);

// [patch][3 channels] of one lamp position.
using DensityReader = std::function<std::vector<float>(const LightSample&, Component)>;

// A fit for each box and component of a lamp; `samples` are the positions of that lamp.
MapLight fit_light(const Light& light, const BakeSettings& settings, const std::vector<LightSample>& samples,
                   std::size_t patch_count, const Neighbourhoods& shared, const DensityReader& density);

}  // namespace pim
