// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/render/photon_map.h"

#include "common/core/parallel.h"
#include "common/core/sampling.h"
#include "statistics.h"
#include "test_scenes.h"

namespace pim {
namespace {

PathScene lit(const Scene& scene, const RayCaster& caster) {
    PathScene s{scene, caster, {}, false};
    for (const Light& light : scene.lights) s.lights.push_back({light.position, light.power});
    return s;
}

ShotPhotons shoot_all(const Scene& scene, uint64_t photons, uint64_t seed = 1) {
    const RayCaster caster(scene.geometry, InstructionSet::pinned);
    return shoot_photons(lit(scene, caster), photons, seed);
}

Vec3d flux_of(const std::vector<StoredPhoton>& photons) {
    Vec3d sum(0);
    for (const StoredPhoton& p : photons) sum += Vec3d(p.flux);
    return sum;
}

// --- shooting ---

TEST(ShootPhotons, FluxIsConserved) {  // power / (1 - rho) lands in a closed room, all told
    const double rho[3] = {0.8, 0.5, 0.2}, power[3] = {3, 2, 1};
    Scene scene = room({0.8f, 0.5f, 0.2f});
    scene.lights[0].power = {3, 2, 1};
    constexpr int kPhotons = 100000;
    const ShotPhotons shot = shoot_all(scene, kPhotons);
    EXPECT_TRUE(shot.caustic.empty());
    EXPECT_NEAR(double(shot.straight.size()), kPhotons, 5);  // but for edges
    const Vec3d straight = flux_of(shot.straight), diffuse = flux_of(shot.diffuse);
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(straight[c], power[c], 1e-4 * power[c]);
        // Roulette follows the channel of 0.8: the photon goes on with that chance, the others' weights
        // fall by r = rho / 0.8 each time. The sum of weights over landings after the first is S with
        // S = 0 by 0.2, else r (1 + S'): mean m = rho/(1 - rho), second moment 0.8 r² (1 + 2 m) / (1 - 0.8
        // r²).
        const double r = rho[c] / 0.8, m = rho[c] / (1 - rho[c]);
        const double second = 0.8 * r * r * (1 + 2 * m) / (1 - 0.8 * r * r);
        const double error = power[c] * std::sqrt((second - m * m) / kPhotons);
        EXPECT_NEAR(diffuse[c], power[c] * m, sigmas(3) * error + 1e-4 * power[c]);
    }
}

TEST(ShootPhotons, LampsShareInProportionToPower) {
    Scene scene = room(Rgb(0.5f));
    scene.lights.push_back(point_lamp({0.7f, 0.7f, 0.7f}, Rgb(3)));
    scene.lights.push_back(point_lamp({0.2f, 0.2f, 0.2f}, Rgb(0)));
    const ShotPhotons shot = shoot_all(scene, 10000);
    EXPECT_NEAR(double(shot.straight.size()), 20000, 3);  // a lamp that is off gets none
    EXPECT_NEAR(flux_of(shot.straight).x, 4, 1e-3);
    for (const StoredPhoton& p : shot.straight) EXPECT_NEAR(p.flux.x, 4.0 / 20000, 1e-9);
}

TEST(ShootPhotons, CausticsHaveMetMirrorsAndGlassAlone) {
    Scene scene = empty_scene(Rgb(0.5f));
    add_quad(scene, {-4, 0, -4}, {0, 0, 8}, {8, 0, 0});
    scene.lights.push_back(point_lamp({0, 3, 0}));
    EXPECT_TRUE(shoot_all(scene, 10000).caustic.empty());
    EXPECT_TRUE(shoot_all(scene, 10000).diffuse.empty());  // one plane: nothing lands twice
    scene.materials.push_back(mirror_material(Rgb(0.9f)));
    add_quad(scene, {-4, 4, -4}, {8, 0, 0}, {0, 0, 8}, 1);  // a mirror above the lamp
    const ShotPhotons shot = shoot_all(scene, 10000);
    EXPECT_FALSE(shot.caustic.empty());
    for (const StoredPhoton& p : shot.caustic) EXPECT_NEAR(p.flux.x, 1e-4, 1e-8);  // 0.9 by roulette
    EXPECT_FALSE(shot.diffuse.empty());  // by way of the floor and the mirror
    for (const StoredPhoton& p : shot.caustic) EXPECT_EQ(p.position.y, 0);
}

TEST(ShootPhotons, SamePhotonsAtAnyThreadCount) {
    Scene scene = room(Rgb(0.6f));
    scene.lights.push_back(point_lamp({0.7f, 0.7f, 0.7f}, Rgb(2)));
    const ShotPhotons all = shoot_all(scene, 20000);
    for (const int threads : {1, 2, 4}) {
        const ThreadLimit limit(threads);
        const ShotPhotons shot = shoot_all(scene, 20000);
        ASSERT_EQ(shot.diffuse.size(), all.diffuse.size());
        for (std::size_t i = 0; i < all.diffuse.size(); ++i) {
            ASSERT_EQ(shot.diffuse[i].position, all.diffuse[i].position);
            ASSERT_EQ(shot.diffuse[i].flux, all.diffuse[i].flux);
        }
    }
}

// --- estimates ---

// Photons of 1 / count W at random places of a horizontal square of side 1, facing up.
std::vector<StoredPhoton> on_a_square(int count, uint64_t seed) {
    RandomStream random(seed, RandomPurpose::evaluation, 0, 0);
    std::vector<StoredPhoton> photons;
    for (int i = 0; i < count; ++i) {
        const float x = random.next(), z = random.next();
        photons.push_back({{x, 0, z}, {0, 1, 0}, Rgb(1, 2, 3) / float(count)});
    }
    return photons;
}

// E = 1 W/m² in the mean, without the k/(k - 1) = 1.25 that counting the farthest photon would give; by cone
// too.
TEST(PhotonMap, UnbiasedWhereLightIsEven) {
    for (const Filter filter : {Filter::none, Filter::cone}) {
        Mean mean;
        for (uint64_t seed = 1; seed <= 2000; ++seed) {
            const PhotonMap map(on_a_square(400, seed), 5, filter);
            mean.add(map.irradiance({0.5f, 0, 0.5f}, {0, 1, 0}).x);
        }
        expect_mean(mean, 1, 0, 2);
        EXPECT_LT(sigmas(2) * mean.standard_error(), 0.1);  // the test can see something
    }
}

// Dim places use all photons within the greatest radius; so does a map of fewer photons than are asked for.
TEST(PhotonMap, FewerPhotonsThanAskedFor) {
    const std::vector<StoredPhoton> one{{{0, 0, 0}, {0, 1, 0}, Rgb(1)}, {{1, 0, 0}, {0, 1, 0}, Rgb(1)}};
    const PhotonMap map(one, 50, Filter::none);
    EXPECT_FLOAT_EQ(map.greatest_radius(), 2);  // twice the distance between them
    EXPECT_FLOAT_EQ(map.irradiance({0, 0, 0}, {0, 1, 0}).x, float(2 / (M_PI * 4)));
    EXPECT_FLOAT_EQ(map.irradiance({-1.5f, 0, 0}, {0, 1, 0}).x, float(1 / (M_PI * 4)));
    EXPECT_EQ(map.irradiance({9, 0, 0}, {0, 1, 0}), Rgb(0));
    EXPECT_EQ(PhotonMap({}, 50, Filter::cone).irradiance(Vec3(0), {0, 1, 0}), Rgb(0));
    const std::vector<StoredPhoton> same(60, one[0]);  // all in one place: no radius, no estimate
    EXPECT_EQ(PhotonMap(same, 50, Filter::none).irradiance({0, 0, 0}, {0, 1, 0}), Rgb(0));
}

TEST(PhotonMap, OnlyPhotonsOnTheSameSideCount) {
    const auto front = on_a_square(2000, 1);
    const PhotonMap alone(front, 50, Filter::none);
    auto all = front;
    for (const Vec3& normal : {Vec3(0, -1, 0), Vec3(1, 0, 0), Vec3(0, 0, -1)})
        for (StoredPhoton p : on_a_square(2000, 2)) {
            p.normal = normal;
            all.push_back(p);
        }
    const PhotonMap mixed(all, 50, Filter::none);
    for (const Vec3& at : {Vec3(0.5f, 0, 0.5f), Vec3(0.3f, 0.01f, 0.6f)}) {
        const Rgb expected = alone.irradiance(at, {0, 1, 0}), found = mixed.irradiance(at, {0, 1, 0});
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(found[c], expected[c], 1e-5 * expected[c]);  // order of the sum
    }
}

TEST(PhotonMap, NearbyIrradianceIsThatOfThePhotonBeside) {
    const auto photons = on_a_square(500, 1);
    PhotonMap map(photons, 20, Filter::none);
    map.precompute_irradiance();
    for (const StoredPhoton& p : photons)
        EXPECT_EQ(map.nearby_irradiance(p.position, p.normal), map.irradiance(p.position, p.normal));
    EXPECT_EQ(map.nearby_irradiance(photons[0].position, {0, -1, 0}), Rgb(0));
}

// --- scenes with a closed form ---

// Indirect light of a diffuse sphere: rho power / ((1 - rho) area) everywhere. The cap of a sphere within
// the distance r of a point has the area pi r², so there is no bias from curvature.
TEST(PhotonMap, IndirectLightOfASphere) {
    const double rho = 0.5, power = 3;
    Scene scene = empty_scene(Rgb(float(rho)));
    add_sphere(scene, Vec3(0), 1, 4, true, false);
    scene.lights.push_back(point_lamp({0.3f, -0.4f, 0.2f}, Rgb(float(power))));
    const double expected = rho * power / ((1 - rho) * total_area(scene.geometry));
    const RayCaster caster(scene.geometry, InstructionSet::pinned);
    const ShotPhotons shot = shoot_photons(lit(scene, caster), 200000, 1);
    for (const Filter filter : {Filter::none, Filter::cone}) {
        const PhotonMap map(shot.diffuse, 10, filter);
        Mean mean;  // places far apart: 2000 disks of 10 photons among 200,000
        for (uint64_t i = 0; i < 2000; ++i) {
            RandomStream random(1, RandomPurpose::evaluation, 0, i);
            const float u = random.next(), v = random.next();
            const SurfacePoint s = surface_seen(scene, caster, Vec3(0), sample_sphere(u, v));
            mean.add(map.irradiance(s.position, s.geometric_normal).x);
        }
        expect_mean(mean, expected, 2e-3 * expected, 2);  // slack: facets are nearer than the sphere, 0.1 %
    }
}

// Two lamps over and under a plane: E = power / (4 pi h²) on each side, of its own lamp.
TEST(PhotonMap, BothSidesOfAPlane) {
    Scene scene = plane_under_lamp(8, 1);
    scene.lights[0].power = Rgb(1);
    scene.lights.push_back(point_lamp({0, -1, 0}, Rgb(4)));
    Mean above, below;
    for (uint64_t seed = 1; seed <= 100; ++seed) {
        const PhotonMap map(shoot_all(scene, 20000, seed).straight, 100, Filter::none);
        above.add(4 * M_PI * map.irradiance(Vec3(0), {0, 1, 0}).x);
        below.add(M_PI * map.irradiance(Vec3(0), {0, -1, 0}).x);
    }
    // The mean over a disk of radius r is smaller by 3/4 r²/h²; r² = 100 / (pi n), with n photons per m²
    // below the lamp: 1/5 and 4/5 of 40,000 over 4 pi.
    expect_mean(above, 1, 0.75 * 100 / (M_PI * 8000 / (4 * M_PI)), 2);
    expect_mean(below, 1, 0.75 * 100 / (M_PI * 32000 / (4 * M_PI)), 2);
}

}  // namespace
}  // namespace pim
