// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/robust_fit.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "bake/fit.h"
#include "bake/outliers.h"
#include "common/core/random.h"
#include "stability_table.h"

namespace pim {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kSamples = 80, kTerms = 6;

MatrixXd orthonormal_design() {
    RandomStream random(3, RandomPurpose::evaluation, 0, 0);
    const MatrixXd a = MatrixXd::NullaryExpr(
        kSamples, kTerms, [&](Index, Index j) { return j == 0 ? 1.0 : 2.0 * random.next() - 1; });
    return MatrixXd(a.householderQr().householderQ() * MatrixXd::Identity(kSamples, kTerms));
}

class RobustLosses : public testing::TestWithParam<RobustLoss> {};

// Residuals far inside of the scale: the loss of all is that of least squares, whose solution is Qᵀ y.
TEST_P(RobustLosses, WithoutOutliersIsLeastSquares) {
    const MatrixXd q = orthonormal_design();
    RandomStream random(4, RandomPurpose::evaluation, 0, 0);
    VectorXd y = q * VectorXd::LinSpaced(kTerms, 5, 1);
    for (double& v : y) v += 1e-3 * (2.0 * random.next() - 1);
    const RobustFit fit =
        robust_fit(q, y, VectorXd::Constant(kSamples, 1), VectorXd::Zero(kTerms), GetParam());
    ASSERT_TRUE(fit.converged);
    // Weights fall by (1e-3 / cut)² at most, and pull on residuals of 1e-3.
    EXPECT_LT((fit.coefficients - q.transpose() * y).norm(), 1e-6);
    EXPECT_GT(fit.weights.minCoeff(), 1 - 1e-5);
}

TEST_P(RobustLosses, GrossErrorsHardlyCount) {
    const MatrixXd q = orthonormal_design();
    const VectorXd truth = VectorXd::LinSpaced(kTerms, 50, 10);
    VectorXd y = q * truth;
    for (const Index m : {3, 17, 40, 66}) y(m) *= 100;
    const VectorXd linear = q.transpose() * y;
    const RobustFit fit = robust_fit(q, y, VectorXd::Constant(kSamples, 0.1), linear, GetParam());
    ASSERT_TRUE(fit.converged);
    EXPECT_GT((linear - truth).norm(), 100);
    // Huber's pull of an outlier is that of a residual of 3 scales; the others' falls with its size.
    EXPECT_LT((fit.coefficients - truth).norm(), 4 * 3 * 0.1 * 2);
    for (const Index m : {3, 17, 40, 66}) EXPECT_LT(fit.weights(m), 0.05);
}

INSTANTIATE_TEST_SUITE_P(All, RobustLosses,
                         testing::Values(RobustLoss::huber, RobustLoss::cauchy, RobustLoss::tukey));

TEST(RobustFit, ANumberThatIsNoneDoesNotConverge) {
    const MatrixXd q = orthonormal_design();
    VectorXd y = VectorXd::Ones(kSamples);
    y(5) = std::nan("");
    EXPECT_FALSE(
        robust_fit(q, y, VectorXd::Ones(kSamples), VectorXd::Zero(kTerms), RobustLoss::huber).converged);
}

TEST(TailProbability, OfAnExponentialVariable) {  // mean = standard deviation: 1 - exp(-y / mean)
    for (const double y : {0.1, 1.5, 10.0}) {
        const double above = std::exp(-y / 2);
        EXPECT_NEAR(tail_probability(y, 2, 4), y > 2 ? above : 1 - above, 1e-12);
    }
    EXPECT_EQ(tail_probability(3, 2, 0), 0);
    EXPECT_EQ(tail_probability(2, 2, 0), 1);
    EXPECT_GT(tail_probability(1 + 1e-9, 1, 1e-12), 0.4);  // far into the normal limit: no overflow
}

// ---- patches in a sheet, lit by photons of weights that differ by a factor of four

struct Sheet {
    static constexpr int kSide = 20;
    Cells cells;
    MapBox box = split_domain(Box3(Vec3(-1), Vec3(1)), Index3(1))[0];
    std::vector<Vec3> positions;
    std::vector<DensityVolume::PerComponent> volumes;

    Sheet(double photons, int samples) {
        cells.grid.size = Index3(kSide, kSide, 1);
        cells.grid.cell_size = 1;
        for (int y = 0; y < kSide; ++y)
            for (int x = 0; x < kSide; ++x) cells.patches.push_back({{x, y, 0}, 2, 1, Vec3(0)});
        cells.index = PatchIndex(cells.grid, cells.patches);
        std::mt19937 random(7);
        std::uniform_real_distribution<float> place(-1, 1);
        std::uniform_real_distribution<double> weight(0.4, 1.6);
        for (int m = 0; m < samples; ++m) {
            positions.emplace_back(place(random), place(random), place(random));
            auto& volume = volumes.emplace_back();
            for (std::size_t p = 0; p < cells.patches.size(); ++p) {
                std::poisson_distribution<int> count(photons * truth(p, positions.back()));
                double sum = 0, squares = 0;
                for (int n = count(random); n > 0; --n) {
                    const double w = weight(random) / photons;
                    sum += w, squares += w * w;
                }
                volume.density.push_back(Rgb(float(sum)));
                volume.variance.push_back(float(squares));
            }
        }
    }
    // Expected density: falls off across the sheet, follows the lamp by a cubic.
    static double truth(std::size_t p, const Vec3& u) {
        const double slope = 0.3 + 0.7 * double(p % kSide) / kSide;
        return slope * (1 + 0.4 * double(u.x) + 0.2 * double(u.y * u.y) - 0.1 * double(u.x * u.z * u.z));
    }
    BoxFit fit(Robust robust, RobustLoss loss = RobustLoss::tukey) const {
        return fit_box(
            box, positions, {3, false, false, robust, loss}, cells.patches.size(),
            [&](std::size_t m) { return volumes[m]; }, Neighbourhoods(cells, true));
    }
    double error(const BoxFit& fit) const {
        double squares = 0, whole = 0;
        for (const float x : {-0.8f, -0.2f, 0.5f})
            for (const float z : {-0.6f, 0.7f}) {
                const Vec3 u(x, -x, z);
                const auto powers = monomials(Vec3d(u));
                for (std::size_t p = 0; p < cells.patches.size(); ++p) {
                    double value = 0;
                    for (std::size_t t = 0; t < kTermCount; ++t)
                        value += powers[t] * double(fit.polynomials.coefficients[(p * kTermCount + t) * 3]);
                    squares += std::pow(value - truth(p, u), 2), whole += std::pow(truth(p, u), 2);
                }
            }
        return std::sqrt(squares / whole);
    }
    static long robust_patches(const BoxFit& fit) {
        return std::ranges::count(fit.polynomials.status, uint8_t(kRobust));
    }
};

TEST(RobustPass, CleanNoiseRaisesFewAlarms) {
    for (const double photons : {0.5, 5.0, 50.0}) {
        const Sheet sheet(photons, 100);
        const BoxFit fit = sheet.fit(Robust::automatic);
        // The stated rate is one in a thousand patches. The tail that is tested is heavier than the noise's;
        // neighbours' medians scatter. 400 patches at 1 %: 4 ± 2.
        EXPECT_LE(Sheet::robust_patches(fit), 8) << photons;
        EXPECT_LE(sheet.error(fit), 1.01 * sheet.error(sheet.fit(Robust::off))) << photons;
    }
}

TEST(RobustPass, SpoiledSamplesHardlyMatter) {
    Sheet sheet(20, 100);
    const double clean = sheet.error(sheet.fit(Robust::off));
    std::mt19937 random(11);
    std::bernoulli_distribution patch_is_hit(0.1), sample_is_hit(0.05);
    std::vector<bool> hit;
    for (std::size_t p = 0; p < sheet.cells.patches.size(); ++p) hit.push_back(patch_is_hit(random));
    for (auto& volume : sheet.volumes)
        for (std::size_t p = 0; p < hit.size(); ++p)
            if (hit[p] && sample_is_hit(random)) volume.density[p] *= 100, volume.variance[p] *= 10000;
    const double plain = sheet.error(sheet.fit(Robust::off)),
                 robust = sheet.error(sheet.fit(Robust::automatic));
    for (const auto& [data, fit, error] : {std::tuple{"clean", "least squares", clean},
                                           {"spoiled", "least squares", plain},
                                           {"spoiled", "robust, Tukey's loss", robust}})
        add_to_table("spoiled", {data, fit, fmt::format("{:.4f}", error)});
    EXPECT_GT(plain, 10 * clean);
    EXPECT_LE(robust, 1.2 * clean);
    for (const auto& [name, loss] : {std::pair{"robust, Huber's loss", RobustLoss::huber},
                                     {"robust, Cauchy's loss", RobustLoss::cauchy}}) {
        const double other = sheet.error(sheet.fit(Robust::automatic, loss));
        add_to_table("spoiled", {"spoiled", name, fmt::format("{:.4f}", other)});
        EXPECT_LE(robust, 1.001 * other);  // the loss that is used serves best
    }
}

// A patch that is lit brightly for a few lamp positions together with those around it is no outlier.
TEST(RobustPass, LightThatNeighboursShareStays) {
    Sheet sheet(50, 100);
    for (std::size_t m = 0; m < sheet.volumes.size(); m += 25)
        for (int y = 8; y < 12; ++y)
            for (int x = 8; x < 12; ++x) {
                const auto p = std::size_t(y * Sheet::kSide + x);
                sheet.volumes[m].density[p] *= 6, sheet.volumes[m].variance[p] *= 6;
            }
    const BoxFit off = sheet.fit(Robust::off), robust = sheet.fit(Robust::automatic);
    double flux_off = 0, flux_robust = 0;
    for (std::size_t p = 0; p < sheet.cells.patches.size(); ++p)
        for (const auto& [fit, flux] : {std::pair{&off, &flux_off}, std::pair{&robust, &flux_robust}})
            *flux += double(fit->polynomials.coefficients[(p * kTermCount + kConstantTerm) * 3]);
    EXPECT_NEAR(flux_robust, flux_off, 0.005 * flux_off);
}

}  // namespace
}  // namespace pim
