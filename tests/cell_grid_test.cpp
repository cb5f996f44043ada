// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/map/cell_grid.h"

#include <set>

#include "common/core/error.h"
#include "common/core/sampling.h"
#include "statistics.h"
#include "test_scenes.h"

namespace pim {
namespace {

Scene board(const Vec3& size) {  // a scene with that bounding box
    Scene scene = empty_scene();
    add_box(scene, Vec3(0), size, true);
    return scene;
}

TEST(MakeGrid, CellsAlongTheLongestSide) {
    Scene scene = board({4, 2, 1});
    scene.grid.resolution = CellCount{8};
    const CellGrid grid = make_grid(scene);
    EXPECT_EQ(grid.size, Index3(8, 4, 2));
    EXPECT_DOUBLE_EQ(grid.cell_size, 0.5);
    EXPECT_EQ(grid.cell_count(), 64u);
    EXPECT_EQ(grid.centre({0, 0, 0}), Vec3d(0.25));
}

TEST(MakeGrid, CellSizeAndRemainders) {
    Scene scene = board({4, 2.1f, 1});
    scene.grid.resolution = CellSize{0.5};
    EXPECT_EQ(make_grid(scene).size, Index3(8, 5, 2));
    scene.grid.bounds = Box3(Vec3(1, 0, 0), Vec3(2, 1, 0.4f));
    EXPECT_EQ(make_grid(scene).size, Index3(2, 2, 1));
    EXPECT_EQ(make_grid(scene).origin, Vec3d(1, 0, 0));
}

TEST(MakeGrid, RefusesWhatCannotBe) {
    Scene scene = board({4, 2, 1});
    scene.grid.bounds = Box3(Vec3(10), Vec3(11));
    EXPECT_THROW(make_grid(scene), Error);  // no surface there
    scene.grid.bounds.reset();
    scene.grid.resolution = CellSize{1e-4};
    EXPECT_THROW(make_grid(scene), Error);  // too many cells
}

TEST(MakeGrid, FlatScenesHaveOneLayer) {
    Scene scene = plane_under_lamp(2, 1);
    scene.grid.resolution = CellCount{4};
    EXPECT_EQ(make_grid(scene).size, Index3(4, 1, 4));
}

// --- facings ---

TEST(FacingWeights, AddToOneAndLieOnTheNormalsSide) {
    const CellGrid grid;
    RandomStream random(1, RandomPurpose::evaluation, 0, 0);
    for (int i = 0; i < 10000; ++i) {
        const float u = random.next();
        const Vec3 n = sample_sphere(u, random.next());
        const FacingWeights facing = facing_weights(grid, n);
        float sum = 0;
        for (int f = 0; f < kFacingCount; ++f) {
            sum += facing.weight[f];
            EXPECT_GE(facing.weight[f], 0);
            EXPECT_TRUE(n[f / 2] * (f % 2 ? -1 : 1) >= 0 || facing.weight[f] == 0);
        }
        EXPECT_NEAR(sum, 1, 4 * 0x1p-23f);  // three divisions and two additions
    }
}

TEST(FacingWeights, AxesStandAlone) {
    const CellGrid grid;
    for (int axis = 0; axis < 3; ++axis)
        for (const float degrees : {0.0f, 7.0f}) {
            Vec3 n(0);
            n[axis] = -std::cos(degrees * kPi / 180);
            n[(axis + 1) % 3] = std::sin(degrees * kPi / 180);
            EXPECT_EQ(facing_weights(grid, n).weight[2 * axis + 1], 1);
        }
    CellGrid thesis;
    thesis.facings = false;
    EXPECT_EQ(facing_weights(thesis, {0, -1, 0}).weight[0], 1);
    EXPECT_EQ(slot_name(thesis, 0), "all");
    EXPECT_EQ(slot_name(grid, 3), "ny");
    EXPECT_EQ(slot_name(grid, 3 + kFacingCount), "ny_behind");
}

// The weights' slope is at most that of n² over the sum, 2 / (1 - 3 · 0.02): steps of 1e-3 radian move them
// by less than 2.2e-3, across axes and octants too.
TEST(FacingWeights, AreContinuous) {
    const CellGrid grid;
    for (const Vec3& tilt : {Vec3(0, 0, 1), Vec3(0.3f, 0.8f, 0.1f), Vec3(1, 1, 1)}) {
        const Frame frame(tilt.normalized());
        FacingWeights before = facing_weights(grid, frame.tangent);
        for (int i = 1; i <= 6284; ++i) {
            const float a = float(i) * 1e-3f;
            const FacingWeights now =
                facing_weights(grid, frame.tangent * std::cos(a) + frame.bitangent * std::sin(a));
            for (int f = 0; f < kFacingCount; ++f) ASSERT_NEAR(now.weight[f], before.weight[f], 2.2e-3f) << a;
            before = now;
        }
    }
}

// --- which cell a place belongs to ---

// A horizontal square at height y over [0,1]², in a grid of cells of 0.25 from 0 up.
struct Floor {
    Scene scene = empty_scene();
    SurfaceCells cells;

    explicit Floor(float y, const Vec3d& origin = Vec3d(0))
        : cells(grid_at(origin), with_floor(scene, y).geometry) {}
    static CellGrid grid_at(const Vec3d& origin) { return {origin, 0.25, Index3(4), true}; }
    static Scene& with_floor(Scene& scene, float y) {
        add_quad(scene, {0, y, 0}, {0, 0, 1}, {1, 0, 0});
        return scene;
    }
};

TEST(SurfaceCells, AFloorOnABorderBelongsToTheCellsThatItsSidesLookInto) {
    const Floor floor(0.5f);
    for (const float wobble : {0.0f, 1e-7f, -1e-7f, 3e-6f, -3e-6f}) {  // roundings of hit points
        const Vec3 place(0.3f, 0.5f + wobble, 0.6f);
        const auto up = floor.cells.fine_cell(0, Side::front, place),
                   down = floor.cells.fine_cell(0, Side::back, place);
        ASSERT_TRUE(up && down);
        EXPECT_EQ(cell_of_fine(*up).y, 2);
        EXPECT_EQ(cell_of_fine(*down).y, 1);
        EXPECT_EQ(cell_of_fine(*up).x, 1);
        EXPECT_EQ(cell_of_fine(*up).z, 2);
    }
}

TEST(SurfaceCells, SurfacesOnTheGridsOwnBorderStayInside) {
    for (const float y : {0.0f, 1.0f}) {
        const Floor floor(y);
        for (const Side side : {Side::front, Side::back}) {
            const auto fine = floor.cells.fine_cell(0, side, {0.3f, y, 0.6f});
            ASSERT_TRUE(fine);
            EXPECT_EQ(cell_of_fine(*fine).y, y == 0 ? 0 : 3);
        }
    }
}

TEST(SurfaceCells, SurfacesBeyondTheGridAreOutside) {
    const Floor floor(1.5f);
    EXPECT_FALSE(floor.cells.fine_cell(0, Side::front, {0.3f, 1.5f, 0.6f}));
    const Floor inside(0.4f);
    EXPECT_FALSE(inside.cells.fine_cell(0, Side::front, {1.3f, 0.4f, 0.6f}));
}

TEST(SurfaceCells, SurfacesAwayFromBordersAreWhereTheyAre) {
    const Floor floor(0.4f);
    for (const Side side : {Side::front, Side::back}) {
        const auto fine = floor.cells.fine_cell(0, side, {0.99f, 0.4f, 0.01f});
        ASSERT_TRUE(fine);
        EXPECT_EQ(*fine, Index3(15, 6, 0));  // fine cells of 1/16
        EXPECT_EQ(floor.cells.tied(0, side, 1), 6);
        EXPECT_FALSE(floor.cells.tied(0, side, 0));
    }
}

// --- patches by cell and facing ---

TEST(PatchIndex, AgreesWithBruteForce) {
    CellGrid grid;
    grid.size = {19, 7, 33};
    std::map<std::tuple<int, int, int, int>, int> expected;
    RandomStream random(1, RandomPurpose::evaluation, 0, 0);
    std::vector<Patch> patches;
    std::set<std::tuple<int, int, int, int>> chosen;
    for (int i = 0; i < 800; ++i) {
        const int x = int(random.next() * 19), y = int(random.next() * 7), z = int(random.next() * 33);
        chosen.insert({x, y, z, int(random.next() * kSlotCount)});
    }
    for (const auto& [x, y, z, f] : chosen) {
        expected[{x, y, z, f}] = int(patches.size());
        patches.push_back({{x, y, z}, f, 1, Vec3(0)});
    }
    EXPECT_TRUE(std::ranges::is_sorted(patches, patch_before));
    const PatchIndex index(grid, patches);
    std::set<std::tuple<int, int, int>> cells;
    for (int x = -1; x <= 19; ++x)
        for (int y = -1; y <= 7; ++y)
            for (int z = -1; z <= 33; ++z)
                for (int f = 0; f < kSlotCount; ++f) {
                    const auto found = expected.find({x, y, z, f});
                    EXPECT_EQ(index.find({x, y, z}, f), found == expected.end() ? -1 : found->second);
                    if (found != expected.end()) cells.insert({x, y, z});
                }
    EXPECT_EQ(index.cell_count(), cells.size());
}

TEST(PatchIndex, EmptyFindsNothing) { EXPECT_EQ(PatchIndex().find({0, 0, 0}, 0), -1); }

}  // namespace
}  // namespace pim
