// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/scene_file.h"

#include <map>
#include <sstream>

#include "common/core/file.h"
#include "common/core/log.h"
#include "common/scene/geometry_check.h"
#include "common/scene/geometry_file.h"
#include "common/scene/toml_table.h"

namespace pim {
namespace {

namespace fs = std::filesystem;
const toml::table kEmpty;

toml::table parse(const std::string& text, const std::string& name) {
    try {
        return toml::parse(text, name);
    } catch (const toml::parse_error& e) {
        throw Error(fmt::format("{}:{}: {}", name, e.source().begin.line, e.description()));
    }
}

Box3 to_box(TomlTable table, const Geometry& geometry) {
    const Vec3d low = table.vector("min"), high = table.vector("max");
    table.refuse_unknown();
    for (int axis = 0; axis < 3; ++axis)
        if (low[axis] > high[axis]) table.fail("min", "must not lie above max on any axis");
    return {geometry.to_local(low), geometry.to_local(high)};
}

// As it was read.
std::string span_of(TomlTable box) {
    const Vec3d low = box.vector("min"), high = box.vector("max");
    return fmt::format("{:.6g},{:.6g},{:.6g} to {:.6g},{:.6g},{:.6g}", low.x, low.y, low.z, high.x, high.y,
                       high.z);
}

// Of grid and bake.
bool leaves_all_open(const toml::table& root) {
    return !root.contains("preset") && !root.contains("grid") && !root.contains("bake");
}

class DescriptionReader {
  public:
    DescriptionReader(const toml::table& root, const std::string& name, const fs::path& folder,
                      const SceneOptions& options)
        : root_(root, name, ""), name_(name), folder_(folder), options_(options) {}

    Scene read() {
        thesis_ = root_.has("preset");
        if (thesis_) root_.choice("preset", {"thesis"});
        read_geometry_file();
        choose_ = leaves_all_open(root_.raw());
        read_bake(table_or_empty("bake"));
        read_grid(table_or_empty("grid"));
        each("material", [&](TomlTable& t) { read_material(t); });
        each("camera", [&](TomlTable& t) { read_camera(t); });
        each("light", [&](TomlTable& t) { read_light(t); });
        root_.refuse_unknown();
        finish();
        return std::move(scene_);
    }

  private:
    template <class Read>
    void each(const std::string& key, Read read) {
        if (!root_.has(key)) return;
        const toml::array* array = root_.raw()[key].as_array();
        if (!array || !array->is_homogeneous<toml::table>())
            root_.fail(key, fmt::format("is written [[{}]]", key));
        for (const toml::node& node : *array) {
            TomlTable table(*node.as_table(), name_, key);
            read(table);
            table.refuse_unknown();
        }
    }

    TomlTable table_or_empty(const std::string& key) {
        return root_.has(key) ? root_.table(key) : TomlTable(kEmpty, name_, key);
    }

    void read_geometry_file() {
        if (!root_.has("scene"))
            throw Error(fmt::format("{}:1: [scene] with geometry = \"FILE\" is missing", name_));
        TomlTable table = root_.table("scene");
        if (!table.has("geometry")) table.fail("geometry", "is missing: name the geometry file");
        scene_.geometry_file = options_.geometry.value_or(folder_ / table.text("geometry", ""));
        GeometryFile file =
            read_geometry(scene_.geometry_file, table.number("metres_per_unit", 1, 1e-12, 1e12));
        table.refuse_unknown();
        for (const std::string& warning : file.warnings) log_warning(warning);
        const Mended mended = mend(file.geometry);
        if (!mended.text().empty())
            log_warning(fmt::format("{}: {}", scene_.geometry_file.string(), mended.text()));
        if (file.geometry.triangles.empty())
            throw Error(fmt::format("{}: holds no triangle with an area", scene_.geometry_file.string()));
        scene_.geometry = std::move(file.geometry);
        scene_.materials = std::move(file.materials);
        scene_.textures = std::move(file.textures);
        scene_.lights = std::move(file.lights);
    }

    void read_material(TomlTable& table) {
        const std::string name = required_name(table);
        std::vector<Material*> targets;
        for (Material& m : scene_.materials)
            if (m.name == name) targets.push_back(&m);
        if (targets.empty()) {
            std::string all;
            for (const Material& m : scene_.materials) all += (all.empty() ? "" : ", ") + m.name;
            table.fail("name", fmt::format("the geometry has no material '{}'; it has: {}", name, all));
        }
        const bool has_kind = table.has("kind");
        const std::size_t kind = table.choice("kind", {"diffuse", "mirror", "glass"});
        for (Material* m : targets) {
            if (has_kind) set_kind(*m, kind);
            if (table.has("diffuse")) {
                m->diffuse = Rgb(table.vector("diffuse", 0, 1));
                m->texture.reset();
                m->texture_tints_specular = false;
            }
            if (table.has("specular")) {
                m->specular = Rgb(table.vector("specular", 0, 1));
                m->texture_tints_specular = false;
            }
            m->ior = float(table.number("ior", m->ior, 1.0001, 10));
            if (max_channel(m->diffuse + m->specular) > 1.0001f)
                table.fail(table.has("specular") ? "specular" : "diffuse",
                           "diffuse + specular must not exceed 1 in any channel");
        }
    }

    static void set_kind(Material& m, std::size_t kind) {
        m.glass = kind == 2;
        if (kind == 0) m.specular = Rgb(0);
        if (kind != 1) return;
        if (is_black(m.specular)) {  // what was diffuse, texture and all, becomes the mirror's
            m.specular = is_black(m.diffuse) ? Rgb(0.9f) : m.diffuse;
            m.texture_tints_specular = m.texture && !is_black(m.diffuse);
        }
        m.diffuse = Rgb(0);
        if (!m.texture_tints_specular) m.texture.reset();
    }

    std::string required_name(TomlTable& table) {
        const std::string name = table.text("name", "");
        if (name.empty()) table.fail("name", "is missing");
        return name;
    }

    void read_camera(TomlTable& table) {
        Camera camera;
        camera.name = required_name(table);
        for (const Camera& other : scene_.cameras)
            if (other.name == camera.name) table.fail("name", "two cameras have this name");
        camera.eye = scene_.geometry.to_local(table.vector("eye"));
        camera.target = scene_.geometry.to_local(table.vector("target"));
        if (table.has("up")) camera.up = Vec3(table.vector("up"));
        camera.vertical_fov = float(table.number("vertical_fov", 40, 0.1, 179));
        if (table.has("size")) {
            const auto size = table.integers("size", 2, 1, 32768);
            camera.size = {size[0], size[1]};
        }
        if (!((camera.target - camera.eye).cross(camera.up).length() > 0))
            table.fail("target", "eye, target and up must not lie on one line");
        scene_.cameras.push_back(camera);
    }

    void read_light(TomlTable& table) {
        Light light;
        light.name = required_name(table);
        if (light.name.find('/') != std::string::npos) table.fail("name", "must not hold a '/'");
        for (const std::string& known : described_lights_)
            if (known == light.name) table.fail("name", "two lights have this name");
        described_lights_.push_back(light.name);
        std::erase_if(scene_.lights, [&](const Light& other) { return other.name == light.name; });
        read_shape(table, light);
        if (table.has("power")) light.power = Rgb(table.vector("power", 0, 1e30));
        read_domain(table, light);
        read_samples(table, light);
        scene_.lights.push_back(light);
    }

    void read_shape(TomlTable& table, Light& light) {
        const std::string type = table.text("type", "point");
        const bool sized = table.has("size"), facing = table.has("normal");
        if (type == "point") {
            if (sized || facing)
                table.fail(sized ? "size" : "normal", "belongs to type = \"rectangle\" only");
            return;
        }
        if (type != "rectangle")
            table.fail("type", fmt::format("'{}' lamps do not exist here; allowed: point, rectangle", type));
        if (!sized || !facing) table.fail("type", "a rectangle needs size = [w, h] and normal = [x, y, z]");
        const auto size = table.numbers("size", 2, 1e-9, 1e9);
        const Vec3 normal(table.vector("normal"));
        if (!(normal.length() > 0)) table.fail("normal", "must not be zero");
        light.shape = RectangleShape({float(size[0]), float(size[1])}, normal);
    }

    void read_domain(TomlTable& table, Light& light) {
        const bool placed = table.has("position"), free = table.has("domain");
        if (!placed && !free)
            table.fail("position", "is missing, and so is domain: say where the lamp stands");
        if (free) light.domain = to_box(table.table("domain"), scene_.geometry);
        light.position = placed ? scene_.geometry.to_local(table.vector("position")) : light.domain.center();
        if (!free) light.domain = Box3(light.position);
        if (!light.domain.intersects(light.position))
            table.fail("position",
                       fmt::format("lies outside the light's domain, {}", span_of(table.table("domain"))));
        light.choose_boxes = is_free(table, "boxes");
        if (light.choose_boxes || !table.has("boxes")) return;
        const auto boxes = table.integers("boxes", 3, 1, 64);
        for (int axis = 0; axis < 3; ++axis)
            light.boxes[axis] = light.domain.max[axis] > light.domain.min[axis] ? boxes[axis] : 1;
    }

    void read_samples(TomlTable& table, Light& light) {
        light.choose_samples = is_free(table, "samples");
        const toml::array* array = table.raw()["samples"].as_array();
        if (array && !array->empty() && array->is_homogeneous<toml::table>()) {
            light.samples = sample_groups(*array);
        } else if (array) {
            const auto n = table.integers("samples", 3, 1, 100);
            light.samples = Index3(n[0], n[1], n[2]);
        } else if (!light.choose_samples) {
            light.samples = int(table.integer("samples", 182, 1, 1000000));
        }
        const bool still = light.domain.min == light.domain.max;
        if (!still) return;
        light.choose_boxes = false;
        if (!std::holds_alternative<std::vector<SampleGroup>>(light.samples)) light.samples = 1;
    }

    std::vector<SampleGroup> sample_groups(const toml::array& array) {
        std::vector<SampleGroup> groups;
        for (const toml::node& node : array) {
            TomlTable table(*node.as_table(), name_, "light.samples");
            const auto boxes = table.integers("boxes", 3, 1, 64);
            groups.push_back({{boxes[0], boxes[1], boxes[2]}, int(table.integer("count", 1, 1, 1000000))});
            table.refuse_unknown();
        }
        return groups;
    }

    // Is a setting left to the bake: written "auto", or not written where the bake is to choose?
    bool is_free(TomlTable& table, const std::string& key) const {
        if (!table.has(key)) return choose_;
        const bool free = table.raw()[key].value<std::string>() == "auto";
        if (free && thesis_) table.fail(key, "preset = \"thesis\" chooses nothing by itself; give a value");
        return free;
    }

    void read_grid(TomlTable table) {
        GridSettings& grid = scene_.grid;
        const bool counted = table.has("cells"), sized = table.has("cell_size");
        if (counted && sized) table.fail("cell_size", "give cells or cell_size, not both");
        scene_.choices.cells = !sized && is_free(table, "cells");
        if (counted && !scene_.choices.cells)
            grid.resolution = CellCount{int(table.integer("cells", 64, 1, 4096))};
        if (sized) grid.resolution = CellSize{table.number("cell_size", 1, 1e-12, 1e12)};
        if (table.has("bounds")) grid.bounds = to_box(table.table("bounds"), scene_.geometry);
        grid.facings = table.flag("facings", true);
        grid.estimator = Estimator(table.choice("estimator", {"area", "sphere"}));
        scene_.choices.reach_photons = is_free(table, "reach_photons");
        if (!scene_.choices.reach_photons)
            grid.reach_photons = uint64_t(
                table.integer("reach_photons", int64_t(grid.reach_photons), 1 << 16, int64_t{1} << 40));
        if (table.has("radius")) grid.radius = table.number("radius", 1, 1e-12, 1e12);
        table.refuse_unknown();
    }

    void read_bake(TomlTable table) {
        BakeSettings& bake = scene_.bake;
        read_choices(table);
        if (!scene_.choices.photons)
            bake.photons = uint64_t(table.integer("photons", int64_t(bake.photons), 1, 1000000000000));
        if (!scene_.choices.degree) bake.degree = int(table.integer("degree", bake.degree, 0, 3));
        bake.robust = Robust(table.has("robust") ? table.choice("robust", {"off", "auto", "always"}) : 1);
        bake.store = Store(table.has("store") ? table.choice("store", {"incident", "absorbed"}) : 0);
        bake.shrinkage = table.flag("shrinkage", true);
        bake.seed = uint64_t(table.integer("seed", 1, 0, INT64_MAX));
        if (table.has("components")) read_components(table);
        table.refuse_unknown();
    }

    void read_choices(TomlTable& table) {
        Choices& choices = scene_.choices;
        if (table.has("target_error")) choices.target_error = table.number("target_error", 0, 1e-6, 10);
        if (table.has("time_budget")) {
            const auto text = table.raw()["time_budget"].value<std::string>();
            choices.time_budget = text ? parse_duration(*text) : table.raw()["time_budget"].value<double>();
            if (!choices.time_budget || !(*choices.time_budget > 0))
                table.fail("time_budget", "must be a time such as \"90s\", \"10m\" or \"8h\"");
        }
        choose_ = choose_ || choices.target_error || choices.time_budget;
        if (choose_ && thesis_)
            table.fail(choices.target_error ? "target_error" : "time_budget",
                       "preset = \"thesis\" chooses nothing by itself");
        choices.photons = is_free(table, "photons");
        choices.degree = is_free(table, "degree");
    }

    void read_components(TomlTable& table) {
        const toml::array* array = table.raw()["components"].as_array();
        scene_.bake.components.clear();
        bool direct = false, indirect = false;
        if (array)
            for (const toml::node& node : *array) {
                const auto text = node.value<std::string>();
                if (text == "direct")
                    direct = true;
                else if (text == "indirect")
                    indirect = true;
                else
                    table.fail("components", "allowed: \"direct\", \"indirect\" or both");
            }
        if (!direct && !indirect)
            table.fail("components", "must be a list of \"direct\", \"indirect\" or both");
        if (direct) scene_.bake.components.push_back(Component::direct);
        if (indirect) scene_.bake.components.push_back(Component::indirect);
    }

    // The thesis' method and nothing else; what the description says otherwise is named in a warning.
    void apply_thesis() {
        std::vector<std::string> overruled;
        const auto set = [&](auto& setting, const auto& value, const char* table, const char* key) {
            if (root_.raw()[table][key] && setting != value)
                overruled.push_back(fmt::format("{}.{}", table, key));
            setting = value;
        };
        set(scene_.grid.facings, false, "grid", "facings");
        set(scene_.grid.estimator, Estimator::sphere, "grid", "estimator");
        set(scene_.bake.degree, 3, "bake", "degree");
        set(scene_.bake.robust, Robust::off, "bake", "robust");
        set(scene_.bake.store, Store::absorbed, "bake", "store");
        set(scene_.bake.shrinkage, false, "bake", "shrinkage");
        set(scene_.bake.components, std::vector{Component::direct, Component::indirect}, "bake",
            "components");
        scene_.grid.reachable_area_only = false;
        scene_.bake.mend_signs = false;
        for (Light& light : scene_.lights) {
            if (light.boxes != Index3(1)) overruled.push_back(fmt::format("boxes of '{}'", light.name));
            light.boxes = Index3(1);
        }
        if (!overruled.empty())
            log_warning(
                fmt::format("{}: preset = \"thesis\" overrules {}", name_, fmt::join(overruled, ", ")));
    }

    void finish() {
        if (thesis_) apply_thesis();
        if (scene_.lights.empty())
            throw Error(fmt::format(
                "{}: there is no lamp: add a [[light]] with name, position or domain, and power", name_));
        if (scene_.cameras.empty()) scene_.cameras.push_back(camera_at_lamp());
        scene_.geometry_hash = content_hash(scene_);
    }

    // Looks from a lamp's place, which is free of surfaces and sees what is lit, to the middle of the scene.
    Camera camera_at_lamp() const {
        const Box3 box = bounds(scene_.geometry);
        Camera camera;
        camera.eye = scene_.lights[0].position;
        camera.target = box.center() - Vec3(0.1f, 0.2f, 0.3f) * box.size();
        camera.vertical_fov = 80;
        if (!((camera.target - camera.eye).cross(camera.up).length() > 0)) camera.up = {0, 0, 1};
        return camera;
    }

    TomlTable root_;
    std::string name_;
    fs::path folder_;
    SceneOptions options_;
    Scene scene_;
    std::vector<std::string> described_lights_;
    bool thesis_ = false;
    bool choose_ = false;  // what is not written
};

void set(toml::table& table, const Setting& setting) {
    if (setting.value.empty()) {
        table.erase(setting.key);
        return;
    }
    if (setting.key == "cells") table.erase("cell_size");
    if (setting.key == "cell_size") table.erase("cells");
    try {
        const toml::table parsed = toml::parse(setting.key + " = " + setting.value);
        table.insert_or_assign(setting.key, *parsed.get(setting.key));
    } catch (const toml::parse_error&) {  // a text without its quotes, which shells eat
        table.insert_or_assign(setting.key, setting.value);
    }
}

void for_each_light(toml::table& root, const std::function<void(toml::table&)>& act) {
    if (toml::array* lights = root["light"].as_array())
        for (toml::node& light : *lights)
            if (light.is_table()) act(*light.as_table());
}

// So that the bake chooses them.
void free_settings(toml::table& root) {
    if (toml::table* grid = root["grid"].as_table()) grid->erase("cells"), grid->erase("cell_size");
    if (toml::table* bake = root["bake"].as_table()) bake->erase("photons"), bake->erase("degree");
    for_each_light(root, [](toml::table& light) { light.erase("samples"), light.erase("boxes"); });
}

// What the bake chooses where there is neither grid nor bake, in so many words.
void write_all_open(toml::table& root) {
    root.insert("grid", toml::table{{"cells", "auto"}});
    root.insert("bake", toml::table{{"photons", "auto"}, {"degree", "auto"}});
    for_each_light(root, [](toml::table& light) {
        light.insert("samples", "auto");  // unless it is given
        if (light.contains("domain")) light.insert("boxes", "auto");
    });
}

void apply_settings(toml::table& root, const std::vector<Setting>& settings) {
    const bool has_goal = std::ranges::any_of(settings, [](const Setting& s) {
        return !s.value.empty() && (s.key == "target_error" || s.key == "time_budget");
    });
    if (has_goal)
        free_settings(root);
    else if (!settings.empty() && leaves_all_open(root))
        write_all_open(root);  // one setting does not settle the others
    for (const Setting& setting : settings) {
        const std::string where = table_of_setting(setting.key);
        if (where == "light") {
            for_each_light(root, [&](toml::table& light) {
                if (setting.light.empty() || light["name"].value<std::string>() == setting.light)
                    set(light, setting);
            });
            continue;
        }
        if (!root.contains(where)) root.insert(where, toml::table{});
        if (toml::table* table = root[where].as_table()) set(*table, setting);
    }
}

std::string text_of(const toml::table& root) {
    std::ostringstream out;
    out << root << "\n";
    return out.str();
}

}  // namespace

std::string table_of_setting(const std::string& key) {
    static const std::map<std::string, std::string> tables{
        {"photons", "bake"},      {"components", "bake"},    {"degree", "bake"},    {"robust", "bake"},
        {"store", "bake"},        {"shrinkage", "bake"},     {"seed", "bake"},      {"cells", "grid"},
        {"cell_size", "grid"},    {"facings", "grid"},       {"estimator", "grid"}, {"radius", "grid"},
        {"bounds", "grid"},       {"reach_photons", "grid"}, {"samples", "light"},  {"boxes", "light"},
        {"target_error", "bake"}, {"time_budget", "bake"}};
    const auto found = tables.find(key);
    if (found != tables.end()) return found->second;
    std::string all;
    for (const auto& [known, table] : tables) all += (all.empty() ? "" : ", ") + known;
    throw UsageError(fmt::format("'{}' is no setting; allowed: {}", key, all));
}

std::optional<double> parse_duration(const std::string& text) {
    std::size_t used = 0;
    double value = 0;
    try {
        value = std::stod(text, &used);
    } catch (const std::exception&) {
        return std::nullopt;
    }
    const std::string unit = text.substr(used);
    const double seconds = unit.empty() || unit == "s" ? 1 : unit == "m" ? 60 : unit == "h" ? 3600 : 0;
    if (!(seconds > 0) || !std::isfinite(value * seconds)) return std::nullopt;
    return value * seconds;
}

Scene read_scene_text(const std::string& text, const std::string& name, const fs::path& folder,
                      const SceneOptions& options) {
    toml::table root = parse(text, name);
    apply_settings(root, options.settings);
    Scene scene = DescriptionReader(root, name, folder, options).read();
    scene.description_file = name;
    scene.description = options.settings.empty() ? text : text_of(root);
    return scene;
}

Scene read_scene(const fs::path& path, const SceneOptions& options) {
    return read_scene_text(read_text(path), path.string(), path.parent_path(), options);
}

}  // namespace pim
