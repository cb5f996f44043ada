// SPDX-License-Identifier: GPL-3.0-or-later
// What the patches of one surface know of each other. Photons tell the noise of a coefficient, its neighbours
// tell how much of it can be signal: empirical Bayes (James and Stein 1961; Lee: Digital image enhancement
// and noise filtering by use of local statistics, 1980), with variances pooled over a neighbourhood.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "bake/cells.h"
#include "bake/least_squares.h"
#include "bake/look_up_means.h"

namespace pim {

// Windows around a patch, in cells to each side on every axis: near, over which variances are pooled, and
// far.
inline constexpr int kNearReach = 1, kFarReach = 3;

// For each patch those of the same slot in the cells around it, itself among them.
class Neighbourhoods {
  public:
    Neighbourhoods() = default;  // of no patches: each is fitted for itself
    // `filter`: the noise of different patches is independent, so that they may be averaged.
    // `means`: what the look-up shows of these patches; empty: nothing is sharpened.
    Neighbourhoods(const Cells& cells, bool filter, LookUpMeans means = {});

    bool empty() const { return first_.empty(); }
    bool filter() const { return filter_; }
    std::span<const uint32_t> near(std::size_t patch) const {
        return {&members_[first_[patch]], near_count_[patch]};
    }
    std::span<const uint32_t> far(std::size_t patch) const {
        return {&members_[first_[patch]], first_[patch + 1] - first_[patch]};
    }
    float area(std::size_t patch) const { return area_[patch]; }  // m²
    const LookUpMeans& means() const { return means_; }
    // exp(-d²/8) for each of far(patch), d the distance of its centroid, in cells.
    const float* closeness(std::size_t patch) const { return &closeness_[first_[patch]]; }

  private:
    std::vector<std::size_t> first_;    // [patch] into members_, and the end
    std::vector<uint32_t> near_count_;  // of a patch's members, the first ones
    std::vector<uint32_t> members_;
    std::vector<float> area_;
    std::vector<float> closeness_;  // [as members_]
    LookUpMeans means_;
    bool filter_ = false;
};

inline constexpr int kDegrees = 4;  // 0 to 3

// Coefficients of orthonormal terms and the variance of their noise.
struct NoisyCoefficients {
    RowMatrix values;                                 // (patch, channel) × term
    std::vector<int> degrees;                         // of the terms
    std::vector<std::array<double, kDegrees>> noise;  // [patch][degree], mean of the channels

    std::size_t patches() const { return noise.size(); }
};

// Noise variances, [patch], as the surface around has them per area: a patch that by chance got few photons
// would think itself certain, and averages of neighbours would lose flux.
std::vector<double> pooled_noise(const std::vector<double>& variance, const Neighbourhoods& shared);

// Coefficients moved towards the mean m of their neighbours', leaving themselves out, by sigma²/(sigma² + q):
// sigma² is the patch's own noise, q the mean square error of m as a guess of the patch's signal, estimated
// per degree over the window. Of the near window (weights area · exp(-distance²/2), in cells) and the far one
// (exp(-distance²/8)) the one with the smaller q serves. Where the light has an edge q is large, and nothing
// moves.
NoisyCoefficients filtered(const NoisyCoefficients& measured, const Neighbourhoods& shared);

// Degrees 1, 2, 3 by tau²/(tau² + sigma²): tau² is the variance of the signal in that degree, estimated over
// the near window.
void shrink(NoisyCoefficients& coefficients, const Neighbourhoods& shared);

// Coefficients v moved by s (v - Av), where Av is what the look-up shows of the patch on the whole: the means
// of what is shown come to those that were measured. For each degree the s, 0 to 1, that makes the mean
// square error of v least: S is the signal's part in v - Av, pooled over the near window, c the noise of v
// that v - Av shares, sigma² its own, s = (S - c) / (S + sigma²).
void sharpen(NoisyCoefficients& coefficients, const Neighbourhoods& shared);

}  // namespace pim
