// SPDX-License-Identifier: GPL-3.0-or-later
// Items 11 and 12 of the list of answers known in advance, through all stages of a bake: cells, lamp
// positions, photons, density, fit. Items 1 to 9 and 13 stand with the units that they test:
// direct_light_test, form_factor_test, photon_test, path_radiance_test, density_test, fit_test; 10 cannot be
// expressed (path_radiance_test says why).
#include "bake/density.h"
#include "bake/fit.h"
#include "statistics.h"
#include "test_scenes.h"

namespace pim {
namespace {

Cells cells_of(Scene scene, const RayCaster& caster) {
    scene.grid.reach_photons = uint64_t{1} << 18;
    return find_cells(scene, caster, [](const Vec3&) { return true; });
}

struct Baked {
    Cells cells;
    MapBox box;
    std::vector<Vec3> positions;
    std::vector<DensityVolume> volumes;  // per position
    BoxFit fit;

    const DensityVolume::PerComponent& of(std::size_t sample) const {
        return volumes[sample].components[int(Component::indirect)];
    }
    float coefficient(std::size_t patch, std::size_t term) const {
        return fit.polynomials.coefficients[(patch * fit.polynomials.terms.size() + term) * 3];
    }
};

// The indirect component of the first lamp, fitted without shrinkage in one box.
Baked bake(const Scene& scene) {
    const RayCaster caster(scene.geometry, InstructionSet::pinned);
    Baked baked;
    baked.cells = cells_of(scene, caster);
    baked.box = split_domain(scene.lights[0].domain, Index3(1))[0];
    const SurfaceCells surface(baked.cells.grid, scene.geometry);
    std::vector<std::string> inside;
    for (const LightSample& sample : light_samples(scene.lights[0], 0, Solids({}, {}), inside)) {
        baked.positions.push_back(sample.position);
        baked.volumes.push_back(trace_density(scene, caster, baked.cells, surface, sample));
    }
    const auto read = [&](std::size_t sample) { return baked.of(sample); };
    baked.fit = fit_box(baked.box, baked.positions, {scene.bake.degree}, baked.cells.patches.size(), read, {});
    return baked;
}

// What each sample's density adds to each coefficient, [sample][term]: the fit of densities that are 1 in one
// sample and 0 in the others.
std::vector<std::vector<double>> influence_of(const Baked& baked) {
    const std::size_t samples = baked.positions.size();
    const auto one_at = [&](std::size_t sample) {
        DensityVolume::PerComponent volume{std::vector<Rgb>(samples, Rgb(0)), {}};
        volume.density[sample] = Rgb(1);
        return volume;
    };
    const BoxFit fit = fit_box(baked.box, baked.positions, {3}, samples, one_at, {});
    const std::size_t terms = fit.polynomials.terms.size();
    std::vector<std::vector<double>> influence(samples, std::vector<double>(terms));
    for (std::size_t m = 0; m < samples; ++m)
        for (std::size_t t = 0; t < terms; ++t)
            influence[m][t] = fit.polynomials.coefficients[(m * terms + t) * 3];
    return influence;
}

// --- item 11 ---

constexpr double kAlbedo = 0.5;
constexpr uint64_t kSpherePhotons = 20000;

Scene diffuse_sphere() {
    Scene scene = empty_scene(Rgb(float(kAlbedo)));
    add_sphere(scene, Vec3(0), 1, 4, true, false);
    scene.lights.push_back(point_lamp(Vec3(0)));
    scene.lights[0].domain = Box3(Vec3(-0.4f), Vec3(0.4f));
    scene.lights[0].samples = 80;
    scene.grid.resolution = CellCount{8};
    scene.bake.photons = kSpherePhotons;
    return scene;
}

class DiffuseSphere : public testing::Test {
  protected:
    static void SetUpTestSuite() { baked_ = new Baked(bake(diffuse_sphere())); }
    static void TearDownTestSuite() { delete baked_; }

    // Does the patch gather photons enough for Gaussian noise: 30 in each volume on average?
    static bool well_lit(std::size_t patch) {
        const double flux =
            double(baked_->coefficient(patch, kConstantTerm)) * baked_->cells.patches[patch].area;
        return flux * kSpherePhotons > 30;
    }
    static inline const Baked* baked_ = nullptr;
};

// Indirect light does not depend on where the lamp stands: every coefficient but the constant is noise.
TEST_F(DiffuseSphere, NonConstantCoefficientsVanishWithinNoise) {
    const auto influence = influence_of(*baked_);
    Mean squares_per_patch;
    double largest = 0;
    int checks = 0;
    for (std::size_t p = 0; p < baked_->cells.patches.size(); ++p) {
        if (!well_lit(p)) continue;
        double squares = 0;
        for (std::size_t t = 0; t + 1 < std::size_t(kTermCount); ++t, ++checks) {
            double variance = 0;
            for (std::size_t m = 0; m < influence.size(); ++m)
                variance += influence[m][t] * influence[m][t] * baked_->of(m).variance[p];
            const double z = baked_->coefficient(p, t) / std::sqrt(variance);
            largest = std::max(largest, std::abs(z));
            squares += z * z / (kTermCount - 1);
        }
        squares_per_patch.add(squares);
    }
    ASSERT_GT(checks, 2000);
    EXPECT_LT(largest, sigmas(checks));
    // Root mean square 1: patches are nearly independent. Slack: photons that land twice in a patch add 1 %
    // each way.
    expect_mean(squares_per_patch, 1, 0.02);
}

// The constant: rho / ((1 - rho) area) per watt, the polyhedron's own area, in the mean over the sphere.
TEST_F(DiffuseSphere, ConstantIsTheClosedForm) {
    double flux = 0, lit_area = 0;
    for (std::size_t p = 0; p < baked_->cells.patches.size(); ++p) {
        const double e = baked_->coefficient(p, kConstantTerm);
        if (e == 0) continue;  // the outside
        flux += e * baked_->cells.patches[p].area;
        lit_area += baked_->cells.patches[p].area;
    }
    const double surface = total_area(diffuse_sphere().geometry);
    EXPECT_NEAR(lit_area, surface, 1e-5 * surface);  // float roundings
    double influence2 = 0;
    for (const auto& of_sample : influence_of(*baked_))
        influence2 += of_sample[kConstantTerm] * of_sample[kConstantTerm];
    // The number of a photon's landings is geometric, of variance rho / (1 - rho)².
    const double error = std::sqrt(influence2 * kAlbedo / double(kSpherePhotons)) / (1 - kAlbedo);
    EXPECT_NEAR(flux, kAlbedo / (1 - kAlbedo), sigmas() * error);
    EXPECT_LT(sigmas() * error, 0.03);  // the test can see something
}

// --- item 12 ---

// A room without symmetry, a board in it.
Scene crooked_room() {
    Scene scene = room({0.7f, 0.5f, 0.3f}, {1, 1.5f, 0.75f});
    add_box(scene, {0.5f, 0, 0.125f}, {0.75f, 0.5f, 0.5f}, false);
    scene.lights[0].position = {0.3f, 1, 0.4f};
    scene.grid.resolution = CellSize{0.25};
    scene.grid.reachable_area_only = false;  // the same patches, whatever the random numbers
    scene.bake.photons = 100000;
    scene.bake.components = {Component::direct, Component::indirect};
    return scene;
}

struct Traced {
    Cells cells;
    DensityVolume volume;
};

Traced trace(const Scene& scene) {
    const RayCaster caster(scene.geometry, InstructionSet::pinned);
    Cells cells = cells_of(scene, caster);
    const SurfaceCells surface(cells.grid, scene.geometry);
    DensityVolume volume = trace_density(scene, caster, cells, surface, {0, 0, scene.lights[0].position});
    return {std::move(cells), std::move(volume)};
}

template <class Move>
void move_scene(Scene& scene, Move move) {
    for (Vec3& p : scene.geometry.positions) p = move(p);
    for (Light& light : scene.lights) light.position = move(light.position);
}

// Densities of `b` are `scale` times those of `a`, within the noise of both; patches correspond by
// `patch_of`.
template <class PatchOf>
void expect_scaled(const Traced& a, const Traced& b, double scale, PatchOf patch_of) {
    ASSERT_EQ(a.cells.patches.size(), b.cells.patches.size());
    const double checks = 2 * double(a.cells.patches.size());
    for (std::size_t p = 0; p < a.cells.patches.size(); ++p) {
        const int q = patch_of(p);
        ASSERT_GE(q, 0);
        for (const Component c : {Component::direct, Component::indirect}) {
            const auto &from = a.volume.components[int(c)], &to = b.volume.components[int(c)];
            // Below a dozen photons noise is not Gaussian: one photon's weight is added for that. Repeated
            // landings of a photon in a patch add a few per cent to the error.
            const double one = 3 / (100000 * double(a.cells.patches[p].area));
            const double error =
                1.05 * std::sqrt(from.variance[p] * scale * scale + to.variance[std::size_t(q)]);
            for (int channel = 0; channel < 3; ++channel)
                EXPECT_NEAR(
                    to.density[std::size_t(q)][channel], from.density[p][channel] * scale,
                    sigmas(3 * checks) * error * 1.3 + one * scale);  // 1.3: channels spread about their mean
        }
    }
}

TEST(ScalingLaws, TwiceTheLengthsAQuarterOfTheIrradiance) {
    Scene large = crooked_room();
    move_scene(large, [](const Vec3& p) { return p * 2; });
    large.grid.resolution = CellSize{0.5};
    const Traced a = trace(crooked_room()), b = trace(large);
    expect_scaled(a, b, 0.25, [](std::size_t p) { return int(p); });
    // Powers of two scale every float exactly: the same photons meet the same places.
    for (std::size_t p = 0; p < a.cells.patches.size(); ++p)
        EXPECT_NEAR(b.volume.components[1].density[p].x, a.volume.components[1].density[p].x / 4,
                    1e-6f * a.volume.components[1].density[p].x);
}

TEST(ScalingLaws, AMovedSceneLooksTheSame) {
    Scene moved = crooked_room();
    move_scene(moved, [](const Vec3& p) { return p + Vec3(3, -7, 5.5f); });
    expect_scaled(trace(crooked_room()), trace(moved), 1, [](std::size_t p) { return int(p); });
}

// Turned by 90° about y: (x, y, z) -> (z, y, w - x), w the room's width. Cells and facings turn with it.
TEST(ScalingLaws, ATurnedSceneLooksTheSame) {
    constexpr float kWidth = 1;
    Scene turned = crooked_room();
    move_scene(turned, [](const Vec3& p) { return Vec3(p.z, p.y, kWidth - p.x); });
    turned.bake.seed = 2;
    const Traced a = trace(crooked_room()), b = trace(turned);
    constexpr int kTurned[kFacingCount] = {5, 4, 2, 3, 0, 1};  // px -> nz, nx -> pz, pz -> px, nz -> nx
    expect_scaled(a, b, 1, [&](std::size_t p) {
        const Patch& patch = a.cells.patches[p];
        const Index3 cell(patch.cell.z, patch.cell.y, a.cells.grid.size.x - 1 - patch.cell.x);
        const int layer = patch.slot / kFacingCount * kFacingCount;
        return b.cells.index.find(cell, kTurned[patch.slot % kFacingCount] + layer);
    });
}

TEST(ScalingLaws, DensityIsPerWatt) {
    Scene strong = crooked_room();
    strong.lights[0].power = {7, 8, 9};
    EXPECT_EQ(trace(crooked_room()).volume.components[1].density, trace(strong).volume.components[1].density);
}

// A map of two lamps, polynomials at random.
IlluminationMap two_lamps() {
    IlluminationMap map;
    map.grid.size = Index3(4);
    for (int x = 0; x < 4; ++x) map.patches.push_back({{x, 0, 0}, 2, 1, Vec3(0)});
    map.index = PatchIndex(map.grid, map.patches);
    map.components = {Component::indirect};
    RandomStream random(1, RandomPurpose::evaluation, 0, 0);
    for (int l = 0; l < 2; ++l) {
        MapLight light;
        light.name = "lamp " + std::to_string(l);
        light.domain = Box3(Vec3(-1), Vec3(2));
        light.boxes = split_domain(light.domain, Index3(2, 1, 1));
        for (std::size_t b = 0; b < light.boxes.size(); ++b) {
            Polynomials p{terms_of(3, {true, true, true}), std::vector<float>(4 * kTermCount * 3),
                          std::vector<float>(4), {}};
            for (float& c : p.coefficients) c = 0.1f * random.next();
            for (std::size_t i = 0; i < 4; ++i)  // positive everywhere: nothing is cut to 0
                for (std::size_t c = 0; c < 3; ++c)
                    p.coefficients[(i * kTermCount + kConstantTerm) * 3 + c] = 2;
            light.polynomials.emplace_back()[int(Component::indirect)] = p;
        }
        map.lights.push_back(light);
    }
    return map;
}

TEST(ScalingLaws, LampsAddAndPowerMultiplies) {
    const IlluminationMap map = two_lamps();
    const LightState one{{0.2f, 0.3f, -0.4f}, {1, 2, 3}}, other{{1.5f, 0, 1}, {4, 5, 6}};
    const auto with = [&](const Rgb& first, const Rgb& second) {
        return patch_irradiance(map, {Component::indirect},
                                {{one.position, one.power * first}, {other.position, other.power * second}});
    };
    const auto both = with(Rgb(1), Rgb(1)), only_one = with(Rgb(1), Rgb(0)),
               only_other = with(Rgb(0), Rgb(1));
    const auto strong = with(Rgb(10), Rgb(10));
    for (std::size_t p = 0; p < both.size(); ++p)
        for (int c = 0; c < 3; ++c) {
            const float rounding = 50 * 0x1p-24f * both[p][c];  // twenty products and sums, twice
            EXPECT_NEAR(both[p][c], only_one[p][c] + only_other[p][c], rounding);
            EXPECT_NEAR(strong[p][c], 10 * both[p][c], 10 * rounding);
            EXPECT_GT(only_one[p][c], 0);
        }
}

}  // namespace
}  // namespace pim
