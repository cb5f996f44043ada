// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/gltf_lights.h"

#include <ImathMatrix.h>
#include <ImathQuat.h>
#include <fmt/format.h>

#include <array>
#include <bit>
#include <cstring>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "common/core/error.h"
#include "common/core/file.h"

namespace pim {
namespace {

namespace fs = std::filesystem;
using Imath::M44d;
using nlohmann::json;

constexpr std::size_t kGlbHeader = 12, kChunkHeader = 8;  // bytes
static_assert(std::endian::native == std::endian::little);

// The JSON of a .glb is its first chunk: length, type, text.
std::string json_text(const fs::path& path) {
    std::ifstream stream(path, std::ios::binary);
    std::array<char, kGlbHeader + kChunkHeader> head{};
    stream.read(head.data(), head.size());
    if (std::memcmp(head.data(), "glTF", 4) != 0) return read_text(path);
    uint32_t length = 0;
    std::memcpy(&length, head.data() + kGlbHeader, sizeof length);
    if (std::memcmp(head.data() + kGlbHeader + 4, "JSON", 4) != 0 || length > fs::file_size(path))
        throw Error(fmt::format("{}: the file does not begin with its JSON chunk", path.string()));
    std::string text(length, '\0');
    stream.read(text.data(), length);
    if (!stream) throw Error(fmt::format("{}: the file ends within its JSON chunk", path.string()));
    return text;
}

// glTF stores columns of matrices for column vectors: the rows of ours.
M44d own_transform(const json& node) {
    if (node.contains("matrix")) {
        const auto m = node["matrix"].get<std::array<double, 16>>();
        return {m[0], m[1], m[2],  m[3],  m[4],  m[5],  m[6],  m[7],
                m[8], m[9], m[10], m[11], m[12], m[13], m[14], m[15]};
    }
    const auto t = node.value("translation", std::array<double, 3>{0, 0, 0});
    const auto r = node.value("rotation", std::array<double, 4>{0, 0, 0, 1});
    const auto s = node.value("scale", std::array<double, 3>{1, 1, 1});
    M44d scale, move;
    scale.setScale(Vec3d(s[0], s[1], s[2]));
    move.setTranslation(Vec3d(t[0], t[1], t[2]));
    return scale * Imath::Quatd(r[3], r[0], r[1], r[2]).normalized().toMatrix44() * move;
}

class Walk {
  public:
    explicit Walk(const json& file) : file_(file) {
        for (const std::size_t root : roots()) visit(root, M44d(), 0);
        name();
    }
    std::vector<GltfLight> lights;

  private:
    // Those of the default scene; nodes that are nobody's children where the file has no scene.
    std::vector<std::size_t> roots() const {
        if (file_.contains("scenes"))
            return file_["scenes"].at(file_.value("scene", std::size_t(0))).value("nodes", Indices{});
        std::set<std::size_t> children;
        const json nodes = file_.value("nodes", json::array());
        for (const json& node : nodes)
            for (const std::size_t child : node.value("children", Indices{})) children.insert(child);
        Indices roots;
        for (std::size_t i = 0; i < nodes.size(); ++i)
            if (!children.contains(i)) roots.push_back(i);
        return roots;
    }

    void visit(std::size_t index, const M44d& parent, std::size_t depth) {
        const json& nodes = file_.at("nodes");
        const json& node = nodes.at(index);
        if (depth > nodes.size()) throw Error("its nodes are children of themselves");
        const M44d transform = own_transform(node) * parent;
        static const json::json_pointer kLight("/extensions/KHR_lights_punctual/light");
        if (node.contains(kLight)) add(node, node[kLight].get<std::size_t>(), transform);
        for (const std::size_t child : node.value("children", Indices{})) visit(child, transform, depth + 1);
    }

    void add(const json& node, std::size_t index, const M44d& transform) {
        static const json::json_pointer kLights("/extensions/KHR_lights_punctual/lights");
        const json& light = file_.at(kLights).at(index);
        const auto color = light.value("color", std::array<float, 3>{1, 1, 1});
        const float intensity = light.value("intensity", 1.0f);
        lights.push_back({light.value("name", ""), light.value("type", "point"),
                          Rgb(color[0], color[1], color[2]) * intensity, transform.translation()});
        node_names_.push_back(node.value("name", ""));
    }

    void name() {
        std::map<std::string, int> count;
        for (const std::string& n : node_names_) ++count[n];
        for (std::size_t i = 0; i < lights.size(); ++i) {
            if (!node_names_[i].empty() && count[node_names_[i]] == 1) lights[i].name = node_names_[i];
            if (lights[i].name.empty()) lights[i].name = "lamp";
        }
    }

    using Indices = std::vector<std::size_t>;
    const json& file_;
    std::vector<std::string> node_names_;  // of the lights
};

}  // namespace

std::vector<GltfLight> read_gltf_lights(const fs::path& path) {
    const std::string text = json_text(path);
    try {
        return Walk(json::parse(text)).lights;
    } catch (const std::exception& e) {
        throw Error(fmt::format("{}: the lamps of the file cannot be read: {}", path.string(), e.what()));
    }
}

}  // namespace pim
