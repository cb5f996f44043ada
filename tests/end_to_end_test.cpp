// SPDX-License-Identifier: GPL-3.0-or-later
// The programs as a user runs them: exit codes, messages, the same bytes however the work is divided.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/core/file.h"
#include "common/map/vdb_file.h"
#include "tests/baked_scenes.h"
#include "tests/programs.h"

namespace pim {
namespace {

Outcome run(const std::string& command) { return run_program(command, test_folder()); }

void expect_failure(const std::string& command, int code, const std::vector<std::string>& words) {
    const Outcome outcome = run(command);
    EXPECT_EQ(outcome.code, code) << command << "\n" << outcome.text;
    for (const std::string& word : words)
        EXPECT_TRUE(outcome.names(word)) << command << " should name '" << word << "':\n" << outcome.text;
}

const std::string kCornell = std::string(PIM_DATA) + "/cornell/cornell.glb";

// A small bake of the Cornell box; `extra` goes to the end, `grid` into [grid].
std::string description(const std::string& name, const std::string& extra = "",
                        const std::string& geometry = kCornell,
                        const std::string& grid = "cells = 12\nreach_photons = 262144") {
    const fs::path path = test_folder() / (name + ".toml");
    std::ofstream(path) << "[scene]\ngeometry = \"" << geometry << "\"\n[grid]\n"
                        << grid << "\n[bake]\nphotons = 3000\ncomponents = [\"direct\", \"indirect\"]\n"
                        << "[[light]]\nname = \"lamp\"\npower = [100, 100, 100]\nsamples = 60\n"
                        << "domain = { min = [1, 3.6, 1], max = [4, 4.9, 4] }\n"
                        << "[[camera]]\nname = \"front\"\neye = [2.78, 2.73, -8]\ntarget = [2.78, 2.73, "
                           "2.8]\nsize = [64, 64]\n"
                        << extra;
    return path.string();
}

std::string map_path(const std::string& name) { return (test_folder() / (name + ".vdb")).string(); }

nlohmann::json json_of(const std::string& command) {
    const Outcome outcome = run(command + " --json --quiet");
    EXPECT_EQ(outcome.code, 0) << command << "\n" << outcome.text;
    return nlohmann::json::parse(outcome.text);
}

TEST(EndToEnd, SameBytesAtAnyThreadCountAndAnySplit) {
    const std::string scene = description("threads");
    for (const char* threads : {"1", "2", "4"})
        ASSERT_EQ(run("bake run " + scene + " -o " + map_path(std::string("threads") + threads) +
                      " --threads " + threads)
                      .code,
                  0);
    const std::string one = read_text(map_path("threads1"));
    EXPECT_EQ(one, read_text(map_path("threads2")));
    EXPECT_EQ(one, read_text(map_path("threads4")));
    const std::string parts = map_path("threadsp");
    for (const char* part : {"2/3", "1/3", "3/3"})
        ASSERT_EQ(run("bake trace " + scene + " -o " + parts + " --part " + part).code, 0);
    ASSERT_EQ(run("bake fit " + scene + " -o " + parts).code, 0);
    EXPECT_EQ(one, read_text(parts));
    for (const char* threads : {"1", "2", "4"})
        ASSERT_EQ(run("viewer " + map_path("threads1") + " --output " + (test_folder() / "t").string() +
                      threads + ".exr --threads " + threads)
                      .code,
                  0);
    EXPECT_EQ(read_text(test_folder() / "t1.exr"), read_text(test_folder() / "t2.exr"));
    EXPECT_EQ(read_text(test_folder() / "t1.exr"), read_text(test_folder() / "t4.exr"));
}

TEST(EndToEnd, AKilledBakeGoesOnToTheSameBytes) {
    const std::string scene = description("killed");
    const std::string whole = map_path("killed_whole"), killed = map_path("killed");
    const std::string more = " --photons 60000";  // long enough to be killed half-way
    ASSERT_EQ(run("bake run " + scene + " -o " + whole + more).code, 0);
    const fs::path work = killed + ".work";
    const auto volumes = [&] {
        int count = 0;
        if (fs::exists(work))
            for (const auto& entry : fs::directory_iterator(work))
                count += entry.path().filename().string().starts_with("lamp.");
        return count;
    };
    for (const int signal : {SIGKILL, SIGTERM}) {
        const pid_t child = fork();
        if (child == 0) {
            const std::string bake = std::string(PIM_BIN) + "/bake";
            execl(bake.c_str(), "bake", "run", scene.c_str(), "-o", killed.c_str(), "--photons", "60000",
                  "--quiet", nullptr);
            _exit(127);
        }
        const int before = volumes();
        for (int i = 0; i < 6000 && volumes() < before + 5; ++i)
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        kill(child, signal);
        int status = 0;
        waitpid(child, &status, 0);
        EXPECT_FALSE(fs::exists(killed)) << "a map before its time";
        EXPECT_GE(volumes(), before + 5);
        if (signal == SIGTERM) {
            EXPECT_EQ(WEXITSTATUS(status), 130);
        }
    }
    ASSERT_EQ(run("bake run " + scene + " -o " + killed + more).code, 0);
    EXPECT_EQ(read_text(whole), read_text(killed));
}

// A bake holds in memory what it traced; a fit of its own reads it from the files. One channel of a grey
// scene is written.
TEST(EndToEnd, AFitFromFilesMakesTheSameBytes) {
    std::string grey;
    for (const char* name : {"white", "red", "green"})
        grey += "[[material]]\nname = \"" + std::string(name) + "\"\ndiffuse = [0.5, 0.5, 0.5]\n";
    for (const std::string& materials : {std::string(), grey}) {
        const std::string scene = description("files", materials), map = map_path("files");
        const Outcome whole = run("bake run " + scene + " --photons 1000 --overwrite -o " + map);
        ASSERT_EQ(whole.code, 0) << whole.text;
        const std::string bytes = read_text(map);
        EXPECT_EQ(VdbReader(map).integer("grey"), materials.empty() ? 0 : 1);
        fs::remove(map);
        ASSERT_EQ(run("bake fit " + scene + " --photons 1000 -o " + map).code, 0);
        EXPECT_TRUE(bytes == read_text(map));
    }
}

TEST(EndToEnd, MapsEvaluatedTogetherSayTheSame) {
    const std::string scene = description("together"), few = map_path("few"), many = map_path("many"),
                      how = " --lights 2 --pixels 64 --paths 8";
    ASSERT_EQ(run("bake run " + scene + " --photons 500 -o " + few).code, 0);
    ASSERT_EQ(run("bake run " + scene + " --photons 2000 -o " + many).code, 0);
    const auto both = json_of("bake evaluate " + few + " " + many + how);
    ASSERT_EQ(both.size(), 2u);
    for (std::size_t i = 0; i < 2; ++i) {
        const std::string& map = i == 0 ? few : many;
        EXPECT_EQ(both[i]["map"], map);
        EXPECT_EQ(both[i]["relrmse"], json_of("bake evaluate " + map + how)["relrmse"]);
    }
    const Outcome text = run("bake evaluate " + few + " " + many + how + " --quiet");
    EXPECT_TRUE(text.names(few) && text.names(many)) << text.text;
    expect_failure("bake evaluate " + few + " " + map_path("none") + how, 1, {"none.vdb"});
    expect_failure("bake evaluate " + few + " " + many + " --parts", 2, {"--parts"});
}

TEST(EndToEnd, TheStoredDescriptionMakesTheSameMap) {
    const std::string scene = description("stored");
    ASSERT_EQ(run("bake run " + scene + " -o " + map_path("stored") + " --photons 1000").code, 0);
    const VdbReader file(map_path("stored"));
    std::ofstream(test_folder() / "again.toml") << file.text("scene");
    ASSERT_EQ(run("bake run " + (test_folder() / "again.toml").string() + " -o " + map_path("again")).code,
              0);
    EXPECT_EQ(read_text(map_path("stored")), read_text(map_path("again")));
}

// Geometry, lamps and a camera, and no word of cells and photons.
std::string bare_description(const std::string& name) {
    const fs::path path = test_folder() / (name + ".toml");
    std::ofstream(path) << "[scene]\ngeometry = \"" << kCornell << "\"\n"
                        << "[[light]]\nname = \"lamp\"\npower = [100, 100, 100]\n"
                        << "domain = { min = [2, 3.8, 2], max = [3.5, 4.8, 3.5] }\n"
                        << "[[camera]]\nname = \"front\"\neye = [2.78, 2.73, -8]\ntarget = [2.78, 2.73, "
                           "2.8]\nsize = [64, 64]\n";
    return path.string();
}

// What it chose is in the stored description, which makes the same bytes; and a target looks at no clock.
TEST(EndToEnd, ABakeThatChoosesForItself) {
    const std::string scene = bare_description("bare"), map = map_path("bare");
    const std::string asked = " --target-error 0.05 --set reach_photons=1048576";
    const Outcome chosen = run("bake run " + scene + asked + " -o " + map + " --threads 2");
    ASSERT_EQ(chosen.code, 0) << chosen.text;
    for (const char* said :
         {"chose cells", "chose", "round 1", "error", "noise", "grid", "polynomial", "is met"})
        EXPECT_NE(chosen.text.find(said), std::string::npos) << said;
    const auto error = json_of("bake evaluate " + map + " --json --lights 8 --pixels 1000");
    EXPECT_LT(error["relrmse"].get<double>(), 0.05 + error["confidence"]["relrmse"].get<double>());
    const auto estimate = nlohmann::json::parse(read_text(map + ".work/run.json"))["estimated_error"];
    EXPECT_NEAR(estimate["relrmse"].get<double>(), error["relrmse"].get<double>(),
                0.25 * error["relrmse"].get<double>() + error["confidence"]["relrmse"].get<double>());

    const Outcome written = run("bake info " + map + " --description");
    EXPECT_EQ(written.text.find("target_error"), std::string::npos);
    std::ofstream(test_folder() / "settled.toml") << written.text;
    ASSERT_EQ(
        run("bake run " + (test_folder() / "settled.toml").string() + " -o " + map_path("settled")).code, 0);
    EXPECT_TRUE(read_text(map) == read_text(map_path("settled")));
    ASSERT_EQ(run("bake run " + scene + asked + " -o " + map_path("bare2") + " --threads 1").code, 0);
    EXPECT_TRUE(read_text(map) == read_text(map_path("bare2")));

    expect_failure("bake trace " + scene + " --part 1/2", 1, {"bare.toml", "bake run", "samples"});
    expect_failure("bake run " + scene + " --target-error 0", 2, {"--target-error"});
    expect_failure("bake run " + scene + " --time-budget soon", 2, {"--time-budget", "10m"});
    EXPECT_NE(run("bake plan " + scene).text.find("chooses"), std::string::npos);
}

// Positions that are given stay where they are, however the domain is split afterwards, and the judge fits
// the degree that is given.
TEST(EndToEnd, AChoiceKeepsWhatIsGiven) {
    const std::string scene = bare_description("kept"), map = map_path("kept");
    const Outcome made = run("bake run " + scene +
                             " --target-error 0.2 --set cells=10 --set samples=80 --set degree=2 -o " + map);
    ASSERT_EQ(made.code, 0) << made.text;
    EXPECT_NE(made.text.find("round 1: 80 positions"), std::string::npos) << made.text;
    EXPECT_NE(made.text.find("degree 2: error"), std::string::npos) << made.text;
    EXPECT_NE(made.text.find("0 lamp positions to trace"), std::string::npos) << made.text;
    EXPECT_EQ(run("bake info " + map + " --description").text.find("degree = 3"), std::string::npos);
}

// With --photons or --set alone the rest is still chosen; a lamp that stands still gets the photons it needs.
TEST(EndToEnd, ALampThatStandsStillIsBakedToATarget) {
    const fs::path scene = test_folder() / "standing.toml";
    std::ofstream(scene) << "[scene]\ngeometry = \"" << kCornell << "\"\n"
                         << "[[light]]\nname = \"lamp\"\nposition = [2.7, 4, 2.7]\n"
                         << "[[camera]]\nname = \"front\"\neye = [2.78, 2.73, -8]\ntarget = [2.78, 2.73, "
                            "2.8]\nsize = [64, 64]\n";
    const std::string map = map_path("standing");
    const Outcome made = run("bake run " + scene.string() + " --set seed=3 -o " + map);
    ASSERT_EQ(made.code, 0) << made.text;
    EXPECT_NE(made.text.find("the target of 0.03 is met"), std::string::npos) << made.text;
    const auto error = json_of("bake evaluate " + map + " --lights 2 --pixels 2000");
    EXPECT_LT(error["relrmse"].get<double>(), 0.03 * 1.25);
    EXPECT_EQ(json_of("bake info " + map)["lights"][0]["terms"], 1);
}

TEST(EndToEnd, AChoiceThatCannotBeMadeSaysWhyAtOnce) {
    const std::string scene = bare_description("blind"), map = map_path("blind");
    std::ofstream(scene, std::ios::app) << "[[camera]]\nname = \"up\"\neye = [2.78, 9, -8]\n"
                                        << "target = [2.78, 99, -9]\nsize = [64, 64]\n";
    std::string away = read_text(scene);
    away.replace(away.find("target = [2.78, 2.73, 2.8]"), 26, "target = [2.78, 9, -20]   ");
    std::ofstream(scene) << away;
    expect_failure("bake run " + scene + " -o " + map, 1,
                   {"blind.toml", "camera 'up' sees no light", "no camera sees any light"});
    const std::string by_hand = description("byhand");
    ASSERT_EQ(run("bake run " + by_hand + " -o " + map).code, 0);
    expect_failure("bake run " + by_hand + " --target-error 0.1 -o " + map, 1,
                   {"other settings", "--overwrite"});
}

TEST(EndToEnd, AnInterruptedChoiceIsMadeAgain) {
    const std::string scene = bare_description("stopped"), map = map_path("stopped");
    const pid_t child = fork();
    if (child == 0) {
        const std::string bake = std::string(PIM_BIN) + "/bake";
        execl(bake.c_str(), "bake", "run", scene.c_str(), "-o", map.c_str(), "--target-error", "0.05",
              "--set", "cells=12", "--quiet", nullptr);
        _exit(127);
    }
    for (int i = 0; i < 6000 && !fs::exists(map + ".work/lamp.000003.vdb"); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    kill(child, SIGTERM);
    int status = 0;
    waitpid(child, &status, 0);
    EXPECT_EQ(WEXITSTATUS(status), 130);
    ASSERT_EQ(run("bake run " + scene + " -o " + map + " --target-error 0.05 --set cells=12").code, 0);
    ASSERT_EQ(
        run("bake run " + scene + " -o " + map_path("unstopped") + " --target-error 0.05 --set cells=12")
            .code,
        0);
    EXPECT_TRUE(read_text(map) == read_text(map_path("unstopped")));
}

// Not a check of the clock: that a budget chooses at all, spends it in rounds and says what more would bring.
TEST(EndToEnd, ABakeForATime) {
    const std::string scene = bare_description("timed"), map = map_path("timed");
    const Outcome timed = run("bake run " + scene + " --time-budget 4s -o " + map);
    ASSERT_EQ(timed.code, 0) << timed.text;
    EXPECT_NE(timed.text.find("the time is used"), std::string::npos) << timed.text;
    EXPECT_EQ(run("bake info " + map + " --description").text.find("time_budget"), std::string::npos);
    // The same command keeps what it chose, whatever a clock would say now; another goal keeps the cells.
    const std::string first = read_text(map);
    const Outcome again = run("bake run " + scene + " --time-budget 4s -o " + map);
    ASSERT_EQ(again.code, 0) << again.text;
    EXPECT_NE(again.text.find("chosen before"), std::string::npos) << again.text;
    EXPECT_EQ(read_text(map), first);
    const Outcome longer = run("bake run " + scene + " --time-budget 5s -o " + map);
    ASSERT_EQ(longer.code, 0) << longer.text;
    EXPECT_NE(longer.text.find("were chosen before"), std::string::npos) << longer.text;
}

// With cells that are given, light's reach is still looked for within the time, and they are found once.
TEST(EndToEnd, ABakeForATimeWithGivenCells) {
    const std::string scene = bare_description("given"), map = map_path("given");
    const auto reach_with = [&](const std::string& settings) {
        const Outcome made =
            run("bake run " + scene + " --overwrite --time-budget 3s --set cells=10 -o " + map + settings);
        EXPECT_EQ(made.code, 0) << made.text;
        const std::string text = run("bake info " + map + " --description").text;
        EXPECT_NE(text.find("cells = 10\n"), std::string::npos) << text;
        const std::size_t at = text.find("reach_photons = ");
        return at == std::string::npos ? 0 : std::stol(text.substr(at + 16));
    };
    EXPECT_EQ(reach_with(""), 1 << 19);
    EXPECT_EQ(reach_with(" --set reach_photons=65536"), 65536);
}

TEST(EndToEnd, ABakeOverwritesNothingButMaps) {
    const std::string scene = description("spared");
    const std::string before = read_text(scene);
    const Outcome outcome = run("bake run " + scene + " -o " + scene);
    EXPECT_EQ(outcome.code, 1) << outcome.text;
    EXPECT_NE(outcome.text.find("ends in .vdb"), std::string::npos) << outcome.text;
    EXPECT_EQ(read_text(scene), before);
}

TEST(EndToEnd, JsonHasTheKeysThatOthersRead) {
    const std::string scene = description("json"), map = map_path("json");
    ASSERT_EQ(run("bake run " + scene + " -o " + map).code, 0);
    const auto keys = [](const std::string& command, const std::vector<std::string>& wanted) {
        const auto json = nlohmann::json::parse(run(command + " --json --quiet").text);
        for (const std::string& key : wanted) EXPECT_TRUE(json.contains(key)) << command << " lacks " << key;
    };
    keys("bake info " + map, {"cells", "lights", "bytes", "residual", "left_out"});
    keys("bake plan " + scene, {"grid", "cells", "light_samples", "photons_total", "memory_bytes",
                                "disk_bytes", "seconds_estimate", "left_out", "warnings"});
    keys("bake evaluate " + map + " --lights 2 --pixels 64 --paths 8",
         {"relrmse", "relrmse_indirect", "relrmse_p95", "relrmse_per_position", "reference_noise",
          "bake_seconds", "frame_seconds"});
    const fs::path stats = test_folder() / "stats.json";
    ASSERT_EQ(run("viewer " + map + " --output " + (test_folder() / "s.png").string() + " --stats " +
                  stats.string())
                  .code,
              0);
    const auto json = nlohmann::json::parse(read_text(stats));
    for (const char* key : {"frame_seconds", "primary_rays", "cells", "packed_bytes", "load_seconds",
                            "peak_rss_bytes", "threads"})
        EXPECT_TRUE(json.contains(key)) << key;
}

TEST(EndToEnd, RivalsOfTheMap) {
    const std::string map = map_path("rivals"), out = " --output " + (test_folder() / "r").string();
    ASSERT_EQ(run("bake run " + description("rivals") + " -o " + map).code, 0);
    const auto picture = [&](const std::string& name, const std::string& options) {
        const Outcome outcome = run("viewer " + map + out + name + ".exr " + options);
        EXPECT_EQ(outcome.code, 0) << outcome.text;
        return read_text(test_folder() / ("r" + name + ".exr"));
    };
    const std::string photons = "--integrator photon_map --photons 5000 ";
    const std::string one = picture("1", photons + "--threads 1");
    EXPECT_EQ(one, picture("2", photons + "--threads 2"));
    EXPECT_EQ(one, picture("4", photons + "--threads 4"));
    EXPECT_EQ(picture("w1", "--integrator whitted --threads 1"),
              picture("w4", "--integrator whitted --threads 4"));
    EXPECT_EQ(picture("w", "--integrator whitted"), picture("d", photons + "--indirect none"));
    for (const char* options :
         {"--gather 4", "--direct baked --nearest 20", "--view indirect", "--direct none"})
        EXPECT_NE(one, picture("o", photons + options)) << options;
    const fs::path stats = test_folder() / "rivals.json";
    picture("s", photons + "--stats " + stats.string());
    const auto json = nlohmann::json::parse(read_text(stats));
    const double parts = double(json.at("photon_seconds")) + double(json.at("tree_seconds")) +
                         double(json.at("render_seconds"));
    EXPECT_LE(parts, double(json.at("frame_seconds")));
    EXPECT_GT(parts, 0.5 * double(json.at("frame_seconds")));
    const std::string refused = "viewer " + map + out + ".exr ";
    for (const char* size : {"640x", "640", "x480", "0x480", "640x480.5", "640x99999", "640y480"})
        expect_failure(refused + "--size " + size, 2, {"--size", size, "1280x720"});
    expect_failure(refused + "--integrator magic", 2, {"magic", "photon_map", "whitted"});
    expect_failure(refused + "--photons 100", 2, {"--photons", "photon_map"});
    expect_failure(refused + "--integrator photon_map --nearest 1", 2, {"--nearest"});
    expect_failure(refused + photons + "--gather 4 --direct baked", 2, {"--gather", "--direct"});
    expect_failure(refused + photons + "--view irradiance", 2, {"--view", "photon_map"});
    expect_failure(refused + "--integrator whitted --direct baked", 2, {"--direct baked", "whitted"});
    expect_failure(refused + "--integrator whitted --view indirect", 2, {"whitted", "indirect"});
    expect_failure("viewer " + map + " --benchmark --integrator whitted", 2, {"--integrator", "--output"});
}

TEST(EndToEnd, SettingsOnTheCommandLineAndAFitInNumbers) {
    const std::string scene = description("samples"), map = map_path("samples");
    ASSERT_EQ(run("bake run " + scene + " -o " + map + " --set degree=1 --set cells=8").code, 0);
    const auto info = json_of("bake info " + map);
    EXPECT_EQ(info["lights"][0]["terms"], 4);
    EXPECT_EQ(*std::ranges::max_element(info["grid"]), 8);
    EXPECT_EQ(json_of("bake plan " + scene + " --set cells=8")["grid"], info["grid"]);

    const auto all = json_of("bake samples " + map + " --count 3");
    ASSERT_EQ(all.size(), 6u);  // of both components
    for (const auto& patch : all) {
        double sum = 0, squares = 0;
        ASSERT_EQ(patch["samples"].size(), 60u);
        for (const auto& s : patch["samples"]) {
            const double difference = s["measured"].get<double>() - s["fitted"].get<double>();
            sum += s["measured"].get<double>() / 60, squares += difference * difference / 60;
        }
        EXPECT_NEAR(patch["mean"].get<double>(), sum, 1e-6 * sum);
        EXPECT_NEAR(patch["residual"].get<double>(), std::sqrt(squares), 1e-6 * std::sqrt(squares));
    }
    const auto relative = [&](std::size_t i) {
        return all[i]["residual"].get<double>() / all[i]["mean"].get<double>();
    };
    EXPECT_GE(relative(0), relative(1));  // the worst first
    EXPECT_GE(relative(1), relative(2));

    const auto whitted =
        json_of("bake evaluate " + map + " --integrator whitted --lights 2 --pixels 100 --paths 32");
    EXPECT_NEAR(whitted["relrmse_indirect"].get<double>(), 1, 1e-6);
    const std::string few = " --lights 2 --pixels 300 --paths 64 --integrator photon_map --photons ";
    EXPECT_GT(json_of("bake evaluate " + map + few + "500")["relrmse_indirect"].get<double>(),
              json_of("bake evaluate " + map + few + "50000")["relrmse_indirect"].get<double>());

    for (const char* ignored :
         {"--photons 100", "--gather 4", "--pictures p", "--own-photons 2", "--parts --integrator whitted"})
        expect_failure("bake evaluate " + map + " " + ignored, 2, {"--"});
    expect_failure("bake evaluate " + map + " --integrator whitted --nearest 9", 2, {"photon_map"});
    expect_failure("bake run " + scene + " --set colour=1", 2, {"colour", "degree"});
    expect_failure("bake run " + scene + " --set degree", 2, {"KEY=VALUE"});
    expect_failure("bake run " + scene + " --set degree=9", 1, {"degree", "0 to 3"});
    expect_failure("bake run " + scene + " --set cells=foo", 1, {"cells", "whole number"});
    expect_failure("bake run " + scene + " --set cells=[8", 1, {"cells", "whole number"});
    EXPECT_EQ(run("bake plan " + scene + " --set robust=off --set cells=8").code, 0);
    EXPECT_EQ(run("bake plan " + scene + " --set time_budget=10m --set cells=8").code, 0);
    fs::remove_all(map + ".work");
    expect_failure("bake samples " + map, 1, {map + ".work", "--clean"});
}

TEST(EndToEnd, BadInputIsOneSentenceAndAnExitCode) {
    expect_failure("bake run /nowhere/scene.toml", 1, {"/nowhere/scene.toml"});
    expect_failure("bake run " + description("no_geometry", "", "nowhere.obj"), 1,
                   {"nowhere.obj", "geometry"});
    std::ofstream(test_folder() / "broken.glb") << "no glTF at all";
    expect_failure("bake run " + description("broken", "", (test_folder() / "broken.glb").string()), 1,
                   {"broken.glb"});
    expect_failure("bake run " + description("unknown", "[extra]\n"), 1,
                   {"unknown.toml", "extra", "unknown"});
    expect_failure("bake run " + description("range", "", kCornell, "cells = -3"), 1,
                   {"range.toml", "cells", "1 to 4096"});
    expect_failure("bake run " + description("type", "", kCornell, "cells = \"many\""), 1,
                   {"type.toml", "cells", "whole number"});
    expect_failure(
        "bake run " + description("bounds", "", kCornell, "bounds = { min = [90,90,90], max = [91,91,91] }"),
        1, {"bounds", "no surface"});
    expect_failure("bake run " + description("fine", "", kCornell, "cell_size = 0.0001"), 1,
                   {"[grid]", "cells"});
    expect_failure("bake run " + description("memory", "", kCornell, "cell_size = 0.0015"), 1,
                   {"[grid]", "GB"});
    expect_failure("bake run " + description("always", "", kCornell, "cells = 8\n[bake2]"), 1, {"bake2"});
    expect_failure("bake run " + description("away",
                                             "[[light]]\nname = \"other\"\nposition = [0, 9, 0]\n"
                                             "domain = { min = [0, 0, 0], max = [1, 2, 3] }\n"),
                   1, {"away.toml", "light.position", "0,0,0 to 1,2,3"});
    expect_failure("bake run", 2, {"SCENE.toml"});
    expect_failure("bake fly x", 2, {});
    expect_failure("bake trace " + description("part") + " --part 4/3", 2, {"--part", "K/N"});
    expect_failure("bake info " + description("notvdb"), 1, {"notvdb.toml"});
    EXPECT_FALSE(fs::exists(map_path("range")));
    for (const auto& entry : fs::directory_iterator(test_folder()))
        EXPECT_EQ(entry.path().filename().string().find(".tmp"), std::string::npos) << entry.path();
}

TEST(EndToEnd, WhatCannotWorkIsSaidBeforeTheWork) {
    const std::string scene = description("early");
    fs::create_directories(test_folder() / "folder.vdb");
    expect_failure("bake run " + scene + " -o " + (test_folder() / "folder.vdb").string(), 1,
                   {"folder.vdb", "is a folder"});
    expect_failure("bake run " + scene + " -o /nowhere/early.vdb", 1, {"/nowhere"});
    EXPECT_FALSE(fs::exists(test_folder() / "folder.vdb.work"));
    std::ofstream(test_folder() / "mirror.mtl") << "newmtl m\nKd 0 0 0\nKs 0.9 0.9 0.9\nillum 3\n";
    std::ofstream(test_folder() / "mirror.obj")
        << "mtllib mirror.mtl\nv 0 0 0\nv 5 0 0\nv 0 5 0\nusemtl m\nf 1 2 3\n";
    expect_failure("bake run " + description("mirrors", "", (test_folder() / "mirror.obj").string()), 1,
                   {"mirrors.toml", "mirrors or glass", "[[material]]"});
}

// A camera inside a closed object makes a room of it, where lamps may stand.
TEST(EndToEnd, AWorkFolderBelongsToItsSolids) {
    const std::string map = map_path("solids");
    const auto scene = [](const std::string& eye) {
        return description("solids",
                           "[[camera]]\nname = \"second\"\neye = [" + eye + "]\ntarget = [9, 0.31, 0.2]\n");
    };
    ASSERT_EQ(run("bake trace " + scene("2.7, 2.7, -7") + " -o " + map + " --part 1/9").code, 0);
    EXPECT_EQ(run("bake trace " + scene("2.7, 2.7, -9") + " -o " + map + " --part 1/9").code, 0);
    expect_failure("bake trace " + scene("1.86, 0.8, 1.69") + " -o " + map + " --part 1/9", 1,
                   {"cells.vdb", "other settings", "--overwrite"});
}

TEST(EndToEnd, GreyScenesHaveOneChannel) {
    const std::string grey =
        "[[material]]\nname = \"red\"\ndiffuse = [0.5, 0.5, 0.5]\n"
        "[[material]]\nname = \"green\"\ndiffuse = [0.5, 0.5, 0.5]\n"
        "[[material]]\nname = \"white\"\ndiffuse = [0.7, 0.7, 0.7]\n";
    for (const bool is_grey : {true, false}) {
        const std::string name = is_grey ? "grey" : "coloured";
        ASSERT_EQ(run("bake run " + description(name, is_grey ? grey : "")).code, 0);
        for (const std::string& file : {map_path(name), map_path(name) + ".work/lamp.000003.vdb"}) {
            const VdbReader reader(file);
            for (const std::string& grid : reader.grid_names()) {
                if (grid.ends_with("/density") || grid.ends_with("/a19")) {
                    EXPECT_EQ(reader.channels(grid), is_grey ? 1 : 3) << file << " " << grid;
                }
            }
        }
    }
    const std::string out = " --output " + (test_folder() / "d.png").string() + " --view density --volume ";
    EXPECT_EQ(run("viewer " + map_path("grey") + out + map_path("grey") + ".work/lamp.000003.vdb").code, 0);
    expect_failure("viewer " + map_path("grey") + out + map_path("coloured") + ".work/lamp.000003.vdb", 1,
                   {"lamp.000003.vdb", "no density volume of this map"});
    expect_failure("viewer " + map_path("grey") + out + "x.vdb --direct traced", 2, {"--direct traced"});
}

TEST(EndToEnd, ViewerRefusesWhatItCannotShow) {
    const std::string map = map_path("viewer"), out = " --output " + (test_folder() / "v.png").string();
    ASSERT_EQ(run("bake run " + description("viewer", "", kCornell) + " -o " + map).code, 0);
    expect_failure("viewer " + map + out + " --light lamp=0,0,0", 2, {"lamp", "domain"});
    expect_failure("viewer " + map + out + " --light lamp=1,2", 2, {"--light", "three numbers"});
    expect_failure("viewer " + map + out + " --light sun=1,2,3", 2, {"sun", "lamp"});
    expect_failure("viewer " + map + out + " --gain lamp=x", 2, {"--gain"});
    expect_failure("viewer " + map + out + " --camera back", 2, {"back", "front"});
    expect_failure("viewer " + map + out + " --size 0x5", 2, {"--size"});
    expect_failure("viewer " + map + " --output v.bmp", 2, {".exr", ".png"});
    expect_failure("viewer " + map + " --output /nowhere/v.png", 1, {"/nowhere"});
    expect_failure("viewer " + map_path("missing") + out, 1, {"missing.vdb"});
    expect_failure("viewer " + map + out + " --geometry " + std::string(PIM_DATA) + "/panel/panel.glb", 1,
                   {"another geometry"});
    std::string cut = read_text(map);
    std::ofstream(map_path("cut"), std::ios::binary) << cut.substr(0, cut.size() / 2);
    expect_failure("viewer " + map_path("cut") + out, 1, {"cut.vdb"});
    EXPECT_EQ(
        run("viewer " + map + out + " --light lamp=2,4,2 --gain lamp=0.5 --direct baked --view density").code,
        0);
}

}  // namespace
}  // namespace pim
