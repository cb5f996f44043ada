// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/files/command_text.h"

#include <fmt/format.h>

#include "viewer/files/names.h"
#include "viewer/files/number_text.h"

namespace pim {
namespace {

using Words = std::vector<std::string>;

// A file whose name starts with a dash is no option.
std::string file_word(const std::filesystem::path& path) {
    const std::string text = path.string();
    return text.starts_with('-') ? "./" + text : text;
}

bool same_view(const Camera& a, const Camera& b) {
    return a.eye == b.eye && a.target == b.target && a.up == b.up && a.vertical_fov == b.vertical_fov;
}

// Two cameras of a scene may look alike: the one of the same name comes first.
const Camera* scene_camera(const Scene& scene, const Camera& camera) {
    const Camera* found = nullptr;
    for (const Camera& known : scene.cameras)
        if (same_view(known, camera) && (!found || known.name == camera.name)) found = &known;
    return found;
}

void add_camera(Words& words, const Scene& scene, const Camera& camera) {
    if (const Camera* known = scene_camera(scene, camera)) {
        words.insert(words.end(), {"--camera", known->name});
        return;
    }
    words.insert(words.end(), {"--eye", commas(world_texts(scene.geometry, camera.eye)),  //
                               "--target", commas(world_texts(scene.geometry, camera.target)), "--up",
                               commas(number_texts(camera.up)),  //
                               "--fov", number_text(camera.vertical_fov)});
}

void add_lamps(Words& words, const Scene& scene, const ViewState& state) {
    const bool any_solo = std::ranges::any_of(state.lamps, &LampControl::solo);
    for (std::size_t l = 0; l < scene.lights.size(); ++l) {
        const Light& light = scene.lights[l];
        const LampControl& lamp = state.lamps[l];
        const auto add = [&](const char* option, const std::string& value) {
            words.insert(words.end(), {option, light.name + "=" + value});
        };
        if (lamp.position != light.position)
            add("--light", commas(world_texts(scene.geometry, lamp.position)));
        const float gain = lamp.on && (lamp.solo || !any_solo) ? lamp.gain : 0;
        if (gain != 1) add("--gain", number_text(gain));
        if (lamp.colour != Rgb(1)) add("--colour", commas(number_texts(lamp.colour)));
    }
}

void add_view(Words& words, const ViewState& state, const ViewState& start) {
    const auto add = [&](const char* option, const std::string& value) {
        words.insert(words.end(), {option, value});
    };
    if (state.direct != start.direct) add("--direct", name(state.direct));
    if (!state.indirect && start.indirect) add("--indirect", "none");
    if (state.view != start.view) add("--view", name(state.view));
    if (state.show_lamps) words.push_back("--show-lamps");
    if (!state.automatic_exposure) add("--exposure", number_text(state.exposure));
    if (state.tone_curve != start.tone_curve) add("--tone-curve", name(state.tone_curve));
}

}  // namespace

std::string shell_word(const std::string& text) {
    static const std::string kPlain =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./,=:+@%";
    if (!text.empty() && text.find_first_not_of(kPlain) == std::string::npos) return text;
    std::string word = "'";
    for (const char c : text) word += c == '\'' ? "'\\''" : std::string(1, c);
    return word + "'";
}

std::string headless_command(const Scene& scene, const IlluminationMap& map, const ViewState& state,
                             const Imath::V2i& size, const CommandFiles& files) {
    Words words{"viewer", file_word(files.map)};
    if (files.geometry) words.insert(words.end(), {"--geometry", file_word(*files.geometry)});
    words.insert(words.end(),
                 {"--output", file_word(files.output), "--size", fmt::format("{}x{}", size.x, size.y)});
    add_camera(words, scene, state.camera);
    add_lamps(words, scene, state);
    add_view(words, state, initial_state(scene, map));
    for (std::string& word : words) word = shell_word(word);
    return fmt::format("{}", fmt::join(words, " "));
}

}  // namespace pim
