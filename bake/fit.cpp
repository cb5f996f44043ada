// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/fit.h"

#include <cmath>

#include "bake/least_squares.h"
#include "common/core/parallel.h"
#include "common/map/polynomial.h"

namespace pim {
namespace {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
constexpr std::size_t kSamplesAtOnce = 32;
constexpr Eigen::Index kRowsAtOnce = 2048;

// Rows: samples; columns: Chebyshev products of the terms.
Eigen::MatrixXd design_of(const MapBox& box, const std::vector<Vec3>& positions,
                          const std::vector<int>& terms) {
    Eigen::MatrixXd design(Eigen::Index(positions.size()), Eigen::Index(terms.size()));
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
    RowMatrix along;          // (patch, channel) × rank
    Eigen::VectorXd squares;  // (patch, channel)

    void add(const RowMatrix& volumes,
             const Eigen::MatrixXd& q) {  // (patch, channel) × samples; samples × rank
        const Eigen::Index rows = along.rows(), blocks = (rows + kRowsAtOnce - 1) / kRowsAtOnce;
        parallel_for(std::size_t(blocks), [&](std::size_t block) {
            const Eigen::Index start = Eigen::Index(block) * kRowsAtOnce,
                               count = std::min(kRowsAtOnce, rows - start);
            along.middleRows(start, count).noalias() += volumes.middleRows(start, count) * q;
            squares.segment(start, count) += volumes.middleRows(start, count).rowwise().squaredNorm();
        });
    }
};

Projections project(const Eigen::MatrixXd& q, std::size_t patch_count, const VolumeReader& read_volume) {
    const auto rows = Eigen::Index(patch_count * 3), samples = q.rows();
    Projections projections{RowMatrix::Zero(rows, q.cols()), Eigen::VectorXd::Zero(rows)};
    for (Eigen::Index first = 0; first < samples; first += Eigen::Index(kSamplesAtOnce)) {
        const Eigen::Index count = std::min<Eigen::Index>(kSamplesAtOnce, samples - first);
        RowMatrix volumes(rows, count);
        parallel_for(std::size_t(count), [&](std::size_t i) {
            const std::vector<float> values = read_volume(std::size_t(first) + i);
            for (Eigen::Index row = 0; row < rows; ++row)
                volumes(row, Eigen::Index(i)) = values[std::size_t(row)];
        });
        projections.add(volumes, q.middleRows(first, count));
    }
    return projections;
}

// Per patch: residual variance, and signal plus noise power of each degree per orthonormal term.
struct Powers {
    std::vector<double> noise;
    std::vector<std::array<double, 4>> of_degree;
    std::array<int, 4> terms{};
};

Powers powers_of(const Projections& projections, const std::vector<int>& degrees, Eigen::Index samples) {
    const std::size_t patches = std::size_t(projections.along.rows()) / 3;
    Powers powers{std::vector<double>(patches), std::vector<std::array<double, 4>>(patches), {}};
    for (const int d : degrees) ++powers.terms[d];
    const double free = 3.0 * double(std::max<Eigen::Index>(1, samples - Eigen::Index(degrees.size())));
    for (std::size_t p = 0; p < patches; ++p) {
        powers.of_degree[p].fill(0);
        for (int c = 0; c < 3; ++c) {
            const auto row = Eigen::Index(3 * p) + c;
            powers.noise[p] +=
                std::max(0.0, projections.squares(row) - projections.along.row(row).squaredNorm()) / free;
            for (std::size_t k = 0; k < degrees.size(); ++k)
                powers.of_degree[p][degrees[k]] += projections.along(row, Eigen::Index(k)) *
                                                   projections.along(row, Eigen::Index(k)) /
                                                   (3.0 * powers.terms[degrees[k]]);
        }
    }
    return powers;
}

// tau² / (tau² + sigma²) for a degree of a patch.
double shrinkage(const Powers& powers, const Neighbourhoods& shared, std::size_t patch, int degree) {
    double signal = 0, weight = 0;
    for (const uint32_t n : shared.of[patch]) {
        signal += shared.area[n] * (powers.of_degree[n][degree] - powers.noise[n]);
        weight += shared.area[n];
    }
    const double tau2 = std::max(0.0, signal / weight);
    return tau2 > 0 ? tau2 / (tau2 + powers.noise[patch]) : 0;
}

}  // namespace

Neighbourhoods neighbourhoods(const PatchIndex& index, const std::vector<Patch>& patches) {
    Neighbourhoods shared;
    shared.of.resize(patches.size());
    for (std::size_t p = 0; p < patches.size(); ++p) {
        shared.area.push_back(patches[p].area);
        for (int x = -1; x <= 1; ++x)
            for (int y = -1; y <= 1; ++y)
                for (int z = -1; z <= 1; ++z)
                    if (const int n = index.find(patches[p].cell + Index3(x, y, z), patches[p].slot); n >= 0)
                        shared.of[p].push_back(uint32_t(n));
    }
    return shared;
}

BoxFit fit_box(const MapBox& box, const std::vector<Vec3>& positions, int highest_degree,
               std::size_t patch_count, const VolumeReader& read_volume, const Neighbourhoods& shared) {
    const std::vector<int> terms = terms_of(highest_degree, box.moves());
    const LeastSquares ls = factorise(design_of(box, positions, terms), low_degrees_first(terms));
    const Projections projections = project(ls.q, patch_count, read_volume);
    const Eigen::MatrixXd solve = to_monomials(terms) * ls.solve;  // terms × rank
    std::vector<int> degrees;                                      // of the orthonormal terms
    for (const int column : ls.kept) degrees.push_back(degree(terms[column]));
    const Powers powers = powers_of(projections, degrees, ls.q.rows());
    BoxFit fit;
    fit.statistics = {int(positions.size()), ls.rank(), ls.condition_number};
    fit.polynomials.terms = terms;
    fit.polynomials.coefficients.resize(patch_count * terms.size() * 3);
    fit.polynomials.residuals.resize(patch_count);
    parallel_for((patch_count + 255) / 256, [&](std::size_t block) {
        for (std::size_t p = block * 256; p < std::min(patch_count, (block + 1) * 256); ++p) {
            double misfit = 0;
            Eigen::VectorXd keep = Eigen::VectorXd::Ones(ls.rank());
            for (Eigen::Index k = 0; k < ls.rank(); ++k)
                if (!shared.of.empty() && degrees[k] > 0) keep(k) = shrinkage(powers, shared, p, degrees[k]);
            for (int c = 0; c < 3; ++c) {
                const auto row = Eigen::Index(3 * p) + c;
                const Eigen::VectorXd along = projections.along.row(row).transpose();
                const Eigen::VectorXd kept = keep.cwiseProduct(along), a = solve * kept;
                for (std::size_t t = 0; t < terms.size(); ++t)
                    fit.polynomials.coefficients[(p * terms.size() + t) * 3 + c] = float(a(Eigen::Index(t)));
                misfit += std::max(
                    0.0, projections.squares(row) - along.squaredNorm() + (along - kept).squaredNorm());
            }
            fit.polynomials.residuals[p] = float(std::sqrt(misfit / (3.0 * double(positions.size()))));
        }
    });
    return fit;
}

std::vector<double> leverages(const MapBox& box, const std::vector<Vec3>& positions, int highest_degree,
                              const std::vector<Vec3d>& at) {
    const std::vector<int> terms = terms_of(highest_degree, box.moves());
    const LeastSquares ls = factorise(design_of(box, positions, terms), low_degrees_first(terms));
    std::vector<Vec3> places(at.begin(), at.end());
    const Eigen::MatrixXd weights = design_of(box, places, terms) * ls.solve;
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
                box, positions, settings.degree, patch_count,
                [&](std::size_t i) { return density(inside[i], c); }, shared);
            statistics = fit.statistics;
            polynomials[int(c)] = std::move(fit.polynomials);
        }
    }
    return fitted;
}

}  // namespace pim
