// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/headless.h"

#include <fmt/format.h>
#include <pim_version.h>

#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>

#include "common/core/error.h"
#include "common/core/file.h"
#include "common/core/log.h"
#include "common/core/memory.h"
#include "common/core/parallel.h"
#include "common/core/progress.h"
#include "common/core/stopwatch.h"
#include "viewer/files/animation.h"
#include "viewer/files/frames.h"
#include "viewer/files/lighting_setup.h"
#include "viewer/files/probe.h"
#include "viewer/files/scene_export.h"
#include "viewer/picture.h"
#include "viewer/ptm_export.h"
#include "viewer/relight/relighter.h"

namespace pim {
namespace {

std::size_t packed_bytes(const IlluminationMap& map) {
    std::size_t bytes = map.patches.size() * sizeof(Patch);
    for (const MapLight& light : map.lights)
        for (const auto& box : light.polynomials)
            for (const auto& p : box)
                if (p) bytes += (p->coefficients.size() + p->residuals.size()) * sizeof(float);
    return bytes;
}

// Before the work, not after it.
void check_outputs(const Arguments& a) {
    check_image_name(a.output);
    check_output(a.output);
    if (a.stats) check_output(*a.stats);
}

PictureOptions picture_options(const Arguments& a, const BakedScene& baked) {
    PictureOptions p;
    p.state = parse_state(a, baked.scene, baked.map);
    p.size = parse_size(a, p.state.camera);
    p.integrator = parse_integrator(a);
    if (p.integrator != Integrator::polynomial && !shows_radiance(p.state.view))
        throw UsageError(
            fmt::format("--view: the {} integrator shows radiance, direct and indirect only", a.integrator));
    p.photon_map = parse_photon_map(a, baked.scene, p.state);
    if (a.volume && p.state.view != View::density) throw UsageError("--volume: needs --view density");
    p.volume = a.volume;
    p.samples = a.samples;
    p.seed = a.seed;
    return p;
}

float exposure_of(const ViewState& state, const Image& linear) {
    return state.automatic_exposure ? automatic_exposure(linear) : std::exp2(state.exposure);
}

// Of the frame of median time. Renders again while that is cheap: five frames, or as many as fit in two
// seconds.
PictureTimes median_times(const BakedScene& baked, const RayCaster& caster, const PictureOptions& picture,
                          const PictureTimes& first) {
    const Stopwatch watch;
    std::vector<PictureTimes> all{first};
    while (all.size() < 5 && watch.seconds() + first.total < 2)
        all.push_back(render_picture(baked, caster, picture).seconds);
    std::ranges::sort(all, {}, &PictureTimes::total);
    return all[all.size() / 2];
}

// All that decides a film's pictures, as text.
std::string film_key(const Arguments& a, const Scene& scene, const ViewState& state, const Imath::V2i& size) {
    ContentHash map;
    map.feed(read_text(a.map));
    std::string key = fmt::format("{} {} {}x{} {} fps, {} samples\n", kVersion, map.hex(), size.x, size.y,
                                  a.frames_per_second, a.samples) +
                      setup_text(scene, state);
    for (const auto& path : a.paths) key += read_text(path);
    return key;
}

// The mean of several passes.
Image sampled(Relighter& relighter, const ViewState& state, const Imath::V2i& size, int samples) {
    relighter.update(state, size);
    Image sum = relighter.linear();
    for (int pass = 1; pass < samples; ++pass) relighter.add_pass(pass, sum);
    for (Rgb& pixel : sum.pixels) {
        pixel /= float(samples);
        if (state.view == View::density) pixel = Rgb(luminance(pixel));
    }
    return sum;
}

}  // namespace

void render_still(const Arguments& a) {
    const Stopwatch load_watch;
    const BakedScene baked = read_baked_scene(a.map, a.geometry);
    const PictureOptions picture = picture_options(a, baked);
    check_outputs(a);
    const RayCaster caster(baked.scene.geometry, InstructionSet::best);
    const double load_seconds = load_watch.seconds();
    warn_of_missing_light(baked, picture);
    const auto [image, seconds, cut_values] = render_picture(baked, caster, picture);
    const float exposure = exposure_of(picture.state, image);
    write_picture(a.output, image, picture.state, {exposure});
    log_info(fmt::format("wrote {} ({} x {}, {:.3f} s, exposure {:.2f} EV)", a.output.string(), image.width,
                         image.height, seconds.total, std::log2(exposure)));
    if (!a.stats) return;
    const PictureTimes times = median_times(baked, caster, picture, seconds);
    nlohmann::json stats{
        {"frame_seconds", times.total},
        {"exposure", std::log2(exposure)},
        {"load_seconds", load_seconds},
        {"primary_rays", uint64_t(image.width) * uint64_t(image.height) * uint64_t(picture.samples)},
        {"cells", baked.map.index.cell_count()},
        {"cut_values", cut_values},
        {"packed_bytes", packed_bytes(baked.map)},
        {"peak_rss_bytes", peak_memory()},
        {"threads", thread_count()}};
    if (picture.integrator == Integrator::photon_map)
        stats.update({{"photon_seconds", times.photons},
                      {"tree_seconds", times.trees},
                      {"render_seconds", times.render}});
    write_text_atomically(*a.stats, stats.dump(2) + "\n");
}

void render_film(const Arguments& a) {
    const MapFile map(a.map);
    const Scene scene = scene_of(map.outline(), a.map, a.geometry);
    const ViewState base = parse_state(a, scene, map.outline());
    const Imath::V2i size = parse_size(a, base.camera);
    const Animation animation = read_animation(a.paths, scene);
    const int count = animation.frame_count(a.frames_per_second);
    check_image_name(frame_name(a.output, 0));
    check_output(frame_name(a.output, 0));
    const auto missing = missing_frames(a.output, count, film_key(a, scene, base, size), a.overwrite);
    log_info(fmt::format("{} frames to render, {} done before", missing.size(), count - int(missing.size())));
    const RayCaster caster(scene.geometry, InstructionSet::best);
    Relighter relighter(map, scene, caster, parse_vector_unit(a));
    const auto render = [&](int frame, ViewState& state) {
        state = animation.at(frame / a.frames_per_second, base);
        return is_unlit(state.view)
                   ? render_unlit(state.view, scene, map.outline(), caster, state.camera, size, a.samples)
                   : sampled(relighter, state, size, a.samples);
    };
    // One exposure, and one scale of false colours, for the whole film: what fits its first frame.
    Exposure exposure{std::exp2(base.exposure)};
    if (!missing.empty() && (base.automatic_exposure || !shows_radiance(base.view))) {
        ViewState first;
        const Image image = render(0, first);
        if (base.automatic_exposure) exposure.factor = automatic_exposure(image);
        exposure.scale = fitting_scale(base.view, image);
    }
    Progress progress("rendering frames", missing.size());
    for (const int frame : missing) {
        ViewState state;
        const Image image = render(frame, state);
        write_picture(frame_name(a.output, frame), image, state, exposure);
        record_frame(a.output, frame);
        progress.advance();
    }
}

void print_probe(const Arguments& a) {
    const BakedScene baked = read_baked_scene(a.map, a.geometry);
    const ViewState state = parse_state(a, baked.scene, baked.map);
    const auto points = read_probe(*a.probe, baked.scene);
    const RayCaster caster(baked.scene.geometry, InstructionSet::best);
    Moment moment{.scene = baked.scene,
                  .caster = caster,
                  .map = baked.map,
                  .lights = shining(baked.scene, state),
                  .direct = direct_part(state),
                  .indirect = indirect_part(state),
                  .shadow_samples = 256,
                  .patch_values = {}};
    evaluate_patches(moment);
    std::vector<Rgb> values;
    for (std::size_t i = 0; i < points.size(); ++i) {
        RandomStream random(1, RandomPurpose::render, 0, i);
        SurfacePoint surface{};
        surface.position = points[i].position;
        surface.geometric_normal = surface.shading_normal = points[i].normal;
        values.push_back(surface_irradiance(moment, surface, random));
    }
    std::cout << probe_text(points, values);
}

void write_scene(const Arguments& a) {
    const BakedScene baked = read_baked_scene(a.map, a.geometry);
    const ViewState state = parse_state(a, baked.scene, baked.map);
    export_scene(*a.exported, baked.scene, state, parse_size(a, state.camera));
    log_info(fmt::format("wrote {}", (*a.exported / "scene.json").string()));
}

void write_texture_map(const Arguments& a) {
    const BakedScene baked = read_baked_scene(a.map, a.geometry);
    const PictureOptions picture = picture_options(a, baked);
    const std::size_t lamp = parse_ptm_lamp(a, baked.scene, picture.state);
    const LampPlane plane = check_ptm(*a.ptm, baked.scene, picture, lamp);
    if (a.stats) check_output(*a.stats);
    const RayCaster caster(baked.scene.geometry, InstructionSet::best);
    warn_of_missing_light(baked, picture);
    const nlohmann::json result = export_ptm(*a.ptm, baked, caster, picture, lamp, plane);
    using Handler = nlohmann::json::error_handler_t;  // names come from files of any encoding
    const std::string report = result.dump(2, ' ', false, Handler::replace) + "\n";
    if (a.stats)
        write_text_atomically(*a.stats, report);
    else
        std::cout << report;
}

}  // namespace pim
