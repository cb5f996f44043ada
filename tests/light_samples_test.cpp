// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/light_samples.h"

#include "statistics.h"
#include "test_scenes.h"

namespace pim {
namespace {

Light roaming(const Box3& domain, const SampleCount& samples, const Index3& boxes = Index3(1)) {
    Light light = point_lamp(domain.center());
    light.domain = domain;
    light.samples = samples;
    light.boxes = boxes;
    return light;
}

const Box3 kDomain(Vec3(-1, 2, 10), Vec3(3, 3, 16));
const Scene kEmpty = empty_scene();

std::vector<LightSample> samples_of(const Light& light) {
    std::vector<std::string> inside;
    const auto samples = light_samples(light, 3, Solids(kEmpty.geometry, {}), inside);
    EXPECT_TRUE(inside.empty());
    return samples;
}

TEST(LightSamples, StayInTheDomainAndAreNumbered) {
    const auto samples = samples_of(roaming(kDomain, 200, {2, 1, 3}));
    ASSERT_EQ(samples.size(), 200u);
    for (std::size_t i = 0; i < samples.size(); ++i) {
        EXPECT_EQ(samples[i].number, int(i));
        EXPECT_EQ(samples[i].light, 3);
        EXPECT_TRUE(kDomain.intersects(samples[i].position));
    }
}

TEST(LightSamples, AShorterListIsTheStartOfALongerOne) {
    const auto few = samples_of(roaming(kDomain, 30, {2, 1, 1})),
               many = samples_of(roaming(kDomain, 100, {2, 1, 1}));
    for (std::size_t i = 0; i < few.size(); ++i) EXPECT_EQ(few[i].position, many[i].position);
}

// A bake that adds positions, with other boxes or the same, keeps those it has.
TEST(LightSamples, GroupsFollowOneAnother) {
    using Groups = std::vector<SampleGroup>;
    const auto whole = samples_of(roaming(kDomain, 40)),
               first = samples_of(roaming(kDomain, Groups{{Index3(1), 40}}));
    const auto more = samples_of(roaming(kDomain, Groups{{Index3(1), 40}, {{2, 1, 1}, 20}}));
    const auto most = samples_of(roaming(kDomain, Groups{{Index3(1), 40}, {{2, 1, 1}, 50}}));
    ASSERT_EQ(more.size(), 60u);
    for (std::size_t i = 0; i < 40; ++i) {
        EXPECT_EQ(first[i].position, whole[i].position);
        EXPECT_EQ(more[i].position, whole[i].position);
    }
    for (std::size_t i = 0; i < more.size(); ++i) {
        EXPECT_EQ(more[i].number, int(i));
        EXPECT_EQ(most[i].position, more[i].position);
        for (std::size_t k = 0; k < i; ++k) EXPECT_NE(more[i].position, more[k].position);
    }
    const auto halves = split_domain(kDomain, {2, 1, 1});
    for (std::size_t i = 40; i < 60; ++i) EXPECT_TRUE(halves[i % 2].contains(Vec3d(more[i].position)));
}

TEST(LightSamples, BoxesGetTheirShare) {
    const auto boxes = split_domain(kDomain, {2, 1, 2});
    std::vector<int> counts(4);
    for (const LightSample& s : samples_of(roaming(kDomain, 100, {2, 1, 2})))
        for (std::size_t b = 0; b < 4; ++b) counts[b] += boxes[b].contains(Vec3d(s.position));
    for (const int n : counts) EXPECT_GE(n, 25);  // its own, and neighbours' in the overlap
}

// Arcsine density: the share of positions in |u| < 1/2 is 1/3 on each axis, to the discrepancy of log(n)/n.
TEST(LightSamples, HaveArcsineDensity) {
    const auto box = split_domain(kDomain, Index3(1))[0];
    constexpr int kCount = 3000;
    std::array<int, 3> middle{};
    for (const LightSample& s : samples_of(roaming(kDomain, kCount)))
        for (int axis = 0; axis < 3; ++axis)
            middle[std::size_t(axis)] += std::abs(box.normalised(Vec3d(s.position))[axis]) < 0.5;
    for (const int n : middle) EXPECT_NEAR(n, kCount / 3.0, 4 * std::log(kCount));
}

TEST(LightSamples, RegularGrids) {
    const auto samples = samples_of(roaming(kDomain, Index3(3, 1, 2)));
    ASSERT_EQ(samples.size(), 6u);
    EXPECT_EQ(samples.front().position, Vec3(-1, 2.5f, 10));
    EXPECT_EQ(samples.back().position, Vec3(3, 2.5f, 16));
    EXPECT_EQ(samples[2].position, Vec3(1, 2.5f, 10));
    EXPECT_EQ(samples_of(roaming(Box3(Vec3(0, 1, 0), Vec3(1, 1, 1)), Index3(4))).size(),
              16u);  // a still axis
}

TEST(LightSamples, LinesAndPoints) {
    for (const LightSample& s : samples_of(roaming(Box3(Vec3(0, 5, 7), Vec3(2, 5, 7)), 10))) {
        EXPECT_EQ(s.position.y, 5);
        EXPECT_EQ(s.position.z, 7);
    }
    const auto point = samples_of(roaming(Box3(Vec3(1, 2, 3)), 1));
    ASSERT_EQ(point.size(), 1u);
    EXPECT_EQ(point[0].position, Vec3(1, 2, 3));
}

TEST(LightSamples, PositionsInsideSolidsAreLeftOutAndSaid) {
    Scene scene = empty_scene();
    scene.geometry.objects[0] = "pillar";
    add_box(scene, {0, 0, 0}, {1, 5, 20}, false);
    const Solids solids(scene.geometry, {});
    std::vector<std::string> inside;
    const auto samples = light_samples(roaming(kDomain, 200), 0, solids, inside);
    EXPECT_LT(samples.size(), 200u);
    EXPECT_GT(samples.size(), 100u);
    for (const LightSample& s : samples)
        EXPECT_TRUE(s.position.x <= 0 || s.position.x >= 1 || s.position.z > 20);
    ASSERT_EQ(inside.size(), 1u);
    EXPECT_NE(inside[0].find("pillar"), std::string::npos);
    EXPECT_NE(inside[0].find(std::to_string(200 - samples.size())), std::string::npos) << inside[0];
    for (std::size_t i = 1; i < samples.size(); ++i) EXPECT_LT(samples[i - 1].number, samples[i].number);
}

}  // namespace
}  // namespace pim
