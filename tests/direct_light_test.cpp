// SPDX-License-Identifier: GPL-3.0-or-later
// Items 1 to 4 of the list of answers known in advance: lamps whose direct irradiance has a closed form.
#include "common/render/direct_light.h"

#include "common/transport/ray_caster.h"
#include "statistics.h"
#include "test_scenes.h"

namespace pim {
namespace {

constexpr int kSamples = 256;      // per estimate
constexpr double kSumming = 2e-5;  // relative: kSamples float additions of 2^-24 each, at worst

// Estimates with different jitter; their spread tells the error of their mean.
Mean irradiance(const Scene& scene, const Vec3& from, const Vec3& towards, int repeats = 200) {
    const RayCaster caster(scene.geometry, InstructionSet::pinned);
    const Light& lamp = scene.lights[0];
    const SurfacePoint surface = surface_seen(scene, caster, from, towards);
    Mean mean;
    for (int i = 0; i < repeats; ++i) {
        RandomStream random(1, RandomPurpose::evaluation, 0, uint64_t(i));
        mean.add(direct_irradiance(caster, lamp, {lamp.position, lamp.power}, surface, kSamples, random).x);
    }
    return mean;
}

// A large floor at y = 0 with that lamp over it; points are seen from above.
Scene floor_with(const Light& lamp) {
    Scene scene = empty_scene();
    add_quad(scene, {-10, 0, -10}, {0, 0, 20}, {20, 0, 0});
    scene.lights.push_back(lamp);
    return scene;
}

Mean floor_irradiance(const Light& lamp, const Vec3& point) {
    return irradiance(floor_with(lamp), point + Vec3(0, 0.1f, 0), point);
}

TEST(DirectLight, PointLampOverAPlane) {  // E = I h / (h² + r²)^(3/2), I = power / 4 pi
    const Scene scene = floor_with(point_lamp({0, 2, 0}, {12, 12, 12}));
    const RayCaster caster(scene.geometry, InstructionSet::pinned);
    RandomStream random(1, RandomPurpose::evaluation, 0, 0);
    for (const float r : {0.0f, 0.5f, 3.0f, 9.0f}) {
        const SurfacePoint surface = surface_seen(scene, caster, {r, 1, 0}, {r, 0, 0});
        const Rgb e = direct_irradiance(caster, scene.lights[0], {{0, 2, 0}, Rgb(12)}, surface, 1, random);
        const double expected = 12 / (4 * M_PI) * 2 / std::pow(4 + double(r) * r, 1.5);
        EXPECT_NEAR(e.x, expected, 2e-6 * expected);  // some ten roundings, positions' included
    }
}

TEST(DirectLight, ShadowAndBackFaces) {
    Scene scene = floor_with(point_lamp({0, 2, 0}));
    add_quad(scene, {-0.5f, 1, -0.5f}, {0, 0, 1}, {1, 0, 0});
    const RayCaster caster(scene.geometry, InstructionSet::pinned);
    RandomStream random(1, RandomPurpose::evaluation, 0, 0);
    const auto e = [&](const Vec3& from, const Vec3& towards) {
        return direct_irradiance(caster, scene.lights[0], {{0, 2, 0}, Rgb(1)},
                                 surface_seen(scene, caster, from, towards), 1, random)
            .x;
    };
    EXPECT_EQ(e({0.9f, 0.1f, 0}, {0.9f, 0, 0}), 0);  // the board's shadow ends at x = 1
    EXPECT_GT(e({1.1f, 0.1f, 0}, {1.1f, 0, 0}), 0);
    EXPECT_EQ(e({3, -1, 0}, {3, 0, 0}), 0);    // the floor's underside
    EXPECT_EQ(e({0, 0.5f, 0}, {0, 1, 0}), 0);  // the board's underside
    EXPECT_GT(e({0, 1.5f, 0}, {0, 1, 0}), 0);
}

// Lambert's polygon formula, the polygon clipped to the horizon of `normal` at the origin.
double lambert_factor(std::vector<Vec3d> polygon, const Vec3d& normal) {
    std::vector<Vec3d> above;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vec3d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
        const double ha = a.dot(normal), hb = b.dot(normal);
        if (ha >= 0) above.push_back(a);
        if ((ha < 0) != (hb < 0)) above.push_back(a + (b - a) * (ha / (ha - hb)));
    }
    double sum = 0;
    for (std::size_t i = 0; i < above.size(); ++i) {
        const Vec3d u = above[i].normalized(), v = above[(i + 1) % above.size()].normalized();
        const Vec3d across = u.cross(v);
        if (across.length() > 0)
            sum += std::acos(std::clamp(u.dot(v), -1.0, 1.0)) * normal.dot(across.normalized());
    }
    return std::abs(sum) / (2 * M_PI);
}

// E = L times pi times that factor; L = power / (pi area).
double lambert_irradiance(const Light& lamp, const Vec3& point, const Vec3d& normal) {
    const RectangleShape& r = *lamp.rectangle();
    const Vec3d centre(lamp.position - point), a(r.axes[0] * (r.size.x / 2)), b(r.axes[1] * (r.size.y / 2));
    return lamp.power.x / r.area() *
           lambert_factor({centre + a + b, centre + a - b, centre - a - b, centre - a + b}, normal);
}

TEST(DirectLight, RectangleAgreesWithLambert) {
    const Light lamps[] = {rectangle_lamp({0, 1, 0}, {1, 2}, {0, -1, 0}, Rgb(5)),
                           rectangle_lamp({0.3f, 2, -0.2f}, {0.5f, 0.7f}, {0.4f, -1, 0.3f}, Rgb(5))};
    for (const Light& lamp : lamps)
        for (const Vec3& point : {Vec3(0), Vec3(0.7f, 0, 0.2f), Vec3(-1, 0, 1.5f)}) {
            const double expected = lambert_irradiance(lamp, point, {0, 1, 0});
            expect_mean(floor_irradiance(lamp, point), expected, kSumming * expected, 6);
        }
}

TEST(DirectLight, RectangleThatDipsBelowTheHorizon) {  // seen from a wall whose plane cuts the lamp
    const Light lamp = rectangle_lamp({0, 1, 0.1f}, {1, 1}, {0, -1, 0}, Rgb(5));
    Scene scene = empty_scene();
    add_quad(scene, {-2, -2, 0}, {4, 0, 0}, {0, 4, 0});  // looks along +z
    scene.lights.push_back(lamp);
    const double expected = lambert_irradiance(lamp, Vec3(0), {0, 0, 1});
    ASSERT_GT(expected, 0);
    expect_mean(irradiance(scene, {0, 0, 1}, Vec3(0)), expected, kSumming * expected);
}

TEST(DirectLight, ElementParallelToARectangle) {  // Howell B-3: corner on the normal
    const double a = 1.5, b = 0.8, c = 1.2, A = a / c, B = b / c;
    const double factor = (A / std::hypot(1, A) * std::atan(B / std::hypot(1, A)) +
                           B / std::hypot(1, B) * std::atan(A / std::hypot(1, B))) /
                          (2 * M_PI);
    Light lamp = rectangle_lamp({0.75f, 1.2f, 0.4f}, {1, 1}, {0, -1, 0}, Rgb(float(a * b)));  // radiance 1/pi
    RectangleShape& shape = std::get<RectangleShape>(lamp.shape);
    shape.size = std::abs(shape.axes[0].x) > 0.5f ? Vec2(1.5f, 0.8f) : Vec2(0.8f, 1.5f);
    expect_mean(floor_irradiance(lamp, Vec3(0)), factor, kSumming * factor);
}

TEST(DirectLight, ElementPerpendicularToARectangle) {  // Howell B-4: a along the element's normal, b width
    const double a = 1.5, b = 0.8, c = 1.2, X = a / b, Y = c / b;
    const double factor =
        (std::atan(1 / Y) - Y / std::hypot(X, Y) * std::atan(1 / std::hypot(X, Y))) / (2 * M_PI);
    // The element at the origin looks up; the rectangle stands at x = c, from the floor up, and looks back.
    Light lamp = rectangle_lamp({1.2f, 0.75f, 0.4f}, {1, 1}, {-1, 0, 0}, Rgb(float(a * b)));
    RectangleShape& shape = std::get<RectangleShape>(lamp.shape);
    shape.size = std::abs(shape.axes[0].y) > 0.5f ? Vec2(1.5f, 0.8f) : Vec2(0.8f, 1.5f);
    expect_mean(floor_irradiance(lamp, Vec3(0)), factor, kSumming * factor);
}

// The same lamp through photons: flux on a rectangle of the floor against the integral of Lambert's formula
// over it.
TEST(DirectLight, PhotonsOfARectangleLandWhereLambertSays) {
    const Light lamp = rectangle_lamp({0.3f, 1, -0.2f}, {0.5f, 0.7f}, {0.4f, -1, 0.3f});
    const Scene scene = floor_with(lamp);
    Mean flux;
    double landed = 0;
    shoot(
        scene, 200000,
        [&](const Landing& l) {
            const Vec3& p = l.surface.position;
            if (l.straight && p.x > 0 && p.x < 1 && p.z > 0 && p.z < 0.5f) landed += l.flux.x;
        },
        [&] { flux.add(std::exchange(landed, 0)); });
    double integral = 0;  // midpoint rule: error of order 1/40², far below the photons' 0.3 %
    constexpr int kSteps = 40;
    for (int i = 0; i < kSteps; ++i)
        for (int j = 0; j < kSteps; ++j)
            integral += lambert_irradiance(
                lamp, {(float(i) + 0.5f) / kSteps, 0, (float(j) + 0.5f) / kSteps / 2}, {0, 1, 0});
    expect_mean(flux, integral / (kSteps * kSteps) / 2);
}

TEST(DirectLight, BlindBehindAOneSidedLamp) {
    const Light lamp = rectangle_lamp({0, 1, 0}, {1, 1}, {0, 1, 0});
    EXPECT_EQ(floor_irradiance(lamp, Vec3(0)).value(), 0);
}

}  // namespace
}  // namespace pim
