// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/outliers.h"

#include <algorithm>
#include <boost/math/special_functions/gamma.hpp>
#include <cmath>

#include "common/core/float_traps.h"
#include "common/core/parallel.h"

namespace pim {
namespace {

constexpr double kBelieved = 0.05;  // of a patch's usual density: the least that a fit counts as
constexpr double kNearEnough = 4;   // standard deviations: what is nearer needs no closer look
constexpr std::size_t kFew = 4;
constexpr double kManyPhotons = 1e5;   // from there on the gamma distribution is the normal one
constexpr double kMostLeverage = 0.9;  // a sample that the fit follows anywhere cannot be judged

double median(std::vector<double>& values) {
    if (values.empty()) return 0;
    // Of a few, the middle one that speaks against outliers.
    const std::size_t place = (values.size() - (values.size() > kFew)) / 2;
    const auto middle = values.begin() + std::ptrdiff_t(place);
    std::ranges::nth_element(values, middle);
    return *middle;
}

}  // namespace

std::vector<double> LinearFit::at(std::size_t sample) const {
    std::vector<double> values(std::size_t(along.rows()));
    Eigen::Map<Eigen::VectorXd>(values.data(), along.rows()) =
        along * q.row(Eigen::Index(sample)).transpose();
    return values;
}

SampleNoise::SampleNoise(const LinearFit& fit, const Neighbourhoods& shared) : shared_(shared) {
    const std::size_t count = fit.noise.size();
    photon_weight_.resize(count), misfit_.resize(count), floor_.resize(count);
    const double constant = 1 / std::sqrt(double(fit.q.rows()));  // the first column of q is this
    const auto mean = [&](std::size_t p) { return fit.along(Eigen::Index(p), 0) * constant; };
    parallel_for(count, [&](std::size_t p) {
        std::vector<double> weights, misfits, means;
        for (const uint32_t n : shared.near(p)) {
            means.push_back(mean(n));
            misfits.push_back(std::max(0.0, fit.residual[n] - fit.noise[n]));
            // Of one photon, times area: neighbours of different sizes have it in common.
            if (mean(n) > 0) weights.push_back(fit.noise[n] / mean(n) * double(shared.area(n)));
        }
        photon_weight_[p] = median(weights) / double(shared.area(p));
        misfit_[p] = median(misfits);
        floor_[p] = kBelieved * std::max(0.0, median(means));
    });
}

SampleNoise::Witness SampleNoise::witness(std::size_t patch, const std::vector<double>& density,
                                          const std::vector<double>& fitted) const {
    double seen = 0, expected = 0, most = 0, least = 0;
    std::size_t highest = patch, lowest = patch;
    const auto believed = [&](std::size_t n) { return std::max(fitted[n], floor_[n]); };
    for (const uint32_t n : shared_.near(patch)) {
        if (n == patch) continue;
        const double area = double(shared_.area(n)), beyond = area * (density[n] - believed(n));
        seen += area * density[n], expected += area * believed(n);
        if (highest == patch || beyond > most) most = beyond, highest = n;
        if (lowest == patch || beyond < least) least = beyond, lowest = n;
    }
    const auto without = [&](std::size_t n) {
        const double area = double(shared_.area(n)), rest = expected - area * believed(n);
        return n != patch && rest > 0 ? (seen - area * density[n]) / rest : 1.0;
    };
    return {std::max(1.0, without(highest)), std::min(1.0, without(lowest))};
}

double SampleNoise::variance(std::size_t patch, double fitted, const Witness& witness) const {
    const double believed = std::max(fitted, floor_[patch]);
    const double explained = believed * std::max(witness.up - 1, 1 - witness.down);
    return believed * witness.up * photon_weight_[patch] + misfit_[patch] + explained * explained;
}

double tail_probability(double y, double mean, double variance) {
    if (!(variance > 0) || !(mean > 0)) return y == mean ? 1 : 0;
    const double shape = mean * mean / variance, x = std::max(0.0, y) * mean / variance;
    if (shape > kManyPhotons) return 0.5 * std::erfc(std::abs(y - mean) / std::sqrt(2 * variance));
    const FloatTraps library(FloatTraps::off);
    return y > mean ? boost::math::gamma_q(shape, x) : boost::math::gamma_p(shape, x);
}

std::vector<uint32_t> patches_with_outliers(const LinearFit& fit, const SampleNoise& noise,
                                            const std::function<std::vector<double>(std::size_t)>& read) {
    const auto samples = std::size_t(fit.q.rows()), patches = fit.noise.size();
    std::vector<std::vector<uint32_t>> found(samples);
    parallel_for(samples, [&](std::size_t m) {
        const double free = 1 - fit.q.row(Eigen::Index(m)).squaredNorm();
        if (free < 1 - kMostLeverage) return;
        const std::vector<double> density = read(m);
        const std::vector<double> fitted = fit.at(m);
        for (std::size_t p = 0; p < patches; ++p) {
            // Of the other samples alone, what is left grows by 1 / free, its variance likewise.
            const double apart = (density[p] - fitted[p]) / free;
            const double expected = std::max(density[p] - apart, noise.least_density(p));
            const double least = noise.variance(p, expected, {}) / free;
            if (!(apart * apart > kNearEnough * kNearEnough * least)) continue;
            const auto witness = noise.witness(p, density, fitted);
            const double mean = expected * (apart > 0 ? witness.up : witness.down);
            if ((density[p] - mean) * apart <= 0) continue;
            const double variance = noise.variance(p, expected, witness) / free;
            if (tail_probability(density[p], mean, variance) < kFalseAlarms / double(samples))
                found[m].push_back(uint32_t(p));
        }
    });
    std::vector<uint32_t> all;
    for (const auto& part : found) all.insert(all.end(), part.begin(), part.end());
    std::ranges::sort(all);
    all.erase(std::ranges::unique(all).begin(), all.end());
    return all;
}

}  // namespace pim
