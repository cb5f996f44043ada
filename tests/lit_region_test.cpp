// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/lit_region.h"

#include <gtest/gtest.h>

#include "test_scenes.h"

namespace pim {
namespace {

bool anywhere(const Vec3&) { return true; }

std::optional<Box3> region_of(const Scene& scene) {
    return lit_region(scene, RayCaster(scene.geometry, InstructionSet::pinned), anywhere);
}

TEST(LitRegion, AClosedRoomIsAllOfIt) { EXPECT_FALSE(region_of(room(Rgb(0.5f)))); }

// Irradiance on a plane under a lamp falls as cos^3: to 1 % of what a photon meets on average (mean of
// cos^3 over photons, 1/4 of the largest) where cos^3 = 1/400, at 7.3 heights. Bounds end there up to the
// size of the bins and the noise of the photons, not at the plane's end.
TEST(LitRegion, AWidePlaneIsCutWhereItIsDim) {
    const auto region = region_of(plane_under_lamp(2000, 1));
    ASSERT_TRUE(region);
    for (const int axis : {0, 2}) {
        EXPECT_GT(region->max[axis], 5);
        EXPECT_LT(region->max[axis], 12);
        EXPECT_GT(region->min[axis], -12);
        EXPECT_LT(region->min[axis], -5);
    }
}

TEST(LitRegion, ARoomOnAWidePlane) {
    Scene scene = room(Rgb(0.5f));
    add_quad(scene, {-500, -0.01f, -500}, {0, 0, 1000}, {1000, 0, 0});
    const auto region = region_of(scene);
    ASSERT_TRUE(region);
    for (int axis = 0; axis < 3; ++axis) {
        EXPECT_LE(region->min[axis], 0);
        EXPECT_GE(region->max[axis], 1);
        EXPECT_LT(region->size()[axis], 1.2f);
    }
}

}  // namespace
}  // namespace pim
