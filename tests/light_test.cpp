// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/light.h"

#include "statistics.h"
#include "test_scenes.h"

namespace pim {
namespace {

const Vec3 kNormals[] = {{0, -1, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, -2}, {0.3f, -0.8f, 0.2f}, {0.01f, 1, 0}};

TEST(RectangleShape, AxesAreOrthonormal) {
    for (const Vec3& n : kNormals) {
        const RectangleShape r({2, 3}, n);
        constexpr float kRounding = 1e-6f;  // a handful of float roundings
        EXPECT_NEAR((r.normal - n.normalized()).length(), 0, kRounding);
        EXPECT_NEAR(r.axes[0].length(), 1, kRounding);
        EXPECT_NEAR(r.axes[1].length(), 1, kRounding);
        EXPECT_NEAR(r.axes[0].dot(r.axes[1]), 0, kRounding);
        EXPECT_NEAR((r.axes[0].cross(r.axes[1]) - r.normal).length(), 0, kRounding);
        EXPECT_FLOAT_EQ(r.area(), 6);
    }
}

// Radiance times pi times area is the flux of a Lambertian lamp.
TEST(EmittedRadiance, GivesThePowerBack) {
    const RectangleShape r({0.5f, 4}, {0, 1, 0});
    const Rgb radiance = emitted_radiance(r, {3, 5, 7});
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(radiance[c] * M_PI * 2, (Rgb{3, 5, 7})[c], 1e-5);
}

TEST(SampleEmission, PointLampShinesUniformly) {
    const Light lamp = point_lamp({1, 2, 3});
    std::vector<long> bins(16 * 16);
    for (uint64_t i = 0; i < 1 << 18; ++i) {
        RandomStream random(1, RandomPurpose::photons, 0, i);
        const Emission e = sample_emission(lamp, lamp.position, random);
        ASSERT_EQ(e.origin, lamp.position);
        const double turn = (std::atan2(e.direction.z, e.direction.x) + M_PI) / (2 * M_PI);
        ++bins[std::size_t(std::min(15, int(8 * (1 + e.direction.y)))) * 16 +
               std::size_t(std::min(15, int(16 * turn)))];
    }
    EXPECT_LT(chi_squared(bins), chi_squared_bound(255));
}

TEST(SampleEmission, RectangleIsUniformInPlaceAndCosineInDirection) {
    const Light lamp = rectangle_lamp({1, 2, 3}, {2, 0.5f}, {0.3f, -0.8f, 0.2f});
    const RectangleShape& shape = *lamp.rectangle();
    std::vector<long> places(64), heights(64);
    Mean place_and_direction;
    for (uint64_t i = 0; i < 1 << 18; ++i) {
        RandomStream random(1, RandomPurpose::photons, 0, i);
        const Emission e = sample_emission(lamp, {1, 2, 3}, random);
        const Vec3 offset = e.origin - Vec3(1, 2, 3);
        ASSERT_NEAR(offset.dot(shape.normal), 0, 1e-6f);  // roundings of numbers near 3
        const float s = offset.dot(shape.axes[0]) / 2 + 0.5f, t = offset.dot(shape.axes[1]) / 0.5f + 0.5f;
        ++places[std::size_t(std::clamp(int(8 * s), 0, 7) * 8 + std::clamp(int(8 * t), 0, 7))];
        const float cosine = e.direction.dot(shape.normal);
        ASSERT_GE(cosine, -1e-6f);
        ++heights[std::size_t(std::clamp(int(64 * cosine * cosine), 0, 63))];
        place_and_direction.add((s - 0.5) * e.direction.dot(shape.axes[0]));
    }
    EXPECT_LT(chi_squared(places), chi_squared_bound(63, 3));
    EXPECT_LT(chi_squared(heights), chi_squared_bound(63, 3));
    expect_mean(place_and_direction, 0, 0, 3);  // place and direction do not depend on each other
}

TEST(Intersect, OnlyTheShiningSideAndInsideTheRectangle) {
    const RectangleShape r({2, 1}, {0, -1, 0});
    const Vec3 centre(0, 3, 0), up(0, 1, 0);
    const auto hit = intersect(r, centre, {0, 1, 0}, up);
    ASSERT_TRUE(hit);
    EXPECT_FLOAT_EQ(*hit, 2);
    EXPECT_FALSE(intersect(r, centre, {0, 5, 0}, -up));            // from behind
    EXPECT_FALSE(intersect(r, centre, {0, 1, 0}, -up));            // away from it
    EXPECT_FALSE(intersect(r, centre, {0, 1, 0}, Vec3(1, 0, 0)));  // along it
    for (const float sign : {-1.0f, 1.0f}) {
        const Vec3 a = r.axes[0] * sign, b = r.axes[1] * sign;
        EXPECT_TRUE(intersect(r, centre, Vec3(0, 1, 0) + a * 0.99f, up));
        EXPECT_FALSE(intersect(r, centre, Vec3(0, 1, 0) + a * 1.01f, up));
        EXPECT_TRUE(intersect(r, centre, Vec3(0, 1, 0) + b * 0.49f, up));
        EXPECT_FALSE(intersect(r, centre, Vec3(0, 1, 0) + b * 0.51f, up));
    }
    const Vec3 slant = Vec3(1, 2, 0).normalized();
    const auto slanted = intersect(r, centre, {-1, 1, 0}, slant);
    ASSERT_TRUE(slanted);
    EXPECT_NEAR(*slanted, std::sqrt(5.0), 1e-6);
}

}  // namespace
}  // namespace pim
