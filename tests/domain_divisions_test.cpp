// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/domain_divisions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <tuple>

#include "bake/trial_fits.h"

namespace pim {
namespace {

Light moving(const Vec3& extent, const Index3& boxes) {
    Light light;
    light.domain = Box3(Vec3(0), extent);
    light.boxes = boxes;
    light.choose_boxes = true;
    return light;
}

std::vector<Index3> sorted(std::vector<Index3> all) {
    std::sort(all.begin(), all.end(), [](const Index3& a, const Index3& b) {
        return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
    });
    return all;
}

TEST(OtherDivisions, OneMoreOneFewerAndTwiceAsMany) {
    EXPECT_TRUE(sorted(other_divisions(moving(Vec3(1, 0, 0), {3, 1, 1}))) ==
                (std::vector<Index3>{{2, 1, 1}, {4, 1, 1}, {6, 1, 1}}));
    EXPECT_TRUE(sorted(other_divisions(moving(Vec3(1, 0, 1), {1, 1, 2}))) ==
                (std::vector<Index3>{{1, 1, 1}, {1, 1, 3}, {1, 1, 4}, {2, 1, 2}}));
}

TEST(OtherDivisions, NoneForALampThatStandsOrWhoseBoxesAreGiven) {
    EXPECT_TRUE(other_divisions(moving(Vec3(0), Index3(1))).empty());
    Light given = moving(Vec3(1), Index3(1));
    given.choose_boxes = false;
    EXPECT_TRUE(other_divisions(given).empty());
}

// Half of the squared noise of two lamps is gone.
TEST(TrialFigures, WithLessNoise) {
    const TrialFigures now{.square = 9e-4, .noise = {2e-4, 4e-4}, .error = {0.03, 0.001}, .below_zero = 0};
    const TrialFigures then = now.with_noise(0.5);
    EXPECT_DOUBLE_EQ(then.square, 6e-4);
    EXPECT_DOUBLE_EQ(then.noise_sum(), 3e-4);
    EXPECT_NEAR(then.error.relrmse, 0.03 * std::sqrt(2.0 / 3), 1e-12);
    EXPECT_DOUBLE_EQ(then.floor(), now.floor());
}

}  // namespace
}  // namespace pim
