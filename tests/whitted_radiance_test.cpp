// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/render/whitted_radiance.h"

#include "common/transport/scattering.h"
#include "statistics.h"
#include "test_scenes.h"

namespace pim {
namespace {

PathScene lit(const Scene& scene, const RayCaster& caster, bool show_lamps = false) {
    PathScene s{scene, caster, {}, show_lamps};
    for (const Light& light : scene.lights) s.lights.push_back({light.position, light.power});
    return s;
}

Ray ray_to(const Vec3& from, const Vec3& to) { return {from, (to - from).normalized()}; }

// One ray of a scene, with random numbers that do not matter under point lamps.
Rgb seen(const Scene& scene, const Ray& ray, bool show_lamps = false) {
    const RayCaster caster(scene.geometry, InstructionSet::pinned);
    RandomStream random(1, RandomPurpose::render, 0, 0);
    return whitted_radiance(lit(scene, caster, show_lamps), ray, 16, random);
}

TEST(WhittedRadiance, IsTheDirectPartOfPaths) {
    Scene scene = room({0.8f, 0.5f, 0.2f});
    add_box(scene, {0.1f, 0, 0.1f}, {0.3f, 0.4f, 0.3f}, false);  // throws a penumbra
    scene.lights.push_back(rectangle_lamp({0.6f, 0.9f, 0.5f}, {0.3f, 0.3f}, {0, -1, 0}, {3, 2, 1}));
    const RayCaster caster(scene.geometry, InstructionSet::pinned);
    const PathScene s = lit(scene, caster);
    const std::vector<Vec3> targets = {
        {0.5f, 0, 0.5f}, {0.05f, 0, 0.45f}, {0.2f, 0.4f, 0.2f}, {0, 0.5f, 0.7f}};
    for (const Vec3& target : targets) {
        Mean direct, whitted;
        for (uint64_t i = 0; i < 20000; ++i) {
            RandomStream random(1, RandomPurpose::reference, 0, i), other(1, RandomPurpose::render, 0, i);
            const Ray ray = ray_to({0.5f, 0.6f, 0.8f}, target);
            const Seen path = path_radiance(s, ray, random);
            direct.add((path.total - path.indirect).y);
            if (i < 1000) whitted.add(whitted_radiance(s, ray, 16, other).y);
        }
        expect_same(direct, whitted, 1e-5 * whitted.value(), double(targets.size()));  // slack: float sums
    }
}

TEST(WhittedRadiance, PointLampOverAPlane) {
    Scene scene = plane_under_lamp(4, 1, {0.5f, 0.4f, 0.3f});
    for (const float x : {0.0f, 0.5f, 1.5f}) {
        const double d2 = 1 + double(x) * x;
        const Rgb radiance = seen(scene, ray_to({x, 0.5f, 0.2f}, {x, 0, 0}));
        for (int c = 0; c < 3; ++c) {  // rho / pi · Phi / (4 pi) · cos / d²
            const double expected = (0.5 - 0.1 * c) / M_PI / (4 * M_PI) / std::sqrt(d2) / d2;
            EXPECT_NEAR(radiance[c], expected, 1e-5 * expected);
        }
    }
    EXPECT_EQ(seen(scene, ray_to({0, -1, 0.1f}, Vec3(0))), Rgb(0));  // the side away from the lamp
    EXPECT_EQ(seen(scene, ray_to({0, 1, 0}, {0, 2, 0})), Rgb(0));
}

TEST(WhittedRadiance, AMirrorShowsWhatItReflects) {
    Scene scene = plane_under_lamp(4, 1);
    scene.materials.push_back(mirror_material({0.9f, 0.6f, 0.3f}));
    add_quad(scene, {2, 0, -2}, {0, 0, 4}, {0, 4, 0}, 1);  // stands on the floor's edge, looks to -x
    const Vec3 eye(1, 0.5f, 0.3f), image_of_eye(3, 0.5f, 0.3f), place(0.5f, 0, 0.1f);
    // From behind the mirror the ray would start in the open: the mirror's own triangles are passed.
    const Vec3 on_mirror = image_of_eye + (place - image_of_eye) * (1 / (image_of_eye.x - place.x));
    const Rgb direct = seen(scene, ray_to(eye, place)), mirrored = seen(scene, ray_to(eye, on_mirror));
    ASSERT_GT(direct.x, 0);
    // A diffuse place has the same radiance from everywhere; the mirror keeps its share.
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(mirrored[c], direct[c] * (0.9 - 0.3 * c), 1e-4 * direct[c]);
}

TEST(WhittedRadiance, ThroughAPaneOfGlass) {
    Scene scene = empty_scene();
    add_quad(scene, {-2, 0, -2}, {0, 0, 4}, {4, 0, 0});
    scene.lights.push_back(point_lamp({1, 1, 0}));
    const Ray down{{0, 3, 0.1f}, {0, -1, 0}};
    const Rgb without = seen(scene, down);
    scene.materials.push_back(glass_material(1.5f));
    add_box(scene, {-2, 2, -2}, {2, 2.1f, 2}, false, 1);
    // (1 - F)² with F = 0.04; of what is reflected to and fro inside, (1 - F)² F² and less, shares below
    // 0.001 are not followed.
    const double f = 0.04, through = (1 - f) * (1 - f);
    const double share = seen(scene, down).x / double(without.x);
    EXPECT_GT(share, through * (1 - 1e-5));
    EXPECT_LT(share, through / (1 - f * f) * (1 + 1e-5));
}

TEST(WhittedRadiance, NoLightButDirectLight) {
    Scene scene = plane_under_lamp(4, 1, Rgb(0.8f));
    add_quad(scene, {-1, 0.5f, -1}, {0, 0, 2}, {2, 0, 0});  // a table over the floor
    EXPECT_EQ(seen(scene, ray_to({0.5f, 0.2f, 0}, Vec3(0))), Rgb(0));
}

TEST(WhittedRadiance, ShownLampsHaveTheirRadiance) {
    Scene scene = plane_under_lamp(4, 3);
    scene.lights[0] = rectangle_lamp({0, 1, 0}, {1, 1}, {0, -1, 0}, {1, 2, 3});
    const Ray up = ray_to({0, 0.5f, 0}, {0.1f, 1, 0.1f});
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(seen(scene, up, true)[c], (c + 1) / M_PI, 1e-6);
    EXPECT_EQ(seen(scene, up), Rgb(0));
}

}  // namespace
}  // namespace pim
