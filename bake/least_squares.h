// SPDX-License-Identifier: GPL-3.0-or-later
// Linear least squares with one design for many right-hand sides: factorised once, in extended precision.
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace pim {

// Columns whose part orthogonal to the columns before them is below this share of their length are dropped:
// the samples do not determine them.
inline constexpr double kIndependence = 1e-5;

// A = Q R for the kept columns of the design A (rows: samples). The solution for a right-hand side y is
// x = solve · (Qᵀ y), 0 for dropped columns.
struct LeastSquares {
    Eigen::MatrixXd q;            // samples × rank, orthonormal columns
    Eigen::MatrixXd solve;        // columns of A × rank
    std::vector<int> kept;        // columns of A, in the order that they were taken
    double condition_number = 1;  // of A's kept columns, scaled to length 1

    int rank() const { return int(kept.size()); }
};

// Gram-Schmidt with reorthogonalisation ("twice is enough": Giraud, Langou, Rozloznik 2005), columns taken in
// the order given, so that what comes first (low orders) survives when samples are too few.
LeastSquares factorise(const Eigen::MatrixXd& design, const std::vector<int>& order);

}  // namespace pim
