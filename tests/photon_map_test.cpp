// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/photon_map.h"

#include <gtest/gtest.h>

#include "common/core/random.h"

namespace pim {
namespace {

TEST(PhotonMap, AgreesWithBruteForce) {
    RandomStream random(1, RandomPurpose::evaluation, 0, 0);
    std::vector<Vec3> positions;
    for (int i = 0; i < 2000; ++i) {
        const float x = random.next(), y = random.next(), z = random.next();
        positions.push_back({x, y, z});
    }
    const PhotonMap map(positions);
    for (int i = 0; i < 50; ++i) {
        const Vec3d centre(positions[std::size_t(i)] + Vec3(0.01f));
        const double radius = 0.05 + 0.005 * i;
        std::vector<std::size_t> expected;
        for (std::size_t k = 0; k < positions.size(); ++k)
            if ((Vec3d(positions[k]) - centre).length2() <= radius * radius) expected.push_back(k);
        EXPECT_EQ(map.within(centre, radius), expected);
    }
}

TEST(PhotonMap, Empty) { EXPECT_TRUE(PhotonMap({}).within(Vec3d(0), 1).empty()); }

}  // namespace
}  // namespace pim
