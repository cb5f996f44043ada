// SPDX-License-Identifier: GPL-3.0-or-later
// Items 9 and 1 of the list of answers known in advance, and the account of energy in scenes of every kind.
#include "common/transport/photon.h"

#include "statistics.h"
#include "test_scenes.h"

namespace pim {
namespace {

struct ByOrder {
    std::vector<Mean> flux;  // landed on the first k + 1 surfaces, per photon
    Mean all;
};

ByOrder landed_flux(const Scene& scene, uint64_t photons, int orders) {
    ByOrder result;
    result.flux.resize(std::size_t(orders));
    std::vector<double> landed(std::size_t(orders), 0.0);
    double total = 0;
    shoot(
        scene, photons,
        [&](const Landing& l) {
            total += l.flux.x;
            for (int k = l.surfaces_met; k < orders; ++k) landed[std::size_t(k)] += l.flux.x;
        },
        [&] {
            result.all.add(total);
            for (std::size_t k = 0; k < landed.size(); ++k) result.flux[k].add(landed[k]);
            total = 0;
            landed.assign(landed.size(), 0);
        });
    return result;
}

// Landed flux after n reflections is (1 - rho^(n+1)) / (1 - rho), in the end 1 / (1 - rho), whatever the
// shape.
TEST(Photon, ClosedBoxIsAGeometricSeries) {
    for (const float rho : {0.0f, 0.5f, 0.9f}) {
        const ByOrder landed = landed_flux(room(Rgb(rho), {1, 2, 3}), 100000, 4);
        for (std::size_t n = 0; n < 4; ++n)
            expect_mean(landed.flux[n], rho > 0 ? (1 - std::pow(rho, double(n + 1))) / (1 - rho) : 1, 1e-6,
                        15);
        expect_mean(landed.all, 1 / (1 - double(rho)), 1e-6, 15);
    }
}

TEST(Photon, CountersAndFlagsOfALanding) {
    Scene scene = room(Rgb(0.5f));
    scene.materials.push_back(mirror_material(Rgb(0.9f)));
    for (std::size_t t = 0; t < 4; ++t) scene.geometry.triangles[t].material = 1;
    int met = 0;
    bool begins_at_mirror = false;
    shoot(
        scene, 2000,
        [&](const Landing& l) {
            EXPECT_EQ(l.surfaces_met, met);
            EXPECT_EQ(l.straight, met == 0);
            EXPECT_EQ(l.begins_specular, begins_at_mirror);
            EXPECT_NEAR(l.direction.length(), 1, 1e-6);
            EXPECT_NEAR(l.chance_of_ending, 1 - max_channel(l.surface.diffuse + l.surface.specular), 1e-6);
            if (met++ == 0) begins_at_mirror = l.surface.material == &scene.materials[1];
        },
        [&] { met = 0, begins_at_mirror = false; });
}

// `store` = "absorbed" rests on this: landed flux where photons end, divided by their chance, is all landed
// flux.
TEST(Photon, EndingsStandForAllLandings) {
    Mean all, ends;
    double landed = 0, ended = 0;
    shoot(
        room(Rgb(0.7f)), 100000,
        [&](const Landing& l) {
            landed += l.flux.x;
            if (l.ends) ended += l.flux.x / l.chance_of_ending;
        },
        [&] {
            all.add(landed), ends.add(ended);
            landed = ended = 0;
        });
    expect_mean(all, 1 / 0.3, 1e-6, 2);
    expect_mean(ends, 1 / 0.3, 1e-6, 2);
}

// Flux on a rectangle a × b whose corner lies below the lamp: atan(ab / (h sqrt(a² + b² + h²))) / 4 pi.
TEST(Photon, PointLampOverARectangle) {
    Scene scene = empty_scene(Rgb(0));
    add_quad(scene, Vec3(0), {0, 0, 3}, {2, 0, 0});
    scene.lights.push_back(point_lamp({0, 1.5f, 0}));
    const ByOrder landed = landed_flux(scene, 200000, 1);
    expect_mean(landed.all, std::atan(6 / (1.5 * std::sqrt(4 + 9 + 2.25))) / (4 * M_PI));
}

TEST(Photon, PointLampOverADisk) {  // (1 - h / sqrt(h² + R²)) / 2
    const Scene scene = plane_under_lamp(10, 1);
    Mean on_disk;
    double landed = 0;
    shoot(
        scene, 200000,
        [&](const Landing& l) {
            if (l.straight && std::hypot(l.surface.position.x, l.surface.position.z) < 2) landed += l.flux.x;
        },
        [&] { on_disk.add(std::exchange(landed, 0)); });
    expect_mean(on_disk, 0.5 * (1 - 1 / std::sqrt(5.0)));
}

TEST(Photon, CubesCentreLightsItsFacesAlike) {
    const Scene scene = room(Rgb(0), Vec3(2), Vec3(0.5f));
    std::vector<long> faces(6);
    shoot(
        scene, 60000, [&](const Landing& l) { ++faces[l.surface.triangle / 2]; }, [] {});
    EXPECT_LT(chi_squared(faces), chi_squared_bound(5));
}

// --- the account of energy ---

void expect_closed(const Scene& scene, uint64_t photons = 50000) {
    const EnergyAccount a = shoot(
        scene, photons, [](const Landing&) {}, [] {});
    EXPECT_EQ(a.emitted, photons);
    EXPECT_EQ(a.absorbed + a.escaped + a.cut_off, a.emitted);
    const Vec3d mean = a.total_flux() / double(photons), error = a.standard_error();
    // 4 standard errors and the rounding of up to a thousand float products: a false alarm once in 16,000
    // runs.
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(mean[c], 1, 4 * error[c] + 1e-5);
}

TEST(EnergyAccount, ClosesInAColouredRoom) { expect_closed(room({0.9f, 0.5f, 0.1f})); }

TEST(EnergyAccount, ClosesInAnOpenScene) {
    const Scene scene = plane_under_lamp(1, 0.5f);
    expect_closed(scene);
    const EnergyAccount a = shoot(
        scene, 50000, [](const Landing&) {}, [] {});
    EXPECT_GT(a.escaped, a.absorbed);
}

TEST(EnergyAccount, ClosesWithMirrorsAndGlass) {
    Scene scene = room({0.6f, 0.7f, 0.8f});
    scene.materials.push_back(mirror_material({0.9f, 0.8f, 0.7f}));
    scene.materials.push_back(glass_material(1.5f));
    Material glossy = diffuse_material({0.2f, 0.3f, 0.4f});
    glossy.specular = {0.5f, 0.4f, 0.3f};
    scene.materials.push_back(glossy);
    add_box(scene, {0.6f, 0.1f, 0.6f}, {0.9f, 0.4f, 0.9f}, false, 1);
    add_sphere(scene, {0.3f, 0.25f, 0.7f}, 0.2f, 2, false, false, 2);
    for (std::size_t t = 4; t < 8; ++t) scene.geometry.triangles[t].material = 3;
    expect_closed(scene);
}

TEST(EnergyAccount, ClosesWithSmoothNormals) {
    for (const uint32_t material : {0u, 1u, 2u}) {
        Scene scene = room({0.6f, 0.7f, 0.8f});
        scene.materials.push_back(mirror_material(Rgb(0.9f)));
        scene.materials.push_back(glass_material(1.5f));
        add_sphere(scene, {0.5f, 0.3f, 0.7f}, 0.25f, 1, false, true, material);
        expect_closed(scene);
    }
}

TEST(EnergyAccount, NamesWhatIsCutOff) {  // nothing but perfect mirrors: every photon runs for ever
    Scene scene = empty_scene();
    scene.materials[0] = mirror_material(Rgb(1));
    add_box(scene, Vec3(0), Vec3(1), true);
    scene.lights.push_back(point_lamp(Vec3(0.5f)));
    const EnergyAccount a = shoot(
        scene, 200, [](const Landing&) {}, [] {});
    EXPECT_EQ(a.cut_off, 200u);
    EXPECT_NEAR(a.cut_off_flux.x, 200, 1e-2);  // a thousand roundings each
}

TEST(EnergyAccount, AddsUp) {
    EnergyAccount a = shoot(
        room(Rgb(0.5f)), 1000, [](const Landing&) {}, [] {}, 1);
    const EnergyAccount b = shoot(
        room(Rgb(0.5f)), 2000, [](const Landing&) {}, [] {}, 2);
    const uint64_t absorbed = a.absorbed;
    a.add(b);
    EXPECT_EQ(a.emitted, 3000u);
    EXPECT_EQ(a.absorbed, absorbed + b.absorbed);
}

}  // namespace
}  // namespace pim
