// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/cells.h"

#include "common/map/irradiance.h"
#include "statistics.h"
#include "test_scenes.h"

namespace pim {
namespace {

bool anywhere(const Vec3&) { return true; }

Cells cells_of(const Scene& scene) {
    return find_cells(scene, RayCaster(scene.geometry, InstructionSet::pinned), anywhere);
}

// A unit room, cells of 1/8, the lamp free in its middle.
Scene room_with_cells() {
    Scene scene = room(Rgb(0.5f));
    scene.lights[0].domain = Box3(Vec3(0.2f, 0.4f, 0.2f), Vec3(0.6f, 0.8f, 0.6f));
    scene.grid.resolution = CellCount{8};
    return scene;
}

uint32_t add_object(Scene& scene) {  // what is added from here on belongs to it
    scene.geometry.objects.push_back("object " + std::to_string(scene.geometry.objects.size()));
    return uint32_t(scene.geometry.triangles.size());
}

const Patch& patch_of(const Cells& cells, const Index3& cell, int slot) {
    return cells.patches[std::size_t(cells.index.find(cell, slot))];
}

TEST(Cells, WhatIsAllVisibleStays) {
    const Scene scene = room_with_cells();
    const Cells cells = cells_of(scene);
    EXPECT_TRUE(cells.left_out.keys().empty());
    const double both_sides = 2 * total_area(scene.geometry);
    EXPECT_NEAR(cells.surface_area, both_sides, 1e-6 * both_sides);  // float roundings
    EXPECT_NEAR(cells.counted_area, both_sides / 2,
                1e-6 * both_sides);  // nothing lights the walls from outside
}

TEST(Cells, AllSurfaceCountsForTheThesis) {
    Scene scene = room_with_cells();
    scene.grid.reachable_area_only = false;
    scene.grid.facings = false;
    add_object(scene);
    add_box(scene, {0.3f, 0, 0.3f}, {0.4f, 0.1f, 0.4f}, false);
    const Cells cells = cells_of(scene);
    EXPECT_TRUE(cells.left_out.keys().empty());
    EXPECT_NEAR(cells.counted_area, 2 * total_area(scene.geometry), 1e-5);
    for (const Patch& p : cells.patches) EXPECT_EQ(p.slot, 0);
}

// Area of the fragments of triangles from `first` on that look along `facing` and lie inside a box: all, and
// left out.
std::pair<double, double> areas_in(const Scene& scene, const Cells& cells, uint32_t first, uint32_t last,
                                   Side side, const Box3& box) {
    std::pair<double, double> areas{0, 0};
    for (const Fragment& f : cut_into_fragments(scene, SurfaceCells(cells.grid, scene.geometry))) {
        if (f.key.triangle < first || f.key.triangle >= last || (f.key.place & 1) != int(side)) continue;
        if (!box.intersects(f.centre)) continue;
        areas.first += f.area;
        if (cells.left_out.contains(f.key)) areas.second += f.area;
    }
    return areas;
}

// A board 1 cm before the wall x = 1. In a gap, light from its edges falls off at least as fast as what one
// reflection each time leaves of it: 6 cm, six times the gap, inside it is far below kDarkShare.
TEST(Cells, WallBehindABoardIsLeftOut) {
    Scene scene = room_with_cells();
    const uint32_t board = add_object(scene);
    add_box(scene, {0.985f, 0.25f, 0.25f}, {0.99f, 0.75f, 0.75f}, false);
    const Cells cells = cells_of(scene);
    const auto [covered, left_out] = areas_in(scene, cells, 0, board, Side::front,
                                              Box3(Vec3(0.999f, 0.31f, 0.31f), Vec3(1.001f, 0.69f, 0.69f)));
    EXPECT_GT(covered, 0.1);
    EXPECT_GT(left_out, 0.98 * covered);  // what no test decides stays: 2 %
    const Box3 low_wall(Vec3(0.999f, 0, 0), Vec3(1.001f, 0.2f, 1)), all(Vec3(0), Vec3(1));
    EXPECT_EQ(areas_in(scene, cells, 0, board, Side::front, low_wall).second, 0);
    const auto front = areas_in(scene, cells, board, uint32_t(scene.geometry.triangles.size()), Side::front,
                                Box3(Vec3(0.984f, 0, 0), Vec3(0.9855f, 1, 1)));
    EXPECT_NEAR(front.first, 0.25, 0.02);
    EXPECT_EQ(front.second, 0);
}

// A closed box within one cell, its sides on borders of fine cells: its inside goes, its outside stays.
TEST(Cells, InsideOfABoxIsLeftOut) {
    Scene scene = room_with_cells();
    add_object(scene);
    constexpr float kLow = 0.53125f, kHigh = 0.59375f, kSide = kHigh - kLow;
    add_box(scene, {kLow, 0, kLow}, {kHigh, kSide, kHigh}, false);
    const Cells cells = cells_of(scene);
    const Index3 cell(4, 0, 4);
    constexpr double kRounding = 1e-7;
    for (const int sideways : {0, 1, 4, 5})
        EXPECT_NEAR(patch_of(cells, cell, sideways).area, kSide * kSide, kRounding);
    // Upwards: the box's top and the floor around it, without the footprint.
    double upwards = patch_of(cells, cell, 2).area;
    if (cells.index.find(cell, 2 + kFacingCount) >= 0)
        upwards += patch_of(cells, cell, 2 + kFacingCount).area;
    EXPECT_NEAR(upwards, 0.125 * 0.125, kRounding);
}

// A thin board in cells so small that each is hit by some 80 photons: too few to tell cell by cell whether
// the board's inside, which shares patches with its outside, is lit. Over the whole board it is plain.
TEST(Cells, InsideOfAThinBoardIsLeftOutInSmallCells) {
    Scene scene = room_with_cells();
    scene.grid.resolution = CellCount{64};
    scene.grid.reach_photons = 1 << 20;
    add_object(scene);
    add_box(scene, {0.3f, 0.2f, 0.8f}, {0.7f, 0.6f, 0.801f}, false);
    const Cells cells = cells_of(scene);
    double board = 0;
    for (const Patch& p : cells.patches)
        if (p.slot % kFacingCount >= 4 && std::abs(cells.grid.centre(p.cell).z - 0.8) < 0.03) board += p.area;
    EXPECT_NEAR(board, 2 * 0.4 * 0.4, 1e-3);
}

// A screen stands on the floor in the middle of a row of fragments, and light falls on both of its sides.
TEST(Cells, FloorOnBothSidesOfAScreenStays) {
    Scene scene = room_with_cells();
    add_object(scene);
    add_quad(scene, {0.2f, 0, 0.8594f}, {0.6f, 0, 0}, {0, 0.3f, 0});
    const Cells cells = cells_of(scene);
    double floor = 0;
    for (const Patch& p : cells.patches)
        if (p.slot % kFacingCount == 2 && p.cell.y == 0) floor += p.area;
    EXPECT_NEAR(floor, 1, 1e-6);
}

// A block, turned and open below, covers parts of fragments of the floor: what is under it does not count,
// and what is left lies where it is seen. 64 places in each of the fragments along its edges decide.
TEST(Cells, TheFootOfATurnedBlockIsCut) {
    Scene scene = room_with_cells();
    add_object(scene);
    const Vec3 corner(0.33f, 0, 0.52f), a(0.2f, 0, 0.11f), b(0.11f, 0, -0.2f), up(0, 0.3f, 0);
    for (const auto& [at, edge] :
         {std::pair(corner, a), std::pair(Vec3(corner + a), b), std::pair(Vec3(corner + a + b), Vec3(-a)),
          std::pair(Vec3(corner + b), Vec3(-b))})
        add_quad(scene, at, edge, up);
    add_quad(scene, corner + up, a, b);
    const Cells cells = cells_of(scene);
    const double foot = a.cross(b).length();
    double floor = 0;
    for (const Patch& p : cells.patches)
        if (p.slot % kFacingCount == 2 && p.cell.y == 0) floor += p.area;
    // Some 30 fragments of 1/32 along each side; their shares come from 64 places spread evenly.
    EXPECT_NEAR(floor, 1 - foot, 1e-3 * foot);
    for (const Patch& p : cells.patches) {
        if (p.slot != 2 || p.cell.y != 0) continue;
        const Vec3 centre = Vec3(cells.grid.centre(p.cell)) + p.centre - corner;
        const float u = centre.dot(a) / a.length2(), v = centre.dot(b) / b.length2();
        const bool well_under = std::min(u, v) > 0.1f && std::max(u, v) < 0.9f;
        EXPECT_FALSE(well_under);
    }
}

TEST(Cells, TwiceThePhotonsChangeLittle) {
    Scene scene = room_with_cells();
    add_object(scene);
    add_box(scene, {0.985f, 0.25f, 0.25f}, {0.99f, 0.75f, 0.75f}, false);
    add_object(scene);
    add_box(scene, {0.3f, 0, 0.3f}, {0.41f, 0.13f, 0.37f}, false);
    const Cells twice = cells_of(scene);
    scene.grid.reach_photons /= 2;
    const Cells once = cells_of(scene);
    EXPECT_NEAR(twice.counted_area, once.counted_area, 0.01 * once.counted_area);  // the mark
    EXPECT_LT(once.counted_area, 2 * total_area(scene.geometry));
}

TEST(Cells, FewPhotonsAreFew) {
    Scene scene = room_with_cells();
    for (const uint64_t most : {uint64_t{1} << 16, uint64_t{100'000}}) {
        scene.grid.reach_photons = most;
        const Cells cells = cells_of(scene);
        EXPECT_LE(cells.deciding_photons, most);
        EXPECT_GT(cells.deciding_photons, most / 2);
        EXPECT_NEAR(cells.counted_area, total_area(scene.geometry), 0.01 * total_area(scene.geometry));
    }
}

TEST(Cells, PatchesAreSortedAndHoldTheirCentres) {
    const Cells cells = cells_of(room_with_cells());
    EXPECT_TRUE(std::ranges::is_sorted(cells.patches, patch_before));
    for (std::size_t p = 0; p < cells.patches.size(); ++p) {
        EXPECT_EQ(cells.index.find(cells.patches[p].cell, cells.patches[p].slot), int(p));
        for (int axis = 0; axis < 3; ++axis)  // within the cell, but for the tie at its border
            EXPECT_LE(std::abs(cells.patches[p].centre[axis]), 0.51f * cells.grid.cell_size);
    }
}

// The board before the wall and the wall around it share cells: two layers, each with its own area.
TEST(Cells, SurfacesOneBehindTheOtherAreTwoPatches) {
    Scene scene = room_with_cells();
    const float front = 1 - 0.03f;
    add_object(scene);
    add_quad(scene, {front, 0.3125f, 0.3125f}, {0, 0, 0.375f}, {0, 0.375f, 0});  // looks to -x
    const Cells cells = cells_of(scene);
    const Index3 cell(7, 2, 4);  // y from 0.25 to 0.375: its upper half is behind the board
    const int wall = cells.index.find(cell, 1 + kFacingCount), board = cells.index.find(cell, 1);
    ASSERT_GE(wall, 0);
    ASSERT_GE(board, 0);
    EXPECT_NEAR(cells.patches[std::size_t(board)].area, 0.125 * 0.0625, 1e-7);
    EXPECT_NEAR(cells.patches[std::size_t(wall)].centre.x, 0.0625, 1e-6);
    EXPECT_NEAR(cells.patches[std::size_t(board)].centre.x, 0.0625 - 0.03, 1e-6);
}

// A sheet hangs 0.01 cells before a wall, over half of fragments. Lines along the wall pass below it, light
// does not: what it covers is no surface, but for a rim where light comes in from the side.
TEST(Cells, WhatASheetCoversDoesNotCount) {
    Scene scene = room_with_cells();
    const float gap = 0.00125f, low = 0.265f, size = 0.47f;
    add_object(scene);
    add_quad(scene, {1 - gap, low, low}, {0, 0, size}, {0, size, 0});  // looks to -x
    const Cells cells = cells_of(scene);
    double facing = 0;
    for (const Patch& p : cells.patches)
        if (p.slot % kFacingCount == 1 && p.cell.x == 7) facing += p.area;
    EXPECT_NEAR(facing, 1, 4 * size * 4 * gap);  // the sheet itself stands for what it covers
}

// A false ceiling hangs just below a border of cells, another one closely above it, in the next cells: places
// on the lower one, lifted by a third of a cell, would stand among those on the upper one.
TEST(Cells, AFalseCeilingDoesNotSeeTheOneAboveIt) {
    Scene scene = room_with_cells();
    scene.grid.reachable_area_only = false;  // so that both have patches
    const float low = 0.87f, high = 0.882f;
    add_object(scene);
    add_quad(scene, {0, low, 0}, {1, 0, 0}, {0, 0, 1});  // looks down
    add_object(scene);
    add_quad(scene, {0, high, 0}, {1, 0, 0}, {0, 0, 1});
    const Cells cells = cells_of(scene);
    const IlluminationMap map = map_without_lights(cells);
    std::vector<PatchShare> shares;
    look_up(map, {0.4f, low, 0.4f}, {0, -1, 0}, shares);
    double of_low = 0, of_high = 0;
    for (const PatchShare& share : shares) {
        const Patch& patch = cells.patches[share.patch];
        (cells.grid.centre(patch.cell).y + double(patch.centre.y) > 0.876 ? of_high : of_low) +=
            double(share.weight);
    }
    EXPECT_GT(of_low, 0.99);
    EXPECT_LT(of_high, 2 * double(kUnseenFactor));
}

// A partition between two rooms, turned against the cells: the floor runs on under it. Where it crosses a
// cell, each side is a patch of its own, with its area and its middle.
TEST(Cells, TheTwoSidesOfAPartitionAreTwoPatches) {
    Scene scene = room_with_cells();
    add_object(scene);
    const float slope = 0.02f;  // crosses cells 3 on x from 0.40 of them to 0.56
    add_quad(scene, {0.425f, 0, 0}, {slope, 0, 1}, {0, 1, 0});
    const Cells cells = cells_of(scene);
    double floor = 0;
    for (int z = 0; z < 8; ++z) {
        const Index3 cell(3, 0, z);
        const int front = cells.index.find(cell, 2), behind = cells.index.find(cell, 2 + kFacingCount);
        ASSERT_GE(front, 0) << z;
        ASSERT_GE(behind, 0) << z;
        const Patch &a = cells.patches[std::size_t(front)], &b = cells.patches[std::size_t(behind)];
        const Patch &left = a.centre.x < b.centre.x ? a : b, &right = a.centre.x < b.centre.x ? b : a;
        const double at = 0.425 + slope * (z + 0.5) / 8 - 0.375;  // from the cell's lower side, at its middle
        const double tolerance = 0.02;  // 64 places in each of the four fragments that it crosses
        EXPECT_NEAR(left.area, at / 8, tolerance * 0.125 / 8) << z;
        EXPECT_NEAR(right.area, (0.125 - at) / 8, tolerance * 0.125 / 8) << z;
        EXPECT_NEAR(left.centre.x, at / 2 - 0.0625, tolerance * 0.125) << z;
        EXPECT_NEAR(right.centre.x, (at + 0.125) / 2 - 0.0625, tolerance * 0.125) << z;
        floor += left.area + right.area;
    }
    EXPECT_NEAR(floor, 0.125, 1e-3 * 0.125);  // a place at the foot may count as covered
    // Neither sees the other, and each sees its own side of the next cells.
    const int front = cells.index.find({3, 0, 4}, 2);
    const int west = cells.index.find({2, 0, 4}, 2);
    EXPECT_FALSE(cells.sight.sees_all(std::size_t(front)));
    EXPECT_FALSE(cells.sight.sees_all(std::size_t(west)));
}

}  // namespace
}  // namespace pim
