// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/scene.h"

#include <fmt/format.h>

#include <set>

#include "common/core/error.h"
#include "common/core/file.h"
#include "common/scene/texture.h"

namespace pim {
namespace {

template <class T>
void feed(ContentHash& hash, const std::vector<T>& values) {
    const uint64_t count = values.size();
    hash.feed(&count, sizeof count);
    hash.feed(values.data(), values.size() * sizeof(T));
}

bool grey(const Rgb& c) { return c.x == c.y && c.y == c.z; }

bool grey(const Scene& scene, const Material& m) {
    if (m.glass) return true;
    const bool textured = m.texture && (m.texture_tints_specular || !is_black(m.diffuse));
    return grey(m.diffuse) && grey(m.specular) &&
           (!textured ||
            std::ranges::all_of(scene.textures[*m.texture].pixels, [](const Rgb& c) { return grey(c); }));
}

template <class Named>
std::string names(const std::vector<Named>& all) {
    std::string text;
    for (const Named& one : all) text += (text.empty() ? "" : ", ") + one.name;
    return text.empty() ? "none" : text;
}

template <class Named>
std::size_t find_named(const std::vector<Named>& all, const std::string& wanted, const char* what) {
    for (std::size_t i = 0; i < all.size(); ++i)
        if (all[i].name == wanted) return i;
    throw UsageError(fmt::format("there is no {} named '{}'; the scene has: {}", what, wanted, names(all)));
}

}  // namespace

const char* name(Component component) { return component == Component::direct ? "direct" : "indirect"; }

Reflectance reflectance(const Scene& scene, uint32_t triangle, float b1, float b2) {
    const Material& m = scene.materials[scene.geometry.triangles[triangle].material];
    if (m.glass) return {Rgb(0), Rgb(0)};
    if (!m.texture) return {m.diffuse, m.specular};
    const auto& v = scene.geometry.triangles[triangle].vertices;
    const auto& uv = scene.geometry.texture_coordinates;
    const Rgb texel =
        sample_texture(scene.textures[*m.texture], uv[v[0]] * (1 - b1 - b2) + uv[v[1]] * b1 + uv[v[2]] * b2);
    return {m.diffuse * texel, m.texture_tints_specular ? m.specular * texel : m.specular};
}

bool is_automatic(const Scene& scene) {
    const Choices& c = scene.choices;
    return c.cells || c.photons || c.degree || c.target_error || c.time_budget ||
           std::ranges::any_of(scene.lights,
                               [](const Light& l) { return l.choose_boxes || l.choose_samples; });
}

bool is_grey(const Scene& scene) {
    std::set<uint32_t> used;
    for (const Triangle& t : scene.geometry.triangles) used.insert(t.material);
    return std::ranges::all_of(used, [&](uint32_t m) { return grey(scene, scene.materials[m]); });
}

const Camera& find_camera(const Scene& scene, const std::string& wanted) {
    return scene.cameras[find_named(scene.cameras, wanted, "camera")];
}

std::size_t find_light(const Scene& scene, const std::string& wanted) {
    return find_named(scene.lights, wanted, "light");
}

std::string content_hash(const Scene& scene) {
    ContentHash hash;
    const Geometry& g = scene.geometry;
    hash.feed(&g.origin, sizeof g.origin);
    feed(hash, g.positions);
    feed(hash, g.normals);
    feed(hash, g.texture_coordinates);
    for (const Triangle& t : g.triangles) {
        hash.feed(t.vertices.data(), sizeof t.vertices);
        hash.feed(&t.material, sizeof t.material);
    }
    for (const Material& m : scene.materials) {
        const Rgb colors[] = {m.diffuse, m.specular};
        const float numbers[] = {float(m.glass), m.ior, float(m.texture.value_or(-1)),
                                 float(m.texture_tints_specular)};
        hash.feed(colors, sizeof colors);
        hash.feed(numbers, sizeof numbers);
    }
    for (const Image& t : scene.textures) {
        hash.feed(&t.width, sizeof t.width);
        feed(hash, t.pixels);
    }
    return hash.hex();
}

}  // namespace pim
