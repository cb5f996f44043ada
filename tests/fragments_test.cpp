// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/fragments.h"

#include <set>

#include "common/core/sampling.h"
#include "common/scene/geometry_check.h"
#include "statistics.h"
#include "test_scenes.h"

namespace pim {
namespace {

Vec3 random_vector(RandomStream& random) {
    const float x = random.next(), y = random.next(), z = random.next();
    return {x, y, z};
}

Scene triangle_soup(int triangles, uint64_t seed, bool smooth = false) {
    Scene scene = empty_scene();
    RandomStream random(seed, RandomPurpose::evaluation, 0, 0);
    for (int i = 0; i < triangles; ++i) {
        const Vec3 a = random_vector(random), size = random_vector(random);
        add_triangle(scene, a, a + (random_vector(random) - Vec3(0.5f)) * size,
                     a + (random_vector(random) - Vec3(0.5f)) * size);
    }
    for (Vec3& n : scene.geometry.normals)
        if (smooth) n = sample_sphere(random.next(), 0.3f);
    scene.grid.resolution = CellCount{7};
    return scene;
}

std::vector<Fragment> cut(const Scene& scene) {
    return cut_into_fragments(scene, SurfaceCells(make_grid(scene), scene.geometry));
}

double sum_of_areas(const std::vector<Fragment>& fragments) {
    double sum = 0;
    for (const Fragment& f : fragments) sum += f.area;
    return sum;
}

// Every fragment's area is rounded to float once, 2^-24 of it, and so is the sum at worst.
constexpr double kAreaRounding = 0x1p-23;

TEST(Fragments, AreasAddUpToBothSidesOfTheTriangles) {
    for (const uint64_t seed : {1u, 2u, 3u}) {
        const Scene scene = triangle_soup(300, seed);
        const double whole = 2 * total_area(scene.geometry);
        EXPECT_NEAR(sum_of_areas(cut(scene)), whole, kAreaRounding * whole);
    }
    for (const Scene& scene : {room(Rgb(0.5f), {1, 2, 3}), plane_under_lamp(3, 1)}) {
        const double whole = 2 * total_area(scene.geometry);
        EXPECT_NEAR(sum_of_areas(cut(scene)), whole, kAreaRounding * whole);
    }
}

TEST(Fragments, OnlySurfaceThatHoldsIrradiance) {
    Scene scene = room(Rgb(0.5f));
    scene.materials.push_back(mirror_material(Rgb(0.9f)));
    scene.materials.push_back(glass_material(1.5f));
    scene.geometry.triangles[0].material = 1;
    scene.geometry.triangles[1].material = 2;
    for (const Fragment& f : cut(scene)) EXPECT_GE(f.key.triangle, 2u);
}

TEST(Fragments, SurfaceBeyondTheBoundsIsLeftOut) {
    Scene scene = plane_under_lamp(3, 1);
    scene.grid.bounds = Box3(Vec3(-0.3f, -0.5f, -0.4f), Vec3(0.5f, 0.5f, 0.4f));
    scene.grid.resolution = CellSize{0.1};
    const double bounds = 2 * 0.8 * 0.8;
    EXPECT_NEAR(sum_of_areas(cut(scene)), bounds,
                4 * kAreaRounding * bounds);  // bounds are floats themselves
}

TEST(Fragments, FacingsShareTheArea) {
    for (const bool smooth : {false, true}) {
        const Scene scene = triangle_soup(100, 4, smooth);
        for (const Fragment& f : cut(scene)) {
            double sum = 0;
            for (const float a : f.facing_area) sum += a;
            EXPECT_NEAR(sum, f.area, 40 * kAreaRounding * f.area);  // some dozen float additions
        }
    }
}

// The facings' areas of a sphere with smooth normals: the integral of the weights, by symmetry a sixth each.
TEST(Fragments, FacingsOfASphereAreEqual) {
    Scene scene = empty_scene();
    add_sphere(scene, Vec3(0), 1, 3, false, true);
    scene.grid.resolution = CellCount{6};
    std::array<double, kFacingCount> sums{};
    for (const Fragment& f : cut(scene))
        for (int k = 0; k < kFacingCount; ++k) sums[k] += f.facing_area[k];
    // Icospheres are symmetric under exchange of the axes' ends; between the axes up to their edges' size
    // squared.
    for (const double s : sums) EXPECT_NEAR(s, 2 * total_area(scene.geometry) / 6, 0.01 * s);
}

TEST(Fragments, KeysAreSortedAndUnique) {
    const auto fragments = cut(triangle_soup(200, 5));
    for (std::size_t i = 1; i < fragments.size(); ++i) EXPECT_LT(fragments[i - 1].key, fragments[i].key);
}

TEST(Fragments, CentresLieInTheirFineCells) {
    const Scene scene = triangle_soup(100, 6);
    const CellGrid grid = make_grid(scene);
    const SurfaceCells surface(grid, scene.geometry);
    const double fine = grid.cell_size / kFinePerCell;
    for (const Fragment& f : cut_into_fragments(scene, surface)) {
        const Index3 cell = cell_of(grid, f.key);
        ASSERT_TRUE(grid.contains(cell));
        const int in = f.key.place >> 1;
        const Vec3d low = grid.corner(cell) + Vec3d(in / 16, in / 4 % 4, in % 4) * fine;
        for (int axis = 0; axis < 3; ++axis) {
            EXPECT_GE(f.centre[axis],
                      low[axis] - 1e-2 * grid.cell_size);  // flat triangles may be tied so far away
            EXPECT_LE(f.centre[axis], low[axis] + fine + 1e-2 * grid.cell_size);
        }
    }
}

using Cell = std::tuple<int, int, int>;

std::set<Cell> cells_with_fragments(const CellGrid& grid, const std::vector<Fragment>& fragments) {
    std::set<Cell> cells;
    for (const Fragment& f : fragments) {
        const Index3 c = cell_of(grid, f.key);
        cells.insert({c.x, c.y, c.z});
    }
    return cells;
}

// Cells whose box, grown on all sides by so much, an exact test finds a triangle to meet.
std::set<Cell> cells_met(const Scene& scene, const CellGrid& grid, double growth) {
    std::set<Cell> cells;
    for (int x = 0; x < grid.size.x; ++x)
        for (int y = 0; y < grid.size.y; ++y)
            for (int z = 0; z < grid.size.z; ++z) {
                const Vec3d low = grid.corner({x, y, z}) - Vec3d(growth);
                const Box3d box(low, low + Vec3d(grid.cell_size + 2 * growth));
                for (uint32_t t = 0; t < scene.geometry.triangles.size(); ++t)
                    if (triangle_meets_box(scene.geometry.corners(t), box)) {
                        cells.insert({x, y, z});
                        break;
                    }
            }
    return cells;
}

bool includes(const std::set<Cell>& all, const std::set<Cell>& some) {
    return std::ranges::includes(all, some);
}

// The closed box of a cell also meets triangles that only touch it at its border. So the cells with fragments
// are exactly those that the exact test finds, but for cells that are merely touched: with boxes made smaller
// by rounding the exact test must find no more of them, with boxes made larger no fewer.
TEST(Fragments, CellsAreThoseThatAnExactTestFinds) {
    for (const uint64_t seed : {7u, 8u}) {
        const Scene scene = triangle_soup(150, seed);
        const CellGrid grid = make_grid(scene);
        const auto cells = cells_with_fragments(grid, cut(scene));
        const double rounding = 1e-6 * grid.cell_size;
        EXPECT_TRUE(includes(cells_met(scene, grid, rounding), cells));
        EXPECT_TRUE(includes(cells, cells_met(scene, grid, -rounding)));
    }
}

// Flat walls on borders belong to the cells in front of each side: no others than the exact test's, and none
// of the cells in whose inside there is surface is missing.
TEST(Fragments, CellsOfARoomWithWallsOnBorders) {
    Scene scene = room(Rgb(0.5f), {1, 0.75f, 0.5f});
    add_quad(scene, {0.25f, 0.5f, 0.1f}, {0, 0, 0.3f}, {0.4f, 0, 0});  // a board on a border between cells
    scene.grid.resolution = CellSize{0.25};
    const CellGrid grid = make_grid(scene);
    const auto cells = cells_with_fragments(grid, cut(scene));
    EXPECT_TRUE(includes(cells_met(scene, grid, 1e-6), cells));
    EXPECT_TRUE(includes(cells, cells_met(scene, grid, -1e-6)));
}

TEST(FragmentKey, CellComesBack) {
    CellGrid grid;
    grid.size = {5, 300, 7};
    for (const Index3& cell : {Index3(0), Index3(4, 299, 6), Index3(2, 17, 3)})
        for (const Index3& in : {Index3(0), Index3(3), Index3(1, 2, 3)}) {
            const FragmentKey key = fragment_key(grid, 9, Side::back, cell * kFinePerCell + in);
            EXPECT_EQ(cell_of(grid, key), cell);
            EXPECT_EQ(key.place, ((in.x * 4 + in.y) * 4 + in.z) * 2 + 1);
        }
}

}  // namespace
}  // namespace pim
