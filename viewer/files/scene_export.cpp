// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/files/scene_export.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "common/core/error.h"
#include "common/core/file.h"
#include "common/core/image.h"

namespace pim {
namespace {

using nlohmann::json;

template <class Number>
json json_of(const Imath::Vec3<Number>& v) {
    return {v.x, v.y, v.z};
}

json json_of(const Vec2& v) { return {v.x, v.y}; }

json json_of(const Triangle& t) { return {t.vertices[0], t.vertices[1], t.vertices[2], t.material}; }

std::string texture_file(int texture) { return fmt::format("texture_{}.exr", texture); }

json json_of(const Material& m) {
    return {{"name", m.name},
            {"diffuse", json_of(m.diffuse)},
            {"specular", json_of(m.specular)},
            {"texture", m.texture ? json(texture_file(*m.texture)) : json()},
            {"texture_tints_specular", m.texture_tints_specular},
            {"glass", m.glass},
            {"ior", m.ior}};
}

template <class Value>
json json_of(const std::vector<Value>& values) {
    json list = json::array();
    for (const Value& v : values) list.push_back(json_of(v));
    return list;
}

json json_of(const Light& light, const LightState& state) {
    json lamp{{"name", light.name},
              {"type", light.rectangle() ? "rectangle" : "point"},
              {"position", json_of(state.position)},
              {"power", json_of(state.power)}};
    if (const RectangleShape* rectangle = light.rectangle()) {
        lamp["size"] = {rectangle->size.x, rectangle->size.y};
        lamp["axes"] = {json_of(rectangle->axes[0]), json_of(rectangle->axes[1])};
        lamp["normal"] = json_of(rectangle->normal);
    }
    return lamp;
}

json lamps(const Scene& scene, const ViewState& state) {
    const std::vector<LightState> states = shining(scene, state);
    json list = json::array();
    for (std::size_t l = 0; l < states.size(); ++l) list.push_back(json_of(scene.lights[l], states[l]));
    return list;
}

json json_of(const Camera& camera, const Imath::V2i& size) {
    return {{"eye", json_of(camera.eye)},
            {"target", json_of(camera.target)},
            {"up", json_of(camera.up)},
            {"vertical_fov", camera.vertical_fov},
            {"size", {size.x, size.y}}};
}

void make_folder(const std::filesystem::path& folder) {
    std::error_code problem;
    std::filesystem::create_directory(folder, problem);
    if (!std::filesystem::is_directory(folder))
        throw Error(fmt::format("{}: the folder cannot be made: {}", folder.string(), problem.message()));
}

}  // namespace

void export_scene(const std::filesystem::path& folder, const Scene& scene, const ViewState& state,
                  const Imath::V2i& size) {
    make_folder(folder);
    for (std::size_t t = 0; t < scene.textures.size(); ++t)
        write_image(folder / texture_file(int(t)), scene.textures[t], 1);
    const Geometry& g = scene.geometry;
    const json exported{{"origin", json_of(g.origin)},          {"vertices", json_of(g.positions)},
                        {"normals", json_of(g.normals)},        {"uv", json_of(g.texture_coordinates)},
                        {"triangles", json_of(g.triangles)},    {"materials", json_of(scene.materials)},
                        {"lights", lamps(scene, state)},        {"lights_visible", state.show_lamps},
                        {"camera", json_of(state.camera, size)}};
    using Handler = json::error_handler_t;  // names come from files of any encoding
    write_text_atomically(folder / "scene.json", exported.dump(-1, ' ', false, Handler::replace) + "\n");
}

}  // namespace pim
