// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/scene_file.h"

#include <gtest/gtest.h>

#include "common/core/error.h"
#include "common/core/log.h"
#include "temporary_folder.h"

namespace pim {
namespace {

const std::string kScene = "[scene]\ngeometry = \"a.obj\"\n";
const std::string kLight = "[[light]]\nname = \"lamp\"\nposition = [0.5, 1, 0.5]\n";

const Material& material_named(const Scene& scene, const std::string& name) {
    return *std::ranges::find(scene.materials, name, &Material::name);
}

class SceneFile : public testing::Test {
  protected:
    SceneFile() {
        set_log_level("error");
        folder_.write("a.mtl", "newmtl wall\nKd 0.25 0.5 0.75\nnewmtl floor\nKd 0.5 0.5 0.5\n");
        folder_.write("a.obj",
                      "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 1\nusemtl wall\nf 1 2 3\nusemtl "
                      "floor\nf 1 2 4\n");
    }
    Scene read(const std::string& text, const SceneOptions& options = {}) const {
        return read_scene_text(text, "test.toml", folder_.path(), options);
    }
    std::string error(const std::string& text) const {
        return message_of<Error>([&] { read(text); });
    }
    // The error names the file, that line and that key.
    void expect_error(const std::string& text, int line, const std::string& key) const {
        const std::string message = error(text), where = "test.toml:" + std::to_string(line) + ":";
        EXPECT_NE(message.find(where), std::string::npos) << where << " in: " << message << "\n" << text;
        EXPECT_NE(message.find(key), std::string::npos) << key << " in: " << message;
        EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    }
    TemporaryFolder folder_;
};

TEST_F(SceneFile, Defaults) {
    const Scene scene = read(kScene + kLight);
    EXPECT_EQ(std::get<CellCount>(scene.grid.resolution).longest, 64);
    EXPECT_TRUE(scene.grid.facings);
    EXPECT_EQ(scene.grid.estimator, Estimator::area);
    EXPECT_TRUE(scene.grid.reachable_area_only);
    EXPECT_EQ(scene.bake.photons, 40000u);
    EXPECT_EQ(scene.bake.components, std::vector<Component>{Component::indirect});
    EXPECT_EQ(scene.bake.degree, 3);
    EXPECT_EQ(scene.bake.store, Store::incident);
    EXPECT_TRUE(scene.bake.shrinkage);
    EXPECT_FALSE(read("[bake]\nshrinkage = false\n" + kScene + kLight).bake.shrinkage);
    EXPECT_EQ(scene.bake.seed, 1u);
    ASSERT_EQ(scene.lights.size(), 1u);
    EXPECT_FALSE(scene.lights[0].rectangle());
    EXPECT_EQ(scene.lights[0].domain.min, scene.lights[0].domain.max);  // it stands still
    EXPECT_EQ(std::get<int>(scene.lights[0].samples), 1);
    EXPECT_EQ(scene.cameras.size(), 1u);  // one that sees everything
    EXPECT_EQ(scene.description, kScene + kLight);
}

TEST_F(SceneFile, EveryKey) {
    const Scene scene = read(R"(
[scene]
geometry = "a.obj"
metres_per_unit = 2.0
[grid]
cell_size = 0.125
bounds = { min = [0, 0, 0], max = [2, 4, 1.5] }
facings = false
estimator = "sphere"
radius = 0.5
[bake]
photons = 1234
components = ["indirect", "direct"]
degree = 2
robust = "off"
store = "absorbed"
seed = 99
[[light]]
name = "panel"
type = "rectangle"
size = [0.5, 0.25]
normal = [0, -2, 0]
power = [1, 2, 3]
domain = { min = [0, 1, 0], max = [1, 1, 2] }
boxes = [2, 3, 4]
samples = [6, 4, 5]
position = [0.5, 1, 1]
[[light]]
name = "bulb"
domain = { min = [0, 0, 0], max = [1, 1, 2] }
samples = 77
[[camera]]
name = "front"
eye = [0, 1, 5]
target = [0, 1, 0]
up = [0, 0.5, 0.5]
vertical_fov = 55.5
size = [393, 200]
[[material]]
name = "wall"
kind = "glass"
ior = 1.7
[[material]]
name = "floor"
diffuse = [0.1, 0.2, 0.3]
specular = [0.9, 0.8, 0.7]
)");
    EXPECT_EQ(scene.geometry.corners(0)[2], Vec3(0, 4, 0));
    EXPECT_EQ(std::get<CellSize>(scene.grid.resolution).metres, 0.125);
    EXPECT_EQ(scene.grid.bounds->max, Vec3(2, 4, 1.5f));
    EXPECT_FALSE(scene.grid.facings);
    EXPECT_EQ(scene.grid.estimator, Estimator::sphere);
    EXPECT_EQ(scene.grid.radius, 0.5);
    EXPECT_EQ(scene.bake.photons, 1234u);
    EXPECT_EQ(scene.bake.components.size(), 2u);
    EXPECT_EQ(scene.bake.degree, 2);
    EXPECT_EQ(scene.bake.robust, Robust::off);
    EXPECT_EQ(scene.bake.store, Store::absorbed);
    EXPECT_EQ(scene.bake.seed, 99u);
    const Light& panel = scene.lights.at(find_light(scene, "panel"));
    ASSERT_TRUE(panel.rectangle());
    EXPECT_EQ(panel.rectangle()->size, Vec2(0.5f, 0.25f));
    EXPECT_EQ(panel.rectangle()->normal, Vec3(0, -1, 0));
    EXPECT_EQ(panel.power, Rgb(1, 2, 3));
    EXPECT_EQ(panel.domain.max, Vec3(1, 1, 2));
    EXPECT_EQ(panel.boxes, Index3(2, 1, 4));  // an axis without movement is not divided
    EXPECT_EQ(std::get<Index3>(panel.samples), Index3(6, 4, 5));
    EXPECT_EQ(panel.position, Vec3(0.5f, 1, 1));
    const Light& bulb = scene.lights.at(find_light(scene, "bulb"));
    EXPECT_EQ(bulb.position, Vec3(0.5f, 0.5f, 1));  // the middle of its domain
    EXPECT_EQ(std::get<int>(bulb.samples), 77);
    const Camera& front = find_camera(scene, "front");
    EXPECT_EQ(front.eye, Vec3(0, 1, 5));
    EXPECT_EQ(front.up, Vec3(0, 0.5f, 0.5f));
    EXPECT_FLOAT_EQ(front.vertical_fov, 55.5f);
    EXPECT_EQ(front.size, Imath::V2i(393, 200));
    EXPECT_TRUE(material_named(scene, "wall").glass);
    EXPECT_EQ(material_named(scene, "wall").ior, 1.7f);
    EXPECT_EQ(material_named(scene, "floor").diffuse, Rgb(0.1f, 0.2f, 0.3f));
    EXPECT_EQ(material_named(scene, "floor").specular, Rgb(0.9f, 0.8f, 0.7f));
    EXPECT_THROW(find_light(scene, "none"), UsageError);
    EXPECT_THROW(find_camera(scene, "none"), UsageError);
}

TEST_F(SceneFile, MirrorKind) {
    const Scene scene = read(kScene + kLight + "[[material]]\nname = \"wall\"\nkind = \"mirror\"\n");
    EXPECT_EQ(material_named(scene, "wall").diffuse, Rgb(0));
    EXPECT_EQ(material_named(scene, "wall").specular, Rgb(0.25f, 0.5f, 0.75f));
}

TEST_F(SceneFile, WithoutGridAndBakeAllIsLeftToTheBake) {
    const std::string roams = "domain = { min = [0,0,0], max = [1,1,1] }\n";
    const Scene open = read(kScene + kLight + roams);
    EXPECT_TRUE(is_automatic(open));
    EXPECT_TRUE(open.choices.cells && open.choices.photons && open.choices.degree);
    EXPECT_TRUE(open.lights[0].choose_boxes && open.lights[0].choose_samples);
    for (const char* table : {"[grid]\n", "[bake]\n"})
        EXPECT_FALSE(is_automatic(read(kScene + kLight + roams + table)));
}

TEST_F(SceneFile, OneSettingOfACommandDoesNotSettleTheOthers) {
    const std::string text = kScene + kLight + "domain = { min = [0,0,0], max = [1,1,1] }\n";
    const Scene scene = read(text, {.settings = {{"seed", "2"}, {"photons", "90"}}, .geometry = {}});
    EXPECT_EQ(scene.bake.seed, 2u);
    EXPECT_EQ(scene.bake.photons, 90u);
    EXPECT_FALSE(scene.choices.photons);
    EXPECT_TRUE(scene.choices.cells && scene.choices.degree && scene.lights[0].choose_samples);
    EXPECT_TRUE(is_automatic(read(scene.description)));
    const Scene settled = read(text, {.settings = {{"cell_size", "0.1"},
                                                   {"photons", "90"},
                                                   {"degree", "2"},
                                                   {"boxes", "[1, 1, 2]"},
                                                   {"samples", "70"}},
                                      .geometry = {}});
    EXPECT_FALSE(is_automatic(settled));
    EXPECT_EQ(std::get<CellSize>(settled.grid.resolution).metres, 0.1);
    EXPECT_FALSE(is_automatic(read(text + "[bake]\n", {.settings = {{"seed", "2"}}, .geometry = {}})));
}

TEST_F(SceneFile, WhatIsWrittenStaysAndAutoIsChosen) {
    const std::string roams = "domain = { min = [0,0,0], max = [1,1,1] }\n";
    const Scene aimed =
        read(kScene + kLight + roams + "boxes = [2, 1, 1]\n[bake]\ntarget_error = 0.05\nphotons = 700\n");
    EXPECT_EQ(aimed.choices.target_error, 0.05);
    EXPECT_TRUE(aimed.choices.cells && aimed.choices.degree && aimed.lights[0].choose_samples);
    EXPECT_TRUE(aimed.choices.reach_photons);
    EXPECT_FALSE(aimed.choices.photons || aimed.lights[0].choose_boxes);
    EXPECT_EQ(aimed.bake.photons, 700u);
    const Scene single = read(kScene + kLight + roams + "samples = \"auto\"\n[grid]\ncells = 20\n");
    EXPECT_TRUE(single.lights[0].choose_samples);
    EXPECT_FALSE(single.lights[0].choose_boxes || single.choices.cells || single.choices.photons);
    EXPECT_EQ(read(kScene + kLight + "[bake]\ntime_budget = \"2.5m\"\n").choices.time_budget, 150.0);
    const Scene timed =
        read(kScene + kLight + "[bake]\ntime_budget = \"5s\"\n[grid]\nreach_photons = 70000\n");
    EXPECT_FALSE(timed.choices.reach_photons);
    EXPECT_EQ(timed.grid.reach_photons, 70000u);
    const Scene groups =
        read(kScene + kLight + roams +
             "samples = [{ boxes = [1,1,1], count = 9 }, { boxes = [2,1,1], count = 5 }]\n[bake]\n");
    const auto& list = std::get<std::vector<SampleGroup>>(groups.lights[0].samples);
    ASSERT_EQ(list.size(), 2u);
    EXPECT_EQ(list[1].boxes, Index3(2, 1, 1));
    EXPECT_EQ(list[1].count, 5);
}

// One place needs photons, not positions: but a bake that chooses adds photons as positions.
TEST_F(SceneFile, ALampThatStandsStillHasOnePositionUnlessAListSaysMore) {
    const std::string lamp = kScene + "[[light]]\nname = \"still\"\nposition = [0.5, 0.5, 0.5]\n";
    EXPECT_EQ(std::get<int>(read(lamp + "samples = 9\n[bake]\n").lights[0].samples), 1);
    const Scene listed = read(lamp + "samples = [{ boxes = [1,1,1], count = 9 }]\n[bake]\n");
    EXPECT_EQ(std::get<std::vector<SampleGroup>>(listed.lights[0].samples)[0].count, 9);
    const Scene open = read(lamp);
    EXPECT_TRUE(open.lights[0].choose_samples);
    EXPECT_FALSE(open.lights[0].choose_boxes);
}

// A target on the command line is for whom does not want to think of settings: those of the description go.
TEST_F(SceneFile, ATargetFreesTheSettingsOfTheDescription) {
    const std::string text = kScene + kLight +
                             "domain = { min = [0,0,0], max = [1,1,1] }\nboxes = [2,1,1]\nsamples = 50\n" +
                             "[grid]\ncells = 20\n[bake]\nphotons = 700\ndegree = 2\nseed = 5\n";
    const Scene scene =
        read(text, {.settings = {{"target_error", "0.1"}, {"photons", "90"}}, .geometry = {}});
    EXPECT_TRUE(scene.choices.cells && scene.choices.degree && scene.lights[0].choose_boxes);
    EXPECT_FALSE(scene.choices.photons);
    EXPECT_EQ(scene.bake.photons, 90u);
    EXPECT_EQ(scene.bake.seed, 5u);
    const Scene settled = read(text, {.settings = {{"target_error", "0.1"},
                                                   {"target_error", ""},
                                                   {"cells", "9"},
                                                   {"photons", "90"},
                                                   {"degree", "1"},
                                                   {"boxes", "[1, 1, 3]", "lamp"},
                                                   {"samples", "30", "lamp"}},
                                      .geometry = {}});
    EXPECT_FALSE(is_automatic(settled));
    EXPECT_EQ(settled.lights[0].boxes, Index3(1, 1, 3));
    const Scene again = read(settled.description);
    EXPECT_EQ(again.description, settled.description);
    EXPECT_EQ(std::get<int>(again.lights[0].samples), 30);
}

TEST_F(SceneFile, DurationsHaveUnits) {
    EXPECT_EQ(parse_duration("90"), 90.0);
    EXPECT_EQ(parse_duration("90s"), 90.0);
    EXPECT_EQ(parse_duration("1.5m"), 90.0);
    EXPECT_EQ(parse_duration("8h"), 28800.0);
    for (const char* wrong : {"", "m", "10 parsecs", "-", "1e999s", "1e308h"})
        EXPECT_FALSE(parse_duration(wrong)) << wrong;
    expect_error(kScene + kLight + "[bake]\ntime_budget = \"soon\"\n", 7, "bake.time_budget");
    expect_error(kScene + kLight + "[bake]\ntarget_error = 0\n", 7, "bake.target_error");
    expect_error("preset = \"thesis\"\n" + kScene + kLight + "[bake]\ntarget_error = 0.1\n", 8, "thesis");
}

TEST_F(SceneFile, UnknownKeysAreNamed) {
    expect_error("what = 1\n" + kScene + kLight, 1, "what");
    expect_error(kScene + "colour = 1\n" + kLight, 3, "scene.colour");
    expect_error(kScene + kLight + "brightness = 3\n", 6, "light.brightness");
    expect_error(kScene + kLight + "[grid]\ncell = 3\n", 7, "grid.cell");
    expect_error(kScene + kLight + "[bake]\nphoton = 3\n", 7, "bake.photon");
    expect_error(kScene + kLight + "[[camera]]\nname = \"c\"\neye = [0,0,1]\ntarget = [0,0,0]\nfov = 3\n", 10,
                 "camera.fov");
    expect_error(kScene + kLight + "[[material]]\nname = \"wall\"\nroughness = 3\n", 8, "material.roughness");
    expect_error(kScene + kLight + "domain = { min = [0,0,0], max = [1,1,1], mid = [0,0,0] }\n", 6, "mid");
}

TEST_F(SceneFile, WrongTypes) {
    expect_error("[scene]\ngeometry = 3\n" + kLight, 2, "scene.geometry");
    expect_error(kScene + kLight + "[grid]\ncells = 3.5\n", 7, "grid.cells");
    expect_error(kScene + kLight + "[grid]\nfacings = 1\n", 7, "grid.facings");
    expect_error(kScene + kLight + "[bake]\nphotons = \"many\"\n", 7, "bake.photons");
    expect_error(kScene + kLight + "power = 100\n", 6, "light.power");
    expect_error(kScene + kLight + "power = [1, 2]\n", 6, "light.power");
    expect_error(kScene + kLight + "power = [1, 2, \"x\"]\n", 6, "light.power");
    expect_error(kScene + kLight + "domain = 3\n", 6, "light.domain");
    expect_error(kScene + kLight + "samples = [2.5, 4, 4]\ndomain = { min = [0,0,0], max = [1,1,1] }\n", 6,
                 "light.samples");
    expect_error(kScene + kLight + "[bake]\ncomponents = \"direct\"\n", 7, "bake.components");
    expect_error(kScene + "[light]\nname = \"lamp\"\n", 3, "light");
    expect_error("scene = 3\n", 1, "scene");
    expect_error(
        kScene + kLight + "[[camera]]\nname = \"c\"\neye = [0,0,1]\ntarget = [0,0,0]\nsize = [100.5, 20]\n",
        10, "camera.size");
}

TEST_F(SceneFile, ValuesOutOfRange) {
    expect_error(kScene + "metres_per_unit = 0\n" + kLight, 3, "metres_per_unit");
    expect_error(kScene + kLight + "[grid]\ncells = 0\n", 7, "grid.cells");
    expect_error(kScene + kLight + "[grid]\ncell_size = -1\n", 7, "grid.cell_size");
    expect_error(kScene + kLight + "[grid]\ncells = 3\ncell_size = 1\n", 8, "grid.cell_size");
    expect_error(kScene + kLight + "[grid]\nestimator = \"box\"\n", 7, "grid.estimator");
    expect_error(kScene + kLight + "[grid]\nbounds = { min = [1,0,0], max = [0,1,1] }\n", 7, "min");
    expect_error(kScene + kLight + "[bake]\nphotons = 0\n", 7, "bake.photons");
    expect_error(kScene + kLight + "[bake]\ndegree = 4\n", 7, "bake.degree");
    expect_error(kScene + kLight + "[bake]\nrobust = \"sometimes\"\n", 7, "bake.robust");
    expect_error(kScene + kLight + "[bake]\ncomponents = []\n", 7, "bake.components");
    expect_error(kScene + kLight + "[bake]\nseed = -1\n", 7, "bake.seed");
    expect_error(kScene + kLight + "power = [-1, 0, 0]\n", 6, "light.power");
    expect_error(kScene + kLight + "power = [nan, 0, 0]\n", 6, "light.power");
    expect_error(kScene + kLight + "type = \"spot\"\n", 6, "light.type");
    expect_error(kScene + kLight + "size = [1, 1]\n", 6, "light.size");
    expect_error(kScene + kLight + "type = \"rectangle\"\n", 6, "light.type");
    expect_error(kScene + kLight + "type = \"rectangle\"\nsize = [1, 1]\nnormal = [0, 0, 0]\n", 8,
                 "light.normal");
    expect_error(kScene + kLight + "domain = { min = [5,5,5], max = [6,6,6] }\n", 5, "light.position");
    expect_error(kScene + kLight + "boxes = [0, 1, 1]\n", 6, "light.boxes");
    expect_error(kScene + kLight + "samples = 0\n", 6, "light.samples");
    expect_error(
        kScene + kLight + "[[material]]\nname = \"wall\"\ndiffuse = [0.8,0,0]\nspecular = [0.3,0,0]\n", 9,
        "specular");
    expect_error(kScene + kLight + "[[material]]\nname = \"sky\"\n", 7, "material.name");
    expect_error(kScene + kLight + "[[material]]\nname = \"wall\"\nior = 0.5\n", 8, "material.ior");
    expect_error(kScene + kLight + "[[camera]]\nname = \"c\"\neye = [0,0,0]\ntarget = [0,0,0]\n", 9,
                 "camera.target");
    expect_error("preset = \"fast\"\n" + kScene + kLight, 1, "preset");
}

TEST_F(SceneFile, MissingAndDoubleThings) {
    expect_error("", 1, "[scene]");
    expect_error("[scene]\n" + kLight, 1, "scene.geometry");
    EXPECT_NE(error(kScene).find("lamp"), std::string::npos);
    expect_error(kScene + "[[light]]\nposition = [0,0,0]\n", 3, "light.name");
    expect_error(kScene + "[[light]]\nname = \"lamp\"\n", 3, "light.position");
    expect_error(kScene + kLight + kLight, 7, "light.name");
    expect_error(kScene + "[[light]]\nname = \"a/b\"\nposition = [0,0,0]\n", 4, "light.name");
    expect_error(kScene + kLight + "x = = 3\n", 6, "");  // no TOML at all
    EXPECT_NE(error("[scene]\ngeometry = \"none.obj\"\n" + kLight).find("none.obj"), std::string::npos);
}

TEST_F(SceneFile, ThesisPreset) {
    for (const std::string& more :
         {std::string(), std::string("[grid]\ncells = 30\n"), std::string("[bake]\nphotons = 500\n"),
          std::string("[grid]\ncells = 30\n[bake]\nphotons = 500\nrobust = \"auto\"\n"),
          std::string("[grid]\nfacings = true\nestimator = \"area\"\n[bake]\nstore = \"incident\"\n"
                      "components = [\"indirect\"]\ndegree = 1\nshrinkage = true\n")}) {
        const Scene scene = read("preset = \"thesis\"\n" + kScene + kLight +
                                 "domain = { min = [0,0,0], max = [1,1,1] }\nboxes = [2, 2, 2]\n" + more);
        EXPECT_FALSE(scene.grid.facings);
        EXPECT_EQ(scene.grid.estimator, Estimator::sphere);
        EXPECT_FALSE(scene.grid.reachable_area_only);
        EXPECT_EQ(scene.bake.components, (std::vector<Component>{Component::direct, Component::indirect}));
        EXPECT_EQ(scene.bake.robust, Robust::off);
        EXPECT_EQ(scene.bake.store, Store::absorbed);
        EXPECT_FALSE(scene.bake.shrinkage);
        EXPECT_FALSE(scene.bake.mend_signs);
        EXPECT_EQ(scene.bake.degree, 3);
        EXPECT_EQ(scene.lights[0].boxes, Index3(1));
    }
}

TEST_F(SceneFile, OverriddenPhotonsStandInTheDescription) {
    SceneOptions options;
    options.settings = {{"photons", "777"}};
    const Scene scene = read(kScene + kLight + "[bake]\nphotons = 5\n", options);
    EXPECT_EQ(scene.bake.photons, 777u);
    EXPECT_EQ(read(scene.description).bake.photons, 777u);  // what is stored makes the same map
    EXPECT_EQ(read(kScene + kLight, options).bake.photons, 777u);
    const std::string wrong = message_of<Error>([&] { read(kScene + kLight + "\n\n[extra]\n", options); });
    EXPECT_NE(wrong.find("test.toml:8:"), std::string::npos) << "lines of the user's own file: " << wrong;
}

TEST_F(SceneFile, GeometryHashFollowsWhatLightSees) {
    const std::string plain = read(kScene + kLight).geometry_hash;
    EXPECT_EQ(read(kScene + kLight + "[bake]\nphotons = 5\n").geometry_hash, plain);
    EXPECT_NE(read(kScene + kLight + "[[material]]\nname = \"wall\"\ndiffuse = [0,0,0]\n").geometry_hash,
              plain);
    EXPECT_NE(read(kScene + "metres_per_unit = 2\n" + kLight).geometry_hash, plain);
}

TEST_F(SceneFile, AllScenesOfTheProjectAreRead) {
    int count = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(PIM_DATA)) {
        if (entry.path().extension() != ".toml") continue;
        const Scene scene = read_scene(entry.path());
        EXPECT_FALSE(scene.geometry.triangles.empty()) << entry.path();
        ++count;
    }
    EXPECT_GE(count, 8);
}

}  // namespace
}  // namespace pim
