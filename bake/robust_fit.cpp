// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/robust_fit.h"

#include <ceres/ceres.h>

#include <memory>
#include <vector>

#include "common/core/float_traps.h"

namespace pim {
namespace {

constexpr int kMostIterations = 100;
// In units of a sample's noise, which is skewed and has exponential tails: wider than for normal noise.
constexpr double kHuber = 3, kCauchy = 4, kTukey = 12;

// y_m - q_m · a
class Residual : public ceres::CostFunction {
  public:
    Residual(const Eigen::VectorXd& row, double y) : row_(row), y_(y) {
        set_num_residuals(1);
        mutable_parameter_block_sizes()->push_back(int(row.size()));
    }
    bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
        residuals[0] = y_ - row_.dot(Eigen::Map<const Eigen::VectorXd>(parameters[0], row_.size()));
        if (jacobians && jacobians[0]) Eigen::Map<Eigen::VectorXd>(jacobians[0], row_.size()) = -row_;
        return true;
    }

  private:
    Eigen::VectorXd row_;
    double y_;
};

std::unique_ptr<ceres::LossFunction> loss_of(RobustLoss loss, double scale) {
    switch (loss) {
        case RobustLoss::huber:
            return std::make_unique<ceres::HuberLoss>(kHuber * scale);
        case RobustLoss::cauchy:
            return std::make_unique<ceres::CauchyLoss>(kCauchy * scale);
        case RobustLoss::tukey:
            return std::make_unique<ceres::TukeyLoss>(kTukey * scale);
    }
    return nullptr;
}

class RobustProblem {
  public:
    RobustProblem(const Eigen::MatrixXd& q, const Eigen::VectorXd& y, const Eigen::VectorXd& scale)
        : q_(q), y_(y), scale_(scale) {
        for (Eigen::Index m = 0; m < q.rows(); ++m)
            residuals_.push_back(std::make_unique<Residual>(q.row(m), y(m)));
    }

    RobustFit solve(const Eigen::VectorXd& start, RobustLoss loss) const {
        RobustFit fit{start, Eigen::VectorXd(q_.rows())};
        ceres::Problem::Options ownership;
        ownership.cost_function_ownership = ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
        ceres::Problem problem(ownership);
        std::vector<std::unique_ptr<ceres::LossFunction>> losses;
        for (Eigen::Index m = 0; m < q_.rows(); ++m) {
            losses.push_back(loss_of(loss, scale_(m)));
            problem.AddResidualBlock(residuals_[std::size_t(m)].get(), losses.back().get(),
                                     fit.coefficients.data());
        }
        ceres::Solver::Options options;
        options.linear_solver_type = ceres::DENSE_QR;
        options.max_num_iterations = kMostIterations;
        options.function_tolerance = 1e-9;
        options.logging_type = ceres::SILENT;
        ceres::Solver::Summary summary;
        const FloatTraps library(FloatTraps::off);
        ceres::Solve(options, &problem, &summary);
        fit.iterations = int(summary.iterations.size());
        fit.converged = summary.termination_type == ceres::CONVERGENCE && fit.coefficients.allFinite();
        const Eigen::VectorXd left = y_ - q_ * fit.coefficients;
        for (Eigen::Index m = 0; m < left.size(); ++m) {
            double rho[3];  // and its derivatives
            losses[std::size_t(m)]->Evaluate(left(m) * left(m), rho);
            fit.weights(m) = rho[1];
        }
        return fit;
    }

  private:
    const Eigen::MatrixXd& q_;
    const Eigen::VectorXd &y_, &scale_;
    std::vector<std::unique_ptr<Residual>> residuals_;
};

}  // namespace

RobustFit robust_fit(const Eigen::MatrixXd& q, const Eigen::VectorXd& y, const Eigen::VectorXd& scale,
                     const Eigen::VectorXd& start, RobustLoss loss) {
    if (!y.allFinite() || !(scale.minCoeff() > 0)) return {start, Eigen::VectorXd::Ones(y.size())};
    const RobustProblem problem(q, y, scale);
    RobustFit fit = problem.solve(start, RobustLoss::huber);
    if (!fit.converged || loss == RobustLoss::huber) return fit;
    const int before = fit.iterations;
    fit = problem.solve(fit.coefficients, loss);
    fit.iterations += before;
    return fit;
}

}  // namespace pim
