// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/core/sampling.h"

#include "statistics.h"

namespace pim {
namespace {

// Unit vectors in all octants, the poles, and next to the poles, where such frames used to break.
std::vector<Vec3> normals() {
    std::vector<Vec3> all = {{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {0, -1, 0}, {1, 0, -0.0f}};
    for (const float tilt : {1e-7f, 1e-4f, 1e-2f})
        for (const float z : {1.0f, -1.0f}) all.push_back(Vec3(tilt, -tilt, z).normalized());
    RandomStream random(1, RandomPurpose::evaluation, 0, 0);
    for (int i = 0; i < 1000; ++i) {
        const float u = random.next();
        all.push_back(sample_sphere(u, random.next()));
    }
    return all;
}

// Duff et al. give an error of a few roundings (2^-24) for their frames; ten of them are allowed.
TEST(Frame, IsOrthonormalAndRightHanded) {
    constexpr float kRounding = 10 * 0x1p-23f;
    for (const Vec3& n : normals()) {
        const Frame f(n);
        EXPECT_NEAR(f.tangent.length(), 1, kRounding);
        EXPECT_NEAR(f.bitangent.length(), 1, kRounding);
        EXPECT_NEAR(f.tangent.dot(f.bitangent), 0, kRounding);
        EXPECT_NEAR(f.tangent.dot(n), 0, kRounding);
        EXPECT_NEAR(f.bitangent.dot(n), 0, kRounding);
        EXPECT_NEAR((f.tangent.cross(f.bitangent) - n).length(), 0, kRounding);
    }
}

// Bins of equal probability: in z or in its distribution function, and in the angle about z.
template <class Sample, class Height>
double chi_squared_of(Sample sample, Height height) {
    constexpr int kRows = 16, kColumns = 16;
    std::vector<long> bins(kRows * kColumns);
    RandomStream random(3, RandomPurpose::evaluation, 0, 0);
    for (int i = 0; i < 1 << 18; ++i) {
        const float u1 = random.next();
        const Vec3 d = sample(u1, random.next());
        EXPECT_NEAR(d.length(), 1, 1e-6f);  // a few roundings
        const double turn = (std::atan2(d.y, d.x) + M_PI) / (2 * M_PI);
        const int row = std::min(kRows - 1, int(height(d.z) * kRows));
        ++bins[std::size_t(row * kColumns + std::min(kColumns - 1, int(turn * kColumns)))];
    }
    return chi_squared(bins);
}

TEST(SampleSphere, IsUniform) {
    EXPECT_LT(chi_squared_of(sample_sphere, [](double z) { return 0.5 * (1 + z); }), chi_squared_bound(255));
}

TEST(SampleCosineHemisphere, HasItsDensity) {  // P(cosine < z) = z²
    EXPECT_LT(chi_squared_of(sample_cosine_hemisphere, [](double z) { return z * z; }),
              chi_squared_bound(255));
}

TEST(SampleCosineHemisphere, Moments) {  // E z = 2/3, E z² = 1/2, E x = 0, E x² = 1/4
    Mean z, z2, x, x2;
    RandomStream random(4, RandomPurpose::evaluation, 0, 0);
    for (int i = 0; i < 1 << 18; ++i) {
        const float u1 = random.next();
        const Vec3 d = sample_cosine_hemisphere(u1, random.next());
        z.add(d.z), z2.add(d.z * d.z), x.add(d.x), x2.add(d.x * d.x);
    }
    expect_mean(z, 2.0 / 3, 0, 4);
    expect_mean(z2, 0.5, 0, 4);
    expect_mean(x, 0, 0, 4);
    expect_mean(x2, 0.25, 0, 4);
}

// Star discrepancy of points in one dimension, exactly (Niederreiter 1992, theorem 2.6).
double star_discrepancy(std::vector<double> points) {
    std::ranges::sort(points);
    double worst = 0;
    const auto n = double(points.size());
    for (std::size_t i = 0; i < points.size(); ++i)
        worst = std::max(worst, 0.5 / n + std::abs(points[i] - (double(i) + 0.5) / n));
    return worst;
}

// A random set's discrepancy lies below 0.4/sqrt(n) with a probability of 0.003 only (Kolmogorov's
// distribution); that of a well-spread one falls like log(n)/n.
TEST(GoldenSequence, BeatsRandomPointsOnEachAxis) {
    constexpr int kPoints = 1000;
    for (int dimensions = 1; dimensions <= 3; ++dimensions)
        for (int axis = 0; axis < dimensions; ++axis) {
            std::vector<double> points;
            for (int k = 0; k < kPoints; ++k) {
                points.push_back(golden_sequence(uint64_t(k), axis, dimensions));
                ASSERT_GE(points.back(), 0);
                ASSERT_LT(points.back(), 1);
            }
            EXPECT_LT(star_discrepancy(points), 0.4 / std::sqrt(kPoints)) << dimensions << " " << axis;
        }
}

// Counts in 8³ boxes: random points make their chi squared 511 ± 32, well-spread ones less than half of it.
TEST(GoldenSequence, FillsTheCubeMoreEvenlyThanRandomPoints) {
    std::vector<long> bins(512);
    for (uint64_t k = 0; k < 5120; ++k) {
        std::size_t bin = 0;
        for (int axis = 0; axis < 3; ++axis) bin = bin * 8 + std::size_t(golden_sequence(k, axis, 3) * 8);
        ++bins[bin];
    }
    EXPECT_LT(chi_squared(bins), 0.5 * 511);
}

}  // namespace
}  // namespace pim
