// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/files/scene_export.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "common/core/error.h"
#include "temporary_folder.h"
#include "test_scenes.h"

namespace pim {
namespace {

using nlohmann::json;

Vec3 vector_of(const json& j) { return {j.at(0).get<float>(), j.at(1).get<float>(), j.at(2).get<float>()}; }

// A room far from the world's origin with a smooth ball, a textured sheet, glass, and a lamp of each type.
class SceneExport : public testing::Test {
  protected:
    SceneExport() : scene_(room(Rgb(0.1f, 0.5f, 0.7f), Vec3(4))) {
        scene_.geometry.origin = {100.1, -20.7, 0.3};
        scene_.materials.push_back(mirror_material({0.3f, 0.2f, 0.1f}));
        scene_.materials.back().diffuse = {0.6f, 0.5f, 0.4f};
        scene_.materials.back().texture = 1;
        scene_.materials.back().texture_tints_specular = true;
        scene_.materials.push_back(glass_material(1.33f));
        add_sphere(scene_, Vec3(2), 0.5f, 1, false, true, 2);
        add_quad(scene_, Vec3(1), {1, 0, 0}, {0, 1, 0}, 1);
        scene_.geometry.texture_coordinates.back() = {-1.3f, 2.7f};
        scene_.textures = {Image(1, 1), Image(3, 2)};
        for (std::size_t i = 0; i < 6; ++i) scene_.textures[1].pixels[i] = Rgb(0.1f, 0.37f, 1.7f) * float(i);
        scene_.lights.push_back(rectangle_lamp({1, 3, 2}, {0.5f, 0.25f}, {0, -1, 0.3f}, {3, 2, 1}));
        state_.lamps = {{.position = {1.1f, 2.2f, 3.3f}, .gain = 2, .colour = {1, 0.5f, 0.1f}},
                        {.position = {1, 3, 2}, .on = true}};
        state_.camera = {.name = "front", .eye = {2, 2, 3.5f}, .target = {2.1f, 2, 0}, .vertical_fov = 39.3f};
    }
    json exported() const {
        export_scene(folder_ / "out", scene_, state_, {321, 123});
        return json::parse(bytes_of(folder_ / "out/scene.json"));
    }

    TemporaryFolder folder_;
    Scene scene_;
    ViewState state_;
};

TEST_F(SceneExport, GeometryIsExact) {
    const json j = exported();
    const Geometry& g = scene_.geometry;
    for (int axis = 0; axis < 3; ++axis) EXPECT_EQ(j["origin"][axis].get<double>(), g.origin[axis]);
    ASSERT_EQ(j["vertices"].size(), g.positions.size());
    ASSERT_EQ(j["normals"].size(), g.positions.size());
    ASSERT_EQ(j["uv"].size(), g.positions.size());
    int flat = 0;
    for (std::size_t v = 0; v < g.positions.size(); ++v) {
        EXPECT_EQ(vector_of(j["vertices"][v]), g.positions[v]);
        EXPECT_EQ(vector_of(j["normals"][v]), g.normals[v]);
        EXPECT_EQ(j["uv"][v][0].get<float>(), g.texture_coordinates[v].x);
        EXPECT_EQ(j["uv"][v][1].get<float>(), g.texture_coordinates[v].y);
        flat += vector_of(j["normals"][v]) == Vec3(0);
    }
    EXPECT_GT(flat, 0);
    EXPECT_LT(flat, int(g.positions.size()));
    ASSERT_EQ(j["triangles"].size(), g.triangles.size());
    for (std::size_t t = 0; t < g.triangles.size(); ++t) {
        for (int k = 0; k < 3; ++k)
            EXPECT_EQ(j["triangles"][t][k].get<uint32_t>(), g.triangles[t].vertices[k]);
        EXPECT_EQ(j["triangles"][t][3].get<uint32_t>(), g.triangles[t].material);
    }
}

TEST_F(SceneExport, Materials) {
    const json materials = exported()["materials"];
    ASSERT_EQ(materials.size(), scene_.materials.size());
    for (std::size_t m = 0; m < scene_.materials.size(); ++m) {
        EXPECT_EQ(materials[m]["name"], scene_.materials[m].name);
        EXPECT_EQ(vector_of(materials[m]["diffuse"]), scene_.materials[m].diffuse);
        EXPECT_EQ(vector_of(materials[m]["specular"]), scene_.materials[m].specular);
        EXPECT_EQ(materials[m]["texture_tints_specular"], scene_.materials[m].texture_tints_specular);
        EXPECT_EQ(materials[m]["glass"], scene_.materials[m].glass);
        EXPECT_EQ(materials[m]["ior"].get<float>(), scene_.materials[m].ior);
    }
    EXPECT_TRUE(materials[0]["texture"].is_null());
    EXPECT_EQ(materials[1]["texture"], "texture_1.exr");
}

TEST_F(SceneExport, TexturesAreLinear) {
    exported();
    EXPECT_EQ(read_image(folder_ / "out/texture_0.exr").pixels, scene_.textures[0].pixels);
    const Image texture = read_image(folder_ / "out/texture_1.exr");
    EXPECT_EQ(texture.width, 3);
    EXPECT_EQ(texture.pixels, scene_.textures[1].pixels);
}

TEST_F(SceneExport, LampsAsTheyShine) {
    const json lamps = exported()["lights"];
    ASSERT_EQ(lamps.size(), 2u);
    EXPECT_EQ(lamps[0]["type"], "point");
    EXPECT_EQ(vector_of(lamps[0]["position"]), state_.lamps[0].position);
    EXPECT_EQ(vector_of(lamps[0]["power"]), Rgb(1) * state_.lamps[0].colour * 2);
    EXPECT_FALSE(lamps[0].contains("size"));
    const RectangleShape& shape = *scene_.lights[1].rectangle();
    EXPECT_EQ(lamps[1]["type"], "rectangle");
    EXPECT_EQ(vector_of(lamps[1]["power"]), Rgb(3, 2, 1));
    EXPECT_EQ(lamps[1]["size"], json({0.5, 0.25}));
    EXPECT_EQ(vector_of(lamps[1]["normal"]), shape.normal);
    for (int axis = 0; axis < 2; ++axis) EXPECT_EQ(vector_of(lamps[1]["axes"][axis]), shape.axes[axis]);
}

TEST_F(SceneExport, LampsThatAreOffHaveNoPower) {
    state_.lamps[1].on = false;
    EXPECT_EQ(vector_of(exported()["lights"][1]["power"]), Rgb(0));
}

TEST_F(SceneExport, Camera) {
    state_.show_lamps = true;
    const json j = exported();
    EXPECT_EQ(j["lights_visible"], true);
    EXPECT_EQ(vector_of(j["camera"]["eye"]), state_.camera.eye);
    EXPECT_EQ(vector_of(j["camera"]["target"]), state_.camera.target);
    EXPECT_EQ(vector_of(j["camera"]["up"]), state_.camera.up);
    EXPECT_EQ(j["camera"]["vertical_fov"].get<float>(), 39.3f);
    EXPECT_EQ(j["camera"]["size"], json({321, 123}));
}

TEST_F(SceneExport, WritesOverAnEarlierOne) {
    exported();
    state_.camera.eye = {1, 2, 3};
    EXPECT_EQ(vector_of(exported()["camera"]["eye"]), Vec3(1, 2, 3));
}

TEST_F(SceneExport, NamesThatAreNoUnicode) {
    scene_.materials[0].name = "caf\xe9";
    EXPECT_EQ(exported()["materials"][0]["name"], "caf\uFFFD");
}

TEST_F(SceneExport, Errors) {
    const auto message = [&](const std::filesystem::path& path) {
        return message_of<Error>([&] { export_scene(path, scene_, state_, {1, 1}); });
    };
    const std::filesystem::path nowhere = folder_ / "missing/out", file = folder_.write("file", "");
    EXPECT_EQ(message(nowhere), nowhere.string() + ": the folder cannot be made: No such file or directory");
    EXPECT_EQ(message(file), file.string() + ": the folder cannot be made: File exists");
}

}  // namespace
}  // namespace pim
