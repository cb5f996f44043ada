// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/files/command_text.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <cstdio>

#include "common/core/command_line.h"
#include "test_scenes.h"

namespace pim {
namespace {

// What a shell makes of the line: its words.
std::vector<std::string> words_of(const std::string& line) {
    FILE* const shell = popen(("set -f; printf '%s\\001' " + line).c_str(), "r");
    std::string all;
    for (int c = std::fgetc(shell); c != EOF; c = std::fgetc(shell)) all += char(c);
    pclose(shell);
    std::vector<std::string> words;
    for (std::size_t at = 0, end; (end = all.find('\1', at)) != std::string::npos; at = end + 1)
        words.push_back(all.substr(at, end - at));
    return words;
}

class CommandText : public testing::Test {
  protected:
    CommandText() : scene_(room(Rgb(0.5f), Vec3(4))) {
        scene_.geometry.origin = {10.1, -20.7, 0.3};
        scene_.lights[0].domain = Box3(Vec3(0.5f), Vec3(3.5f));
        scene_.lights.push_back(scene_.lights[0]);
        scene_.lights[1].name = "Otto's lamp";
        scene_.cameras = {{.name = "front", .eye = {2, 2, 3}, .target = {2, 2, 0}},
                          {.name = "side", .eye = {3, 2, 2}, .target = {0, 2, 2}}};
        map_.components = {Component::indirect, Component::direct};
        state_ = initial_state(scene_, map_);
    }
    std::string command() const {
        return headless_command(scene_, map_, state_, {640, 480}, {"room.vdb", "frame.png", {}});
    }
    // What follows the camera.
    std::string options() const {
        const std::string text = command(), start = kStart + " --camera front";
        EXPECT_TRUE(text.starts_with(start)) << text;
        return text.substr(start.size());
    }
    const std::string kStart = "viewer room.vdb --output frame.png --size 640x480";
    Scene scene_;
    IlluminationMap map_;
    ViewState state_;
};

TEST_F(CommandText, StartNeedsNoOptions) { EXPECT_EQ(command(), kStart + " --camera front"); }

TEST_F(CommandText, CameraGoesByNameOnlyIfItIsThatCamera) {
    state_.camera = scene_.cameras[1];
    state_.camera.size = {1, 1};
    EXPECT_EQ(command(), kStart + " --camera side");
    state_.camera.eye = scene_.geometry.to_local({12.5, -18.7, 3.2});
    state_.camera.target = scene_.geometry.to_local({12.1, -18, -1});
    EXPECT_EQ(command(), kStart + " --eye 12.5,-18.7,3.2 --target 12.1,-18,-1 --up 0,1,0 --fov 40");
    state_.camera = scene_.cameras[0];
    state_.camera.name = "elsewhere";
    EXPECT_EQ(command(), kStart + " --camera front");
    state_.camera.vertical_fov = std::nextafter(40.0f, 50.0f);
    EXPECT_NE(command().find("--fov 40.000004"), std::string::npos) << command();
}

TEST_F(CommandText, TwinCamerasGoByTheirOwnName) {
    scene_.cameras[1] = scene_.cameras[0];
    scene_.cameras[1].name = "twin";
    state_.camera = scene_.cameras[1];
    EXPECT_EQ(command(), kStart + " --camera twin");
}

TEST_F(CommandText, LampsThatMovedOrChanged) {
    state_.lamps[0].position = scene_.geometry.to_local({11.5, -19, 2});
    state_.lamps[0].gain = 0.3f;
    state_.lamps[1].colour = {1, 0.5f, 0.1f};
    EXPECT_EQ(options(), " --light lamp=11.5,-19,2 --gain lamp=0.3 --colour 'Otto'\\''s lamp=1,0.5,0.1'");
}

TEST_F(CommandText, LampsThatAreOffOrSilencedHaveNoGain) {
    state_.lamps[0].on = false, state_.lamps[0].gain = 2;
    EXPECT_EQ(options(), " --gain lamp=0");
    state_.lamps[0] = {.position = scene_.lights[0].position, .solo = true};
    EXPECT_EQ(options(), " --gain 'Otto'\\''s lamp=0'");
    state_.lamps[1].solo = true;
    EXPECT_EQ(options(), "");
}

TEST_F(CommandText, WhatIsShown) {
    state_.direct = DirectLight::none;
    state_.indirect = false;
    state_.view = View::albedo;
    state_.show_lamps = true;
    state_.automatic_exposure = false, state_.exposure = -1.5f;
    state_.tone_curve = ToneCurve::aces;
    EXPECT_EQ(options(),
              " --direct none --indirect none --view albedo --show-lamps --exposure -1.5 --tone-curve aces");
}

TEST_F(CommandText, DefaultsAreThoseOfTheMap) {
    state_.direct = DirectLight::traced;
    EXPECT_EQ(options(), " --direct traced");
    map_.components = {Component::indirect};
    EXPECT_EQ(options(), "");
    map_.components = {Component::direct};
    state_ = initial_state(scene_, map_);
    EXPECT_EQ(options(), "");
}

TEST_F(CommandText, ShellAndParserGiveTheNumbersBack) {
    scene_.lights[1].name = "-a $(b) `c` \"d\" 'e' \\f = g;h*?~#\n&|<>é";
    const Vec3 place(0.70000005f, 1.2345678f, 3.3333333f);
    state_.lamps[1].position = place;
    state_.camera.eye = {-3.1415927f, 2.7182817f, 1e-3f};
    state_.automatic_exposure = false, state_.exposure = -0.1f;
    std::vector<std::string> words =
        words_of(headless_command(scene_, map_, state_, {8, 6}, {"-my maps/a b.vdb", "it's.png", "-g.obj"}));
    ASSERT_GT(words.size(), 2u);
    EXPECT_EQ(words[0], "viewer");
    CLI::App app;
    std::string map, output, geometry, size, eye, target, up, fov, exposure;
    std::vector<std::string> lights;
    app.add_option("map", map);
    app.add_option("--output", output);
    app.add_option("--geometry", geometry);
    app.add_option("--size", size);
    app.add_option("--eye", eye);
    app.add_option("--target", target);
    app.add_option("--up", up);
    app.add_option("--fov", fov);
    app.add_option("--exposure", exposure);
    app.add_option("--light", lights)->allow_extra_args(false);
    std::vector<std::string> arguments(words.rbegin(), words.rend() - 1);
    ASSERT_NO_THROW(app.parse(arguments));
    EXPECT_EQ(map, "./-my maps/a b.vdb");
    EXPECT_EQ(geometry, "./-g.obj");
    EXPECT_EQ(output, "it's.png");
    EXPECT_EQ(float(std::stod(exposure)), -0.1f);
    const auto e = parse_triple(eye, "--eye");
    EXPECT_EQ(scene_.geometry.to_local({e[0], e[1], e[2]}), state_.camera.eye);
    ASSERT_EQ(lights.size(), 1u);
    const std::size_t equals = lights[0].rfind('=');
    EXPECT_EQ(lights[0].substr(0, equals), scene_.lights[1].name);
    const auto p = parse_triple(lights[0].substr(equals + 1), "--light");
    EXPECT_EQ(scene_.geometry.to_local({p[0], p[1], p[2]}), place);
}

TEST(ShellWord, QuotesWhatAShellWouldTouch) {
    EXPECT_EQ(shell_word("a-b_c.1,2=/+:@%"), "a-b_c.1,2=/+:@%");
    EXPECT_EQ(shell_word(""), "''");
    EXPECT_EQ(shell_word("a b"), "'a b'");
    EXPECT_EQ(shell_word("it's"), "'it'\\''s'");
    EXPECT_EQ(shell_word("~"), "'~'");
}

}  // namespace
}  // namespace pim
