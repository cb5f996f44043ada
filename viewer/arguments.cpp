// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/arguments.h"

#include <fmt/format.h>

#include <cmath>
#include <sstream>

#include "common/core/command_line.h"
#include "common/core/error.h"
#include "viewer/files/lighting_setup.h"
#include "viewer/files/names.h"

namespace pim {
namespace {

// "NAME=value" parts.
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

Vec3d parse_vector(const std::string& text, const std::string& option) {
    const auto v = parse_triple(text, option);
    return {v[0], v[1], v[2]};
}

// Calls set(lamp, option text, value text) for each NAME=value.
template <class Set>
void for_each_lamp(const std::vector<std::string>& texts, const char* option, const Scene& scene, Set set) {
    for (const std::string& text : texts) {
        const auto [name, value] = split_assignment(text, option);
        set(find_light(scene, name), fmt::format("{} {}", option, name), value);
    }
}

void place_lamps(const Arguments& a, const Scene& scene, ViewState& state) {
    for_each_lamp(
        a.lights, "--light", scene, [&](std::size_t l, const std::string& option, const std::string& value) {
            const Vec3 at = scene.geometry.to_local(parse_vector(value, option));
            check_in_domain(scene.lights[l].name, scene.lights[l].domain, at, scene.geometry.origin);
            state.lamps[l].position = at;
        });
    for_each_lamp(a.gains, "--gain", scene,
                  [&](std::size_t l, const std::string& option, const std::string& value) {
                      const double gain = parse_number(value, option);
                      if (gain < 0) throw UsageError(fmt::format("{}: {} is negative", option, gain));
                      state.lamps[l].gain = float(gain);
                      state.lamps[l].on = true;
                  });
    for_each_lamp(a.colours, "--colour", scene,
                  [&](std::size_t l, const std::string& option, const std::string& value) {
                      const Rgb colour(parse_vector(value, option));
                      if (std::min({colour.x, colour.y, colour.z}) < 0)
                          throw UsageError(fmt::format("{}: {} holds a negative number", option, value));
                      state.lamps[l].colour = colour;
                  });
}

void place_camera(const Arguments& a, const Scene& scene, Camera& camera) {
    if (!a.camera.empty()) camera = find_camera(scene, a.camera);
    if (!a.eye.empty()) camera.eye = scene.geometry.to_local(parse_vector(a.eye, "--eye"));
    if (!a.target.empty()) camera.target = scene.geometry.to_local(parse_vector(a.target, "--target"));
    if (!a.up.empty()) camera.up = Vec3(parse_vector(a.up, "--up"));
    if (!a.fov.empty()) camera.vertical_fov = float(parse_number(a.fov, "--fov"));
    if (!(camera.vertical_fov >= 0.1f && camera.vertical_fov <= 179))
        throw UsageError(fmt::format("--fov: {} is out of range; allowed: 0.1 to 179 degrees", a.fov));
    if (!((camera.target - camera.eye).cross(camera.up).length() > 0))
        throw UsageError("--eye, --target, --up: must not lie on one line");
}

// Whatever the map holds: rivals do not look at it.
void choose_parts_of_rival(const Arguments& a, ViewState& state) {
    const bool whitted = parse_integrator(a) == Integrator::whitted;
    if (a.direct.empty() && state.direct == DirectLight::baked) state.direct = DirectLight::traced;
    if (whitted && state.direct == DirectLight::baked)
        throw UsageError("--direct baked: the whitted integrator traces it; allowed: traced, none");
    if (whitted && (a.indirect == "baked" || state.view == View::indirect))
        throw UsageError("the whitted integrator has no indirect light");
    if (!a.indirect.empty() && a.indirect != "baked" && a.indirect != "none")
        throw UsageError(fmt::format("--indirect: '{}' is unknown; allowed: baked, none", a.indirect));
    state.indirect = !whitted && a.indirect != "none";
}

void choose_parts(const Arguments& a, const IlluminationMap& map, ViewState& state) {
    if (!a.view.empty()) state.view = parse_view(a.view);
    if (!a.direct.empty()) state.direct = parse_direct_light(a.direct);
    if (is_rival(parse_integrator(a))) return choose_parts_of_rival(a, state);
    if (state.direct == DirectLight::baked && !map.has(Component::direct))
        throw UsageError(
            "--direct baked: the map lacks the direct part; bake with components = [\"direct\", "
            "\"indirect\"]");
    if (state.view == View::density && a.direct == "traced")
        throw UsageError("--direct traced: the density view shows the map alone; allowed: baked, none");
    if (a.indirect.empty()) return;
    if (a.indirect != "baked" && a.indirect != "none")
        throw UsageError(fmt::format("--indirect: '{}' is unknown; allowed: baked, none", a.indirect));
    state.indirect = a.indirect == "baked";
    if (state.indirect && !map.has(Component::indirect))
        throw UsageError("--indirect baked: the map lacks the indirect part");
}

void choose_tone(const Arguments& a, ViewState& state) {
    if (!a.tone_curve.empty()) state.tone_curve = parse_tone_curve(a.tone_curve);
    if (a.exposure.empty()) return;
    state.automatic_exposure = a.exposure == "auto";
    if (!state.automatic_exposure) state.exposure = float(parse_number(a.exposure, "--exposure"));
}

}  // namespace

ViewState parse_state(const Arguments& a, const Scene& scene, const IlluminationMap& map) {
    ViewState state = a.setup ? load_setup(*a.setup, scene, map) : initial_state(scene, map);
    place_lamps(a, scene, state);
    place_camera(a, scene, state.camera);
    choose_parts(a, map, state);
    choose_tone(a, state);
    if (a.show_lamps) state.show_lamps = true;
    return state;
}

Imath::V2i parse_size(const Arguments& a, const Camera& camera) {
    if (a.size.empty()) return camera.size;
    constexpr int kMost = 32768;
    Imath::V2i size(0);
    char x = 0, more = 0;
    std::istringstream text(a.size);
    text >> std::noskipws;
    if (!(text >> size.x >> x >> size.y) || x != 'x' || text >> more || std::min(size.x, size.y) < 1 ||
        std::max(size.x, size.y) > kMost)
        throw UsageError(fmt::format("--size: '{}' must look like 1280x720, both whole numbers from 1 to {}",
                                     a.size, kMost));
    return size;
}

Integrator parse_integrator(const Arguments& a) {
    static const std::pair<const char*, Integrator> kNames[] = {{"polynomial", Integrator::polynomial},
                                                                {"photon_map", Integrator::photon_map},
                                                                {"whitted", Integrator::whitted},
                                                                {"path", Integrator::path}};
    for (const auto& [name, integrator] : kNames)
        if (a.integrator == name) return integrator;
    throw UsageError(fmt::format(
        "--integrator: '{}' is unknown; allowed: polynomial, photon_map, whitted, path", a.integrator));
}

std::size_t parse_ptm_lamp(const Arguments& a, const Scene& scene, const ViewState& state) {
    const std::vector<LightState> lights = shining(scene, state);
    const auto shines = [](const LightState& light) { return !is_black(light.power); };
    if (a.ptm_lamp.empty()) {
        const auto first = std::ranges::find_if(lights, shines);
        if (first == lights.end()) throw UsageError("--export-ptm: no lamp shines");
        return std::size_t(first - lights.begin());
    }
    const std::size_t lamp = find_light(scene, a.ptm_lamp);
    if (!shines(lights[lamp])) throw UsageError(fmt::format("--ptm-lamp: {} does not shine", a.ptm_lamp));
    return lamp;
}

PhotonMapOptions parse_photon_map(const Arguments& a, const Scene& scene, const ViewState& state) {
    PhotonMapOptions options;
    if (parse_integrator(a) != Integrator::photon_map && (a.photons || a.nearest || a.gather))
        throw UsageError("--photons, --nearest, --gather: need --integrator photon_map");
    if (parse_integrator(a) != Integrator::photon_map) return options;
    options.photons_per_lamp = a.photons.value_or(scene.bake.photons);
    if (options.photons_per_lamp > kMostPhotons)
        throw UsageError(fmt::format("--photons: {} as baked are too many for a photon map; give at most {}",
                                     options.photons_per_lamp, kMostPhotons));
    if (a.nearest) options.nearest = *a.nearest;
    if (a.gather) options.gather = *a.gather;
    options.direct = direct_part(state);
    options.indirect = indirect_part(state);
    if (options.gather > 0 && options.direct == DirectLight::baked)
        throw UsageError("--gather: direct light cannot be gathered; --direct must be traced or none");
    return options;
}

VectorUnit parse_vector_unit(const Arguments& a) {
    if (a.vector_unit == "auto") return best_vector_unit();
    const auto unit = find_vector_unit(a.vector_unit);
    if (!unit)
        throw UsageError(
            fmt::format("--vector-unit: '{}' is unknown; allowed: auto, plain, avx2, avx512", a.vector_unit));
    if (!is_supported(*unit))
        throw UsageError(fmt::format("--vector-unit: this processor has no {}", a.vector_unit));
    return *unit;
}

}  // namespace pim
