// SPDX-License-Identifier: GPL-3.0-or-later
// Samples that neither photon noise nor the polynomial's own misfit nor the light around explains: a rare
// bright path, a file that was spoiled.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "bake/density.h"
#include "bake/patch_filter.h"

namespace pim {

// Per patch and fit, of which a bake has up to a million; of clean data.
inline constexpr double kFalseAlarms = 1e-6;

// What a linear fit of all samples left, per patch; means of the channels throughout.
struct LinearFit {
    Eigen::MatrixXd q;  // samples × terms, orthonormal
    RowMatrix along;    // patch × term
    // Of one sample's density: of its noise as the photons tell, and of the residual. [patch]
    std::vector<double> noise, residual;

    std::vector<double> at(std::size_t sample) const;  // what is fitted there, by patch
};

// Variance of a sample: photons weigh the same whatever their number, so that their noise goes with the
// *fitted* density, not with the sample's own count; beside it stands the misfit. Both are medians over the
// patches around, which up to half of them spoiled do not sway.
class SampleNoise {
  public:
    // The arguments must outlive it.
    SampleNoise(const LinearFit& fit, const Neighbourhoods& shared);

    // What a sample's neighbours say of its light: their density over what is fitted to them, the highest and
    // the lowest of them left out in turn. Light that really came shows there too.
    struct Witness {
        double up = 1, down = 1;  // >= 1, <= 1
    };
    Witness witness(std::size_t patch, const std::vector<double>& density,
                    const std::vector<double>& fitted) const;

    double variance(std::size_t patch, double fitted, const Witness& witness) const;
    double least_density(std::size_t patch) const { return floor_[patch]; }  // that a fit is believed

  private:
    const Neighbourhoods& shared_;
    std::vector<double> photon_weight_, misfit_, floor_;
};

// Probability that a density is as far from `mean` as y or farther, on its side: of the gamma distribution of
// that mean and variance, whose tail is exponential, as that of a compound Poisson sum with bounded weights
// is at most.
double tail_probability(double y, double mean, double variance);

// The patches with an outlier among their samples, in order. `read` gives one sample's densities.
std::vector<uint32_t> patches_with_outliers(const LinearFit& fit, const SampleNoise& noise,
                                            const std::function<std::vector<double>(std::size_t)>& read);

}  // namespace pim
