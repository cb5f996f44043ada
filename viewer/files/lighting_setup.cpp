// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/files/lighting_setup.h"

#include <set>

#include "common/core/file.h"
#include "common/scene/toml_table.h"
#include "viewer/files/names.h"
#include "viewer/files/number_text.h"

namespace pim {
namespace {

constexpr double kFarthest = 1e30, kBrightest = 1e30;  // finite as floats, and their squares as doubles

std::string quoted(const std::string& text) {
    std::string result = "\"";
    for (const char c : text) {
        const auto code = static_cast<unsigned char>(c);
        if (c == '"' || c == '\\')
            result += {'\\', c};
        else if (code < 0x20 || code == 0x7f)
            result += fmt::format("\\u{:04X}", code);
        else
            result += c;
    }
    return result + "\"";
}

// A TOML float always: a TOML integer does not hold every whole number that a float does.
std::string real(const std::string& number) {
    return number.find_first_of(".e") == std::string::npos ? number + ".0" : number;
}

std::string list(const NumberTexts& t) {
    return fmt::format("[{}, {}, {}]", real(t[0]), real(t[1]), real(t[2]));
}

bool has_camera(const Scene& scene, const std::string& name) {
    return std::ranges::any_of(scene.cameras, [&](const Camera& c) { return c.name == name; });
}

std::string camera_text(const Scene& scene, const Camera& camera) {
    std::string text = "\n[camera]\n";
    if (has_camera(scene, camera.name)) text += fmt::format("name = {}\n", quoted(camera.name));
    return text + fmt::format("eye = {}\ntarget = {}\nup = {}\nvertical_fov = {}\n",
                              list(world_texts(scene.geometry, camera.eye)),
                              list(world_texts(scene.geometry, camera.target)), list(number_texts(camera.up)),
                              real(number_text(camera.vertical_fov)));
}

std::string lamp_text(const Scene& scene, std::size_t l, const LampControl& lamp) {
    return fmt::format("\n[[light]]\nname = {}\nposition = {}\non = {}\nsolo = {}\ngain = {}\ncolour = {}\n",
                       quoted(scene.lights[l].name), list(world_texts(scene.geometry, lamp.position)),
                       lamp.on, lamp.solo, real(number_text(lamp.gain)), list(number_texts(lamp.colour)));
}

toml::table parse(const std::string& text, const std::string& name) {
    try {
        return toml::parse(text, name);
    } catch (const toml::parse_error& e) {
        throw Error(fmt::format("{}:{}: {}", name, e.source().begin.line, e.description()));
    }
}

class SetupReader {
  public:
    SetupReader(const toml::table& root, const std::string& file, const Scene& scene,
                const IlluminationMap& map)
        : root_(root, file, ""), file_(file), scene_(scene), map_(map), state_(initial_state(scene, map)) {}

    ViewState read() {
        read_view();
        if (root_.has("camera")) read_camera(root_.table("camera"));
        if (root_.has("light")) read_lamps();
        root_.refuse_unknown();
        return std::move(state_);
    }

  private:
    void read_view() {
        if (root_.has("view")) state_.view = View(root_.choice("view", view_names()));
        if (root_.has("direct")) state_.direct = DirectLight(root_.choice("direct", direct_light_names()));
        if (state_.direct == DirectLight::baked && !map_.has(Component::direct))
            root_.fail("direct", "the map lacks the direct part; allowed: none, traced");
        state_.indirect = root_.flag("indirect", state_.indirect);
        if (state_.indirect && !map_.has(Component::indirect))
            root_.fail("indirect", "the map lacks the indirect part; allowed: false");
        state_.show_lamps = root_.flag("show_lamps", state_.show_lamps);
        if (root_.has("exposure")) read_exposure();
        if (root_.has("tone_curve"))
            state_.tone_curve = ToneCurve(root_.choice("tone_curve", tone_curve_names()));
    }

    void read_exposure() {
        const toml::node_view value = root_.raw()["exposure"];
        state_.automatic_exposure = value.value<std::string>() == "auto";
        if (state_.automatic_exposure) return;
        if (!value.is_number()) root_.fail("exposure", "must be \"auto\" or a number of stops");
        state_.exposure = float(root_.number("exposure", 0, -100, 100));
    }

    void read_camera(TomlTable table) {
        if (table.has("name")) state_.camera = named_camera(table);
        Camera& camera = state_.camera;
        const auto world = [&](const char* key) {
            return scene_.geometry.to_local(table.vector(key, -kFarthest, kFarthest));
        };
        if (table.has("eye")) camera.eye = world("eye");
        if (table.has("target")) camera.target = world("target");
        if (table.has("up")) camera.up = Vec3(table.vector("up", -kFarthest, kFarthest));
        camera.vertical_fov = float(table.number("vertical_fov", camera.vertical_fov, 0.1, 179));
        table.refuse_unknown();
        if (!(Vec3d(camera.target - camera.eye).cross(Vec3d(camera.up)).length() > 0))
            table.fail("target", "eye, target and up must not lie on one line");
    }

    const Camera& named_camera(TomlTable& table) const {
        const std::string name = table.text("name", "");
        try {
            return find_camera(scene_, name);
        } catch (const UsageError& e) {
            table.fail("name", e.what());
        }
    }

    void read_lamps() {
        const toml::array* array = root_.raw()["light"].as_array();
        if (!array || !array->is_homogeneous<toml::table>()) root_.fail("light", "is written [[light]]");
        for (const toml::node& node : *array) read_lamp(TomlTable(*node.as_table(), file_, "light"));
    }

    void read_lamp(TomlTable table) {
        const std::size_t l = named_lamp(table);
        LampControl& lamp = state_.lamps[l];
        if (table.has("position")) lamp.position = lamp_position(table, scene_.lights[l]);
        lamp.on = table.flag("on", lamp.on);
        lamp.solo = table.flag("solo", lamp.solo);
        lamp.gain = float(table.number("gain", lamp.gain, 0, kBrightest));
        if (table.has("colour")) lamp.colour = Rgb(table.vector("colour", 0, kBrightest));
        table.refuse_unknown();
    }

    std::size_t named_lamp(TomlTable& table) {
        if (!table.has("name")) table.fail("name", "is missing");
        const std::string name = table.text("name", "");
        if (!seen_.insert(name).second) table.fail("name", fmt::format("'{}' is here twice", name));
        try {
            return find_light(scene_, name);
        } catch (const UsageError& e) {
            table.fail("name", e.what());
        }
    }

    Vec3 lamp_position(TomlTable& table, const Light& light) const {
        const Vec3 position = scene_.geometry.to_local(table.vector("position", -kFarthest, kFarthest));
        try {
            check_in_domain(light.name, light.domain, position, scene_.geometry.origin);
        } catch (const UsageError& e) {
            table.fail("position", e.what());
        }
        return position;
    }

    TomlTable root_;
    std::string file_;
    const Scene& scene_;
    const IlluminationMap& map_;
    ViewState state_;
    std::set<std::string> seen_;
};

}  // namespace

std::string setup_text(const Scene& scene, const ViewState& state) {
    std::string text = fmt::format(
        "# A set-up of pim's viewer; positions in world coordinates, metres.\n"
        "view = \"{}\"\ndirect = \"{}\"\nindirect = {}\nshow_lamps = {}\n",
        name(state.view), name(state.direct), state.indirect, state.show_lamps);
    text += fmt::format("exposure = {}\n",
                        state.automatic_exposure ? "\"auto\"" : real(number_text(state.exposure)));
    text += fmt::format("tone_curve = \"{}\"\n", name(state.tone_curve));
    text += camera_text(scene, state.camera);
    for (std::size_t l = 0; l < scene.lights.size(); ++l) text += lamp_text(scene, l, state.lamps[l]);
    return text;
}

void save_setup(const std::filesystem::path& path, const Scene& scene, const ViewState& state) {
    write_text_atomically(path, setup_text(scene, state));
}

ViewState load_setup(const std::filesystem::path& path, const Scene& scene, const IlluminationMap& map) {
    const toml::table root = parse(read_text(path), path.string());
    return SetupReader(root, path.string(), scene, map).read();
}

}  // namespace pim
