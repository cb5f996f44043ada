// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/density.h"

#include "common/core/parallel.h"
#include "statistics.h"
#include "test_scenes.h"

namespace pim {
namespace {

struct Traced {
    Cells cells;
    DensityVolume volume;

    const std::vector<Rgb>& density(Component c) const { return volume.components[int(c)].density; }
    const std::vector<float>& variance(Component c) const { return volume.components[int(c)].variance; }
    double flux(Component c) const {  // of the first channel, in all patches
        double sum = 0;
        for (std::size_t p = 0; p < cells.patches.size(); ++p)
            sum += double(density(c)[p].x) * cells.patches[p].area;
        return sum;
    }
};

Traced trace(const Scene& scene, Cells cells) {
    const RayCaster caster(scene.geometry, InstructionSet::pinned);
    const SurfaceCells surface(cells.grid, scene.geometry);
    DensityVolume volume = trace_density(scene, caster, cells, surface, {0, 0, scene.lights[0].position});
    return {std::move(cells), std::move(volume)};
}

Cells cells_of(Scene scene) {
    scene.grid.reach_photons = uint64_t{1} << 18;
    const RayCaster caster(scene.geometry, InstructionSet::pinned);
    return find_cells(scene, caster, [](const Vec3&) { return true; });
}

Traced trace(const Scene& scene) { return trace(scene, cells_of(scene)); }

Scene with_settings(Scene scene, int cells, uint64_t photons, std::vector<Component> components) {
    scene.grid.resolution = CellCount{cells};
    scene.bake.photons = photons;
    scene.bake.components = std::move(components);
    return scene;
}

// Share of a point lamp's flux on the rectangle from (0,0) to (a,b) at distance h, signs of a and b kept.
double flux_from_corner(double a, double b, double h) {
    return std::atan(a * b / (h * std::sqrt(a * a + b * b + h * h))) / (4 * M_PI);
}

double flux_on(double x0, double x1, double z0, double z1, double h) {
    return flux_from_corner(x1, z1, h) - flux_from_corner(x0, z1, h) - flux_from_corner(x1, z0, h) +
           flux_from_corner(x0, z0, h);
}

// Item 1: every cell of a plane. Counts are binomial.
TEST(Density, PlaneUnderAPointLamp) {
    constexpr uint64_t kPhotons = 400000;
    Scene scene = with_settings(plane_under_lamp(2, 1), 8, kPhotons, {Component::direct});
    scene.lights[0].position = {0.3f, 1, -0.2f};
    const Traced traced = trace(scene);
    int lit = 0;
    for (std::size_t p = 0; p < traced.cells.patches.size(); ++p) {
        const Patch& patch = traced.cells.patches[p];
        if (patch.slot != 2) continue;
        ++lit;
        const double x = -1 + 0.25 * patch.cell.x - 0.3, z = -1 + 0.25 * patch.cell.z + 0.2;
        const double share = flux_on(x, x + 0.25, z, z + 0.25, 1);
        const double error = std::sqrt(share * (1 - share) / double(kPhotons));
        EXPECT_NEAR(traced.density(Component::direct)[p].x * patch.area, share, sigmas(64) * error);
        const double variance = traced.variance(Component::direct)[p] * patch.area * patch.area;
        EXPECT_NEAR(variance, error * error,
                    0.1 * error * error);  // its own noise: 1/sqrt(1000 photons), three times
    }
    EXPECT_EQ(lit, 64);
}

TEST(Density, DirectAndIndirectFluxOfARoom) {  // 1 and rho / (1 - rho)
    const Traced traced =
        trace(with_settings(room({0.7f, 0.5f, 0.0f}), 4, 200000, {Component::direct, Component::indirect}));
    EXPECT_NEAR(traced.flux(Component::direct), 1, 1e-5);  // every photon lands once; float roundings
    const double rho = 0.7,
                 error = std::sqrt(rho / 200000) / (1 - rho);  // of a geometric distribution's mean
    EXPECT_NEAR(traced.flux(Component::indirect), rho / (1 - rho), sigmas() * error);
    for (const Rgb& e : traced.density(Component::indirect)) EXPECT_EQ(e.z, 0);
}

// Landings at every diffuse hit, or where photons end: the same E, patch by patch.
TEST(Density, BothWaysToStoreAgree) {
    Scene incident = with_settings(room(Rgb(0.6f)), 4, 400000, {Component::indirect}), absorbed = incident;
    absorbed.bake.store = Store::absorbed;
    absorbed.bake.seed = 2;
    const Traced a = trace(incident), b = trace(absorbed);
    ASSERT_EQ(a.cells.patches.size(), b.cells.patches.size());
    for (std::size_t p = 0; p < a.cells.patches.size(); ++p) {
        const double variance = a.variance(Component::indirect)[p] + b.variance(Component::indirect)[p];
        // Sums of squared weights leave out that one photon may land twice in a patch: a few per cent of 192
        // patches.
        const double error = 1.05 * std::sqrt(variance);
        EXPECT_NEAR(a.density(Component::indirect)[p].x, b.density(Component::indirect)[p].x,
                    sigmas(192) * error);
    }
}

// `variance` is the variance: the same patches with many seeds.
TEST(Density, VarianceIsThatOfRepeatedBakes) {
    Scene scene = with_settings(room(Rgb(0.6f)), 2, 2000, {Component::indirect});
    std::vector<std::vector<double>> values;
    std::vector<double> said;
    const Cells cells = cells_of(scene);
    for (uint64_t seed = 1; seed <= 100; ++seed) {
        scene.bake.seed = seed;
        const Traced traced = trace(scene, cells);
        values.resize(traced.cells.patches.size());
        said.resize(values.size());
        for (std::size_t p = 0; p < values.size(); ++p) {
            values[p].push_back(traced.density(Component::indirect)[p].x);
            said[p] += traced.variance(Component::indirect)[p] / 100;
        }
    }
    double ratio = 0, lit = 0;
    for (std::size_t p = 0; p < values.size(); ++p) {
        Mean mean;
        for (const double v : values[p]) mean.add(v);
        if (said[p] > 0) ratio += 100 * mean.standard_error() * mean.standard_error() / said[p], ++lit;
    }
    // 24 patches × 99 degrees of freedom: 3 %; landings of one photon that share a patch add up to 15 %.
    EXPECT_NEAR(ratio / lit, 1.075, 0.075 + 4 * 0.03);
}

// --- the thesis' estimator: photons within r of the centre / (pi r²) ---

// The cell under the lamp; the sphere cuts a disk out of the plane.
double expected_by_sphere(double radius, double above) {
    const double disk2 = radius * radius - above * above;
    return 0.5 * (1 - 1 / std::sqrt(1 + disk2)) / (M_PI * radius * radius);
}

Scene sphere_scene(bool facings) {
    Scene scene = with_settings(plane_under_lamp(2, 1), 9, 400000, {Component::direct});
    scene.grid.estimator = Estimator::sphere;
    scene.grid.radius = 0.3;
    scene.grid.facings = facings;
    return scene;
}

void expect_sphere_estimate(const Scene& scene) {
    const Traced traced = trace(scene);
    const int slot = scene.grid.facings ? 2 : 0;
    const int patch = traced.cells.index.find({4, 0, 4}, slot);
    ASSERT_GE(patch, 0);
    const double expected = expected_by_sphere(0.3, 1.0 / 9), area = M_PI * 0.3 * 0.3;
    const double error = std::sqrt(expected * area / 400000) / area;
    EXPECT_NEAR(traced.density(Component::direct)[std::size_t(patch)].x, expected, sigmas(2) * error);
}

TEST(Density, SphereEstimatorOnAPlane) { expect_sphere_estimate(sphere_scene(false)); }

// The floor's dark underside in the same cell must not change what its upper side receives.
TEST(Density, SphereEstimatorOnAPlaneWithFacings) { expect_sphere_estimate(sphere_scene(true)); }

// --- the grid's own border ---

// Bounds that cut through a surface: flux and area must both end there.
TEST(Density, BoundsThroughASurface) {
    constexpr uint64_t kPhotons = 2000000;
    Scene scene = with_settings(plane_under_lamp(4, 1), 2, kPhotons, {Component::direct});
    scene.grid.bounds = Box3(Vec3(-0.5f, -0.25f, -0.5f), Vec3(0.5f, 0.75f, 0.5f));
    const Traced traced = trace(scene);
    const double share = flux_on(-0.5, 0.5, -0.5, 0.5, 1);
    EXPECT_NEAR(traced.flux(Component::direct), share,
                sigmas() * std::sqrt(share * (1 - share) / double(kPhotons)));
}

TEST(Density,
     FloorOnABorderBetweenCells) {  // the trap of torn floors: nothing is lost, whatever the rounding
    Scene scene = with_settings(plane_under_lamp(2, 1), 4, 200000, {Component::direct});
    for (Vec3& p : scene.geometry.positions) p.y = 0.1f;
    scene.lights[0].position = {0, 1.1f, 0};
    scene.grid.resolution = CellSize{0.1};
    scene.grid.bounds =
        Box3(Vec3(-1, -0.3f, -1), Vec3(1, 0.5f, 1));  // cells of 0.1: a border at 0.1, in rounding
    const Traced traced = trace(scene);
    const double share = flux_on(-1, 1, -1, 1, 1);
    EXPECT_NEAR(traced.flux(Component::direct), share, sigmas() * std::sqrt(share * (1 - share) / 200000));
    for (const Patch& p : traced.cells.patches) EXPECT_EQ(p.cell.y, p.slot == 2 ? 4 : 3);
}

// --- reproducible ---

TEST(Density, SameBytesAtAnyThreadCount) {
    for (const Estimator estimator : {Estimator::area, Estimator::sphere}) {
        Scene scene =
            with_settings(room({0.7f, 0.5f, 0.3f}), 4, 1200000, {Component::indirect});  // three chunks
        scene.grid.estimator = estimator;
        if (estimator == Estimator::sphere) scene.bake.photons = 550000;  // two, k-d tree queries are slow
        const auto with = [&](int threads) {
            const ThreadLimit limit(threads);
            return trace(scene);
        };
        const Traced one = with(1), four = with(4);
        EXPECT_EQ(one.density(Component::indirect), four.density(Component::indirect));
        EXPECT_EQ(one.variance(Component::indirect), four.variance(Component::indirect));
        EXPECT_EQ(one.volume.account.absorbed_flux, four.volume.account.absorbed_flux);
    }
}

}  // namespace
}  // namespace pim
