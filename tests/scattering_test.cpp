// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/transport/scattering.h"

#include "common/core/sampling.h"
#include "statistics.h"
#include "test_scenes.h"

namespace pim {
namespace {

constexpr float kRounding = 2e-6f;  // some ten float roundings of numbers near 1

SurfacePoint surface_of(const Material& material, Side side = Side::front,
                        const Vec3& shading = Vec3(0, 0, 1)) {
    return {.triangle = 0,
            .side = side,
            .position = Vec3(0),
            .geometric_normal = Vec3(0, 0, 1),
            .shading_normal = shading.normalized(),
            .material = &material,
            .diffuse = material.diffuse,
            .specular = material.specular};
}

Vec3 incoming(float degrees) {  // towards a surface that faces +z
    const float a = degrees * kPi / 180;
    return {std::sin(a), 0, -std::cos(a)};
}

TEST(Fresnel, NormalIncidence) {  // ((n-1)/(n+1))²
    for (const float n : {1.1f, 1.5f, 2.4f, 1 / 1.5f}) {
        const float share = (n - 1) / (n + 1);
        EXPECT_NEAR(fresnel_reflectance(1, n), share * share, kRounding);
    }
}

// At Brewster's angle, tan = n, only the perpendicular part is reflected: half of ((n²-1)/(n²+1))².
TEST(Fresnel, BrewstersAngle) {
    for (const float n : {1.33f, 1.5f, 2.0f}) {
        const float share = (n * n - 1) / (n * n + 1);
        EXPECT_NEAR(fresnel_reflectance(1 / std::sqrt(1 + n * n), n), 0.5f * share * share, kRounding);
    }
}

TEST(Fresnel, GrazingAndTotalReflection) {
    EXPECT_NEAR(fresnel_reflectance(1e-6f, 1.5f), 1, 1e-4f);  // 1 - R is about 6 cosines
    const float critical = std::sqrt(1 - 1 / (1.5f * 1.5f));  // cosine at which light stays in the glass
    EXPECT_FLOAT_EQ(fresnel_reflectance(0.999f * critical, 1 / 1.5f), 1);
    EXPECT_LT(fresnel_reflectance(1.01f * critical, 1 / 1.5f), 1);
}

TEST(Fresnel, TheSameFromBothSides) {  // R at an angle equals R at the refracted angle from the far side
    for (const float cosine : {0.2f, 0.5f, 0.9f}) {
        const float inside = std::sqrt(1 - (1 - cosine * cosine) / 2.25f);
        EXPECT_NEAR(fresnel_reflectance(cosine, 1.5f), fresnel_reflectance(inside, 1 / 1.5f), 10 * kRounding);
    }
}

TEST(Mirror, KeepsTheTangentAndTurnsTheNormal) {
    const Vec3 n = Vec3(1, 2, -2) / 3, in = Vec3(-2, 1, 2) / 3;
    const Vec3 out = mirror(in, n);
    EXPECT_NEAR(out.dot(n), -in.dot(n), kRounding);
    EXPECT_NEAR(((out - n * out.dot(n)) - (in - n * in.dot(n))).length(), 0, kRounding);
}

TEST(Glass, RefractionObeysSnell) {
    const Material glass = glass_material(1.5f);
    for (const Side side : {Side::front, Side::back})
        for (const float degrees : {0.0f, 20.0f, 40.0f}) {
            const Vec3 in = incoming(degrees);
            const GlassSplit split = split_at_glass(surface_of(glass, side), in);
            const float ratio = side == Side::front ? 1.5f : 1 / 1.5f;
            EXPECT_NEAR(split.relative_ior, ratio, kRounding);
            EXPECT_NEAR(ratio * split.refracted.x, in.x, kRounding);  // sines
            EXPECT_NEAR(split.refracted.length(), 1, kRounding);
            EXPECT_LT(split.refracted.z, 0);
            EXPECT_NEAR((split.reflected - mirror(in, {0, 0, 1})).length(), 0, kRounding);
        }
    EXPECT_EQ(split_at_glass(surface_of(glass, Side::back), incoming(60)).reflected_share, 1);
}

TEST(Glass, SplitsByFresnelAndScalesRadiance) {
    const Material glass = glass_material(1.5f);
    const SurfacePoint surface = surface_of(glass);
    const Vec3 in = incoming(70);
    Mean reflected;
    RandomStream random(1, RandomPurpose::evaluation, 0, 0);
    for (int i = 0; i < 100000; ++i) {
        const auto s = scatter(surface, in, Rgb(1), 1, Transport::from_eye, random);
        ASSERT_TRUE(s);
        const bool up = s->direction.z > 0;
        reflected.add(up);
        ASSERT_NEAR(s->correction, up ? 1 : 1 / 2.25f, kRounding);  // radiance over n² is kept
        ASSERT_EQ(s->weight, Rgb(1));
        const auto photon = scatter(surface, in, Rgb(1), 1, Transport::from_lamp, random);
        ASSERT_NEAR(photon->correction, 1, kRounding);  // flux is kept
    }
    expect_mean(reflected, fresnel_reflectance(-in.z, 1.5f));
}

Material mixed_material() {
    Material m = diffuse_material({0.5f, 0.3f, 0.1f});
    m.specular = {0.1f, 0.2f, 0.4f};
    return m;
}

// Continuations times their weights: diffuse and mirror reflectance, channel by channel.
TEST(Scatter, WeightsKeepTheExpectedEnergy) {
    const Material material = mixed_material();
    const SurfacePoint surface = surface_of(material);
    const Vec3 in = incoming(50);
    for (const Rgb& throughput : {Rgb(1), Rgb(0.1f, 1, 3), Rgb(0, 0, 2)})
        for (const Transport transport : {Transport::from_eye, Transport::from_lamp})
            for (const float survival : {1.0f, survival_probability(surface, throughput)}) {
                std::array<Mean, 3> diffuse, specular;
                RandomStream random(2, RandomPurpose::evaluation, 0, 0);
                for (int i = 0; i < 50000; ++i) {
                    const auto s = scatter(surface, in, throughput, survival, transport, random);
                    const bool specular_event = s && s->event == Event::specular;
                    for (int c = 0; c < 3; ++c) {
                        const double kept = s ? s->weight[c] * s->correction : 0;
                        diffuse[c].add(specular_event ? 0 : kept);
                        specular[c].add(specular_event ? kept : 0);
                    }
                    ASSERT_NEAR(specular_event ? (s->direction - mirror(in, {0, 0, 1})).length() : 0, 0,
                                kRounding);
                }
                for (int c = 0; c < 3; ++c) {
                    expect_mean(diffuse[c], material.diffuse[c], kRounding, 72);
                    expect_mean(specular[c], material.specular[c], kRounding, 72);
                }
            }
}

TEST(SurvivalProbability, KeepsTheLargestChannelConstant) {
    const Material material = mixed_material();
    const SurfacePoint surface = surface_of(material);
    EXPECT_NEAR(survival_probability(surface, Rgb(1)), 0.6f, kRounding);
    EXPECT_NEAR(survival_probability(surface, {0, 0, 3}), 0.5f, kRounding);
    EXPECT_NEAR(survival_probability(surface, {1, 0, 10}), 0.5f, kRounding);
    EXPECT_EQ(survival_probability(surface, Rgb(0)), 0);
    const Material black = diffuse_material(Rgb(0)), glass = glass_material(1.5f);
    EXPECT_EQ(survival_probability(surface_of(black), Rgb(1)), 0);
    EXPECT_EQ(survival_probability(surface_of(glass), Rgb(1)), 1);
}

TEST(Scatter, BlackSurfacesAbsorb) {
    const Material black = diffuse_material(Rgb(0));
    RandomStream random(1, RandomPurpose::evaluation, 0, 0);
    EXPECT_FALSE(scatter(surface_of(black), incoming(10), Rgb(1), 0, Transport::from_lamp, random));
    EXPECT_FALSE(scatter(surface_of(black), incoming(10), Rgb(1), 1, Transport::from_eye, random));
}

TEST(LandingFactor, RatioOfCosines) {
    const Material material = diffuse_material(Rgb(0.5f));
    const Vec3 in = incoming(30), shading = Vec3(-0.5f, 0, 1).normalized();
    EXPECT_EQ(landing_factor(surface_of(material), in), 1);
    EXPECT_NEAR(landing_factor(surface_of(material, Side::front, shading), in), in.dot(shading) / in.z,
                kRounding);
    const Vec3 away = Vec3(1, 0, 0.1f).normalized();  // the shading normal does not see this light
    EXPECT_EQ(landing_factor(surface_of(material, Side::front, away), in), 0);
}

// A light path through a surface with a shading normal carries as much whichever end it starts from (Veach
// 1997, 5.3): diffuse, flux per solid angle sent towards `out` by a beam of irradiance |in·ng|, against
// radiance towards -in reflected to the eye: both reflectance |in·ns| |out·ng| / pi.
TEST(Scatter, SentAndGatheredLightAgreeUnderShadingNormals) {
    const Material material = diffuse_material(Rgb(0.8f));
    const SurfacePoint surface = surface_of(material, Side::front, Vec3(0.6f, 0.1f, 1));
    const Vec3 light(-0.3f, 0.2f, -1), in = light.normalized();
    // Sent: mean over the hemisphere of flux into the cone x > 0, by the geometric cosine.
    Mean sent, gathered;
    RandomStream random(5, RandomPurpose::evaluation, 0, 0);
    for (int i = 0; i < 200000; ++i) {
        const auto s = scatter(surface, in, Rgb(1), 1, Transport::from_lamp, random);
        sent.add(s && s->direction.x > 0 ? s->weight.x * s->correction * landing_factor(surface, in) * -in.z
                                         : 0);
        // Gathered: eye rays arrive along -out, out cosine-distributed about ng, and meet the light at `in`.
        const float u1 = random.next();
        const Vec3 out = sample_cosine_hemisphere(u1, random.next());
        const float cosine = std::max(0.0f, -in.dot(surface.shading_normal));
        gathered.add(out.x > 0 ? material.diffuse.x * cosine : 0);  // f cos_s, times pi from out's density
    }
    expect_same(sent, gathered);
}

}  // namespace
}  // namespace pim
