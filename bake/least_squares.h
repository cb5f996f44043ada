// SPDX-License-Identifier: GPL-3.0-or-later
// Linear least squares with one design for many right-hand sides: factorised once, in extended precision.
// A design has some hundred rows, so that this costs nothing beside the photons, and even designs that double
// precision cannot solve give most of their digits (docs/stability.md).
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace pim {

using Extended = long double;
using ExtendedMatrix = Eigen::Matrix<Extended, Eigen::Dynamic, Eigen::Dynamic>;
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using ExtendedVector = Eigen::Matrix<Extended, Eigen::Dynamic, 1>;

// Columns whose part orthogonal to the columns before them is below this share of their length are dropped:
// the samples do not determine them.
inline constexpr double kIndependence = 1e-5;

// A = Q R for the kept columns of the design A (rows: samples). The solution for a right-hand side y is
// x = solve · (Qᵀ y), 0 for dropped columns.
struct LeastSquares {
    ExtendedMatrix q;             // samples × rank, orthonormal columns
    ExtendedMatrix solve;         // columns of A × rank
    std::vector<int> kept;        // columns of A, in the order that they were taken
    std::vector<int> dropped;     // likewise
    double condition_number = 1;  // of A's kept columns, scaled to length 1

    int rank() const { return int(kept.size()); }
    ExtendedVector solution(const ExtendedVector& y) const { return solve * (q.transpose() * y); }
};

// Gram-Schmidt with reorthogonalisation ("twice is enough": Giraud, Langou, Rozloznik 2005), columns taken in
// the order given, so that what comes first (low orders) survives when samples are too few.
LeastSquares factorise(const ExtendedMatrix& design, const std::vector<int>& order,
                       double independence = kIndependence);

}  // namespace pim
