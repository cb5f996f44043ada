// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/held_out.h"

#include <gtest/gtest.h>

#include "bake/tracing.h"
#include "statistics.h"
#include "test_scenes.h"

namespace pim {
namespace {

// A unit room, the lamp roaming its middle, seen from a corner.
Scene roamed_room() {
    Scene scene = room(Rgb(0.6f, 0.5f, 0.4f));
    scene.lights[0].domain = Box3(Vec3(0.3f), Vec3(0.7f));
    scene.grid.resolution = CellCount{8};
    Camera camera;
    camera.name = "corner";
    camera.eye = Vec3(0.05f);
    camera.target = Vec3(0.9f, 0.6f, 0.8f);
    camera.vertical_fov = 70;
    camera.size = {64, 64};
    scene.cameras.push_back(camera);
    return scene;
}

struct Prepared {
    Scene scene = roamed_room();
    RayCaster caster{scene.geometry, InstructionSet::pinned};
    Solids solids = solids_of(scene);
    Cells cells = find_cells(scene, caster, [](const Vec3&) { return true; });
    HeldOut held_out{scene, caster, solids, {.positions = 5, .pixels = 300, .paths = 64}};

    Prepared() { held_out.set_cells(scene, caster, cells); }
    std::vector<HeldOut::Values> constant(const Rgb& irradiance) const {
        return {std::size_t(held_out.positions()), HeldOut::Values(held_out.patches().size(), irradiance)};
    }
};

const Prepared& prepared() {
    static const Prepared all;
    return all;
}

TEST(HeldOut, LampsAreSpreadOverTheDomainAndNotThoseOfEvaluations) {
    const Prepared& p = prepared();
    Box3 all;
    for (int i = 0; i < p.held_out.positions(); ++i) {
        const Vec3 position = p.held_out.lamps(i)[0].position;
        EXPECT_TRUE(p.scene.lights[0].domain.intersects(position));
        all.extendBy(position);
        for (int k = 0; k < 16; ++k) EXPECT_NE(position, unseen_lamps(p.scene, p.solids, k)[0].position);
    }
    for (int axis = 0; axis < 3; ++axis) EXPECT_GT(all.size()[axis], 0.2f);
}

// Phi rho / (A (1 - rho)), with A = 6 m².
Rgb right_light(const Scene& scene) {
    const Rgb rho = scene.materials[0].diffuse;
    Rgb balance;
    for (int c = 0; c < 3; ++c) balance[c] = scene.lights[0].power[c] * rho[c] / (6 * (1 - rho[c]));
    return balance;
}

// The room's own irradiance per patch: indirect light of a lamp in a closed room of equal walls is nearly
// constant, Phi rho / (A (1 - rho)) on average (energy balance). A map that holds it everywhere errs less
// than one that is dark, or twice as bright.
TEST(HeldOut, TheRightLightErrsLeast) {
    const Prepared& p = prepared();
    const Rgb balance = right_light(p.scene);
    const auto right = p.constant(balance), dark = p.constant(Rgb(0)), bright = p.constant(balance * 2.0f);
    EXPECT_LT(p.held_out.square(right, right), 0.1 * p.held_out.square(dark, dark));
    EXPECT_LT(p.held_out.square(right, right), 0.1 * p.held_out.square(bright, bright));
    EXPECT_LT(p.held_out.error(right).relrmse, 0.1);
}

// Errors are quadratic in the patches' values: with d a constant change, and I - R = e,
// |e + d|² + |e - d|² = 2 |e|² + 2 |d|².
TEST(HeldOut, SquaresObeyTheParallelogramLaw) {
    const Prepared& p = prepared();
    const auto middle = p.constant(Rgb(0.2f)), more = p.constant(Rgb(0.3f)), less = p.constant(Rgb(0.1f));
    const double sum = p.held_out.square(more, more) + p.held_out.square(less, less),
                 half = p.held_out.difference(more, middle);
    EXPECT_NEAR(sum, 2 * p.held_out.square(middle, middle) + 2 * half, 1e-4 * sum);
    EXPECT_NEAR(p.held_out.difference(more, less), 4 * half, 1e-4 * half);
    EXPECT_EQ(p.held_out.difference(more, more), 0);
}

// What a map's renderer shows, another way round: every pixel's radiance from its surface's look-up.
TEST(HeldOut, ErrorIsThatOfTheMapsPictures) {
    const Prepared& p = prepared();
    IlluminationMap map = map_without_lights(p.cells);
    std::vector<Rgb> values(map.patches.size());
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = Rgb(0.1f + 0.001f * float(i % 97));
    std::vector<HeldOut::Values> own(std::size_t(p.held_out.positions()));
    for (auto& position : own)
        for (const uint32_t patch : p.held_out.patches()) position.push_back(values[patch]);
    double error = 0;
    const Reference reference(
        p.scene, p.caster,
        [&] {
            std::vector<std::vector<LightState>> lamps;
            for (int i = 0; i < p.held_out.positions(); ++i) lamps.push_back(p.held_out.lamps(i));
            return lamps;
        }(),
        {.lights = 5, .pixels = 300, .paths = 64, .geometry = {}}, 77);
    for (int i = 0; i < reference.positions(); ++i) {
        Moment m = evaluated_moment(p.scene, p.caster, map, reference.lamps(i));
        m.indirect = true;
        m.direct = DirectLight::traced;
        m.patch_values = values;
        const auto seen = reference.seen(
            i, 0, [&](const Ray& ray, RandomStream& random) { return map_radiance(m, ray, random); });
        double square = 0, norm = 0;
        for (std::size_t k = 0; k < seen.size(); ++k) {
            const auto& r = reference.pixels(i, 0)[k].all;
            square += double((seen[k] - r[0]).dot(seen[k] - r[1]));
            norm += double(r[0].dot(r[1]));
        }
        error += std::sqrt(square / norm) / reference.positions();
    }
    // Other pixels and paths of the same five views: they agree as far as 300 pixels can.
    EXPECT_NEAR(p.held_out.error(own).relrmse, error, 0.1 * error);
}

// The paths of one half of a pixel are spread evenly and so depend on each other; the halves must not: in a
// diffuse sphere, whose indirect light is known, the product of their errors has mean zero.
TEST(Reference, HalvesAreIndependent) {
    Scene scene = empty_scene(Rgb(0.5f));
    add_sphere(scene, Vec3(0), 1, 4, true, false);
    scene.cameras.push_back({"c", Vec3(0), {0, 0, -1}, {0, 1, 0}, 90, {64, 64}});
    const std::vector<LightState> lamp{{{0.3f, -0.4f, 0.2f}, Rgb(1)}};
    scene.lights.push_back(point_lamp(lamp[0].position, lamp[0].power));
    const RayCaster caster(scene.geometry, InstructionSet::pinned);
    const Reference reference(scene, caster, std::vector<std::vector<LightState>>{lamp},
                              {.lights = 1, .pixels = 10000, .paths = 16, .geometry = {}}, 5);
    Mean all, products, squares;
    for (const ReferencePixel& p : reference.pixels(0, 0)) all.add(0.5 * (p.indirect[0].x + p.indirect[1].x));
    for (const ReferencePixel& p : reference.pixels(0, 0)) {
        const double a = p.indirect[0].x - all.value(), b = p.indirect[1].x - all.value();
        products.add(a * b), squares.add(a * a);
    }
    const double expected = 0.25 / (4 * M_PI * M_PI * 0.5);
    // Slack: the polyhedron, see PathRadiance.IndirectLightOfASphere.
    expect_mean(all, expected, 3 * (1 - total_area(scene.geometry) / (4 * M_PI)) * expected, 2);
    expect_mean(products, 0, 1e-3 * squares.value(), 2);
}

// Sixteen paths or 256 per pixel: the mean over many views is the same error, where views' own roots
// would be mere noise at sixteen.
TEST(HeldOut, FewPathsLeaveTheErrorAsItIs) {
    const Prepared& p = prepared();
    const auto error = [&](int paths) {
        HeldOut held_out(p.scene, p.caster, p.solids, {.positions = 24, .pixels = 300, .paths = paths});
        held_out.set_cells(p.scene, p.caster, p.cells);
        const HeldOut::Values balance(held_out.patches().size(), right_light(p.scene));
        return held_out.error(std::vector<HeldOut::Values>(24, balance));
    };
    const auto few = error(16), many = error(256);
    EXPECT_NEAR(few.relrmse, many.relrmse, 4 * std::hypot(few.standard_error, many.standard_error));
    EXPECT_LT(many.standard_error, 0.1 * many.relrmse);
    EXPECT_LT(few.standard_error, 0.25 * many.relrmse);
}

}  // namespace
}  // namespace pim
