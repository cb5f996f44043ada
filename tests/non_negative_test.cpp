// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/non_negative.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/core/random.h"
#include "common/map/illumination_map.h"

namespace pim {
namespace {

Cubic random_cubic(uint64_t number) {
    RandomStream random(5, RandomPurpose::evaluation, 0, number);
    Cubic cubic;
    for (double& a : cubic) a = 2.0 * random.next() - 1;
    return cubic;
}

double value(const Cubic& cubic, const Vec3d& u) {
    const auto powers = monomials(u);
    double sum = 0;
    for (std::size_t t = 0; t < cubic.size(); ++t) sum += cubic[t] * powers[t];
    return sum;
}

// Calls visit(u) on a fine lattice, corners and edges included.
template <class Visit>
void on_lattice(int steps, Visit visit) {
    for (int i = 0; i <= steps; ++i)
        for (int j = 0; j <= steps; ++j)
            for (int k = 0; k <= steps; ++k)
                visit(Vec3d(2.0 * i / steps - 1, 2.0 * j / steps - 1, 2.0 * k / steps - 1));
}

double least_on_lattice(const Cubic& cubic, int steps = 40) {
    double least = value(cubic, Vec3d(0));
    on_lattice(steps, [&](const Vec3d& u) { least = std::min(least, value(cubic, u)); });
    return least;
}

TEST(MeanOverBox, IsThatOfGaussPoints) {
    const double g = 1 / std::sqrt(3.0);  // two points are exact for cubics
    for (uint64_t n = 0; n < 20; ++n) {
        const Cubic cubic = random_cubic(n);
        double sum = 0;
        for (const double x : {-g, g})
            for (const double y : {-g, g})
                for (const double z : {-g, g}) sum += value(cubic, {x, y, z}) / 8;
        EXPECT_NEAR(mean_over_box(cubic), sum, 1e-12);
    }
}

TEST(LowerBound, LiesCloseBelowTheLeastValue) {
    for (uint64_t n = 0; n < 200; ++n) {
        const Cubic cubic = random_cubic(n);
        const double least = least_on_lattice(cubic, 20), mean = mean_over_box(cubic);
        if (least >= 0) continue;
        for (const double tolerance : {0.1, 0.01, 1e-4}) {
            const double bound = lower_bound_in_box(cubic, tolerance);
            EXPECT_LE(bound, least + 1e-12);
            // The lattice misses the least value by second derivatives (at most some 60) times (0.05)² / 8
            // · 3.
            EXPECT_GE(bound, least - tolerance * (mean - bound) - 60 * 3 * 0.1 * 0.1 / 8);
        }
    }
}

TEST(LowerBound, TouchingZeroInside) {  // (x - 0.3)², and with a hair less
    Cubic cubic{};
    cubic[10] = 1, cubic[16] = -0.6, cubic[kConstantTerm] = 0.09;
    EXPECT_GE(lower_bound_in_box(cubic), -1e-8);
    cubic[kConstantTerm] -= 1e-4;
    EXPECT_LT(lower_bound_in_box(cubic), 0);
    EXPECT_GE(lower_bound_in_box(cubic), -1.1e-4 - 0.01);
}

TEST(MendSign, KeepsTheMeanAndTheLargestShare) {
    int mended = 0;
    for (uint64_t n = 0; n < 300; ++n) {
        const Cubic before = random_cubic(n);
        Cubic after = before;
        const double mean = mean_over_box(before), least = least_on_lattice(before, 20),
                     share = mend_sign(after);
        if (mean <= 0) {
            EXPECT_EQ(share, 0);
            EXPECT_EQ(after, Cubic{});
            continue;
        }
        EXPECT_NEAR(mean_over_box(after), mean, 1e-12);
        EXPECT_GE(least_on_lattice(after, 20), 0);
        if (share == 1) {
            EXPECT_EQ(after, before);
            continue;
        }
        ++mended;
        EXPECT_LE(share, mean / (mean - std::min(0.0, least)));
        for (int t = 0; t < kConstantTerm; ++t)
            EXPECT_NEAR(after[std::size_t(t)], share * before[std::size_t(t)], 1e-12);
    }
    EXPECT_GT(mended, 50);
}

// Over an orthonormal design the mended polynomial is nearer to the original than plain mending comes.
TEST(SignMender, LosesLess) {
    const std::vector<int> terms = terms_of(3, {true, true, true});
    std::vector<Vec3d> samples;
    on_lattice(5, [&](const Vec3d& u) { samples.push_back(u); });
    Eigen::MatrixXd design(Eigen::Index(samples.size()), kTermCount);
    for (std::size_t m = 0; m < samples.size(); ++m) {
        const auto powers = monomials(samples[m]);
        for (int t = 0; t < kTermCount; ++t)  // the constant first
            design(Eigen::Index(m), t) = powers[std::size_t(kTermCount - 1 - t)];
    }
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(design);
    Eigen::MatrixXd r = qr.matrixQR().topRows(kTermCount).triangularView<Eigen::Upper>();
    const double sign = r(0, 0) < 0 ? -1 : 1;  // the first orthonormal term is + 1 / sqrt(samples)
    r.row(0) *= sign;
    const Eigen::MatrixXd solve = r.inverse().colwise().reverse();
    const SignMender mender(solve, terms, int(samples.size()), {true, true, true});
    double plain_loss = 0, loss = 0;
    for (uint64_t n = 0; n < 100; ++n) {
        Cubic wanted = random_cubic(n);
        wanted[kConstantTerm] += 1;
        Eigen::VectorXd reversed(kTermCount);
        for (int t = 0; t < kTermCount; ++t) reversed(t) = wanted[std::size_t(kTermCount - 1 - t)];
        const Eigen::RowVectorXd orthonormal = (r * reversed).transpose();
        Cubic plain = wanted, cubic = mender.cubic(orthonormal);
        for (int t = 0; t < kTermCount; ++t) ASSERT_NEAR(cubic[std::size_t(t)], wanted[std::size_t(t)], 1e-9);
        Eigen::RowVectorXd moved = orthonormal;
        const uint8_t status = mender.mend(cubic, moved);
        const double share = mend_sign(plain);
        if (share == 1 || share == 0) {
            EXPECT_EQ(status, share == 0 ? kBlack : 0);
            continue;
        }
        EXPECT_EQ(status, kMended);
        EXPECT_GE(lower_bound_in_box(cubic), 0);
        EXPECT_NEAR(mean_over_box(cubic), mean_over_box(wanted), 1e-9);
        const Cubic again = mender.cubic(moved);
        for (int t = 0; t < kTermCount; ++t) EXPECT_NEAR(cubic[std::size_t(t)], again[std::size_t(t)], 1e-9);
        for (const Vec3d& u : samples) {
            plain_loss += std::pow(value(plain, u) - value(wanted, u), 2);
            loss += std::pow(value(cubic, u) - value(wanted, u), 2);
        }
    }
    EXPECT_LT(loss, 0.7 * plain_loss);
}

}  // namespace
}  // namespace pim
