// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/error_parts.h"

#include "bake/visible_light.h"
#include "common/map/irradiance.h"
#include "tests/baked_scenes.h"

namespace pim {
namespace {

fs::path bake_with(const std::string& scene, const std::string& name, std::vector<Setting> settings) {
    settings.push_back({"reach_photons", "262144"});
    set_log_level("error");
    const fs::path map = test_folder() / (name + ".vdb");
    bake_run(fs::path(PIM_DATA) / scene / (scene + ".toml"),
             {.output = map, .settings = settings, .overwrite = true});
    return map;
}

nlohmann::json parts_of(const fs::path& map, int paths = 64) {
    return error_parts(
        map, {.evaluate = {.lights = 6, .pixels = 400, .paths = paths, .geometry = {}}, .pictures = {}});
}

double square(const nlohmann::json& parts, int j, int k) {
    return parts["relative_squares"][std::size_t(j)][std::size_t(k)].get<double>();
}
constexpr int kNoise = 0, kPolynomial = 1, kLeak = 2, kGrid = 3;

TEST(ErrorParts, SumToTheErrorThatEvaluationFinds) {
    const fs::path map = bake_with("cornell", "whole", {{"photons", "2000"}, {"cells", "12"}});
    const auto parts = parts_of(map);
    double sum = 0;
    for (int j = 0; j < 4; ++j)
        for (int k = 0; k < 4; ++k) {
            sum += square(parts, j, k);
            EXPECT_EQ(square(parts, j, k), square(parts, k, j));
        }
    EXPECT_NEAR(sum, parts["relative_square"].get<double>(), 1e-12);
    const auto evaluated = Evaluator({.lights = 6, .pixels = 400, .paths = 64, .geometry = {}}).evaluate(map);
    double squares = 0;  // cornell has one camera: each position is one view
    for (const auto& e : evaluated["relrmse_per_position"]) squares += e.get<double>() * e.get<double>() / 6;
    EXPECT_NEAR(sum, squares, 1e-4 * squares);  // the rays' instruction sets differ
}

// Everything on the wall of a closed sphere sees everything, and its indirect light is the same wherever the
// lamp stands: nothing is left but noise, which falls with the photons.
TEST(ErrorParts, ASphereHasNoiseOnly) {
    // A map holds as much as a volume of photons times positions; an own volume, several times that.
    // Plain least squares, because a filter leaves next to no noise on such a surface; enough photons that
    // noise does not take the polynomials below zero, where they would be mended.
    const auto few = parts_of(bake_with("sphere", "few", {{"photons", "500"}, {"shrinkage", "false"}}), 120);
    const auto many = parts_of(bake_with("sphere", "many", {{"photons", "8000"}, {"shrinkage", "false"}}), 8);
    EXPECT_GT(square(few, kNoise, kNoise), 0.7 * few["relative_square"].get<double>());
    const double ratio = square(few, kNoise, kNoise) / square(many, kNoise, kNoise);
    EXPECT_GT(ratio, 16 / 1.6);
    EXPECT_LT(ratio, 16 * 1.6);
    // The product of two independent noises, over some 100 independent patches in view: a tenth of the
    // square.
    for (const int part : {kPolynomial, kLeak, kGrid})
        EXPECT_LT(std::abs(square(few, part, part)), 0.3 * square(few, kNoise, kNoise)) << part;
}

TEST(ErrorParts, AConstantForAPolynomialIsSeenAsSuch) {
    const auto cubic = parts_of(
                   bake_with("cornell", "cubic",
                             {{"cells", "16"}, {"photons", "10000"}, {"samples", "150"}, {"degree", "3"}})),
               constant = parts_of(
                   bake_with("cornell", "constant",
                             {{"cells", "16"}, {"photons", "10000"}, {"samples", "150"}, {"degree", "0"}}));
    EXPECT_GT(square(constant, kPolynomial, kPolynomial), 4 * square(cubic, kPolynomial, kPolynomial));
    EXPECT_GT(square(constant, kPolynomial, kPolynomial), 0.5 * constant["relative_square"].get<double>());
    // The cells are the same, so what they cost is the same, up to the experiments' noise.
    const double both = square(cubic, kGrid, kGrid) + square(cubic, kLeak, kLeak);
    EXPECT_NEAR(square(constant, kGrid, kGrid) + square(constant, kLeak, kLeak), both, 0.3 * std::abs(both));
}

// Light, photons and cells of one lamp position at its start.
struct Lit {
    const Baked& scene;
    Cells cells;
    SurfaceCells surface;
    VisibleLight visible;
    std::vector<Rgb> values;

    explicit Lit(const Baked& b)
        : scene(b),
          cells(find_cells(b.baked.scene, b.caster, [](const Vec3&) { return true; })),
          surface(cells.grid, b.baked.scene.geometry),
          visible(b.baked.scene, cells, surface),
          values(cells.patches.size(), Rgb(0)) {
        const LightSample sample{0, 7, b.baked.scene.lights[0].position};
        visible.set(landed_light(b.baked.scene, b.caster, cells, surface, sample, Rgb(1)));
        const auto volume = trace_density(b.baked.scene, b.caster, cells, surface, sample);
        for (const auto& component : volume.components)
            for (std::size_t p = 0; p < component.density.size(); ++p) values[p] += component.density[p];
    }
    SurfacePoint seen_from(const Vec3& eye, const Vec3& direction) const {
        return surface_at(scene.baked.scene, *scene.caster.intersect({eye, direction}));
    }
    float looked_up(const SurfacePoint& s) const {
        return irradiance_at(scene.baked.map, values, s.position, s.shading_normal).x;
    }
    float seen(const SurfacePoint& s) const { return visible.irradiance(scene.baked.map, scene.caster, s).x; }
};

// Where all see all, what is seen is the look-up itself.
TEST(VisibleLight, IsTheLookUpWhereNothingStandsBetween) {
    const Lit lit(baked_scene("sphere"));
    for (int i = 0; i < 200; ++i) {
        RandomStream random(5, RandomPurpose::evaluation, 0, uint64_t(i));
        const Vec3 direction = sample_sphere(random.next(), random.next());
        const SurfacePoint s = lit.seen_from(lit.scene.baked.scene.lights[0].position, direction);
        EXPECT_NEAR(lit.seen(s), lit.looked_up(s), 1e-4f * lit.looked_up(s));
    }
    const auto sums = lit.visible.patch_values();
    ASSERT_EQ(sums.size(), lit.values.size());
    for (std::size_t p = 0; p < sums.size(); ++p)
        EXPECT_NEAR(sums[p].x, lit.values[p].x, 1e-5f * lit.values[p].x);
}

// Cells of the floor straddle the wall at x = 3 between a bright room and one without light.
TEST(VisibleLight, AThinWallDoesNotLeak) {
    const Lit lit(baked_scene("thin_wall"));
    double leaked = 0, seen = 0, bright = 0;
    for (int i = 0; i < 100; ++i) {
        const float z = 0.5f + 0.02f * float(i);
        const SurfacePoint dark = lit.seen_from({3.08f, 1, z}, {0, -1, 0}),
                           lit_floor = lit.seen_from({2.5f, 0.5f, z}, {0, -1, 0});
        leaked += double(lit.looked_up(dark));
        seen += double(lit.seen(dark));
        bright += double(lit.looked_up(lit_floor));
    }
    EXPECT_GT(leaked, 0.02 * bright);
    EXPECT_LT(seen, 0.05 * leaked);
}

}  // namespace
}  // namespace pim
