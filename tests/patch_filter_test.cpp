// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/patch_filter.h"

#include <numeric>
#include <random>

#include "common/core/parallel.h"
#include "statistics.h"

namespace pim {
namespace {

constexpr int kSlot = 5;

// A flat sheet of n × n patches, one in each cell of a layer.
Cells sheet(int n, float area = 1) {
    Cells cells;
    cells.grid.size = Index3(n, n, 3);
    for (int x = 0; x < n; ++x)
        for (int y = 0; y < n; ++y) cells.patches.push_back({{x, y, 1}, kSlot, area, Vec3(0)});
    cells.index = PatchIndex(cells.grid, cells.patches);
    return cells;
}

// Degrees 0 to 3 as a cubic in three variables has them.
const std::vector<int> kCubic{0, 1, 1, 1, 2, 2, 2, 2, 2, 2, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3};

// signal(patch) in all terms and channels, and unit noise.
template <class Signal>
NoisyCoefficients noisy(std::size_t patches, Signal signal) {
    std::mt19937 engine(1);
    std::normal_distribution<double> gauss;
    NoisyCoefficients c{RowMatrix(Eigen::Index(3 * patches), Eigen::Index(kCubic.size())), kCubic, {}};
    for (Eigen::Index row = 0; row < c.values.rows(); ++row)
        for (Eigen::Index k = 0; k < c.values.cols(); ++k)
            c.values(row, k) = signal(std::size_t(row) / 3) + gauss(engine);
    c.noise.resize(patches);
    for (auto& noise : c.noise) noise.fill(1);
    return c;
}

TEST(Neighbourhoods, SameSlotInTheCellsAround) {
    Cells cells;
    cells.grid.size = Index3(6);
    for (int x = 0; x < 6; ++x) cells.patches.push_back({{x, 1, 1}, 2, float(x + 1), Vec3(0, 0, 0.25f)});
    cells.patches.push_back({{5, 1, 1}, 4, 9, Vec3(0)});
    cells.index = PatchIndex(cells.grid, cells.patches);
    const auto list = [](std::span<const uint32_t> s) { return std::vector<uint32_t>(s.begin(), s.end()); };
    const Neighbourhoods shared(cells, true);
    EXPECT_EQ(list(shared.near(0)), (std::vector<uint32_t>{0, 1}));
    EXPECT_EQ(list(shared.near(2)), (std::vector<uint32_t>{1, 2, 3}));
    EXPECT_EQ(list(shared.far(1)), (std::vector<uint32_t>{0, 1, 2, 3, 4}));
    EXPECT_EQ(list(shared.far(6)), (std::vector<uint32_t>{6}));
    EXPECT_EQ(shared.area(6), 9);
    for (std::size_t i = 0; i < shared.far(1).size(); ++i) {  // centroids (n, 1, 1.25), in cells
        const double apart = double(shared.far(1)[i]) - 1;
        EXPECT_NEAR(shared.closeness(1)[i], std::exp(-apart * apart / 8), 1e-6);
    }
    EXPECT_EQ(list(Neighbourhoods(cells, false).far(2)), (std::vector<uint32_t>{1, 2, 3}));
    EXPECT_TRUE(Neighbourhoods().empty());
}

// Under even light every patch has the variance v / area.
TEST(PooledNoise, EvenLightStaysAsItIs) {
    Cells cells = sheet(5);
    for (std::size_t p = 0; p < cells.patches.size(); ++p) cells.patches[p].area = 1 + float(p % 3);
    std::vector<double> variance;
    for (const Patch& p : cells.patches) variance.push_back(7 / double(p.area));
    const auto pooled = pooled_noise(variance, Neighbourhoods(cells, true));
    for (std::size_t p = 0; p < pooled.size(); ++p) EXPECT_NEAR(pooled[p], variance[p], 1e-9);
}

// sum of w² / (sum of w)² over a square window of weights exp(-d² / (2 width²)), its middle left out.
double noise_of_mean(int reach, double width) {
    double sum = 0, squares = 0;
    for (int x = -reach; x <= reach; ++x)
        for (int y = -reach; y <= reach; ++y) {
            if (x == 0 && y == 0) continue;
            const double w = std::exp(-(x * x + y * y) / (2 * width * width));
            sum += w, squares += w * w;
        }
    return squares / (sum * sum);
}

// No signal varies: the best mix of a patch and a mean of noise v has the variance v / (1 + v). The signal's
// variance is estimated from n = 3 channels × terms × 49 patches, whose guesses overlap, so with a scatter of
// at most s = 2 sqrt(2/n); a wrong share costs up to s² on top.
TEST(Filter, EvenSignalGetsTheNoiseOfItsNeighbourhood) {
    constexpr int kSide = 40, kReach = 3;
    const Cells cells = sheet(kSide);
    const NoisyCoefficients before = noisy(cells.patches.size(), [](std::size_t) { return 5.0; });
    const NoisyCoefficients after = filtered(before, Neighbourhoods(cells, true));
    const double v = noise_of_mean(kReach, 2);
    ASSERT_LT(v, noise_of_mean(1, 1));
    const std::array<double, kDegrees> terms{1, 3, 6, 10};
    for (int d = 0; d < kDegrees; ++d) {
        Mean squares, said;
        for (std::size_t p = 0; p < cells.patches.size(); ++p) {
            const Index3& c = cells.patches[p].cell;
            if (std::min(c.x, c.y) < kReach || std::max(c.x, c.y) >= kSide - kReach) continue;
            said.add(after.noise[p][std::size_t(d)]);
            for (std::size_t k = 0; k < kCubic.size(); ++k)
                for (int channel = 0; kCubic[k] == d && channel < 3; ++channel)
                    squares.add(
                        std::pow(after.values(Eigen::Index(3 * p) + channel, Eigen::Index(k)) - 5, 2));
        }
        const double s2 = 8 / (3 * terms[std::size_t(d)] * 49);
        // Neighbours share their noise: as many independent numbers as windows fit.
        const double slack = sigmas() * std::sqrt(2 * 49.0 / (kSide * kSide * 3 * terms[std::size_t(d)])) * v;
        EXPECT_GT(squares.value(), v / (1 + v) - slack) << d;
        EXPECT_LT(squares.value(), v / (1 + v) + s2 + slack) << d;
        EXPECT_NEAR(said.value(), squares.value(), s2 + slack) << d;
    }
}

// A step of 2 S = 40 standard deviations. Next to it three of eight near neighbours stand on the other side,
// with 0.37 of the weight: the guess is off by 0.75 S, the pooled square at least a third of S², and the
// patch moves by at most 0.75 S · 3 / S² = 0.11.
TEST(Filter, EdgeStays) {
    constexpr int kSide = 40;
    constexpr double kStep = 20;
    const Cells cells = sheet(kSide);
    const auto signal = [&](std::size_t p) { return cells.patches[p].cell.x < kSide / 2 ? -kStep : kStep; };
    const NoisyCoefficients after =
        filtered(noisy(cells.patches.size(), signal), Neighbourhoods(cells, true));
    Mean beside, all;
    for (std::size_t p = 0; p < cells.patches.size(); ++p)
        for (int channel = 0; channel < 3; ++channel)
            for (std::size_t k = 0; k < kCubic.size(); ++k) {
                const double value = after.values(Eigen::Index(3 * p) + channel, Eigen::Index(k));
                if (cells.patches[p].cell.x == kSide / 2) beside.add(value - kStep);
                all.add(std::pow(value - signal(p), 2));
            }
    EXPECT_NEAR(beside.value(), 0, 0.11 + sigmas() / std::sqrt(3.0 * kSide * double(kCubic.size())));
    EXPECT_LT(all.value(), 0.5);  // of 1 before
}

// Few photons, each patch's variance estimated from its own count c. Shares that follow the count would pull
// down most where it is high by chance. With pooled variances only the sheet's border, where windows are cut
// off, changes the sum: by less than the noise of the photons there.
TEST(Filter, KeepsTheFluxOfFewPhotons) {
    constexpr int kSide = 60;
    const Cells cells = sheet(kSide);
    const Neighbourhoods shared(cells, true);
    std::mt19937 engine(1);
    std::poisson_distribution<int> photons(3);
    std::vector<double> count;
    for (std::size_t p = 0; p < cells.patches.size(); ++p) count.push_back(photons(engine));
    const double before = std::accumulate(count.begin(), count.end(), 0.0);
    const auto change = [&](const std::vector<double>& variance) {
        NoisyCoefficients c{RowMatrix(Eigen::Index(3 * count.size()), 1), {0}, {}};
        for (std::size_t p = 0; p < count.size(); ++p)
            c.values.middleRows(3 * Eigen::Index(p), 3).setConstant(count[p]);
        for (const double v : variance) c.noise.emplace_back().fill(v);
        return filtered(c, shared).values.sum() / (3 * before) - 1;
    };
    const double at_border = 4 * 3 * kSide * 3.0;  // photons within the reach of it
    EXPECT_NEAR(change(pooled_noise(count, shared)), 0, sigmas() * std::sqrt(at_border) / before);
    EXPECT_LT(change(count), -0.05);
}

// A patch without neighbours is left alone.
TEST(Filter, LonePatchStays) {
    const Cells cells = sheet(1);
    const NoisyCoefficients before = noisy(1, [](std::size_t) { return 0.0; });
    const NoisyCoefficients after = filtered(before, Neighbourhoods(cells, true));
    EXPECT_EQ(after.values, before.values);
    EXPECT_EQ(after.noise, before.noise);
}

TEST(Filter, SameBytesAtAnyThreadCount) {
    const Cells cells = sheet(40);
    const NoisyCoefficients before = noisy(cells.patches.size(), [](std::size_t p) { return double(p % 7); });
    const auto with = [&](int threads) {
        const ThreadLimit limit(threads);
        NoisyCoefficients after = filtered(before, Neighbourhoods(cells, true));
        shrink(after, Neighbourhoods(cells, true));
        return after.values;
    };
    EXPECT_EQ(with(1), with(4));
}

}  // namespace
}  // namespace pim
