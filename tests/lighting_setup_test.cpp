// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/files/lighting_setup.h"

#include <gtest/gtest.h>

#include <random>

#include "common/core/error.h"
#include "temporary_folder.h"
#include "test_scenes.h"
#include "viewer/files/names.h"
#include "viewer/files/number_text.h"

namespace pim {
namespace {

void expect_same(const ViewState& a, const ViewState& b) {
    ASSERT_EQ(a.lamps.size(), b.lamps.size());
    for (std::size_t l = 0; l < a.lamps.size(); ++l) {
        EXPECT_EQ(a.lamps[l].position, b.lamps[l].position);
        EXPECT_EQ(a.lamps[l].on, b.lamps[l].on);
        EXPECT_EQ(a.lamps[l].solo, b.lamps[l].solo);
        EXPECT_EQ(a.lamps[l].gain, b.lamps[l].gain);
        EXPECT_EQ(a.lamps[l].colour, b.lamps[l].colour);
    }
    EXPECT_EQ(a.camera.name, b.camera.name);
    EXPECT_EQ(a.camera.eye, b.camera.eye);
    EXPECT_EQ(a.camera.target, b.camera.target);
    EXPECT_EQ(a.camera.up, b.camera.up);
    EXPECT_EQ(a.camera.vertical_fov, b.camera.vertical_fov);
    EXPECT_EQ(a.view, b.view);
    EXPECT_EQ(a.direct, b.direct);
    EXPECT_EQ(a.indirect, b.indirect);
    EXPECT_EQ(a.show_lamps, b.show_lamps);
    EXPECT_EQ(a.automatic_exposure, b.automatic_exposure);
    EXPECT_EQ(a.exposure, b.exposure);
    EXPECT_EQ(a.tone_curve, b.tone_curve);
}

// A room far from the world's origin, two lamps that roam it, two cameras.
class LightingSetup : public testing::Test {
  protected:
    LightingSetup() : scene_(room(Rgb(0.5f), Vec3(4))) {
        scene_.geometry.origin = {100.1, -20.7, 0.3};
        scene_.lights[0].domain = Box3(Vec3(0.5f), Vec3(3.5f));
        scene_.lights.push_back(scene_.lights[0]);
        scene_.lights[1].name = "desk \"lamp\" = a\\b";
        Camera front{.name = "front", .eye = {2, 2, 3.5f}, .target = {2, 2, 0}};
        Camera side{.name = "side", .eye = {3.5f, 2, 2}, .target = {0, 2, 2}};
        scene_.cameras = {front, side};
        map_.components = {Component::indirect, Component::direct};
    }
    ViewState load(const std::string& text) const {
        return load_setup(folder_.write("setup.toml", text), scene_, map_);
    }
    // The error names the line and all of that.
    void expect_error(const std::string& text, int line, const std::vector<std::string>& parts) const {
        const std::string message = message_of<Error>([&] { load(text); });
        EXPECT_NE(message.find("setup.toml:" + std::to_string(line) + ": "), std::string::npos)
            << line << " in: " << message << "\n"
            << text;
        for (const std::string& part : parts)
            EXPECT_NE(message.find(part), std::string::npos) << part << " in: " << message;
        EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    }
    ViewState random_state(std::mt19937& random) const {
        std::uniform_real_distribution<float> unit(0, 1);
        const auto vector = [&] { return Vec3(unit(random), unit(random), unit(random)); };
        ViewState state = initial_state(scene_, map_);
        for (LampControl& lamp : state.lamps)
            lamp = {Vec3(0.5f) + vector() * 3.0f, random() % 2 == 0, random() % 2 == 0,
                    std::exp(60 * unit(random) - 30), vector()};
        state.camera = scene_.cameras[random() % 2];
        state.camera.eye = vector() * 4.0f, state.camera.target = vector() * -4.0f;
        state.camera.up = vector(), state.camera.vertical_fov = 1 + 100 * unit(random);
        state.view = View(random() % view_names().size());
        state.direct = DirectLight(random() % direct_light_names().size());
        state.tone_curve = ToneCurve(random() % tone_curve_names().size());
        state.indirect = random() % 2, state.show_lamps = random() % 2;
        state.automatic_exposure = random() % 2;
        if (!state.automatic_exposure) state.exposure = 20 * unit(random) - 10;
        return state;
    }

    Scene scene_;
    IlluminationMap map_;
    TemporaryFolder folder_;
};

TEST_F(LightingSetup, SavedAndLoadedIsTheSameToTheLastBit) {
    std::mt19937 random(1);
    for (int i = 0; i < 200; ++i) {
        const ViewState state = random_state(random);
        save_setup(folder_ / "setup.toml", scene_, state);
        expect_same(load_setup(folder_ / "setup.toml", scene_, map_), state);
    }
}

TEST_F(LightingSetup, TextIsShort) {
    ViewState state = initial_state(scene_, map_);
    state.lamps[0].position = scene_.geometry.to_local({101.3, -19.2, 1.7});
    state.lamps[0].gain = 0.1f;
    const std::string text = setup_text(scene_, state);
    EXPECT_NE(text.find("position = [101.3, -19.2, 1.7]\n"), std::string::npos) << text;
    EXPECT_NE(text.find("gain = 0.1\n"), std::string::npos) << text;
    EXPECT_NE(text.find("vertical_fov = 40.0\n"), std::string::npos) << text;
    EXPECT_NE(text.find("exposure = \"auto\"\n"), std::string::npos) << text;
}

TEST_F(LightingSetup, WhatIsLeftOutStaysAsItOpens) {
    expect_same(load(""), initial_state(scene_, map_));
    ViewState expected = initial_state(scene_, map_);
    expected.camera = scene_.cameras[1];
    expected.lamps[0].on = false;
    expect_same(load("[camera]\nname = \"side\"\n[[light]]\nname = \"lamp\"\non = false\n"), expected);
}

TEST_F(LightingSetup, WholeNumbersAndStops) {
    const ViewState state = load("exposure = -2\n[[light]]\nname = \"lamp\"\ngain = 3\n");
    EXPECT_FALSE(state.automatic_exposure);
    EXPECT_EQ(state.exposure, -2);
    EXPECT_EQ(state.lamps[0].gain, 3);
    ViewState large = initial_state(scene_, map_);
    large.lamps[0].gain = 9.9e15f;  // no TOML integer that a double surely holds
    EXPECT_EQ(load(setup_text(scene_, large)).lamps[0].gain, 9.9e15f);
}

TEST_F(LightingSetup, CameraOfNoNameInTheSceneKeepsItsPlace) {
    ViewState state = initial_state(scene_, map_);
    state.camera = {.name = "free", .eye = {1, 1, 1}, .target = {2, 1, 1}, .vertical_fov = 33};
    const ViewState loaded = load(setup_text(scene_, state));
    EXPECT_EQ(loaded.camera.eye, state.camera.eye);
    EXPECT_EQ(loaded.camera.target, state.camera.target);
    EXPECT_EQ(loaded.camera.vertical_fov, 33);
}

TEST_F(LightingSetup, ErrorsNameLineKeyAndWhatIsAllowed) {
    expect_error("view = \"shiny\"\n", 1, {"view", "'shiny'", "radiance, irradiance", "trust"});
    expect_error("\ndirect = \"some\"\n", 2, {"direct", "none, traced, baked"});
    expect_error("indirect = 1\n", 1, {"indirect", "true or false"});
    expect_error("show_lamps = \"yes\"\n", 1, {"show_lamps", "true or false"});
    expect_error("tone_curve = \"film\"\n", 1, {"tone_curve", "none, reinhard, aces"});
    expect_error("exposure = \"bright\"\n", 1, {"exposure", "\"auto\"", "stops"});
    expect_error("exposure = true\n", 1, {"exposure", "\"auto\"", "stops"});
    expect_error("exposure = 1000\n", 1, {"exposure", "-100 to 100"});
    expect_error("view = \"radiance\"\nzoom = 2\n", 2, {"zoom", "unknown", "tone_curve", "camera", "light"});
    expect_error("view =\n", 1, {});
}

TEST_F(LightingSetup, ErrorsOfCameras) {
    expect_error("camera = \"front\"\n", 1, {"camera", "table"});
    expect_error("[camera]\nname = \"back\"\n", 2, {"camera.name", "'back'", "front, side"});
    expect_error("[camera]\nname = 3\n", 2, {"camera.name", "text"});
    expect_error("[camera]\neye = [1, 2]\n", 2, {"camera.eye", "3 numbers"});
    expect_error("[camera]\neye = [1, 2, inf]\n", 2, {"camera.eye", "out of range"});
    expect_error("[camera]\nvertical_fov = 180\n", 2, {"camera.vertical_fov", "0.1 to 179"});
    expect_error("[camera]\nroll = 1\n", 2, {"camera.roll", "unknown", "vertical_fov"});
    expect_error("[camera]\neye = [0, 0, 0]\ntarget = [0, 0, 0]\n", 3, {"camera.target", "one line"});
}

TEST_F(LightingSetup, ErrorsOfLamps) {
    const std::string lamp = "[[light]]\nname = \"lamp\"\n";
    expect_error("light = 1\n", 1, {"light", "[[light]]"});
    expect_error("[[light]]\non = true\n", 1, {"light.name", "missing"});
    expect_error("[[light]]\nname = \"sun\"\n", 2, {"light.name", "'sun'", "lamp, desk"});
    expect_error(lamp + lamp, 4, {"light.name", "twice"});
    expect_error(lamp + "position = [0, 0, 0]\n", 3,
                 {"light.position", "'lamp'", "outside its domain", "100.6,-20.2,0.8"});
    expect_error(lamp + "gain = -1\n", 3, {"light.gain", "0 to"});
    expect_error(lamp + "gain = nan\n", 3, {"light.gain"});
    expect_error(lamp + "colour = [1, -1, 1]\n", 3, {"light.colour", "out of range"});
    expect_error(lamp + "on = 1\n", 3, {"light.on", "true or false"});
    expect_error(lamp + "colour = \"red\"\n", 3, {"light.colour", "3 numbers"});
    expect_error(lamp + "color = [1, 1, 1]\n", 3, {"light.color", "unknown", "colour"});
}

TEST_F(LightingSetup, PartsThatTheMapLacksAreRefused) {
    map_.components = {Component::indirect};
    expect_error("direct = \"baked\"\n", 1, {"direct", "lacks", "none, traced"});
    map_.components = {Component::direct};
    expect_error("indirect = true\n", 1, {"indirect", "lacks", "false"});
    EXPECT_FALSE(load("direct = \"traced\"\n").indirect);
}

TEST_F(LightingSetup, FileThatIsNotThere) {
    EXPECT_NE(message_of<Error>([&] { load_setup(folder_ / "none.toml", scene_, map_); }).find("none.toml"),
              std::string::npos);
    EXPECT_THROW(save_setup(folder_ / "no/such.toml", scene_, initial_state(scene_, map_)), Error);
}

TEST(Names, BothWays) {
    for (std::size_t i = 0; i < view_names().size(); ++i) EXPECT_EQ(parse_view(name(View(i))), View(i));
    for (std::size_t i = 0; i < direct_light_names().size(); ++i)
        EXPECT_EQ(parse_direct_light(name(DirectLight(i))), DirectLight(i));
    for (std::size_t i = 0; i < tone_curve_names().size(); ++i)
        EXPECT_EQ(parse_tone_curve(name(ToneCurve(i))), ToneCurve(i));
    EXPECT_EQ(name(View::radiance), "radiance");
    EXPECT_EQ(name(View::trust), "trust");
    EXPECT_EQ(view_names().size(), std::size_t(View::trust) + 1);
    EXPECT_EQ(name(DirectLight::none), "none");
    EXPECT_EQ(name(DirectLight::traced), "traced");
    EXPECT_EQ(name(DirectLight::baked), "baked");
    EXPECT_EQ(name(ToneCurve::none), "none");
    EXPECT_EQ(name(ToneCurve::reinhard), "reinhard");
    EXPECT_EQ(name(ToneCurve::aces), "aces");
}

TEST(Names, UnknownOnesListWhatIsAllowed) {
    EXPECT_EQ(message_of<UsageError>([] { parse_direct_light("some"); }),
              "--direct: 'some' is unknown; allowed: none, traced, baked");
    EXPECT_EQ(message_of<UsageError>([] { parse_tone_curve("x", "--curve"); }),
              "--curve: 'x' is unknown; allowed: none, reinhard, aces");
    EXPECT_THROW(parse_view(""), UsageError);
}

TEST(NumberText, ShortestThatReadsBack) {
    EXPECT_EQ(number_text(0.1f), "0.1");
    EXPECT_EQ(number_text(0.1), "0.1");
    EXPECT_EQ(number_text(100.0f), "100");
    EXPECT_EQ(number_text(-0.5f), "-0.5");
    EXPECT_EQ(number_text(0.0f), "0");
    EXPECT_EQ(number_text(1e30f), "1e+30");
    EXPECT_EQ(number_text(1.0 / 3), "0.3333333333333333");
    EXPECT_EQ(number_text(16777216.0f), "16777216");
    std::mt19937 random(2);
    std::uniform_real_distribution<float> exponent(-80, 80);
    for (int i = 0; i < 1000; ++i) {
        const float value = std::exp(exponent(random));
        EXPECT_EQ(float(std::stod(number_text(value))), value);
        EXPECT_EQ(std::stod(number_text(double(value) / 3)), double(value) / 3);
    }
}

}  // namespace
}  // namespace pim
