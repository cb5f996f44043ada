// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/sample_photons.h"

#include <set>

#include "statistics.h"
#include "test_scenes.h"

namespace pim {
namespace {

Scene indirect_room() {
    Scene scene = room(Rgb(0.5f));
    scene.bake.components = {Component::indirect};
    return scene;
}

TEST(SamplePhotons, SharedStartsWhereTheFirstLandingBringsNothing) {
    Scene scene = indirect_room();
    EXPECT_EQ(photons_of_a_start(scene), kPhotonsOfAStart);
    scene.bake.components = {Component::direct, Component::indirect};
    EXPECT_EQ(photons_of_a_start(scene), 1);
    scene = indirect_room();
    scene.materials.push_back(mirror_material(Rgb(0.8f)));
    EXPECT_EQ(photons_of_a_start(scene), 1);
    scene.materials.back() = glass_material(1.5f);
    EXPECT_EQ(photons_of_a_start(scene), 1);
}

struct Tracer {
    Scene scene;
    RayCaster caster{scene.geometry, InstructionSet::pinned};
    LightSample sample{0, 3, scene.lights[0].position};
    SamplePhotons photons{scene, caster, sample};

    explicit Tracer(Scene s) : scene(std::move(s)) {}
};

// Analytic, item 9: of a photon's flux rho/(1 - rho) lands after the first surface. Photons of a start are
// one draw.
TEST(SamplePhotons, LightAfterTheFirstSurfaceIsAsMuch) {
    const Tracer tracer(indirect_room());
    Mean flux;
    EnergyAccount account;
    for (uint64_t start = 0; start < 5000; ++start) {
        double landed = 0;
        const auto add = [&](const Landing& l) { landed += l.straight ? 0 : double(l.flux.x); };
        tracer.photons.trace(start * kPhotonsOfAStart, (start + 1) * kPhotonsOfAStart, add, account);
        flux.add(landed / kPhotonsOfAStart);
    }
    EXPECT_NEAR(flux.value(), 1, sigmas() * flux.standard_error());
    EXPECT_EQ(account.emitted, 5000u * kPhotonsOfAStart);
    EXPECT_EQ(account.emitted, account.absorbed + account.escaped + account.cut_off);
}

// Which photon is which does not depend on how they are cut into parts, nor does a last start with fewer.
TEST(SamplePhotons, PartsMakeTheWhole) {
    const Tracer tracer(indirect_room());
    const auto places = [&](std::initializer_list<std::pair<uint64_t, uint64_t>> parts) {
        std::vector<std::pair<float, bool>> found;
        EnergyAccount account;
        for (const auto& [begin, end] : parts)
            tracer.photons.trace(
                begin, end, [&](const Landing& l) { found.emplace_back(l.surface.position.x, l.straight); },
                account);
        return found;
    };
    const auto whole = places({{0, 101}});
    EXPECT_TRUE(whole == places({{0, 16}, {16, 96}, {96, 101}}));
    std::set<float> starts;
    std::size_t straight = 0;
    for (const auto& [x, first] : whole)
        if (first) starts.insert(x), ++straight;
    EXPECT_EQ(straight, 101u);
    EXPECT_LE(starts.size(), 13u);
    EXPECT_GE(starts.size(), 10u);  // two walls of six are at one x each
}

}  // namespace
}  // namespace pim
