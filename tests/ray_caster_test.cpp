// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/transport/ray_caster.h"

#include "common/core/sampling.h"
#include "statistics.h"
#include "test_scenes.h"

namespace pim {
namespace {

Scene soup(int triangles) {
    Scene scene = empty_scene();
    RandomStream random(1, RandomPurpose::evaluation, 0, 0);
    const auto vector = [&] {
        const float x = random.next(), y = random.next(), z = random.next();
        return Vec3(x, y, z);
    };
    for (int i = 0; i < triangles; ++i) {
        const Vec3 a = vector();
        add_triangle(scene, a, a + (vector() - Vec3(0.5f)) * 0.5f, a + (vector() - Vec3(0.5f)) * 0.5f);
    }
    return scene;
}

// Distance along the ray by Cramer's rule in double; infinity for a miss. `margin`: how far inside the hit
// lies, in barycentric weights.
double distance_to(const Geometry& g, uint32_t t, const Ray& ray, double& margin) {
    const auto c = g.corners(t);
    const Vec3d e1 = Vec3d(c[1]) - Vec3d(c[0]), e2 = Vec3d(c[2]) - Vec3d(c[0]), d(ray.direction);
    const Vec3d s = Vec3d(ray.origin) - Vec3d(c[0]), p = d.cross(e2), q = s.cross(e1);
    const double det = e1.dot(p), b1 = s.dot(p) / det, b2 = d.dot(q) / det, along = e2.dot(q) / det;
    margin = std::min({b1, b2, 1 - b1 - b2});
    return margin >= 0 && along > 0 ? along : std::numeric_limits<double>::infinity();
}

TEST(RayCaster, AgreesWithBruteForce) {
    const Scene scene = soup(200);
    const Geometry& g = scene.geometry;
    for (const InstructionSet set : {InstructionSet::pinned, InstructionSet::best}) {
        const RayCaster caster(g, set);
        RandomStream random(2, RandomPurpose::evaluation, 0, 0);
        int hits = 0;
        for (int i = 0; i < 3000; ++i) {
            const float x = random.next(), y = random.next(), z = random.next(), u = random.next();
            const Ray ray{{x, y, z}, sample_sphere(u, random.next())};
            double nearest = std::numeric_limits<double>::infinity(), least_margin = 1;
            uint32_t triangle = 0;
            for (uint32_t t = 0; t < g.triangles.size(); ++t) {
                double margin = 0;
                const double distance = distance_to(g, t, ray, margin);
                least_margin = std::min(least_margin, std::abs(margin));
                if (distance < nearest) nearest = distance, triangle = t;
            }
            if (least_margin < 1e-5 || nearest < 1e-5) continue;  // rounding decides
            const auto hit = caster.intersect(ray);
            ASSERT_EQ(hit.has_value(), std::isfinite(nearest));
            if (!hit) continue;
            ++hits;
            EXPECT_EQ(hit->triangle, triangle);
            EXPECT_NEAR(hit->distance, nearest, 1e-4);
            const auto c = g.corners(triangle);
            const Vec3 place = c[0] * (1 - hit->b1 - hit->b2) + c[1] * hit->b1 + c[2] * hit->b2;
            EXPECT_NEAR((place - (ray.origin + ray.direction * hit->distance)).length(), 0, 1e-4);
            EXPECT_EQ(hit->side, geometric_normal(c).dot(ray.direction) < 0 ? Side::front : Side::back);
            EXPECT_TRUE(caster.occluded({ray.origin, ray.direction, float(nearest) * 1.01f}));
            EXPECT_FALSE(caster.occluded({ray.origin, ray.direction, float(nearest) * 0.99f}));
        }
        EXPECT_GT(hits, 1000);
    }
}

TEST(RayCaster, ClosedRoomsHaveNoLeaks) {  // edges and corners included
    const Scene scene = room(Rgb(0.5f));
    const RayCaster caster(scene.geometry, InstructionSet::pinned);
    for (int i = 0; i <= 64; ++i)
        for (int j = 0; j <= 64; ++j) {
            const Vec3 target(float(i) / 64, float(j) / 64, 1), eye(0.5f);
            EXPECT_TRUE(caster.intersect({eye, (target - eye).normalized()}));
        }
}

TEST(RayCaster, SurfaceOffsetGrowsWithTheScene) {
    const auto offset = [](float size) {
        return RayCaster(room(Rgb(0.5f), Vec3(size)).geometry, InstructionSet::pinned).surface_offset();
    };
    EXPECT_GT(offset(1), 0);
    EXPECT_LT(offset(1), 1e-5f);
    EXPECT_FLOAT_EQ(offset(1000), 1000 * offset(1));
}

}  // namespace
}  // namespace pim
