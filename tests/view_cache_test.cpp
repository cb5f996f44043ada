// SPDX-License-Identifier: GPL-3.0-or-later
// Patch by patch what relighter_test sees as pictures.
#include "viewer/relight/view_cache.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "common/map/irradiance.h"
#include "measured.h"
#include "synthetic_maps.h"
#include "test_scenes.h"

namespace pim {
namespace {

const Imath::V2i kSize(70, 45);

struct Viewed {
    const MappedScene& m;
    ViewBuilder builder;
    CameraRays rays;

    explicit Viewed(const MappedScene& scene)
        : m(scene),
          builder(m.scene(), m.caster, m.baked.map, kernels(best_vector_unit())),
          rays(m.scene().cameras[0], kSize) {}
    std::vector<ViewTile> tiles(const ViewOptions& options) const {
        std::vector<ViewTile> all = make_tiles(kSize);
        for (ViewTile& tile : all) builder.build(rays, Vec2(0.5f), options, tile);
        return all;
    }
    std::optional<SurfacePoint> seen(const ViewTile& tile, int pixel) const {
        const auto hit = m.caster.intersect(
            rays.through(float(tile.x + pixel % kTileSize) + 0.5f, float(tile.y + pixel / kTileSize) + 0.5f));
        if (!hit) return std::nullopt;
        return surface_at(m.scene(), *hit);
    }
};

// Calls each(pixel, weights by patch, factor) for every point of a tile; checks that the rest is padding.
template <class Each>
void for_each_point(const ViewTile& tile, Each each) {
    std::size_t blocks = 0;
    for (const PointGroup& g : tile.groups) {
        ASSERT_EQ(g.first_block, blocks) << "one after the other";
        blocks += g.blocks;
        ASSERT_LE(g.first_patch + g.patches, tile.patches.size());
        for (std::size_t slot = g.first_block * kLanes; slot < blocks * kLanes; ++slot) {
            const std::size_t block = slot / kLanes, lane = slot % kLanes;
            const bool mixed = g.first_factor != PointGroup::kOneFactor;
            Rgb factor = g.factor;
            for (int c = 0; c < 3 && mixed; ++c)
                factor[c] = tile.factors[g.first_factor +
                                         ((block - g.first_block) * 3 + std::size_t(c)) * kLanes + lane];
            if (tile.pixels[slot] == kNoPixel) {
                ASSERT_TRUE(!mixed || factor == Rgb(0));
                continue;
            }
            std::map<uint32_t, double> weights;
            const std::size_t first = g.first_weight + (block - g.first_block) * g.patches * kLanes;
            for (uint32_t p = 0; p < g.patches; ++p)
                weights[tile.patches[g.first_patch + p]] +=
                    double(tile.weights[first + p * kLanes + lane]) / double(kWeightSteps);
            each(int(tile.pixels[slot]), weights, factor);
        }
    }
    ASSERT_EQ(blocks, tile.block_count());
}

TEST(ViewTiles, CoverEachPixelOnce) {
    for (const Imath::V2i& size : {Imath::V2i(1, 1), {32, 32}, {33, 31}, {64, 1}, {100, 70}}) {
        std::set<std::pair<int, int>> pixels;
        for (const ViewTile& tile : make_tiles(size)) {
            EXPECT_TRUE(tile.width >= 1 && tile.width <= kTileSize && tile.height >= 1 &&
                        tile.height <= kTileSize);
            for (int y = 0; y < tile.height; ++y)
                for (int x = 0; x < tile.width; ++x)
                    EXPECT_TRUE(pixels.emplace(tile.x + x, tile.y + y).second);
        }
        EXPECT_EQ(pixels.size(), std::size_t(size.x * size.y));
        EXPECT_EQ(*pixels.rbegin(), std::pair(size.x - 1, size.y - 1));
    }
}

// Positions are within 8 roundings of 10 m, 1e-5 cells, of those of single rays; weights change by at most
// some 6 per cell; of two layers as near as that, shares differ by up to a thousand times as much.
TEST(ViewCache, PointsWeighPatchesAsLookUpDoes) {
    for (const auto& [layers, walls] :
         {std::pair(false, false), {true, false}, {false, true}, {true, true}}) {
        SyntheticOptions options;
        options.layers = layers;
        options.walls = walls;
        const MappedScene m(scene_of_data("cornell"), options);
        const Viewed view(m);
        Largest off(fmt::format("weight{}{}", layers ? "_with_layers" : "", walls ? "_with_walls" : ""));
        int points = 0, apart = 0;
        for (const ViewTile& tile : view.tiles({.surfaces = true})) {
            std::set<int> pixels;
            EXPECT_TRUE(tile.one_point_per_pixel);
            for_each_point(tile,
                           [&](int pixel, const std::map<uint32_t, double>& weights, const Rgb& factor) {
                               EXPECT_TRUE(pixels.insert(pixel).second);
                               const auto surface = view.seen(tile, pixel);
                               ASSERT_TRUE(surface);
                               EXPECT_NEAR((factor - surface->diffuse / kPi).length(), 0, 1e-6f);
                               std::vector<PatchShare> shares;
                               look_up(m.baked.map, surface->position, surface->shading_normal, shares);
                               std::map<uint32_t, double> expected;
                               for (const PatchShare& s : shares) expected[s.patch] += double(s.weight);
                               double worst = 0, sum = 0;
                               for (const auto& [patch, w] : weights) {
                                   worst = std::max(worst, std::abs(w - expected[patch]));
                                   sum += w;
                                   expected.erase(patch);
                               }
                               for (const auto& [patch, w] : expected) worst = std::max(worst, w);
                               EXPECT_NEAR(sum, 1, 1e-5);
                               apart += worst > (layers ? 1e-3 : 1e-4);  // an edge within roundings
                               if (worst <= 1e-3) off.add(worst);
                               ++points;
                           });
            for (int y = 0; y < tile.height; ++y)
                for (int x = 0; x < tile.width; ++x) {
                    const int pixel = y * kTileSize + x;
                    EXPECT_EQ(pixels.contains(pixel), view.seen(tile, pixel).has_value());
                }
        }
        EXPECT_GT(points, kSize.x * kSize.y / 3);
        EXPECT_LE(apart, points / 500);
    }
}

TEST(ViewCache, MirrorsGiveSeveralPointsToAPixel) {
    const MappedScene m(scene_of_data("caustic"));
    const Viewed view(m);
    bool several = false;
    for (const ViewTile& tile : view.tiles({})) {
        std::map<int, int> count;
        for_each_point(tile, [&](int pixel, const auto&, const Rgb&) { ++count[pixel]; });
        const bool own = std::ranges::any_of(count, [](const auto& one) { return one.second > 1; });
        EXPECT_TRUE(!own || !tile.one_point_per_pixel);
        several = several || own;
        EXPECT_TRUE(tile.segments.empty());
    }
    EXPECT_TRUE(several);
    // As irradiance each first surface is one point, mirror or not, and counts as it is.
    for (const ViewTile& tile : view.tiles({.radiance = false})) {
        EXPECT_TRUE(tile.one_point_per_pixel);
        for_each_point(tile, [](int, const auto&, const Rgb& factor) { EXPECT_EQ(factor, Rgb(1)); });
    }
}

TEST(ViewCache, SegmentsBeginWithThePixelsOwn) {
    const MappedScene m(scene_of_data("caustic"));
    const Viewed view(m);
    int secondary = 0;
    for (const ViewTile& tile : view.tiles({.segments = true})) {
        std::set<int> primary;
        for (const Segment& s : tile.segments) {
            if (s.primary) {
                EXPECT_TRUE(primary.insert(s.pixel).second);
                EXPECT_EQ(s.throughput, Rgb(1));
                EXPECT_EQ(s.ray.origin, view.rays.eye());
            } else {
                EXPECT_TRUE(primary.contains(s.pixel));
                ++secondary;
            }
            EXPECT_NEAR(s.ray.direction.length(), 1, 1e-6f);
        }
        EXPECT_EQ(primary.size(), std::size_t(tile.width * tile.height));
        EXPECT_FALSE(tile.one_point_per_pixel);
    }
    EXPECT_GT(secondary, 0);
}

bool same(const ViewTile& a, const ViewTile& b) {
    return a.patches == b.patches && a.weights == b.weights && a.factors == b.factors &&
           a.pixels == b.pixels && a.surfaces == b.surfaces;
}

// A thread keeps what it has found of one map; another map's cells are others.
TEST(ViewCache, MapsDoNotMix) {
    SyntheticOptions finer;
    finer.cells = 12;
    const MappedScene coarse(scene_of_data("cornell")), fine(scene_of_data("cornell"), finer);
    const Viewed a(coarse), b(fine);
    const auto first = a.tiles({.surfaces = true}), other = b.tiles({.surfaces = true}),
               again = a.tiles({.surfaces = true});
    for (std::size_t t = 0; t < first.size(); ++t) {
        EXPECT_TRUE(same(first[t], again[t])) << t;
        EXPECT_TRUE(first[t].pixels.empty() || !same(first[t], other[t])) << t;
    }
    auto used = b.tiles({});  // tiles' memory does not show either
    for (std::size_t t = 0; t < used.size(); ++t) {
        a.builder.build(a.rays, Vec2(0.5f), {.surfaces = true}, used[t]);
        EXPECT_TRUE(same(first[t], used[t])) << t;
    }
}

}  // namespace
}  // namespace pim
