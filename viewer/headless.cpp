// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/headless.h"

#include <sys/resource.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "common/core/command_line.h"
#include "common/core/error.h"
#include "common/core/file.h"
#include "common/core/log.h"
#include "common/core/parallel.h"
#include "common/core/stopwatch.h"
#include "viewer/picture.h"

namespace pim {
namespace {

// "NAME=value" parts. Throws UsageError.
std::pair<std::string, std::string> split_assignment(const std::string& text, const char* option) {
    const std::size_t equals = text.rfind('=');
    if (equals == std::string::npos || equals == 0)
        throw UsageError(fmt::format("{}: '{}' must look like NAME=value", option, text));
    return {text.substr(0, equals), text.substr(equals + 1)};
}

double parse_number(const std::string& text, const std::string& option) {
    try {
        std::size_t used = 0;
        const double value = std::stod(text, &used);
        if (used == text.size() && std::isfinite(value)) return value;
    } catch (const std::logic_error&) {
    }
    throw UsageError(fmt::format("{}: '{}' is no number", option, text));
}

template <class Value>
Value choose(const std::string& text, const char* option,
             const std::vector<std::pair<std::string, Value>>& all) {
    std::string names;
    for (const auto& [name, value] : all) {
        if (name == text) return value;
        names += (names.empty() ? "" : ", ") + name;
    }
    throw UsageError(fmt::format("{}: '{}' is unknown; allowed: {}", option, text, names));
}

std::vector<LightState> place_lights(const BakedScene& baked, const HeadlessOptions& o) {
    const Scene& scene = baked.scene;
    std::vector<LightState> states;
    for (const Light& light : scene.lights) states.push_back({light.position, light.power});
    for (const std::string& text : o.lights) {
        const auto [name, value] = split_assignment(text, "--light");
        const auto at = parse_triple(value, "--light " + name);
        const std::size_t l = find_light(scene, name);
        states[l].position = scene.geometry.to_local({at[0], at[1], at[2]});
        check_in_domain(name, scene.lights[l].domain, states[l].position, scene.geometry.origin);
    }
    for (const std::string& text : o.gains) {
        const auto [name, value] = split_assignment(text, "--gain");
        const double gain = parse_number(value, "--gain " + name);
        if (gain < 0) throw UsageError(fmt::format("--gain {}: {} is negative", name, gain));
        states[find_light(scene, name)].power *= float(gain);
    }
    return states;
}

DirectLight choose_direct(const IlluminationMap& map, const HeadlessOptions& o) {
    if (o.direct.empty()) return map.has(Component::direct) ? DirectLight::baked : DirectLight::traced;
    const auto direct = choose<DirectLight>(
        o.direct, "--direct",
        {{"traced", DirectLight::traced}, {"baked", DirectLight::baked}, {"none", DirectLight::none}});
    if (direct == DirectLight::baked && !map.has(Component::direct))
        throw UsageError(
            "--direct baked: the map lacks the direct part; bake with components = [\"direct\", "
            "\"indirect\"]");
    return direct;
}

bool choose_indirect(const IlluminationMap& map, const HeadlessOptions& o) {
    if (o.indirect.empty()) return map.has(Component::indirect);
    const bool baked = choose<bool>(o.indirect, "--indirect", {{"baked", true}, {"none", false}});
    if (baked && !map.has(Component::indirect))
        throw UsageError("--indirect baked: the map lacks the indirect part");
    return baked;
}

Imath::V2i choose_size(const Camera& camera, const std::string& text) {
    if (text.empty()) return camera.size;
    const std::size_t x = text.find('x');
    if (x == std::string::npos) throw UsageError(fmt::format("--size: '{}' must look like 1280x720", text));
    const double w = parse_number(text.substr(0, x), "--size"),
                 h = parse_number(text.substr(x + 1), "--size");
    if (w < 1 || h < 1 || w > 32768 || h > 32768 || w != std::floor(w) || h != std::floor(h))
        throw UsageError(fmt::format("--size: '{}' must be whole numbers from 1 to 32768", text));
    return {int(w), int(h)};
}

PictureOptions picture_options(const BakedScene& baked, const HeadlessOptions& o) {
    PictureOptions p;
    p.camera = o.camera.empty() ? baked.scene.cameras[0] : find_camera(baked.scene, o.camera);
    p.size = choose_size(p.camera, o.size);
    p.lights = place_lights(baked, o);
    p.direct = choose_direct(baked.map, o);
    p.indirect = choose_indirect(baked.map, o);
    p.show_lamps = o.show_lamps;
    p.integrator = choose<Integrator>(o.integrator, "--integrator",
                                      {{"polynomial", Integrator::polynomial}, {"path", Integrator::path}});
    p.view = choose<View>(o.view, "--view",
                          {{"radiance", View::radiance},
                           {"irradiance", View::irradiance},
                           {"density", View::density},
                           {"cells", View::cells}});
    if (p.integrator == Integrator::path && p.view != View::radiance)
        throw UsageError("--view: the path integrator shows radiance only");
    if (p.view == View::density && o.direct == "traced")
        throw UsageError("--direct traced: the density view shows the map alone; allowed: baked, none");
    if (o.volume && p.view != View::density) throw UsageError("--volume: needs --view density");
    p.volume = o.volume;
    p.samples = o.samples;
    return p;
}

std::size_t packed_bytes(const IlluminationMap& map) {
    std::size_t bytes = map.patches.size() * sizeof(Patch);
    for (const MapLight& light : map.lights)
        for (const auto& box : light.polynomials)
            for (const auto& p : box)
                if (p) bytes += (p->coefficients.size() + p->residuals.size()) * sizeof(float);
    return bytes;
}

uint64_t peak_memory() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return uint64_t(usage.ru_maxrss) * 1024;
}

// Before the work, not after it.
void check_outputs(const HeadlessOptions& o) {
    check_image_name(o.output);
    check_output(o.output);
    if (o.stats) check_output(*o.stats);
    if (o.exposure != "auto") parse_number(o.exposure, "--exposure");
}

float choose_exposure(const Image& image, const std::string& text) {
    if (text == "auto") return automatic_exposure(image);
    return float(std::exp2(parse_number(text, "--exposure")));
}

Image timed_picture(const BakedScene& baked, const RayCaster& caster, const PictureOptions& picture,
                    std::vector<double>& seconds) {
    const Stopwatch watch;
    Image image = render_picture(baked, caster, picture);
    seconds.push_back(watch.seconds());
    return image;
}

// Renders again while that is cheap: five frames, or as many as fit in two seconds.
double median_frame_seconds(const BakedScene& baked, const RayCaster& caster, const PictureOptions& picture,
                            std::vector<double> seconds) {
    const Stopwatch watch;
    while (seconds.size() < 5 && watch.seconds() + seconds[0] < 2)
        timed_picture(baked, caster, picture, seconds);
    std::ranges::sort(seconds);
    return seconds[seconds.size() / 2];
}

}  // namespace

void render_headless(const HeadlessOptions& o) {
    const Stopwatch load_watch;
    const BakedScene baked = read_baked_scene(o.map, o.geometry);
    const PictureOptions picture = picture_options(baked, o);
    check_outputs(o);
    const RayCaster caster(baked.scene.geometry, InstructionSet::best);
    const double load_seconds = load_watch.seconds();
    std::vector<double> seconds;
    const Image image = timed_picture(baked, caster, picture, seconds);
    const bool false_colours = picture.view == View::cells;
    const float exposure = false_colours ? 1.0f : choose_exposure(image, o.exposure);
    write_image(o.output, image, exposure);
    log_info(fmt::format("wrote {} ({} x {}, {:.3f} s, exposure {:.2f} EV)", o.output.string(), image.width,
                         image.height, seconds[0], std::log2(exposure)));
    if (!o.stats) return;
    const double frame_seconds = median_frame_seconds(baked, caster, picture, seconds);
    const nlohmann::json stats{
        {"frame_seconds", frame_seconds},
        {"load_seconds", load_seconds},
        {"primary_rays", uint64_t(image.width) * uint64_t(image.height) * uint64_t(picture.samples)},
        {"cells", baked.map.index.cell_count()},
        {"packed_bytes", packed_bytes(baked.map)},
        {"peak_rss_bytes", peak_memory()},
        {"threads", thread_count()}};
    write_text_atomically(*o.stats, stats.dump(2) + "\n");
}

}  // namespace pim
