// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/map/map_box.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace pim {
namespace {

const Box3 kDomain(Vec3(-1, 2, 10), Vec3(3, 3, 16));

// Positions on a lattice over the domain, its borders included.
std::vector<Vec3d> lattice(int steps) {
    std::vector<Vec3d> all;
    const Vec3d low(kDomain.min), size(kDomain.max - kDomain.min);
    for (int i = 0; i <= steps; ++i)
        for (int j = 0; j <= steps; ++j)
            for (int k = 0; k <= steps; ++k) all.push_back(low + size * (Vec3d(i, j, k) / steps));
    return all;
}

TEST(BoxWeights, AddToOneEverywhere) {
    for (const Index3& divisions : {Index3(1), Index3(2, 1, 4), Index3(3)}) {
        const auto boxes = split_domain(kDomain, divisions);
        EXPECT_EQ(int(boxes.size()), divisions.x * divisions.y * divisions.z);
        for (const Vec3d& p : lattice(12)) {
            const auto weights = box_weights(boxes, p);
            EXPECT_NEAR(std::accumulate(weights.begin(), weights.end(), 0.0), 1, 1e-14);
            for (std::size_t b = 0; b < boxes.size(); ++b)
                EXPECT_TRUE(weights[b] == 0 || boxes[b].contains(p));
        }
    }
}

TEST(BoxWeights, AreOneAwayFromOverlaps) {
    const auto boxes = split_domain(kDomain, {2, 1, 1});
    EXPECT_EQ(box_weights(boxes, {-1, 2, 10})[0], 1);  // the outer corner
    EXPECT_EQ(box_weights(boxes, {3, 3, 16})[1], 1);
    EXPECT_NEAR(box_weights(boxes, {1, 2.5, 13})[0], 0.5, 1e-12);  // the middle belongs to both
}

// The overlap is kOverlap of a division, half to each side.
TEST(SplitDomain, NeighboursShareTheOverlap) {
    const auto boxes = split_domain(kDomain, {2, 1, 1});
    const double right = boxes[0].centre.x + boxes[0].half.x, left = boxes[1].centre.x - boxes[1].half.x;
    EXPECT_NEAR(right - left, kOverlap * 2, 1e-12);
    EXPECT_NEAR(0.5 * (right + left), 1, 1e-12);
    EXPECT_EQ(boxes[0].overlap_low.x, 0);
    EXPECT_NEAR(boxes[0].overlap_high.x, kOverlap * 2, 1e-12);
    EXPECT_EQ(boxes[0].overlap_high.y, 0);
    EXPECT_NEAR(boxes[0].centre.x - boxes[0].half.x, -1, 1e-12);
    EXPECT_NEAR(boxes[1].centre.x + boxes[1].half.x, 3, 1e-12);
}

// C¹: halving the step of a difference quotient halves its jump from step to step at most; a kink would keep
// it.
TEST(BoxWeights, AreSmooth) {
    const auto boxes = split_domain(kDomain, {3, 1, 1});
    const auto largest_jump_of_slope = [&](double step) {
        double worst = 0;
        for (double x = -1 + step; x < 3 - step; x += step)
            for (std::size_t b = 0; b < boxes.size(); ++b) {
                const auto w = [&](double at) { return box_weights(boxes, {at, 2.5, 13})[b]; };
                worst = std::max(worst, std::abs(w(x + step) - 2 * w(x) + w(x - step)) / step);
            }
        return worst;
    };
    const double coarse = largest_jump_of_slope(1e-3), fine = largest_jump_of_slope(5e-4);
    EXPECT_GT(coarse, 0);
    EXPECT_LT(fine, 0.6 * coarse);  // exactly 0.5 for a bounded second derivative, and sampling of the steps
}

TEST(MapBox, NormalisesToTheUnitCube) {
    const auto box = split_domain(kDomain, Index3(1))[0];
    EXPECT_EQ(box.normalised({-1, 2, 10}), Vec3d(-1));
    EXPECT_EQ(box.normalised({3, 3, 16}), Vec3d(1));
    EXPECT_EQ(box.normalised({1, 2.5, 13}), Vec3d(0));
    EXPECT_EQ(box.moves(), (std::array{true, true, true}));
}

TEST(MapBox, StillAxesDoNotCount) {
    const auto boxes = split_domain(Box3(Vec3(0, 5, 0), Vec3(2, 5, 0)), Index3(1));
    ASSERT_EQ(boxes.size(), 1u);
    EXPECT_EQ(boxes[0].moves(), (std::array{true, false, false}));
    EXPECT_EQ(boxes[0].normalised({2, 5, 0}), Vec3d(1, 0, 0));
    EXPECT_TRUE(boxes[0].contains({1, 5, 0}));
    EXPECT_EQ(box_weights(boxes, {1, 5, 0})[0], 1);
    const auto point = split_domain(Box3(Vec3(1, 2, 3)), Index3(1));
    EXPECT_EQ(box_weights(point, {1, 2, 3})[0], 1);
    EXPECT_EQ(point[0].normalised({1, 2, 3}), Vec3d(0));
}

TEST(MapBox, ContainsItsBordersUpToRounding) {
    const auto box = split_domain(kDomain, Index3(1))[0];
    EXPECT_TRUE(box.contains({3 + 1e-6, 3, 16}));
    EXPECT_FALSE(box.contains({3.001, 3, 16}));
    EXPECT_EQ(box.weight({3.001, 3, 16}), 0);
}

}  // namespace
}  // namespace pim
