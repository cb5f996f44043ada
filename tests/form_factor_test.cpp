// SPDX-License-Identifier: GPL-3.0-or-later
// Items 5 to 8 of the list of answers known in advance: a rectangular lamp is a diffuse emitter, so the share
// of its photons that land on a surface is a form factor (J. Howell: A Catalog of Radiation Heat Transfer
// Configuration Factors).
#include "statistics.h"
#include "test_scenes.h"

namespace pim {
namespace {

constexpr uint64_t kPhotons = 400000;

// Share of the photons for which `counts` holds at their first landing.
template <class Counts>
Mean share_landing(const Scene& scene, Counts counts, uint64_t photons = kPhotons) {
    Mean share;
    bool landed = false;
    shoot(
        scene, photons, [&](const Landing& l) { landed = landed || (l.straight && counts(l.surface)); },
        [&] { share.add(std::exchange(landed, false)); });
    return share;
}

Scene under(const Light& lamp) {  // no surface yet
    Scene scene = empty_scene(Rgb(0));
    scene.lights.push_back(lamp);
    return scene;
}

double opposed_rectangles(double X, double Y) {  // Howell C-11, X = a/c, Y = b/c
    const double x2 = 1 + X * X, y2 = 1 + Y * Y;
    return 2 / (M_PI * X * Y) *
           (std::log(std::sqrt(x2 * y2 / (1 + X * X + Y * Y))) +
            X * std::sqrt(y2) * std::atan(X / std::sqrt(y2)) +
            Y * std::sqrt(x2) * std::atan(Y / std::sqrt(x2)) - X * std::atan(X) - Y * std::atan(Y));
}

TEST(FormFactor, TheFormulaGivesTheUnitCube) { EXPECT_NEAR(opposed_rectangles(1, 1), 0.1998248957, 1e-10); }

TEST(FormFactor, OpposedRectangles) {
    for (const auto& [a, b, c] : {std::array{1.0f, 1.0f, 1.0f}, std::array{2.0f, 2.0f, 0.5f}}) {
        Scene scene = under(rectangle_lamp({a / 2, c, b / 2}, {a, b}, {0, -1, 0}));
        add_quad(scene, Vec3(0), {0, 0, b}, {a, 0, 0});
        expect_mean(share_landing(scene, [](const SurfacePoint&) { return true; }),
                    opposed_rectangles(a / c, b / c), 0, 2);
    }
}

// The lamp covers the top of a unit cube: 0.1998 to the bottom, 0.2000437761 (Howell C-14) to each side, in
// all 1.
TEST(FormFactor, UnitCube) {
    Scene scene = room(Rgb(0));
    const float top = 1 - 1e-6f;  // just inside the cube's ceiling
    scene.lights[0] = rectangle_lamp({0.5f, top, 0.5f}, {1, 1}, {0, -1, 0});
    std::array<Mean, 6> faces;
    for (std::size_t f = 0; f < 6; ++f)
        faces[f] = share_landing(scene, [&](const SurfacePoint& s) { return s.triangle / 2 == f; });
    // add_box's order of walls: x, y, z low, then x, y, z high. Slack: the gap of 1e-6 under the ceiling.
    for (const std::size_t side : {0u, 2u, 3u, 5u}) expect_mean(faces[side], 0.2000437761, 1e-5, 6);
    expect_mean(faces[1], 0.1998248957, 1e-5, 6);
    expect_mean(faces[4], 0, 1e-5, 6);
}

TEST(FormFactor, CoaxialDisks) {  // Howell C-41, (h, r1, r2) = (1, 0.7, 0.9)
    const double R1 = 0.7, R2 = 0.9, S = 1 + (1 + R2 * R2) / (R1 * R1);
    const double factor = 0.5 * (S - std::sqrt(S * S - 4 * (R2 / R1) * (R2 / R1)));
    // Of a square lamp's photons, those that start within the first disk count.
    Scene scene = under(rectangle_lamp({0, 1, 0}, {1.4f, 1.4f}, {0, -1, 0}));
    add_quad(scene, {-100, 0, -100}, {0, 0, 200}, {200, 0, 0});
    Mean share;
    shoot(
        scene, kPhotons,
        [&](const Landing& l) {
            const Vec3 start = l.surface.position - l.direction / -l.direction.y;  // back to y = 1
            if (std::hypot(start.x, start.z) < 0.7f)
                share.add(std::hypot(l.surface.position.x, l.surface.position.z) < 0.9f);
        },
        [] {});
    // Slack: photons that miss the plane 200 m wide, fewer than 1/100² of them.
    expect_mean(share, factor, 1e-4);
}

TEST(FormFactor, ElementToACoaxialDisk) {  // r² / (r² + h²)
    Scene scene = under(rectangle_lamp({0, 1, 0}, {1e-3f, 1e-3f}, {0, -1, 0}));
    add_quad(scene, {-2, 0, -2}, {0, 0, 4}, {4, 0, 0});
    const Mean share = share_landing(
        scene, [](const SurfacePoint& s) { return std::hypot(s.position.x, s.position.z) < 0.8f; });
    expect_mean(share, 0.64 / 1.64, 1e-6);  // slack: the element's size squared
}

// (R/d)² cos theta. The polyhedron lies between the sphere through its corners and the one that its faces
// touch.
TEST(FormFactor, ElementToASphere) {
    for (const float degrees : {0.0f, 50.0f}) {
        const float angle = degrees * kPi / 180, d = 2, radius = 0.5f;
        Scene scene = under(rectangle_lamp(Vec3(0), {1e-3f, 1e-3f}, {0, -1, 0}));
        const Vec3 centre(d * std::sin(angle), -d * std::cos(angle), 0);
        add_sphere(scene, centre, radius, 4, false, false);
        double inner = radius;
        for (uint32_t t = 0; t < scene.geometry.triangles.size(); ++t) {
            const auto c = scene.geometry.corners(t);
            inner = std::min<double>(inner, (c[0] - centre).dot(geometric_normal(c)));
        }
        const double scale = std::cos(angle) / (d * d), most = scale * radius * radius,
                     least = scale * inner * inner;
        expect_mean(share_landing(scene, [](const SurfacePoint&) { return true; }), 0.5 * (most + least),
                    0.5 * (most - least) + 1e-6, 2);
    }
}

}  // namespace
}  // namespace pim
