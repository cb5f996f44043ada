// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/robust_pass.h"

#include <cmath>
#include <numeric>

#include "common/core/parallel.h"

namespace pim {
namespace {

constexpr std::size_t kNumbersAtOnce = 1 << 25;
constexpr double kOutlier = 0.5;  // weight of a sample below which it is one

std::vector<double> means(const DensityVolume::PerComponent& volume) {
    std::vector<double> values;
    values.reserve(volume.density.size());
    for (const Rgb& d : volume.density) values.push_back(double(mean_channel(d)));
    return values;
}

// All samples of one patch.
struct Samples {
    Eigen::MatrixXd density;   // sample × channel
    Eigen::VectorXd variance;  // of its noise, mean of the channels
    std::vector<SampleNoise::Witness> witness;
};

class RobustPass {
  public:
    RobustPass(const LinearFit& fit, const SampleNoise& noise, const VolumeReader& read_volume,
               RobustLoss loss)
        : fit_(fit), noise_(noise), read_volume_(read_volume), loss_(loss) {}

    void run(std::span<const uint32_t> patches, std::vector<Refit>& refits) const {
        const std::vector<Samples> samples = gather(patches);
        std::vector<std::optional<Refit>> found(patches.size());
        parallel_for(patches.size(), [&](std::size_t i) { found[i] = refit(patches[i], samples[i]); });
        for (auto& one : found)
            if (one) refits.push_back(std::move(*one));
    }

  private:
    std::vector<Samples> gather(std::span<const uint32_t> patches) const {
        const Eigen::Index count = fit_.q.rows();
        std::vector<Samples> all(patches.size());
        for (Samples& s : all) {
            s.density.resize(count, 3), s.variance.resize(count);
            s.witness.resize(std::size_t(count));
        }
        parallel_for(std::size_t(count), [&](std::size_t m) {
            const auto volume = read_volume_(m);
            const auto density = means(volume);
            const auto fitted = fit_.at(m);
            for (std::size_t i = 0; i < patches.size(); ++i) {
                const uint32_t p = patches[i];
                for (int c = 0; c < 3; ++c) all[i].density(Eigen::Index(m), c) = double(volume.density[p][c]);
                all[i].variance(Eigen::Index(m)) = channel_variance(volume.density[p], volume.variance[p]);
                all[i].witness[m] = noise_.witness(p, density, fitted);
            }
        });
        return all;
    }

    Eigen::VectorXd scales(uint32_t patch, const Samples& samples, const Eigen::VectorXd& fitted) const {
        Eigen::VectorXd scale(fitted.size());
        for (Eigen::Index m = 0; m < scale.size(); ++m)
            scale(m) = std::sqrt(noise_.variance(patch, fitted(m), samples.witness[std::size_t(m)]));
        return scale;
    }

    // None: no sample is an outlier.
    std::optional<Refit> refit(uint32_t patch, const Samples& samples) const {
        const Eigen::VectorXd y = samples.density.rowwise().mean();
        const Eigen::VectorXd start = fit_.along.row(patch).transpose();
        std::vector<double> sorted(y.begin(), y.end());
        std::ranges::nth_element(sorted, sorted.begin() + y.size() / 2);
        const double usual = sorted[std::size_t(y.size() / 2)];
        const auto usual_scale = scales(patch, samples, Eigen::VectorXd::Constant(y.size(), usual));
        Refit result{patch, false, {}};
        if (!(usual_scale.minCoeff() > 0)) return std::nullopt;  // no light, no noise
        RobustFit robust = robust_fit(fit_.q, y, usual_scale, start, RobustLoss::huber);
        result.iterations = robust.iterations;
        if (!robust.converged) return result;
        const auto scale = scales(patch, samples, fit_.q * robust.coefficients);
        robust = robust_fit(fit_.q, y, scale, robust.coefficients, loss_);
        result.iterations += robust.iterations;
        if (!robust.converged) return result;
        if (robust.weights.minCoeff() > kOutlier) return std::nullopt;
        weigh(samples, robust.weights, result);
        return result;
    }

    // Weighted least squares for each channel.
    void weigh(const Samples& samples, const Eigen::VectorXd& weights, Refit& result) const {
        const Eigen::MatrixXd weighted = weights.asDiagonal() * fit_.q;
        const Eigen::LDLT<Eigen::MatrixXd> normal(fit_.q.transpose() * weighted);
        result.along = normal.solve(weighted.transpose() * samples.density).transpose();
        // Too few samples count for all terms: their equations have no one solution.
        result.converged =
            normal.info() == Eigen::Success && normal.rcond() > 1e-6 && result.along.allFinite();
        result.residual = (samples.density - fit_.q * result.along.transpose()).squaredNorm() /
                          double(samples.density.size());
        result.noise = weights.dot(samples.variance) / weights.sum();
    }

    const LinearFit& fit_;
    const SampleNoise& noise_;
    const VolumeReader& read_volume_;
    RobustLoss loss_;
};

}  // namespace

double channel_variance(const Rgb& density, float variance_of_mean) {
    const double mean = double(density.x + density.y + density.z) / 3;
    return mean > 0 ? double(variance_of_mean) * double(density.dot(density)) / (3 * mean * mean) : 0;
}

std::vector<Refit> robust_pass(const LinearFit& fit, const Neighbourhoods& shared,
                               const VolumeReader& read_volume, Robust which, RobustLoss loss) {
    if (which == Robust::off || shared.empty() || fit.q.cols() >= fit.q.rows()) return {};
    const SampleNoise noise(fit, shared);
    std::vector<uint32_t> patches(fit.noise.size());
    std::iota(patches.begin(), patches.end(), 0u);
    if (which == Robust::automatic)
        patches = patches_with_outliers(fit, noise, [&](std::size_t m) { return means(read_volume(m)); });
    const RobustPass pass(fit, noise, read_volume, loss);
    const std::size_t at_once = std::max<std::size_t>(1, kNumbersAtOnce / (6 * std::size_t(fit.q.rows())));
    std::vector<Refit> refits;
    for (std::size_t first = 0; first < patches.size(); first += at_once)
        pass.run(std::span(patches).subspan(first, std::min(at_once, patches.size() - first)), refits);
    return refits;
}

}  // namespace pim
