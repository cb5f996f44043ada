// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/render/photon_radiance.h"

#include "common/core/parallel.h"
#include "common/render/frame.h"
#include "common/render/light_image.h"
#include "common/scene/scene_file.h"
#include "statistics.h"
#include "test_scenes.h"

namespace pim {
namespace {

PathScene lit(const Scene& scene, const RayCaster& caster) {
    PathScene s{scene, caster, {}, false};
    for (const Light& light : scene.lights) s.lights.push_back({light.position, light.power});
    return s;
}

PhotonScene photon_scene(const PathScene& s, const PhotonMapOptions& options) {
    return build_photon_maps(s, shoot_photons(s, options.photons_per_lamp, options.seed), options);
}

Image picture(const PathScene& s, const Camera& camera, int size, int samples,
              const PhotonMapOptions& options) {
    const PhotonScene scene = photon_scene(s, options);
    return render_frame(
        camera, {.size = {size, size}, .samples = samples},
        [&](const Ray& ray, RandomStream& random) { return photon_radiance(scene, ray, random); });
}

double mean_of(const Image& image) {
    double sum = 0;
    for (const Rgb& pixel : image.pixels) sum += mean_channel(pixel);
    return sum / double(image.pixels.size());
}

Camera camera_at(const Vec3& eye, const Vec3& target, float vertical_fov) {
    Camera camera;
    camera.eye = eye;
    camera.target = target;
    camera.up = {0, 0, 1};
    camera.vertical_fov = vertical_fov;
    return camera;
}

// --- the Cornell box, its indirect light as paths see it ---

class CornellBox : public testing::Test {
  protected:
    static constexpr int kSize = 24, kReferenceSamples = 2048;

    struct Reference {
        Scene scene = read_scene(std::string(PIM_DATA) + "/cornell/cornell.toml");
        RayCaster caster{scene.geometry, InstructionSet::pinned};
        Image halves[2];  // independent

        Reference() {
            for (uint64_t half = 0; half < 2; ++half)
                halves[half] =
                    render_frame(scene.cameras[0],
                                 {.size = {kSize, kSize}, .samples = kReferenceSamples, .seed = half + 7},
                                 [&](const Ray& ray, RandomStream& random) {
                                     return path_radiance(lit(scene, caster), ray, random).indirect;
                                 });
        }
    };
    static void SetUpTestSuite() { reference_ = new Reference; }
    static void TearDownTestSuite() { delete reference_; }

    static Image render(const PhotonMapOptions& options) {
        return picture(lit(reference_->scene, reference_->caster), reference_->scene.cameras[0], kSize, 16,
                       options);
    }
    // ||I - R|| / ||R|| without the reference's noise: its halves are independent.
    static double error(const Image& image) {
        double misfit = 0, norm = 0;
        for (std::size_t i = 0; i < image.pixels.size(); ++i) {
            const Rgb &r1 = reference_->halves[0].pixels[i], &r2 = reference_->halves[1].pixels[i];
            misfit += (image.pixels[i] - r1).dot(image.pixels[i] - r2);
            norm += r1.dot(r2);
        }
        return std::sqrt(std::max(0.0, misfit / norm));
    }
    static double reference_mean() {
        return (mean_of(reference_->halves[0]) + mean_of(reference_->halves[1])) / 2;
    }
    static inline const Reference* reference_ = nullptr;
};

TEST_F(CornellBox, ConvergesToPathsAsPhotonsGrow) {
    double before = 1;
    for (const auto& [photons, nearest] :
         {std::pair{2500, 16}, {20000, 64}, {160000, 256}, {1280000, 1024}}) {
        const PhotonMapOptions options{
            .photons_per_lamp = uint64_t(photons), .nearest = nearest, .direct = DirectLight::none};
        const PhotonScene scene = photon_scene(lit(reference_->scene, reference_->caster), options);
        const Image image = render(options);
        // Disks of radius r grow by sqrt(1/2) from step to step. Noise of 1 / sqrt(nearest) halves; bias by
        // edges, where disks reach beyond the surface, goes with r.
        EXPECT_LT(error(image), 0.85 * before) << photons;
        before = error(image);
        // A disk whose centre is d < r from a straight edge loses on average 2/(3 pi) of its area, so a
        // surface of area A and edges of length l loses 2/(3 pi) l r/A of its light. Seen here are five walls
        // of side s = 5.5 (l/A = 4/s) and two boxes, of sides 1.7 and their double (l/A = 2 to 2.4 /m, a
        // fifth of the picture): l/A below 1.0 /m. r below the greatest radius, which is twice that of most
        // places.
        const double bias = 2 / (3 * M_PI) * 1.0 * scene.global.greatest_radius() / 2;
        // All photons make the mean: noise of 1.2 / sqrt(photons) with several landings each, and the
        // reference's.
        const double noise = sigmas() * std::hypot(1.5 / std::sqrt(photons), 0.003);
        const double ratio = mean_of(image) / reference_mean();
        EXPECT_LT(ratio, 1 + noise) << photons;
        EXPECT_GT(ratio, 1 - bias - noise) << photons;
    }
    EXPECT_LT(before, 0.12);
}

TEST_F(CornellBox, FinalGatheringReducesTheError) {
    PhotonMapOptions options{.photons_per_lamp = 5000, .direct = DirectLight::none};
    const double seen_itself = error(render(options));
    options.gather = 64;  // 16 samples of a pixel: noise of some 1 / sqrt(1024) is left
    EXPECT_LT(error(render(options)), 0.5 * seen_itself);
}

TEST_F(CornellBox, DirectLightByPhotonsConverges) {
    // All-light photon map: its error falls too, though shadow borders keep it high.
    const Image traced = render({.photons_per_lamp = 200000, .direct = DirectLight::traced});
    double before = 1;
    for (const int photons : {4000, 64000, 1024000}) {
        const Image baked = render({.photons_per_lamp = uint64_t(photons), .direct = DirectLight::baked});
        double misfit = 0, norm = 0;
        for (std::size_t i = 0; i < baked.pixels.size(); ++i) {
            misfit += (baked.pixels[i] - traced.pixels[i]).length2();
            norm += traced.pixels[i].length2();
        }
        EXPECT_LT(std::sqrt(misfit / norm), 0.8 * before) << photons;
        before = std::sqrt(misfit / norm);
    }
}

// --- caustics ---

// A glass ball between lamp and floor; the camera sees the floor beneath it and not the ball.
struct Caustic {
    Scene scene = empty_scene(Rgb(0.5f));
    Camera camera = camera_at({0, 0.55f, -0.8f}, {0, 0, 0}, 50);

    Caustic() {
        add_quad(scene, {-4, 0, -4}, {0, 0, 8}, {8, 0, 0});
        scene.materials.push_back(glass_material(1.5f));
        add_sphere(scene, {0, 1, 0}, 0.3f, 4, false, true, 1);
        scene.lights.push_back(point_lamp({0, 2, 0}, Rgb(100)));
        camera.up = {0, 1, 0};
    }
};

// Where the ball gathers light the map of caustics brightens the floor; the mean is that of light tracing.
TEST(PhotonRadiance, CausticHasTheFluxOfLightTracing) {
    const Caustic c;
    const RayCaster caster(c.scene.geometry, InstructionSet::pinned);
    const PathScene s = lit(c.scene, caster);
    constexpr int kSize = 16;
    Mean photon_map, light_tracing;
    for (uint64_t seed = 1; seed <= 16; ++seed) {
        const PhotonMapOptions options{.photons_per_lamp = 300000, .direct = DirectLight::none, .seed = seed};
        photon_map.add(mean_of(picture(s, c.camera, kSize, 16, options)));
        const Image paths = render_frame(
            c.camera, {.size = {kSize, kSize}, .samples = 64, .seed = seed},
            [&](const Ray& ray, RandomStream& random) { return path_radiance(s, ray, random).indirect; });
        const Image light = light_image(s, c.camera, {kSize, kSize}, 300000, seed, 0);
        light_tracing.add(mean_of(paths) + mean_of(light));
    }
    // Student's t with 15 degrees of freedom: 6 standard errors are passed once in 40,000. Slack: what the
    // kernel of 50 photons carries over the picture's border, where there is a hundredth of the light.
    const double error = std::hypot(photon_map.standard_error(), light_tracing.standard_error());
    EXPECT_NEAR(photon_map.value(), light_tracing.value(), 6 * error + 0.01 * light_tracing.value());
    EXPECT_LT(6 * error, 0.05 * light_tracing.value());
}

TEST(PhotonRadiance, CausticIsBrighterThanTheFloorAround) {
    const Caustic c;
    const RayCaster caster(c.scene.geometry, InstructionSet::pinned);
    const PathScene s = lit(c.scene, caster);
    ShotPhotons photons = shoot_photons(s, 100000, 1);
    ShotPhotons without = photons;
    without.caustic.clear();
    const PhotonScene whole = build_photon_maps(s, std::move(photons), {});
    const PhotonScene dark = build_photon_maps(s, std::move(without), {});
    RandomStream random(1, RandomPurpose::render, 0, 0);
    const Ray at_focus{c.camera.eye, (Vec3(0) - c.camera.eye).normalized()};
    const Ray beside{c.camera.eye, (Vec3(2, 0, 0) - c.camera.eye).normalized()};
    const float focus = photon_radiance(whole, at_focus, random).x;
    EXPECT_GT(focus, 3 * photon_radiance(dark, at_focus, random).x);
    EXPECT_GT(focus, 2 * photon_radiance(whole, beside, random).x);
}

// --- the rest ---

TEST(PhotonRadiance, PartsAddUp) {
    Scene scene = room(Rgb(0.6f));
    scene.materials.push_back(mirror_material(Rgb(0.9f)));
    add_box(scene, {0.6f, 0, 0.5f}, {0.9f, 0.3f, 0.8f}, false, 1);
    const RayCaster caster(scene.geometry, InstructionSet::pinned);
    const PathScene s = lit(scene, caster);
    const Camera camera = camera_at({0.5f, 0.5f, 0.05f}, {0.5f, 0.4f, 1}, 70);
    const auto part = [&](DirectLight direct, bool indirect) {
        return picture(s, camera, 12, 1, {.photons_per_lamp = 5000, .direct = direct, .indirect = indirect});
    };
    const Image both = part(DirectLight::traced, true), direct = part(DirectLight::traced, false),
                indirect = part(DirectLight::none, true);
    for (std::size_t i = 0; i < both.pixels.size(); ++i)
        EXPECT_NEAR(both.pixels[i].x, direct.pixels[i].x + indirect.pixels[i].x, 1e-5 * both.pixels[i].x);
    EXPECT_GT(mean_of(indirect), 0);
    for (const Rgb& pixel : part(DirectLight::none, false).pixels) EXPECT_EQ(pixel, Rgb(0));
}

TEST(PhotonRadiance, SameBytesAtAnyThreadCount) {
    Scene scene = room({0.6f, 0.4f, 0.2f});
    scene.materials.push_back(glass_material(1.5f));
    add_sphere(scene, {0.6f, 0.3f, 0.6f}, 0.2f, 2, false, true, 1);
    scene.lights.push_back(rectangle_lamp({0.5f, 0.9f, 0.5f}, {0.3f, 0.3f}, {0, -1, 0}));
    const RayCaster caster(scene.geometry, InstructionSet::best);
    const PathScene s = lit(scene, caster);
    const Camera camera = camera_at({0.5f, 0.5f, 0.05f}, {0.5f, 0.4f, 1}, 70);
    for (const int gather : {0, 5}) {
        const PhotonMapOptions options{.photons_per_lamp = 20000, .gather = gather};
        const Image all = picture(s, camera, 32, 2, options);
        for (const int threads : {1, 2, 4}) {
            const ThreadLimit limit(threads);
            EXPECT_EQ(picture(s, camera, 32, 2, options).pixels, all.pixels) << gather << ' ' << threads;
        }
    }
}

// Gathering finds all indirect light but caustics, however few its rays: in a closed room of one albedo the
// mean over rays does not depend on how many there are.
TEST(PhotonRadiance, GatheringIsUnbiasedInItsRays) {
    Scene scene = room(Rgb(0.5f));
    const RayCaster caster(scene.geometry, InstructionSet::pinned);
    const PathScene s = lit(scene, caster);
    const Ray ray{{0.5f, 0.5f, 0.5f}, {0, -1, 0}};
    std::vector<Mean> means;
    for (const int gather : {1, 5, 36}) {
        const PhotonScene photons =
            photon_scene(s, {.photons_per_lamp = 20000, .gather = gather, .direct = DirectLight::none});
        Mean& mean = means.emplace_back();
        for (uint64_t i = 0; i < 4000; ++i) {
            RandomStream random(1, RandomPurpose::render, uint32_t(gather), i);
            mean.add(photon_radiance(photons, ray, random).x);
        }
    }
    expect_same(means[0], means[2], 0, 2);
    expect_same(means[1], means[2], 0, 2);
}

}  // namespace
}  // namespace pim
