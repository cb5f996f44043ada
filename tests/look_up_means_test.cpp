// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/look_up_means.h"

#include <gtest/gtest.h>

#include "bake/cells.h"
#include "bake/patch_filter.h"
#include "common/map/irradiance.h"
#include "statistics.h"
#include "test_scenes.h"

namespace pim {
namespace {

constexpr int kSide = 8;

// A floor of 8 × 8 cells, all of which counts.
struct Floor {
    Scene scene = empty_scene();
    Cells cells;

    Floor() {
        add_quad(scene, Vec3(0), Vec3(0, 0, 1), Vec3(1, 0, 0));
        scene.lights.push_back(point_lamp({0.5f, 0.5f, 0.5f}));
        scene.grid.resolution = CellCount{kSide};
        scene.grid.reachable_area_only = false;
        cells = find_cells(scene, RayCaster(scene.geometry, InstructionSet::pinned),
                           [](const Vec3&) { return true; });
    }
    int slot() const { return 2; }  // py
    uint32_t patch(int x, int z) const {
        const auto& some = cells.patches.front().cell;
        for (int y = 0; y <= some.y + 1; ++y)
            if (const int p = cells.index.find({x, y, z}, slot()); p >= 0) return uint32_t(p);
        return ~0u;
    }
    Index3 first() const {  // cell of the floor's corner
        Index3 low = cells.patches.front().cell;
        for (const Patch& p : cells.patches)
            for (int a = 0; a < 3; ++a) low[a] = std::min(low[a], p.cell[a]);
        return low;
    }
};

float weight_of(const LookUpMeans& means, uint32_t patch, uint32_t of) {
    float sum = 0;
    for (const auto& s : means.of(patch))
        if (s.patch == of) sum += s.weight;
    return sum;
}

// The mean of linear interpolation over a cell in the middle of a floor: 1/8, 3/4, 1/8 along each axis.
TEST(LookUpMeans, MeanOfInterpolationOverACell) {
    const Floor floor;
    const LookUpMeans& means = floor.cells.means;
    const Index3 low = floor.first();
    const std::array<float, 3> line{0.125f, 0.75f, 0.125f};
    const int x = low.x + 5, z = low.z + 3;  // off the diagonal between the floor's triangles
    for (int i = -1; i <= 1; ++i)
        for (int j = -1; j <= 1; ++j)
            EXPECT_NEAR(weight_of(means, floor.patch(x, z), floor.patch(x + i, z + j)),
                        line[std::size_t(i + 1)] * line[std::size_t(j + 1)], 1e-5);
    for (std::size_t p = 0; p < floor.cells.patches.size(); ++p) {
        float sum = 0;
        for (const auto& s : means.of(p)) sum += s.weight;
        EXPECT_NEAR(sum, 1, 1e-5);
    }
}

// Averages of x² over cells of size h: interpolated they are too large by h²/4 in the mean, sharpened not at
// all.
TEST(LookUpMeans, SharpenedValuesShowTheMeansOfAQuadratic) {
    const Floor floor;
    const LookUpMeans& means = floor.cells.means;
    std::vector<Rgb> averages;
    for (const Patch& p : floor.cells.patches) {
        const float x = float(p.cell.x) + 0.5f;  // in cells
        averages.emplace_back(x * x + 1 / 12.0f);
    }
    const auto sharp = sharpened(averages, means);
    const auto shown = [&](const std::vector<Rgb>& values, uint32_t patch) {
        double sum = 0;
        for (const auto& s : means.of(patch)) sum += double(s.weight) * double(values[s.patch].x);
        return sum;
    };
    const Index3 low = floor.first();
    for (int x = low.x + 2; x < low.x + kSide - 2; ++x) {
        const uint32_t p = floor.patch(x, low.z + 4);
        EXPECT_NEAR(shown(averages, p) - double(averages[p].x), 0.25, 1e-4);
        EXPECT_NEAR(shown(sharp, p), double(averages[p].x), 1e-4);
    }
}

// Even light stays as it is, whatever way surfaces face.
TEST(LookUpMeans, EvenLightStays) {
    Scene scene = empty_scene();
    add_sphere(scene, Vec3(0), 1, 2, false, true);
    scene.lights.push_back(point_lamp({2, 2, 2}));
    scene.grid.resolution = CellCount{5};
    scene.grid.reachable_area_only = false;
    const Cells cells = find_cells(scene, RayCaster(scene.geometry, InstructionSet::pinned),
                                   [](const Vec3&) { return true; });
    for (const Rgb& v : sharpened(std::vector<Rgb>(cells.patches.size(), Rgb(3)), cells.means))
        EXPECT_NEAR(v.x, 3, 1e-4);
}

// Some patches only: the shares of the others go to those that are there.
TEST(LookUpMeans, PartHasTheNumbersOfThePart) {
    const Floor floor;
    const LookUpMeans& means = floor.cells.means;
    const Index3 low = floor.first();
    std::vector<uint32_t> kept{floor.patch(low.x + 3, low.z + 4), floor.patch(low.x + 4, low.z + 4)};
    std::ranges::sort(kept);
    const LookUpMeans part = means.part(kept);
    EXPECT_NEAR(weight_of(part, 0, 0), 0.75 / 0.875, 1e-5);
    EXPECT_NEAR(weight_of(part, 0, 1), 0.125 / 0.875, 1e-5);
    EXPECT_TRUE(LookUpMeans().part(kept).empty());
}

NoisyCoefficients constants(const Cells& cells, double noise,
                            const std::function<double(const Patch&)>& signal) {
    NoisyCoefficients c{RowMatrix(Eigen::Index(3 * cells.patches.size()), 1), {0}, {}};
    RandomStream random(5, RandomPurpose::evaluation, 0, 0);
    for (std::size_t p = 0; p < cells.patches.size(); ++p)
        for (int channel = 0; channel < 3; ++channel) {
            double gauss = -6;
            for (int i = 0; i < 12; ++i) gauss += double(random.next());
            c.values(Eigen::Index(3 * p) + channel, 0) = signal(cells.patches[p]) + noise * gauss;
        }
    c.noise.resize(cells.patches.size());
    for (auto& n : c.noise) n.fill(noise * noise);
    return c;
}

double mean_square_change(const NoisyCoefficients& a, const NoisyCoefficients& b) {
    return (a.values - b.values).squaredNorm() / double(a.values.size());
}

TEST(Sharpen, WhatIsNoiseStays) {
    const Floor floor;
    const Neighbourhoods shared(floor.cells, true, floor.cells.means);
    const auto before = constants(floor.cells, 1, [](const Patch&) { return 10.0; });
    auto after = before;
    sharpen(after, shared);
    EXPECT_LT(mean_square_change(after, before), 0.01);
}

TEST(Sharpen, WithoutNoiseTheMeansAreShown) {
    const Floor floor;
    const LookUpMeans& means = floor.cells.means;
    const Neighbourhoods shared(floor.cells, true, floor.cells.means);
    const auto wave = [](const Patch& p) { return std::sin(double(p.cell.x)); };
    const auto before = constants(floor.cells, 1e-6, wave);
    auto after = before;
    sharpen(after, shared);
    std::vector<Rgb> plain;
    for (std::size_t p = 0; p < floor.cells.patches.size(); ++p)
        plain.emplace_back(float(before.values(Eigen::Index(3 * p), 0)));
    const auto sharp = sharpened(plain, means);
    for (std::size_t p = 0; p < plain.size(); ++p)
        EXPECT_NEAR(after.values(Eigen::Index(3 * p), 0), sharp[p].x, 1e-4);
}

// Between the two the error falls where signal can be told, and hardly grows where it cannot.
TEST(Sharpen, BetweenNoiseAndSignalTheErrorFalls) {
    const Floor floor;
    const Neighbourhoods shared(floor.cells, true, floor.cells.means);
    const auto wave = [](const Patch& p) { return std::sin(1.5 * double(p.cell.x)); };
    const auto truth = constants(floor.cells, 1e-6, wave);
    auto wanted = truth;
    sharpen(wanted, shared);
    for (const auto& [noise, most] : {std::pair{0.03, 0.6}, {0.1, 0.95}, {0.3, 1.05}, {1.0, 1.05}}) {
        const auto before = constants(floor.cells, noise, wave);
        auto after = before;
        sharpen(after, shared);
        EXPECT_LT(mean_square_change(after, wanted), most * mean_square_change(before, wanted)) << noise;
    }
}

}  // namespace
}  // namespace pim
