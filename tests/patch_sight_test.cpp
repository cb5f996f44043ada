// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/map/patch_sight.h"

#include <gtest/gtest.h>

#include "bake/cells.h"
#include "common/map/irradiance.h"
#include "test_scenes.h"

namespace pim {
namespace {

constexpr int kUp = 2;  // the facing +y

int part_at(int x, int y, int z) { return x + 4 * y + 16 * z; }

TEST(HomeOf, IsThePlacesCellAndFineCell) {
    // From the lowest centre (0.5, 0.5, 0.5): the place (0.9, 1.1, 1.3) lies in cell (0, 1, 1).
    const Home home = home_of({0.4f, 0.6f, 0.8f}, {0, 1, 0});
    EXPECT_EQ(home.step(), Index3(0, 1, 1));
    EXPECT_EQ(home.part, part_at(3, 0, 1));
}

TEST(HomeOf, BordersBelongToWhatTheSurfaceFaces) {
    EXPECT_EQ(home_of({0, 0.5f, 0}, {0, 1, 0}).step().y, 1);
    EXPECT_EQ(home_of({0, 0.5f, 0}, {0, -1, 0}).step().y, 0);
    EXPECT_EQ(home_of({0, 0.4999999f, 0}, {0, 1, 0}).part, home_of({0, 0.5000001f, 0}, {0, 1, 0}).part);
}

TEST(PatchSight, HoldsWhatItWasGiven) {
    const std::vector<PatchSight::Entry> given{{2, 7, 0x8001}, {0, 63, 0}, {0, 5, 0x00ff}};
    const PatchSight sight(3, given);
    EXPECT_EQ(sight.unseen(0, 5, kUp), 0x00ff);
    EXPECT_EQ(sight.unseen(0, 63, kUp), 0);
    EXPECT_EQ(sight.unseen(2, 7, kUp), 0x8001);
    EXPECT_TRUE(sight.sees_all(1));
    EXPECT_FALSE(sight.sees_all());
    EXPECT_EQ(sight.entries().size(), given.size());
    EXPECT_TRUE(PatchSight(3, {}).sees_all());
}

TEST(PatchSight, BesideASurfaceItIsThatOfTheSurface) {
    const Unseen low_x = 0b01010101;  // the four lower cells on x
    const PatchSight sight(1, {{0, part_at(0, 1, 0), low_x}});
    EXPECT_EQ(sight.unseen(0, part_at(0, 0, 0), kUp), low_x);
    EXPECT_EQ(sight.unseen(0, part_at(0, 2, 0), kUp), low_x);  // other cells above, the same on x
    EXPECT_EQ(sight.unseen(0, part_at(0, 3, 0), kUp), 0);
    // Across the middle on y the cell's own layer, the upper one before, is the lower one.
    const PatchSight upper(1, {{0, part_at(0, 1, 0), Unseen(1 << 2)}});
    EXPECT_EQ(upper.unseen(0, part_at(0, 2, 0), kUp), 1 << 0 | 1 << 2);
}

// A floor of 4 × 4 unit cells, light on x < 2, none beyond; a wall there if the parts' sight says so.
struct Floor {
    IlluminationMap map;
    std::vector<Rgb> values;

    explicit Floor(bool wall) {
        map.grid.size = Index3(4, 1, 4);
        std::vector<PatchSight::Entry> entries;
        for (int x = 0; x < 4; ++x)
            for (int z = 0; z < 4; ++z) {
                const auto p = uint32_t(map.patches.size());
                map.patches.push_back({{x, 0, z}, kUp, 1, Vec3(0, -0.5f, 0)});
                values.emplace_back(x < 2 ? 1.0f : 0.0f);
                if (!wall || x == 0) continue;
                for (int part = 0; part < kPartCount; ++part) {
                    const bool towards = x < 2 ? (part & 3) >= 2 && x == 1 : (part & 3) < 2 && x == 2;
                    // Of the eight cells the far four: the upper ones on x from the left, the lower ones
                    // from the right.
                    entries.push_back({p, part, Unseen(!towards ? 0 : x < 2 ? 0xaaaa : 0x5555)});
                }
            }
        map.index = PatchIndex(map.grid, map.patches);
        map.sight = PatchSight(map.patches.size(), std::move(entries));
    }
    float at(float x, float z) const { return irradiance_at(map, values, {x, 0, z}, {0, 1, 0}).x; }
};

TEST(LookUp, KeepsToWhatThePlaceSees) {
    const Floor open(false), parted(true);
    EXPECT_NEAR(open.at(2.05f, 1.3f), 0.45f, 1e-5f);
    EXPECT_NEAR(parted.at(2.05f, 1.3f), 0, 0.45f / 0.55f * kUnseenFactor);
    EXPECT_NEAR(parted.at(1.95f, 1.3f), 1, 0.45f / 0.55f * kUnseenFactor);
}

TEST(LookUp, IsTheSameToTheBitWhereAllIsSeen) {
    const Floor open(false), parted(true);
    for (int i = 0; i < 400; ++i)
        for (const float x : {0.01f * float(i % 150), 4 - 0.01f * float(i % 150)})
            EXPECT_EQ(open.at(x, 0.01f * float(i)), parted.at(x, 0.01f * float(i))) << x;
}

// A room of 1 × 1 × 1, cells of 1/8, the lamp anywhere in it.
Scene lit_room() {
    Scene scene = room(Rgb(0.5f));
    scene.lights[0].domain = Box3(Vec3(0.1f, 0.3f, 0.1f), Vec3(0.9f, 0.9f, 0.9f));
    scene.grid.resolution = CellCount{8};
    return scene;
}

Cells cells_of(Scene scene) {
    scene.grid.reach_photons = 1 << 19;
    return find_cells(scene, RayCaster(scene.geometry, InstructionSet::pinned),
                      [](const Vec3&) { return true; });
}

TEST(FindSight, AnEmptyRoomSeesAll) { EXPECT_TRUE(cells_of(lit_room()).sight.sees_all()); }

TEST(FindSight, TheThesisSeesAll) {
    Scene scene = lit_room();
    add_quad(scene, {0.5f, 0, 0}, {0, 0, 1}, {0, 1, 0});
    scene.grid.facings = false;
    scene.grid.reachable_area_only = false;
    EXPECT_TRUE(cells_of(scene).sight.sees_all());
}

// A wall on the border between cells 3 and 4, lit from both sides: nothing of the floor is seen across it,
// all else is.
TEST(FindSight, FloorsOnBothSidesOfAWallDoNotSeeEachOther) {
    Scene scene = lit_room();
    add_quad(scene, {0.5f, 0, 0}, {0, 0, 1}, {0, 1, 0});
    const Cells cells = cells_of(scene);
    int parts = 0;
    for (int x = 0; x < 8; ++x) {
        const int patch = cells.index.find({x, 0, 4}, kUp);
        ASSERT_GE(patch, 0);
        for (int fx = 0; fx < 4; ++fx)
            for (int fz = 0; fz < 4; ++fz) {
                const bool from_left = x == 3 && fx >= 2, from_right = x == 4 && fx < 2;
                Unseen expected = from_left ? 0b10101010 : from_right ? 0b01010101 : 0;
                // The floor lies in the lowest cells: the lower four of the eight are not there.
                expected &= 0b11001100;
                EXPECT_EQ(cells.sight.unseen(std::size_t(patch), part_at(fx, 0, fz), kUp), expected)
                    << x << " " << fx << " " << fz;
                parts += expected != 0;
            }
    }
    EXPECT_EQ(parts, 16);
}

}  // namespace
}  // namespace pim
