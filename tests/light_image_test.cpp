// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/render/light_image.h"

#include "common/render/frame.h"
#include "tests/statistics.h"
#include "tests/test_scenes.h"

namespace pim {
namespace {

// A floor, a mirror standing on its edge, a point lamp: by way of the mirror the floor is lit by the lamp's
// image.
struct MirrorScene {
    Scene scene = empty_scene(Rgb(0.5f));
    Camera camera;
    Vec3 lamp_image{3, 1, 0};  // of a lamp at x = -1 in the mirror x = 1

    MirrorScene() {
        add_quad(scene, {-4, 0, -4}, {0, 0, 8}, {5, 0, 0});
        scene.materials.push_back(mirror_material(Rgb(0.8f)));
        add_quad(scene, {1, 0, -40}, {0, 0, 80}, {0, 80, 0}, 1);
        scene.lights.push_back(point_lamp({-1, 1, 0}, Rgb(100)));
        camera.eye = {-1, 5, 0};
        camera.target = {-1, 0, 0};
        camera.up = {0, 0, 1};
        camera.vertical_fov = 20;
        camera.size = {4, 4};
    }
    // rho/pi · reflectance · Phi cos / (4 pi d²), the mean over a pixel by the middles of 64 parts.
    double expected(int x, int y) const {
        const CameraRays rays(camera, camera.size);
        double sum = 0;
        for (int i = 0; i < 64; ++i) {
            const Ray ray =
                rays.through(float(x) + (float(i % 8) + 0.5f) / 8, float(y) + (float(i / 8) + 0.5f) / 8);
            const Vec3 p = ray.origin + ray.direction * (-ray.origin.y / ray.direction.y);
            const Vec3 path = lamp_image - p;
            sum += 0.5 / double(kPi) * 0.8 * 100 * (path.y / path.length()) /
                   (4 * double(kPi) * path.length2()) / 64;
        }
        return sum;
    }
};

TEST(LightImage, FloorIsLitByTheLampsMirrorImage) {
    const MirrorScene m;
    const RayCaster caster(m.scene.geometry, InstructionSet::pinned);
    const PathScene paths{m.scene, caster, {{m.scene.lights[0].position, m.scene.lights[0].power}}};
    constexpr int kImages = 16;
    std::vector<Image> images;
    for (int i = 0; i < kImages; ++i)
        images.push_back(light_image(paths, m.camera, m.camera.size, 1000000, 1, uint32_t(i)));
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x) {
            double mean = 0, squares = 0;
            for (const Image& image : images) mean += image.at(x, y).x / kImages;
            for (const Image& image : images) squares += std::pow(image.at(x, y).x - mean, 2);
            const double error = std::sqrt(squares / (kImages * (kImages - 1.0)));
            // Student's t with 15 degrees of freedom: 6 standard errors are passed once in 40,000.
            EXPECT_NEAR(mean, m.expected(x, y), 6 * error) << x << ' ' << y;
            EXPECT_LT(error, 0.04 * mean);
        }
}

TEST(LightImage, HoldsNothingThatPathsFind) {
    Scene scene = room(Rgb(0.7f));
    const RayCaster caster(scene.geometry, InstructionSet::pinned);
    Camera camera;
    camera.eye = {0.5f, 0.5f, 0.9f};
    camera.target = {0.5f, 0.4f, 0};
    const PathScene paths{scene, caster, {{scene.lights[0].position, scene.lights[0].power}}};
    for (const Rgb& pixel : light_image(paths, camera, {8, 8}, 10000, 1, 0).pixels) EXPECT_EQ(pixel, Rgb(0));
    EXPECT_FALSE(point_lamps_meet_specular(scene));
}

double mean_of(const Image& image) {
    double sum = 0;
    for (const Rgb& pixel : image.pixels) sum += double(pixel.x) / double(image.pixels.size());
    return sum;
}

// Paths find a rectangle by way of mirrors and glass, too, if seldom: together with a light image the same
// light, with less noise where the lamp is small.
TEST(LightImage, SharesARectanglesLightWithPaths) {
    constexpr int kSize = 16, kSamples = 64;
    for (const float size : {0.05f, 1.5f}) {
        MirrorScene m;
        add_quad(m.scene, {-4, 0, -1}, {5, 0, 0}, {0, 4, 0});  // a wall, which the caustic lights
        m.scene.materials.push_back(glass_material(1.5f));
        add_sphere(m.scene, {-2.2f, 1, 0}, 0.5f, 3, false, true, 2);
        m.scene.lights = {rectangle_lamp({-3.2f, 2.5f, 0}, {size, size}, {1, -1.5f, 0}, Rgb(100))};
        const RayCaster caster(m.scene.geometry, InstructionSet::pinned);
        PathScene alone{m.scene, caster, {{m.scene.lights[0].position, m.scene.lights[0].power}}};
        PathScene together = alone;
        together.image_photons = kSize * kSize * CameraRays(m.camera, {kSize, kSize}).pixel_solid_angle();
        const auto paths = [&](const PathScene& scene, uint64_t seed) {
            return mean_of(render_frame(m.camera, {.size = {kSize, kSize}, .samples = kSamples, .seed = seed},
                                        [&](const Ray& ray, RandomStream& random) {
                                            return path_radiance(scene, ray, random).indirect;
                                        }));
        };
        Mean by_paths, by_both, by_image;
        for (uint64_t seed = 1; seed <= 32; ++seed) {
            by_paths.add(paths(alone, seed));
            const double image =
                mean_of(light_image(together, m.camera, {kSize, kSize}, kSize * kSize * kSamples, seed, 0));
            by_image.add(image);
            by_both.add(paths(together, seed + 100) + image);
        }
        // Student's t with 31 degrees of freedom: 5.2 standard errors are passed once in 100,000.
        EXPECT_NEAR(by_both.value(), by_paths.value(),
                    5.2 * std::hypot(by_both.standard_error(), by_paths.standard_error()));
        EXPECT_LT(by_both.standard_error(), 0.02 * by_both.value());
        EXPECT_GT(by_image.value(), 0);
        if (size < 1) {
            EXPECT_LT(by_both.standard_error(), 0.5 * by_paths.standard_error());
        }
    }
}

}  // namespace
}  // namespace pim
