// SPDX-License-Identifier: GPL-3.0-or-later
// Cubics that never go below zero in their box: irradiance does not.
#pragma once

#include <array>
#include <cstdint>

#include "bake/least_squares.h"
#include "common/map/polynomial.h"

namespace pim {

using Cubic = std::array<double, kTermCount>;  // coefficients of the monomials over [-1,1]³

double mean_over_box(const Cubic& cubic);

// A bound from below of the cubic's least value in the box, at most `tolerance` of the distance from the mean
// to it too low; where the cubic is nowhere negative, any bound of at least 0. By the convex hull of its
// Bernstein coefficients, boxes with the least of them split in halves first (Garloff: Convergent bounds for
// the range of multivariate polynomials, 1985).
double lower_bound_in_box(const Cubic& cubic, double tolerance = 0.01);

// Moves a cubic that goes below zero towards its mean over the box, by the largest share that keeps it from
// it, so that the mean stays: mean + share · (cubic - mean). A negative mean becomes 0. The share that is
// left of what is not the mean: 1 if nothing had to be done, 0 where the mean was negative.
double mend_sign(Cubic& cubic);

// The same for the cubics of one design, with less loss: a cubic that would lose much of its shape is moved
// to the nearest one, over the design's samples, of the same mean that is not negative on a lattice of points
// (a quadratic programme, by Hildreth's method, 1957), and that one is mended.
class SignMender {
  public:
    // `solve`: orthonormal coefficients to those of the monomials `terms`; terms × rank. The first
    // orthonormal term is the constant 1 / sqrt(samples).
    SignMender(const Eigen::MatrixXd& solve, const std::vector<int>& terms, int samples,
               const std::array<bool, 3>& moves);

    Cubic cubic(const Eigen::RowVectorXd& orthonormal) const;
    // Mends both, which belong to the same polynomial. What was done: of FitStatus, or 0.
    uint8_t mend(Cubic& cubic, Eigen::Ref<Eigen::RowVectorXd> orthonormal) const;

  private:
    void lift(Eigen::Ref<Eigen::RowVectorXd> orthonormal) const;

    Eigen::MatrixXd solve_;
    std::vector<int> terms_;
    double constant_;            // sqrt(samples): of the orthonormal term that is 1
    RowMatrix values_;           // point × rank: of the orthonormal terms
    RowMatrix moves_;            // likewise, without what changes the mean
    Eigen::VectorXd influence_;  // [point] on its own value, of a step along moves_
};

}  // namespace pim
