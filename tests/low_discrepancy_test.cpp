// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/core/low_discrepancy.h"

#include "common/core/random.h"
#include "statistics.h"

namespace pim {
namespace {

SobolPoint scramble(uint64_t number) {
    return RandomStream(7, RandomPurpose::evaluation, 0, number).next_block();
}

// The first 2^m points, or any 2^m that follow a multiple of 2^m, have one in each interval of length 2^-m.
TEST(Sobol, EachAxisIsStratifiedWhateverTheScramble) {
    for (const int m : {1, 4, 10})
        for (const uint32_t begin : {0u, 3u << m})
            for (std::size_t d = 0; d < kSobolDimensions; ++d) {
                std::vector<int> plain(1 << m), scrambled(1 << m);
                for (uint32_t k = begin; k < begin + (1u << m); ++k) {
                    ++plain[sobol_point(k)[d] >> (32 - m)];
                    ++scrambled[scrambled_sobol_point(k, scramble(d))[d] >> (32 - m)];
                }
                EXPECT_EQ(plain, std::vector<int>(1 << m, 1)) << m << " " << d;
                EXPECT_EQ(scrambled, std::vector<int>(1 << m, 1)) << m << " " << d;
            }
}

// The first two axes are a (0,2) sequence: each box of area 2^-m, however long, has one of 2^m points.
TEST(Sobol, TheFirstTwoAxesFillEveryElementaryBox) {
    constexpr int kM = 8;
    for (int wide = 0; wide <= kM; ++wide) {
        std::vector<int> boxes(1 << kM);
        for (uint32_t k = 0; k < 1u << kM; ++k) {
            const SobolPoint p = scrambled_sobol_point(k, scramble(1));
            const uint64_t x = uint64_t(p[0]) >> (32 - wide), y = uint64_t(p[1]) >> (32 - (kM - wide));
            ++boxes[x << (kM - wide) | y];
        }
        EXPECT_EQ(boxes, std::vector<int>(1 << kM, 1)) << wide;
    }
}

// Any other two axes, at least not worse than random points, whose chi squared is 255 ± 23.
TEST(Sobol, NoTwoAxesMoveInStep) {
    for (std::size_t a = 0; a < kSobolDimensions; ++a)
        for (std::size_t b = 0; b < a; ++b) {
            std::vector<long> boxes(256);
            for (uint32_t k = 0; k < 4096; ++k) {
                const SobolPoint p = scrambled_sobol_point(k, scramble(2));
                ++boxes[(p[a] >> 28) << 4 | p[b] >> 28];
            }
            EXPECT_LT(chi_squared(boxes), chi_squared_bound(255)) << a << " " << b;
        }
}

TEST(Sobol, EachScrambledPointByItselfIsUniform) {
    for (const uint32_t k : {0u, 1u, 37u}) {
        std::vector<long> bins(64);
        for (uint64_t s = 0; s < 1 << 15; ++s) ++bins[scrambled_sobol_point(k, scramble(s))[3] >> 26];
        EXPECT_LT(chi_squared(bins), chi_squared_bound(63)) << k;
    }
}

// The mean of a smooth function over n points: random ones have variance 1/12 n.
TEST(Sobol, MeansAreFarBetterThanRandomOnes) {
    constexpr int kPoints = 64, kTrials = 2000;
    Mean mean;
    for (uint64_t trial = 0; trial < kTrials; ++trial) {
        double sum = 0;
        for (uint32_t k = 0; k < kPoints; ++k) {
            const SobolPoint p = scrambled_sobol_point(k, scramble(trial));
            sum += (p[0] * 0x1p-32 - 0.5) * (p[1] * 0x1p-32 - 0.5) + p[2] * 0x1p-32;
        }
        mean.add(sum / kPoints);
    }
    expect_mean(mean, 0.5, 0, 1);
    EXPECT_LT(mean.standard_error() * mean.standard_error() * kTrials, 0.02 / (12 * kPoints));
}

}  // namespace
}  // namespace pim
