// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include "bake/statistics.h"

namespace pim {
namespace {

// Of the density exp(-x⁴/(2 d²)), x from 0 up: moments by the gamma function. Slack: midpoints of 400 steps.
TEST(LikelyError, WhereNothingWasMeasured) {
    const double doubt = 3e-4;
    const LikelyError likely = likely_error({0, doubt});
    EXPECT_NEAR(likely.mean, std::pow(2 * doubt * doubt, 0.25) * std::tgamma(0.5) / std::tgamma(0.25),
                1e-5 * likely.mean);
    EXPECT_NEAR(likely.square, std::sqrt(2) * doubt * std::tgamma(0.75) / std::tgamma(0.25),
                1e-5 * likely.square);
}

TEST(LikelyError, WithoutDoubtIsTheRoot) {
    EXPECT_EQ(likely_error({0.09, 0}).mean, std::sqrt(0.09));
    EXPECT_EQ(likely_error({-0.09, 0}).mean, 0);
    EXPECT_NEAR(likely_error({0.09, 1e-4}).mean, 0.3, 1e-5);
}

TEST(LikelyError, GrowsWithWhatWasMeasuredAndIsNeverBelowZero) {
    double before = 0;
    for (double square = -7.75; square < 50; square += 0.25) {
        const LikelyError likely = likely_error({square, 1});
        EXPECT_GT(likely.mean, before) << square;
        EXPECT_GE(likely.square, likely.mean * likely.mean) << square;
        before = likely.mean;
    }
}

TEST(Combined, WeighsByVariances) {
    const Doubtful one = combined({3, 2}, {8, 1});
    EXPECT_NEAR(one.value, (3.0 / 4 + 8) / (1.0 / 4 + 1), 1e-12);
    EXPECT_NEAR(one.doubt, 1 / std::sqrt(1.0 / 4 + 1), 1e-12);
    EXPECT_EQ(combined({3, 2}, {8, 0}).value, 8);
    EXPECT_EQ(combined({3, 2}, {8, 0}).doubt, 0);
}

}  // namespace
}  // namespace pim
