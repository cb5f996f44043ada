// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/least_squares.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "common/core/random.h"
#include "common/map/polynomial.h"

namespace pim {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kEpsilon = 0x1p-52;

std::vector<int> in_order(Index columns) {
    std::vector<int> order(static_cast<std::size_t>(columns));
    std::iota(order.begin(), order.end(), 0);
    return order;
}

LeastSquares factorise(const MatrixXd& design, const std::vector<int>& order) {
    return pim::factorise(design.cast<Extended>(), order);
}

VectorXd solve(const LeastSquares& ls, const VectorXd& y) {
    return ls.solution(y.cast<Extended>()).cast<double>();
}

MatrixXd random_matrix(Index rows, Index columns) {
    RandomStream random(1, RandomPurpose::evaluation, 0, 0);
    return MatrixXd::NullaryExpr(rows, columns, [&] { return 2.0 * random.next() - 1; });
}

// Products of Chebyshev polynomials on a regular grid of positions, low degrees first.
MatrixXd grid_design(int nx, int ny, int nz) {
    MatrixXd design(nx * ny * nz, kTermCount);
    const auto place = [](int i, int n) { return n > 1 ? 2.0 * i / (n - 1) - 1 : 0.0; };
    Index row = 0;
    for (int x = 0; x < nx; ++x)
        for (int y = 0; y < ny; ++y)
            for (int z = 0; z < nz; ++z, ++row) {
                const auto products = chebyshev_products({place(x, nx), place(y, ny), place(z, nz)});
                for (int t = 0; t < kTermCount; ++t)
                    design(row, kTermCount - 1 - t) = products[std::size_t(t)];
            }
    return design;
}

// Errors of both solutions are some 30 columns × condition number × epsilon of the solution's size; no more
// than twice that between them.
TEST(LeastSquares, AgreesWithEigensQr) {
    const MatrixXd a = random_matrix(60, 20);
    const VectorXd y = random_matrix(60, 21).col(20);
    const LeastSquares ls = factorise(a, in_order(20));
    ASSERT_EQ(ls.rank(), 20);
    const VectorXd expected = a.colPivHouseholderQr().solve(y);
    EXPECT_LT((solve(ls, y) - expected).norm(), 60 * ls.condition_number * kEpsilon * expected.norm());
}

TEST(LeastSquares, ConditionNumberOfScaledColumns) {
    MatrixXd a = random_matrix(60, 5);
    const double before = factorise(a, in_order(5)).condition_number;
    a.col(2) *= 1e6;
    EXPECT_NEAR(factorise(a, in_order(5)).condition_number, before, 1e-9 * before);
    EXPECT_NEAR(factorise(MatrixXd::Identity(7, 4), in_order(4)).condition_number, 1, 1e-12);
    MatrixXd two(2, 2);  // unit vectors at an angle: condition number cot(angle / 2)
    const double angle = 0.01;
    two << 1, std::cos(angle), 0, std::sin(angle);
    EXPECT_NEAR(factorise(two, in_order(2)).condition_number, 1 / std::tan(angle / 2), 1e-6);
}

TEST(LeastSquares, QIsOrthonormalAndSpansTheColumns) {
    const MatrixXd a = grid_design(5, 5, 5);
    const LeastSquares ls = factorise(a, in_order(kTermCount));
    const MatrixXd q = ls.q.cast<double>();
    EXPECT_LT((q.transpose() * q - MatrixXd::Identity(ls.rank(), ls.rank())).norm(), 100 * kEpsilon);
    EXPECT_LT((q * (q.transpose() * a) - a).norm(), 100 * kEpsilon * a.norm());
}

TEST(LeastSquares, ExactSolutionsComeBack) {  // Wampler 1 of NIST: all coefficients 1, degree 5, x = 0 .. 20
    MatrixXd a(21, 6);
    for (int i = 0; i < 21; ++i)
        for (int j = 0; j < 6; ++j) a(i, j) = std::pow(i, j);
    const VectorXd y = a.rowwise().sum();
    const LeastSquares ls = factorise(a, in_order(6));
    ASSERT_EQ(ls.rank(), 6);
    const VectorXd x = solve(ls, y);
    // y holds numbers up to 3·10⁶: their rounding, seen through the last rows of the solution.
    for (int j = 0; j < 6; ++j)
        EXPECT_NEAR(x(j), 1, 21 * kEpsilon * y.norm() * double(ls.solve.row(j).norm()));
}

TEST(LeastSquares, GridsTooCoarseForACubic) {
    EXPECT_EQ(factorise(grid_design(13, 7, 2), in_order(kTermCount)).rank(), 16);
    EXPECT_EQ(factorise(grid_design(8, 4, 3), in_order(kTermCount)).rank(), 19);
    EXPECT_EQ(factorise(grid_design(4, 4, 4), in_order(kTermCount)).rank(), 20);
}

TEST(LeastSquares, DroppedColumnsGetNothing) {
    MatrixXd a = random_matrix(30, 5);
    a.col(3) = 2 * a.col(0) - a.col(1);
    const LeastSquares ls = factorise(a, in_order(5));
    EXPECT_EQ(ls.kept, (std::vector<int>{0, 1, 2, 4}));
    EXPECT_EQ(ls.dropped, std::vector<int>{3});
    const VectorXd y = a * VectorXd::LinSpaced(5, 1, 5);
    const VectorXd x = solve(ls, y);
    EXPECT_EQ(x(3), 0);
    EXPECT_LT((a * x - y).norm(), 1000 * kEpsilon * y.norm());  // still the best fit
}

TEST(LeastSquares, OrderSaysWhatSurvives) {
    MatrixXd a = random_matrix(10, 3);
    a.col(2) = a.col(0);
    EXPECT_EQ(factorise(a, {2, 1, 0}).kept, (std::vector<int>{2, 1}));
    EXPECT_EQ(factorise(random_matrix(2, 4), {3, 0, 1, 2}).kept, (std::vector<int>{3, 0}));
    EXPECT_EQ(factorise(random_matrix(2, 4), {3, 0, 1, 2}).dropped, (std::vector<int>{1, 2}));
}

TEST(LeastSquares, RepeatedRowsChangeNothing) {
    const MatrixXd a = random_matrix(25, 4);
    const VectorXd y = random_matrix(25, 5).col(4);
    MatrixXd twice(50, 4);
    twice << a, a;
    VectorXd twice_y(50);
    twice_y << y, y;
    const LeastSquares once = factorise(a, in_order(4));
    EXPECT_LT((solve(once, y) - solve(factorise(twice, in_order(4)), twice_y)).norm(),
              50 * once.condition_number * kEpsilon * y.norm());
}

TEST(LeastSquares, OneSampleGivesTheConstant) {
    const LeastSquares ls = factorise(MatrixXd::Ones(1, 4), in_order(4));
    ASSERT_EQ(ls.kept, std::vector<int>{0});
    EXPECT_NEAR(solve(ls, VectorXd::Constant(1, 7.0))(0), 7, 10 * kEpsilon);
    EXPECT_NEAR(ls.condition_number, 1, 10 * kEpsilon);
}

TEST(LeastSquares, AZeroColumnIsDropped) {
    MatrixXd a = random_matrix(10, 2);
    a.col(0).setZero();
    EXPECT_EQ(factorise(a, in_order(2)).kept, std::vector<int>{1});
}

}  // namespace
}  // namespace pim
