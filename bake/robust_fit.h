// SPDX-License-Identifier: GPL-3.0-or-later
// A patch's coefficients where some of its samples are spoiled, by Ceres.
#pragma once

#include <Eigen/Dense>

namespace pim {

enum class RobustLoss { huber, cauchy, tukey };

struct RobustFit {
    Eigen::VectorXd coefficients;  // of the columns of q
    Eigen::VectorXd weights;       // of the samples, 0 to 1: how much each counts; 1 within its noise
    int iterations = 0;
    bool converged = false;
};

// Minimises sum_m s_m² rho((y_m - q_m · a)² / s_m²) over a: least squares for samples within a few s_m, less
// for others. `scale` holds s_m, the noise that each sample may have. First with Huber's loss, whose minimum
// is the only one, from `start`; then with `loss` from there (Huber: Robust Statistics, 1981; Black and
// Rangarajan, 1996, for Tukey's as a loss).
RobustFit robust_fit(const Eigen::MatrixXd& q, const Eigen::VectorXd& y, const Eigen::VectorXd& scale,
                     const Eigen::VectorXd& start, RobustLoss loss);

}  // namespace pim
