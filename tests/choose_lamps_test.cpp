// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/choose_lamps.h"

#include <gtest/gtest.h>

namespace pim {
namespace {

Light free_lamp(const Vec3& extent, const Index3& boxes) {
    Light light;
    light.domain = Box3(Vec3(0), extent);
    light.boxes = boxes;
    light.choose_samples = true;
    return light;
}

TEST(PlannedPositions, EveryGivenBoxGetsMoreThanItsTerms) {
    EXPECT_GE(planned_positions(free_lamp(Vec3(1, 1, 1), {1, 1, 1})), 4 * 3 * 20);
    EXPECT_GE(planned_positions(free_lamp(Vec3(1, 1, 1), {5, 5, 5})), 4 * 20 * 125);
    EXPECT_GE(planned_positions(free_lamp(Vec3(1, 0, 0), {5, 1, 1})), 4 * 4 * 5);
    EXPECT_GE(planned_positions(free_lamp(Vec3(0), {1, 1, 1})), 4 * 5);
}

TEST(PlannedPositions, AGridCountsOnTheAxesThatMove) {
    Light lamp = free_lamp(Vec3(1, 0, 0), {1, 1, 1});
    lamp.choose_samples = false;
    lamp.samples = Index3(9, 9, 9);
    EXPECT_EQ(planned_positions(lamp), 9);
    lamp.samples = std::vector<SampleGroup>{{{1, 1, 1}, 64}, {{2, 1, 1}, 30}};
    EXPECT_EQ(planned_positions(lamp), 94);
}

TEST(TermsOfCubic, AreThoseOfTheLampThatMovesMost) {
    Scene scene;
    scene.lights = {free_lamp(Vec3(0), {1, 1, 1}), free_lamp(Vec3(1, 0, 2), {2, 1, 2})};
    EXPECT_EQ(terms_of_cubic(scene), 10);
}

}  // namespace
}  // namespace pim
