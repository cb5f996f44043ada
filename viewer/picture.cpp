// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/picture.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "common/core/error.h"
#include "common/core/log.h"
#include "common/core/stopwatch.h"
#include "common/map/irradiance.h"
#include "common/map/map_file.h"
#include "common/render/frame.h"
#include "common/render/light_image.h"
#include "common/render/path_radiance.h"
#include "common/render/whitted_radiance.h"
#include "viewer/cell_view.h"
#include "viewer/tone/tone_curve.h"

namespace pim {
namespace {

PathScene lit_scene(const BakedScene& baked, const RayCaster& caster, const ViewState& state) {
    return {baked.scene, caster, shining(baked.scene, state), state.show_lamps};
}

Image render_paths(const BakedScene& baked, const RayCaster& caster, const PictureOptions& o,
                   const FrameOptions& frame) {
    PathScene scene = lit_scene(baked, caster, o.state);
    const bool direct = direct_part(o.state) != DirectLight::none, indirect = indirect_part(o.state);
    const bool by_photons = indirect && lamps_meet_specular(baked.scene);
    const uint64_t pixels = uint64_t(frame.size.x) * uint64_t(frame.size.y);
    if (by_photons)
        scene.image_photons = float(pixels) * CameraRays(o.state.camera, frame.size).pixel_solid_angle();
    Image image = render_frame(o.state.camera, frame, [&](const Ray& ray, RandomStream& random) {
        const Seen seen = path_radiance(scene, ray, random);
        Rgb shown(0);
        if (direct) shown += seen.total - seen.indirect;
        if (indirect) shown += seen.indirect;
        return shown;
    });
    if (!by_photons) return image;
    const Image added =
        light_image(scene, o.state.camera, frame.size, pixels * uint64_t(o.samples), frame.seed, 0);
    for (std::size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] += added.pixels[i];
    return image;
}

Moment moment_of(const BakedScene& baked, const RayCaster& caster, const PictureOptions& o) {
    Moment moment{.scene = baked.scene,
                  .caster = caster,
                  .map = baked.map,
                  .lights = shining(baked.scene, o.state),
                  .direct = direct_part(o.state),
                  .indirect = indirect_part(o.state),
                  .show_lamps = o.state.show_lamps,
                  .patch_values = {}};
    if (o.volume)
        moment.patch_values = read_volume(baked.map, *o.volume);
    else
        evaluate_patches(moment);
    return moment;
}

// Root mean square misfit of each patch under the lamps, W/m².
std::vector<Rgb> patch_residuals(const Moment& m) {
    std::vector<Rgb> sum(m.map.patches.size(), Rgb(0));
    for (std::size_t l = 0; l < m.lights.size(); ++l) {
        const MapLight& light = m.map.lights[l];
        const auto weights = box_weights(light.boxes, clamped(light.domain, m.lights[l].position));
        for (std::size_t b = 0; b < weights.size(); ++b)
            for (std::size_t p = 0; weights[b] > 0 && p < sum.size(); ++p) {
                float square = 0;
                for (const Component c : m.map.components) {
                    if (c == Component::direct ? m.direct != DirectLight::baked : !m.indirect) continue;
                    const float r = light.polynomials[b][int(c)]->residuals[p];
                    square += r * r;
                }
                sum[p] += m.lights[l].power * (float(weights[b]) * std::sqrt(square));
            }
    }
    return sum;
}

Rgb ratio(const Rgb& a, const Rgb& b) {
    return {b.x > 0 ? a.x / b.x : 0, b.y > 0 ? a.y / b.y : 0, b.z > 0 ? a.z / b.z : 0};
}

Image render_from_map(const BakedScene& baked, const RayCaster& caster, const PictureOptions& o,
                      const FrameOptions& frame, std::size_t& cut_values) {
    const View view = o.state.view;
    const Camera& camera = o.state.camera;
    if (is_unlit(view)) return render_unlit(view, baked.scene, baked.map, caster, camera, o.size, o.samples);
    const Moment moment = moment_of(baked, caster, o);
    cut_values = moment.cut_values;
    if (shows_radiance(view))
        return render_frame(camera, frame, [&](const Ray& ray, RandomStream& random) {
            return map_radiance(moment, ray, random);
        });
    const std::vector<Rgb> residuals = view == View::trust ? patch_residuals(moment) : std::vector<Rgb>{};
    return render_frame(camera, frame, [&](const Ray& ray, RandomStream& random) {
        const auto hit = caster.intersect(ray);
        if (!hit) return Rgb(0);
        const SurfacePoint s = surface_at(baked.scene, *hit);
        if (view == View::irradiance) return surface_irradiance(moment, s, random);
        const auto at = [&](const std::vector<Rgb>& values) {
            return irradiance_at(baked.map, values, s.position, s.shading_normal);
        };
        if (view == View::trust) return ratio(at(residuals), at(moment.patch_values));
        return Rgb(luminance(at(moment.patch_values)));
    });
}

Image render_whitted(const BakedScene& baked, const RayCaster& caster, const PictureOptions& o,
                     const FrameOptions& frame) {
    const PathScene lit = lit_scene(baked, caster, o.state);
    const int shadow_samples = direct_part(o.state) == DirectLight::none ? 0 : Moment::kShadowSamples;
    return render_frame(o.state.camera, frame, [&](const Ray& ray, RandomStream& random) {
        return whitted_radiance(lit, ray, shadow_samples, random);
    });
}

Picture render_photon_map(const BakedScene& baked, const RayCaster& caster, const PictureOptions& o,
                          const FrameOptions& frame) {
    const PhotonMapOptions& options = o.photon_map;
    Picture picture;
    Stopwatch watch;
    const auto lap = [&] { return std::exchange(watch, Stopwatch()).seconds(); };
    PathScene lit = lit_scene(baked, caster, o.state);
    ShotPhotons photons;
    if (options.indirect || options.direct == DirectLight::baked)
        photons = shoot_photons(lit, options.photons_per_lamp, options.seed);
    picture.seconds.photons = lap();
    const PhotonScene scene = build_photon_maps(std::move(lit), std::move(photons), options);
    picture.seconds.trees = lap();
    picture.image = render_frame(o.state.camera, frame, [&](const Ray& ray, RandomStream& random) {
        return photon_radiance(scene, ray, random);
    });
    picture.seconds.render = lap();
    return picture;
}

}  // namespace

std::vector<Rgb> read_volume(const IlluminationMap& map, const std::filesystem::path& file) {
    const VdbReader reader(file);
    const auto alien = [&] {
        return Error(
            fmt::format("{}: is no density volume of this map: another grid or scene", file.string()));
    };
    if (!reader.metadata().contains("geometry_hash") || reader.text("geometry_hash") != map.geometry_hash)
        throw alien();
    std::vector<Rgb> values(map.patches.size(), Rgb(0));
    const auto facings = cells_by_slot(map.patches);
    bool any = false;
    for (const Component c : {Component::direct, Component::indirect})
        for (int f = 0; f < kSlotCount; ++f) {
            const std::string grid = fmt::format("{}/{}/density", name(c), slot_name(map.grid, f));
            if (facings[f].cells.empty() || !reader.has(grid)) continue;
            any = true;
            auto active = reader.active_cells(grid);
            std::sort(active.begin(), active.end(), cell_before);
            if (active != facings[f].cells) throw alien();
            const auto own = reader.values(grid, facings[f].cells, 3);
            for (std::size_t i = 0; i < facings[f].patches.size(); ++i)
                values[facings[f].patches[i]] += Rgb(own[3 * i], own[3 * i + 1], own[3 * i + 2]);
        }
    if (!any) throw alien();
    return values;
}

Image render_unlit(View view, const Scene& scene, const IlluminationMap& map, const RayCaster& caster,
                   const Camera& camera, const Imath::V2i& size, int samples) {
    const FrameOptions frame{.size = size, .samples = samples};
    if (view == View::cells) return render_cells(scene, map, caster, camera, frame);
    return render_frame(camera, frame, [&](const Ray& ray, RandomStream&) {
        const auto hit = caster.intersect(ray);
        if (!hit) return Rgb(0);
        const SurfacePoint surface = surface_at(scene, *hit);
        if (view == View::albedo) return surface.diffuse + surface.specular;
        return (surface.shading_normal + Vec3(1)) * 0.5f;
    });
}

Picture render_picture(const BakedScene& baked, const RayCaster& caster, const PictureOptions& o) {
    FrameOptions frame{.size = o.size, .samples = o.samples, .seed = o.seed};
    const Stopwatch watch;
    Picture picture;
    if (o.integrator == Integrator::photon_map) {
        if (o.photon_map.gather > 0) frame.progress = "gathering";
        picture = render_photon_map(baked, caster, o, frame);
    } else if (o.integrator == Integrator::whitted) {
        picture.image = render_whitted(baked, caster, o, frame);
    } else if (o.integrator == Integrator::path) {
        frame.progress = "tracing paths";
        picture.image = render_paths(baked, caster, o, frame);
    } else {
        picture.image = render_from_map(baked, caster, o, frame, picture.cut_values);
    }
    picture.seconds.total = watch.seconds();
    return picture;
}

void warn_of_missing_light(const BakedScene& baked, const PictureOptions& o) {
    if (o.integrator == Integrator::path && indirect_part(o.state) && point_lamps_meet_specular(baked.scene))
        log_warning(
            "light of point lamps by way of mirrors or glass is added by photons from the lamps; seen in "
            "mirrors or through glass it is missing");
}

std::optional<Scale> fitting_scale(View view, const Image& linear) {
    if (view == View::irradiance) return automatic_scale(linear, false, "W/m²");
    if (view == View::trust) return automatic_scale(linear, false, "");
    return std::nullopt;
}

void write_picture(const std::filesystem::path& path, const Image& linear, const ViewState& state,
                   const Exposure& exposure) {
    write_image(path, path.extension() == ".png" ? displayed(linear, state, exposure) : linear, 1);
}

Image displayed(const Image& linear, const ViewState& state, const Exposure& exposure) {
    if (is_unlit(state.view)) return linear;
    const auto scale = exposure.scale ? exposure.scale : fitting_scale(state.view, linear);
    if (scale) return false_colours(linear, *scale);
    Image image = linear;
    for (Rgb& pixel : image.pixels)
        for (int c = 0; c < 3; ++c) pixel[c] = apply(state.tone_curve, exposure.factor * pixel[c]);
    return image;
}

}  // namespace pim
