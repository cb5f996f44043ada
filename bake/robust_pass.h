// SPDX-License-Identifier: GPL-3.0-or-later
// From the linear fit of all patches to robust fits of those with outliers.
#pragma once

#include <functional>

#include "bake/outliers.h"
#include "bake/robust_fit.h"
#include "common/scene/scene.h"

namespace pim {

// Densities of all patches for sample i, and the variance of their noise.
using VolumeReader = std::function<DensityVolume::PerComponent(std::size_t sample)>;

// Variance of a density's noise, mean of its channels, from that of the channels' mean: photons of a patch
// have about the density's colour.
double channel_variance(const Rgb& density, float variance_of_mean);

struct Refit {
    uint32_t patch;
    bool converged;       // else the patch keeps its linear fit
    RowMatrix along;      // channel × term, of the orthonormal terms
    double residual = 0;  // mean square over samples and channels, of all samples
    double noise = 0;     // variance of a sample's density, of those that count
    int iterations = 0;
};

// Fits of the patches that hold outliers, or of all (Robust::always); those that turn out to hold none are
// left out. Weights are found for the mean of the channels and serve all three.
std::vector<Refit> robust_pass(const LinearFit& fit, const Neighbourhoods& shared,
                               const VolumeReader& read_volume, Robust which, RobustLoss loss);

}  // namespace pim
