// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/fit.h"

#include <cmath>
#include <limits>

#include "bake/least_squares.h"
#include "bake/non_negative.h"
#include "common/core/parallel.h"
#include "common/map/polynomial.h"

namespace pim {
namespace {

constexpr std::size_t kSamplesAtOnce = 32;
constexpr Eigen::Index kRowsAtOnce = 2048;

// Rows: samples; columns: Chebyshev products of the terms.
ExtendedMatrix design_of(const MapBox& box, const std::vector<Vec3>& positions,
                         const std::vector<int>& terms) {
    ExtendedMatrix design(Eigen::Index(positions.size()), Eigen::Index(terms.size()));
    for (std::size_t m = 0; m < positions.size(); ++m) {
        const auto products = chebyshev_products(box.normalised(Vec3d(positions[m])));
        for (std::size_t t = 0; t < terms.size(); ++t)
            design(Eigen::Index(m), Eigen::Index(t)) = products[terms[t]];
    }
    return design;
}

// Places in `terms`, low degrees first.
std::vector<int> low_degrees_first(const std::vector<int>& terms) {
    std::vector<int> order(terms.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = int(i);
    std::ranges::stable_sort(order, {}, [&](int i) { return degree(terms[i]); });
    return order;
}

// Coefficients of the Chebyshev products to coefficients of the monomials, both over `terms`.
Eigen::MatrixXd to_monomials(const std::vector<int>& terms) {
    Eigen::MatrixXd change = Eigen::MatrixXd::Zero(Eigen::Index(terms.size()), Eigen::Index(terms.size()));
    for (std::size_t j = 0; j < terms.size(); ++j) {
        const auto column = chebyshev_in_monomials(terms[j]);
        for (std::size_t i = 0; i < terms.size(); ++i)
            change(Eigen::Index(i), Eigen::Index(j)) = column[terms[i]];
    }
    return change;
}

// Qᵀ y for every patch and channel, and the sum of squares of y, volumes added a few at a time.
struct Projections {
    RowMatrix along;               // (patch, channel) × rank
    Eigen::VectorXd squares;       // (patch, channel)
    std::vector<double> variance;  // [patch] of the noise, mean of samples and channels

    void add(const Eigen::MatrixXd& volumes,
             const Eigen::MatrixXd& q) {  // (patch, channel) × samples; samples × rank
        const Eigen::Index rows = along.rows(), blocks = (rows + kRowsAtOnce - 1) / kRowsAtOnce;
        parallel_for(std::size_t(blocks), [&](std::size_t block) {
            const Eigen::Index start = Eigen::Index(block) * kRowsAtOnce,
                               count = std::min(kRowsAtOnce, rows - start);
            along.middleRows(start, count).noalias() += volumes.middleRows(start, count) * q;
            for (Eigen::Index i = 0; i < volumes.cols(); ++i)
                squares.segment(start, count) += volumes.col(i).segment(start, count).cwiseAbs2();
        });
    }
};

Projections project(const Eigen::MatrixXd& q, std::size_t patch_count, const VolumeReader& read_volume,
                    bool with_variance) {
    const auto rows = Eigen::Index(patch_count * 3), samples = q.rows();
    Projections projections{RowMatrix::Zero(rows, q.cols()), Eigen::VectorXd::Zero(rows),
                            std::vector<double>(with_variance ? patch_count : 0)};
    for (Eigen::Index first = 0; first < samples; first += Eigen::Index(kSamplesAtOnce)) {
        const Eigen::Index count = std::min<Eigen::Index>(kSamplesAtOnce, samples - first);
        Eigen::MatrixXd volumes(rows, count), variances(Eigen::Index(projections.variance.size()), count);
        parallel_for(std::size_t(count), [&](std::size_t i) {
            const auto read = read_volume(std::size_t(first) + i);
            for (std::size_t p = 0; p < patch_count; ++p)
                for (int c = 0; c < 3; ++c)
                    volumes(3 * Eigen::Index(p) + c, Eigen::Index(i)) = double(read.density[p][c]);
            for (std::size_t p = 0; p < projections.variance.size(); ++p)
                variances(Eigen::Index(p), Eigen::Index(i)) =
                    channel_variance(read.density[p], read.variance[p]);
        });
        projections.add(volumes, q.middleRows(first, count));
        for (Eigen::Index i = 0; i < count; ++i)
            for (std::size_t p = 0; p < projections.variance.size(); ++p)
                projections.variance[p] += variances(Eigen::Index(p), i) / double(samples);
    }
    return projections;
}

// Variance of the residuals, which hold what no cubic follows besides noise. [patch]
std::vector<double> residual_variance(const Projections& projections, Eigen::Index samples) {
    const auto free = 3.0 * double(std::max<Eigen::Index>(1, samples - projections.along.cols()));
    std::vector<double> variance(std::size_t(projections.along.rows()) / 3);
    for (std::size_t p = 0; p < variance.size(); ++p)
        for (int c = 0; c < 3; ++c) {
            const auto row = Eigen::Index(3 * p) + c;
            variance[p] +=
                std::max(0.0, projections.squares(row) - projections.along.row(row).squaredNorm()) / free;
        }
    return variance;
}

// Patches with outliers get coefficients in which these count less.
std::vector<uint8_t> fit_robustly(const Eigen::MatrixXd& q, const VolumeReader& read_volume,
                                  const Neighbourhoods& shared, const FitSettings& settings,
                                  Projections& projections, FitStatistics& statistics) {
    const auto patches = std::size_t(projections.along.rows()) / 3;
    std::vector<uint8_t> status(patches, 0);
    if (settings.robust == Robust::off || shared.empty()) return status;
    LinearFit linear{q, RowMatrix(Eigen::Index(patches), q.cols()), projections.variance,
                     residual_variance(projections, q.rows())};
    for (Eigen::Index p = 0; p < linear.along.rows(); ++p)
        linear.along.row(p) = projections.along.middleRows(3 * p, 3).colwise().mean();
    for (const Refit& r : robust_pass(linear, shared, read_volume, settings.robust, settings.loss)) {
        status[r.patch] = r.converged ? kRobust : kRobustFailed;
        statistics.iterations += r.iterations;
        if (!r.converged) continue;
        const Eigen::Index row = 3 * Eigen::Index(r.patch);
        projections.along.middleRows(row, 3) = r.along;
        projections.variance[r.patch] = r.noise;
        projections.squares.segment(row, 3) =
            r.along.rowwise().squaredNorm().array() + r.residual * double(q.rows());
    }
    return status;
}

// The projections and what is known of their noise.
NoisyCoefficients measured(Projections& projections, const std::vector<int>& degrees, Eigen::Index samples,
                           const Neighbourhoods& shared) {
    const std::vector<double> variance = shared.filter() ? pooled_noise(projections.variance, shared)
                                                         : residual_variance(projections, samples);
    NoisyCoefficients coefficients{std::move(projections.along), degrees, {}};
    for (const double v : variance) coefficients.noise.emplace_back().fill(v);
    return coefficients;
}

// Spheres about neighbouring cells share photons, so their noise is not independent.
bool filters(const Scene& scene) { return scene.grid.estimator == Estimator::area; }

// Some of the patches, and no more.
Cells part_of(const Cells& cells, const std::vector<uint32_t>& patches) {
    Cells part;
    part.grid = cells.grid;
    for (const uint32_t p : patches) part.patches.push_back(cells.patches[p]);
    part.index = PatchIndex(part.grid, part.patches);
    return part;
}

RowMatrix kept_of(const NoisyCoefficients& measured, const Neighbourhoods& shared, bool shrinkage) {
    if (shared.empty() || !shrinkage) return measured.values;
    NoisyCoefficients kept = shared.filter() ? filtered(measured, shared) : measured;
    if (!shared.means().empty()) sharpen(kept, shared);
    shrink(kept, shared);
    return std::move(kept.values);
}

}  // namespace

Neighbourhoods neighbourhoods(const Scene& scene, const Cells& cells) {
    if (!scene.bake.shrinkage && scene.bake.robust == Robust::off) return {};
    return {cells, filters(scene), scene.bake.shrinkage ? cells.means : LookUpMeans()};
}

Neighbourhoods neighbourhoods(const Scene& scene, const Cells& cells, const std::vector<uint32_t>& patches) {
    if (!scene.bake.shrinkage && scene.bake.robust == Robust::off) return {};
    return {part_of(cells, patches), filters(scene),
            scene.bake.shrinkage ? cells.means.part(patches) : LookUpMeans()};
}

BoxFit fit_box(const MapBox& box, const std::vector<Vec3>& positions, const FitSettings& settings,
               std::size_t patch_count, const VolumeReader& read_volume, const Neighbourhoods& shared) {
    const std::vector<int> terms = terms_of(settings.degree, box.moves());
    const LeastSquares ls = factorise(design_of(box, positions, terms), low_degrees_first(terms));
    BoxFit fit;
    fit.statistics.samples = int(positions.size());
    fit.statistics.rank = ls.rank();
    fit.statistics.condition_number = ls.condition_number;
    for (const int column : ls.dropped) fit.statistics.dropped.push_back(terms[std::size_t(column)]);
    const Eigen::MatrixXd q = ls.q.cast<double>();
    Projections projections = project(q, patch_count, read_volume, !shared.empty());
    fit.polynomials.status = fit_robustly(q, read_volume, shared, settings, projections, fit.statistics);
    const SignMender mender(to_monomials(terms) * ls.solve.cast<double>(), terms, int(positions.size()),
                            box.moves());
    std::vector<int> degrees;  // of the orthonormal terms
    for (const int column : ls.kept) degrees.push_back(degree(terms[std::size_t(column)]));
    const NoisyCoefficients all = measured(projections, degrees, q.rows(), shared);
    RowMatrix kept = kept_of(all, shared, settings.shrinkage);
    fit.polynomials.terms = terms;
    fit.polynomials.coefficients.resize(patch_count * terms.size() * 3);
    fit.polynomials.residuals.resize(patch_count);
    parallel_for((patch_count + 255) / 256, [&](std::size_t block) {
        for (std::size_t p = block * 256; p < std::min(patch_count, (block + 1) * 256); ++p) {
            double misfit = 0;
            for (int c = 0; c < 3; ++c) {
                const auto row = Eigen::Index(3 * p) + c;
                const auto along = all.values.row(row);
                Cubic cubic = mender.cubic(kept.row(row));
                if (settings.non_negative) fit.polynomials.status[p] |= mender.mend(cubic, kept.row(row));
                for (std::size_t t = 0; t < terms.size(); ++t)
                    fit.polynomials.coefficients[(p * terms.size() + t) * 3 + std::size_t(c)] =
                        float(cubic[std::size_t(terms[t])]);
                misfit += std::max(0.0, projections.squares(row) - along.squaredNorm() +
                                            (along - kept.row(row)).squaredNorm());
            }
            fit.polynomials.residuals[p] = float(std::sqrt(misfit / (3.0 * double(positions.size()))));
        }
    });
    return fit;
}

double raw_condition_number(const MapBox& box, const std::vector<Vec3>& positions, int highest_degree,
                            const Vec3d& origin) {
    const std::vector<int> terms = terms_of(highest_degree, box.moves());
    ExtendedMatrix design(Eigen::Index(positions.size()), Eigen::Index(terms.size()));
    for (std::size_t m = 0; m < positions.size(); ++m) {
        const auto powers = monomials(Imath::Vec3<Extended>(Vec3d(positions[m]) + origin));
        for (std::size_t t = 0; t < terms.size(); ++t)
            design(Eigen::Index(m), Eigen::Index(t)) = powers[std::size_t(terms[t])];
    }
    const double most = 1 / double(std::numeric_limits<Extended>::epsilon());
    return std::min(most, factorise(design, low_degrees_first(terms), 0).condition_number);
}

std::vector<double> leverages(const MapBox& box, const std::vector<Vec3>& positions, int highest_degree,
                              const std::vector<Vec3d>& at) {
    const std::vector<int> terms = terms_of(highest_degree, box.moves());
    const LeastSquares ls = factorise(design_of(box, positions, terms), low_degrees_first(terms));
    std::vector<Vec3> places(at.begin(), at.end());
    const Eigen::MatrixXd weights = (design_of(box, places, terms) * ls.solve).cast<double>();
    std::vector<double> sums;
    for (Eigen::Index i = 0; i < weights.rows(); ++i) sums.push_back(weights.row(i).squaredNorm());
    return sums;
}

MapLight fit_light(const Light& light, const BakeSettings& settings, const std::vector<LightSample>& samples,
                   std::size_t patch_count, const Neighbourhoods& shared, const DensityReader& density) {
    MapLight fitted{light.name, light.domain, split_domain(light.domain, light.boxes), {}, {}};
    fitted.type = light.rectangle() ? "rectangle" : "point";
    fitted.power = light.power;
    for (const MapBox& box : fitted.boxes) {
        std::vector<LightSample> inside;
        std::vector<Vec3> positions;
        for (const LightSample& s : samples)
            if (box.contains(Vec3d(s.position))) inside.push_back(s), positions.push_back(s.position);
        auto& polynomials = fitted.polynomials.emplace_back();
        auto& statistics = fitted.fits.emplace_back();
        for (const Component c : settings.components) {
            BoxFit fit = fit_box(
                box, positions, {settings.degree, settings.shrinkage, settings.mend_signs, settings.robust},
                patch_count, [&](std::size_t i) { return density(inside[i], c); }, shared);
            statistics = fit.statistics;
            polynomials[int(c)] = std::move(fit.polynomials);
        }
    }
    return fitted;
}

}  // namespace pim
