// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/reference.h"

#include <fmt/format.h>

#include <cmath>

#include "bake/reach.h"
#include "common/core/low_discrepancy.h"
#include "common/core/parallel.h"
#include "common/core/progress.h"
#include "common/render/camera_rays.h"
#include "common/render/light_image.h"
#include "common/render/path_radiance.h"

namespace pim {
namespace {

constexpr uint64_t kSeed = 0x5eed;
constexpr uint64_t kLightPhotons = 4096;  // per path of a pixel, lamp and view, for what only they find
constexpr double kPhotonsOfAPath = 3;     // that cost as much

// A place in pixel p of the raster; the stream goes on from there.
Vec2 place_in(RandomStream& random, std::size_t p, int columns) {
    const float x = float(int(p) % columns) + random.next();
    return {x, float(int(p) / columns) + random.next()};
}

}  // namespace

double reference_photons(const Scene& scene, const EvaluateOptions& o) {
    const double paths = double(o.lights) * o.pixels * o.paths;
    if (!lamps_meet_specular(scene)) return kPhotonsOfAPath * paths;
    const double images = 2.0 * o.lights * double(scene.cameras.size() * scene.lights.size());
    return kPhotonsOfAPath * paths + images * double(kLightPhotons) * o.paths;
}

Moment evaluated_moment(const Scene& scene, const RayCaster& caster, const IlluminationMap& map,
                        const std::vector<LightState>& lamps) {
    Moment m{.scene = scene, .caster = caster, .map = map, .lights = lamps, .patch_values = {}};
    m.direct = map.has(Component::direct) ? DirectLight::baked : DirectLight::traced;
    m.indirect = map.has(Component::indirect);
    m.shadow_samples = kEvaluationShadowSamples;
    return m;
}

std::vector<LightState> unseen_lamps(const Scene& scene, const Solids& solids, int i) {
    std::vector<LightState> states;
    for (std::size_t l = 0; l < scene.lights.size(); ++l) {
        const Light& light = scene.lights[l];
        RandomStream random(kSeed, RandomPurpose::evaluation, uint32_t(l), uint64_t(i));
        const auto allowed = [&](const Vec3& position) { return solids.containing(position).empty(); };
        states.push_back({random_lamp_position(light, allowed, random), light.power});
    }
    return states;
}

namespace {

std::vector<std::vector<LightState>> all_unseen_lamps(const Scene& scene, const Solids& solids, int count) {
    std::vector<std::vector<LightState>> lamps;
    for (int i = 0; i < count; ++i) lamps.push_back(unseen_lamps(scene, solids, i));
    return lamps;
}

}  // namespace

Reference::Reference(const Scene& scene, const RayCaster& caster, const Solids& solids,
                     const EvaluateOptions& options)
    : Reference(scene, caster, all_unseen_lamps(scene, solids, options.lights), options, kSeed) {}

Reference::Reference(const Scene& scene, const RayCaster& caster, std::vector<std::vector<LightState>> lamps,
                     const EvaluateOptions& options, uint64_t seed)
    : options_(options), seed_(seed), cameras_(scene.cameras), lamps_(std::move(lamps)) {
    Progress progress("tracing the reference", lamps_.size());
    for (int i = 0; i < positions(); ++i) {
        for (int c = 0; c < cameras(); ++c) trace(scene, caster, i, c);
        progress.advance();
    }
}

Imath::V2i Reference::size(int number) const {
    const Camera& camera = cameras_[std::size_t(number)];
    const double wanted = std::max(16.0, double(options_.pixels) / double(cameras_.size()));
    const double aspect = double(camera.size.x) / double(camera.size.y);
    const int columns = std::max(1, int(std::lround(std::sqrt(wanted * aspect))));
    return {columns, std::max(1, int(std::lround(wanted / columns)))};
}

void Reference::for_each_ray(int position, int camera, const Visitor& visit) const {
    const int columns = size(camera).x, rows = size(camera).y;
    const CameraRays rays(cameras_[std::size_t(camera)], {columns, rows});
    parallel_for(std::size_t(columns) * std::size_t(rows), [&](std::size_t p) {
        RandomStream random(seed_, RandomPurpose::evaluation, uint32_t(view(position, camera) + 64), p);
        const Vec2 place = place_in(random, p, columns);
        visit(p, rays.through(place.x, place.y), random);
    });
}

std::vector<Rgb> Reference::seen(int position, int camera, const Renderer& renderer) const {
    std::vector<Rgb> colours(pixels(position, camera).size());
    for_each_ray(position, camera, [&](std::size_t p, const Ray& ray, RandomStream& random) {
        colours[p] = renderer(ray, random);
    });
    return colours;
}

void Reference::trace(const Scene& scene, const RayCaster& caster, int position, int camera) {
    PathScene paths{scene, caster, lamps(position)};
    const Camera& eye = cameras_[std::size_t(camera)];
    const int half = std::max(1, options_.paths / 2);
    const uint64_t photons = lamps_meet_specular(scene) ? uint64_t(options_.paths) * kLightPhotons : 0;
    paths.image_photons = float(photons) / float(half) * CameraRays(eye, eye.size).pixel_solid_angle();
    const int columns = size(camera).x, rows = size(camera).y;
    const CameraRays rays(eye, {columns, rows});
    const auto number = uint32_t(view(position, camera));
    auto& pixels = pixels_.emplace_back(std::size_t(columns) * std::size_t(rows));
    parallel_for(pixels.size(), [&](std::size_t p) {
        RandomStream random(seed_, RandomPurpose::evaluation, number + 64, p);
        const Vec2 place = place_in(random, p, columns);
        const Ray ray = rays.through(place.x, place.y);
        ReferencePixel& pixel = pixels[p];
        pixel.place = {std::min(place.x / float(columns), 0.99999f),
                       std::min(place.y / float(rows), 0.99999f)};
        const std::array scrambles{random.next_block(), random.next_block()};  // of both halves
        for (int k = 0; k < 2 * half; ++k) {
            RandomStream path(seed_, RandomPurpose::reference, number, p << 20 | uint64_t(k));
            path.begin_with(scrambled_sobol_point(uint32_t(k / 2), scrambles[std::size_t(k & 1)]));
            const Seen seen = path_radiance(paths, ray, path);
            pixel.surface = seen.surface;
            pixel.all[k & 1] += seen.total / float(half);
            pixel.indirect[k & 1] += seen.indirect / float(half);
        }
    });
    if (photons == 0) return;
    // Light that photons from the lamps find, from two independent images of the camera's own size.
    for (uint32_t h = 0; h < 2; ++h) {
        const Image image = light_image(paths, eye, eye.size, photons, seed_, 2 * number + h);
        for (ReferencePixel& p : pixels) {
            const Rgb& added =
                image.at(int(p.place.x * float(image.width)), int(p.place.y * float(image.height)));
            p.all[h] += added;
            p.indirect[h] += added;
        }
    }
}

std::string Reference::key(const Scene& scene, const EvaluateOptions& o) {
    const auto text = [](const Vec3& v) { return fmt::format("{},{},{} ", v.x, v.y, v.z); };
    std::string key = fmt::format("{} {} {} {}\n", scene.geometry_hash, o.lights, o.pixels, o.paths);
    for (const Light& light : scene.lights) {
        key += text(light.domain.min) + text(light.domain.max) + text(light.position) + text(light.power);
        if (const RectangleShape* r = light.rectangle())
            key += text(r->axes[0] * r->size.x) + text(r->axes[1] * r->size.y) + text(r->normal);
        key += "\n";
    }
    for (const Camera& c : scene.cameras)
        key += text(c.eye) + text(c.target) + text(c.up) +
               fmt::format("{} {}x{}\n", c.vertical_fov, c.size.x, c.size.y);
    return key;
}

}  // namespace pim
