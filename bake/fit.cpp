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
Eigen::MatrixXd design_of(const MapBox& box, const std::vector<Vec3>& positions, const std::vector<int>& terms) {
    Eigen::MatrixXd design(Eigen::Index(positions.size()), Eigen::Index(terms.size()));
    for (std::size_t m = 0; m < positions.size(); ++m) {
        const auto products = chebyshev_products(box.normalised(Vec3d(positions[m])));
        for (std::size_t t = 0; t < terms.size(); ++t) design(Eigen::Index(m), Eigen::Index(t)) = products[terms[t]];
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
        for (std::size_t i = 0; i < terms.size(); ++i) change(Eigen::Index(i), Eigen::Index(j)) = column[terms[i]];
    }
    return change;
}

// Qᵀ y for every patch and channel, and the sum of squares of y, volumes added a few at a time.
struct Projections {
    RowMatrix along;               // (patch, channel) × rank
    Eigen::VectorXd squares;       // (patch, channel)

    void add(const RowMatrix& volumes, const Eigen::MatrixXd& q) {   // (patch, channel) × samples; samples × rank
        const Eigen::Index rows = along.rows(), blocks = (rows + kRowsAtOnce - 1) / kRowsAtOnce;
        parallel_for(std::size_t(blocks), [&](std::size_t block) {
            const Eigen::Index start = Eigen::Index(block) * kRowsAtOnce, count = std::min(kRowsAtOnce, rows - start);
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
            for (Eigen::Index row = 0; row < rows; ++row) volumes(row, Eigen::Index(i)) = values[std::size_t(row)];
        });
        projections.add(volumes, q.middleRows(first, count));
    }
    return projections;
}

}  // namespace

BoxFit fit_box(const MapBox& box, const std::vector<Vec3>& positions, int highest_degree, std::size_t patch_count,
               const VolumeReader& read_volume) {
    const std::vector<int> terms = terms_of(highest_degree, box.moves());
    const LeastSquares ls = factorise(design_of(box, positions, terms), low_degrees_first(terms));
    const Projections projections = project(ls.q, patch_count, read_volume);
    const Eigen::MatrixXd solve = to_monomials(terms) * ls.solve;   // terms × rank
    BoxFit fit;
    fit.statistics = {int(positions.size()), ls.rank(), ls.condition_number};
    fit.polynomials.terms = terms;
    fit.polynomials.coefficients.resize(patch_count * terms.size() * 3);
    fit.polynomials.residuals.resize(patch_count);
    parallel_for((patch_count + 255) / 256, [&](std::size_t block) {
        for (std::size_t p = block * 256; p < std::min(patch_count, (block + 1) * 256); ++p) {
            double misfit = 0;
            for (int c = 0; c < 3; ++c) {
                const auto row = Eigen::Index(3 * p) + c;
                const Eigen::VectorXd a = solve * projections.along.row(row).transpose();
                for (std::size_t t = 0; t < terms.size(); ++t)
                    fit.polynomials.coefficients[(p * terms.size() + t) * 3 + c] = float(a(Eigen::Index(t)));
                misfit += std::max(0.0, projections.squares(row) - projections.along.row(row).squaredNorm());
            }
            fit.polynomials.residuals[p] = float(std::sqrt(misfit / (3.0 * double(positions.size()))));
        }
    });
    return fit;
}

}  // namespace pim
