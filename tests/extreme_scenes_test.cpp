// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes, lamps and settings at the edge of what can be meant, baked as a user would: the right answer, a
// clear refusal, or a warning that names the loss.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "baked_scenes.h"
#include "base64.h"
#include "common/map/map_file.h"
#include "programs.h"
#include "stability_table.h"

namespace pim {
namespace {

constexpr double kAlbedo = 0.5;

// A room of 4 x 3 x 5 as OBJ, all its lengths times `size`; `more` behind it, vertices counted from 9.
std::string room(double size = 1, const std::string& more = "") {
    std::string text = "mtllib a.mtl\nusemtl wall\n";
    for (int k = 0; k < 8; ++k)
        text += fmt::format("v {:.9g} {:.9g} {:.9g}\n", k & 1 ? 4 * size : 0, k & 2 ? 3 * size : 0,
                            k & 4 ? 5 * size : 0);
    return text + "f 1 5 7 3\nf 2 4 8 6\nf 1 2 6 5\nf 3 7 8 4\nf 1 3 4 2\nf 5 6 8 7\n" + more;
}

struct Lamp {
    std::string low = "[1.5, 1.8, 2]", high = "[2.5, 2.4, 3]", position = "[2, 2, 2.5]",
                power = "[100, 100, 100]";
    std::string more = "samples = 40\n";
};

struct Setup {
    std::string eye = "[0.5, 1.5, 0.5]", target = "[2, 1.5, 4]", obj = room();
    double albedo = kAlbedo;
    Lamp lamp;
    std::string scene = "", grid = "cells = 8\n", bake = "photons = 4000\n";
};

fs::path write(const Setup& s, const std::string& name) {
    const fs::path folder = test_folder() / name;
    fs::create_directories(folder);
    std::ofstream(folder / "a.obj") << s.obj;
    std::ofstream(folder / "a.mtl") << "newmtl wall\nKd " << s.albedo << " " << s.albedo << " " << s.albedo
                                    << "\n";
    std::ofstream(folder / "a.toml") << "[scene]\ngeometry = \"a.obj\"\n"
                                     << s.scene << "[grid]\nreach_photons = 262144\n"
                                     << s.grid << "[bake]\n"
                                     << s.bake << "[[light]]\nname = \"lamp\"\npower = " << s.lamp.power
                                     << "\nposition = " << s.lamp.position
                                     << "\ndomain = { min = " << s.lamp.low << ", max = " << s.lamp.high
                                     << " }\n"
                                     << s.lamp.more << "[[camera]]\nname = \"eye\"\neye = " << s.eye
                                     << "\ntarget = " << s.target << "\nsize = [32, 32]\n";
    return folder / "a.toml";
}

struct Result {
    Outcome outcome;
    std::optional<IlluminationMap> map;
    double flux = 0;  // indirect, landing, per watt, at the lamp's position
};

// Values that are not finite anywhere in a map.
std::size_t not_finite(const IlluminationMap& map) {
    std::size_t count = 0;
    for (const MapLight& light : map.lights)
        for (const auto& box : light.polynomials)
            for (const auto& p : box)
                if (p) {
                    for (const float a : p->coefficients) count += !std::isfinite(a);
                    for (const float r : p->residuals) count += !std::isfinite(r);
                }
    return count;
}

Result bake(const Setup& setup, const std::string& name) {
    const fs::path description = write(setup, name);
    const fs::path map = fs::path(description).replace_extension(".vdb");
    Result result{run_program("bake run " + description.string() + " --overwrite --clean", test_folder()),
                  {}};
    if (result.outcome.code != 0) return result;
    result.map = read_map(map);
    const MapLight& light = result.map->lights[0];
    EXPECT_EQ(not_finite(*result.map), 0u) << name;
    const Vec3 position((Vec3d(light.domain.min) + Vec3d(light.domain.max)) * 0.5);
    const auto values = patch_irradiance(*result.map, {Component::indirect}, {{position, Rgb(1)}});
    for (std::size_t p = 0; p < values.size(); ++p)
        result.flux += double(mean_channel(values[p])) * double(result.map->patches[p].area);
    EXPECT_TRUE(std::isfinite(result.flux)) << name;
    const Outcome picture = run_program(
        "viewer " + map.string() + " --spp 1 --output " + (test_folder() / (name + ".exr")).string(),
        test_folder());
    EXPECT_EQ(picture.code, 0) << name << picture.text;
    return result;
}

// Of a closed room: what lands after the first surface, sum of albedo^k.
double closed_room(double albedo) { return albedo / (1 - albedo); }

enum class Expect { right, warned, refused };

struct SceneCase {
    std::string group, name;
    Setup setup;
    Expect expect = Expect::right;
    std::string word = "";            // of the warning or the refusal
    std::optional<double> flux = {};  // where it is known
    double tolerance = 0.03;  // of that; 160,000 photons of some ten bounces tell it to half a percent
};

Setup scaled(double size) {
    Setup s;
    s.scene = fmt::format("metres_per_unit = {:.17g}\n", size);
    const auto place = [&](double x, double y, double z) {
        return fmt::format("[{:.9g}, {:.9g}, {:.9g}]", x * size, y * size, z * size);
    };
    s.lamp.low = place(1.5, 1.8, 2), s.lamp.high = place(2.5, 2.4, 3), s.lamp.position = place(2, 2, 2.5);
    s.eye = place(0.5, 1.5, 0.5), s.target = place(2, 1.5, 4);
    return s;
}

Setup with_obj(const std::string& more) {
    Setup s;
    s.obj = room(1, more);
    return s;
}

Setup with_lamp(const Lamp& lamp) {
    Setup s;
    s.lamp = lamp;
    return s;
}

Setup with_power(const std::string& power) { return with_lamp({.power = power}); }

Setup with_albedo(double albedo, int photons = 4000) {
    Setup s;
    s.albedo = albedo;
    s.bake = fmt::format("photons = {}\n", photons);
    return s;
}

Setup with_grid(const std::string& grid) {
    Setup s;
    s.grid = grid;
    return s;
}

Setup with_bake(const std::string& settings) {
    Setup s;
    s.bake = settings;
    return s;
}

Lamp at(const std::string& low, const std::string& high, const std::string& position) {
    return {.low = low, .high = high, .position = position};
}

std::string many_coincident_triangles(int count) {
    std::string text = "v 1 0.5 1\nv 1.5 0.5 1\nv 1 0.5 1.5\n";
    for (int i = 0; i < count; ++i) text += "f 9 10 11\n";
    return text;
}

std::vector<SceneCase> scene_cases() {
    const double half = closed_room(kAlbedo);
    const std::string tiny_box =
        "v 1 0 1\nv 1.5 0 1\nv 1.5 0 1.5\nv 1 0 1.5\nv 1 1 1\nv 1.5 1 1\nv 1.5 1 1.5\nv 1 1 1.5\n";
    Setup open;
    open.obj = "mtllib a.mtl\nusemtl wall\nv 0 0 0\nv 0.01 0 0\nv 0 0 0.01\nf 1 2 3\n";
    open.lamp = at("[-5, 50, -5]", "[5, 60, 5]", "[0, 55, 0]");
    Setup empty;
    empty.obj = "mtllib a.mtl\nusemtl wall\n";
    Setup doorway = with_obj(
        "v 2 0 0\nv 2 3 0\nv 2 3 2\nv 2 0 2\nf 9 10 11 12\nv 2 0 3\nv 2 3 3\nv 2 3 5\nv 2 0 5\nf 13 14 15 "
        "16\n");
    doorway.lamp = at("[1, 1, 2.2]", "[3, 1.8, 2.8]", "[1.5, 1.5, 2.5]");
    Setup inside_solid = with_obj(
        tiny_box + "f 9 10 11 12\nf 13 16 15 14\nf 9 13 14 10\nf 10 14 15 11\nf 11 15 16 12\nf 12 16 13 9\n");
    inside_solid.lamp = at("[1.1, 0.2, 1.1]", "[1.4, 0.8, 1.4]", "[1.25, 0.5, 1.25]");
    return {
        {"scenes", "0.001 mm across", scaled(2.5e-7), Expect::right, "", half},
        {"scenes", "1 mm across", scaled(2.5e-4), Expect::right, "", half},
        {"scenes", "1,000 km across", scaled(2.5e5), Expect::right, "", half},
        {"scenes", "needle triangles, 4 m by 0.1 µm",
         with_obj("v 0 1 1\nv 4 1 1\nv 4 1.0000001 1\nf 9 10 11\n"), Expect::right, "", half},
        {"scenes", "triangles of no area", with_obj("v 1 1 1\nv 2 1 1\nv 3 1 1\nf 9 10 11\nf 9 9 9\n"),
         Expect::warned, "without area", half},
        {"scenes", "a vertex that is no number", with_obj("v nan 1 1\nv 2 1 1\nv 3 2 1\nf 9 10 11\n"),
         Expect::warned, "no number", half},
        {"scenes", "1,000,000 coincident triangles", with_obj(many_coincident_triangles(1'000'000)),
         Expect::warned, "duplicate", half},
        {"scenes", "an edge of three faces",
         with_obj("v 2 0 2\nv 2 1 2\nv 2 0 3\nv 3 0 2\nv 1 0 2\nf 9 10 11\nf 9 10 12\nf 9 10 13\n"),
         Expect::right, "", half, 0.03},
        {"scenes", "one face turned round",
         [] {
             Setup s;
             s.obj.replace(s.obj.find("f 1 5 7 3"), 9, "f 3 7 5 1");
             return s;
         }(),
         Expect::right, "", half},
        {"scenes", "the same face from both sides", with_obj("f 3 4 8 7\n"), Expect::warned, "duplicate",
         half},
        {"scenes", "open: one photon in 10^9 meets a surface", open, Expect::warned, "ended on a surface", 0},
        {"scenes", "no surface at all", empty, Expect::refused, ""},
        {"scenes", "closed, all light reflected", with_albedo(1, 500), Expect::warned, "cut off",
         closed_room(1000.0 / 1001), 0.05},
        {"scenes", "closed, reflectance 0.999", with_albedo(0.999, 500), Expect::warned, "cut off",
         closed_room(0.999) * (1 - std::exp(-1.0005)), 0.05},
        {"scenes", "black", with_albedo(0), Expect::right, "", 0},
        {"lamps", "1 mm from a wall", with_lamp(at("[0.001, 1, 2]", "[0.5, 2, 3]", "[0.001, 1.5, 2.5]")),
         Expect::right, "", half, 0.1},
        {"lamps", "touching a wall", with_lamp(at("[0, 1, 2]", "[0.5, 2, 3]", "[0, 1.5, 2.5]")),
         Expect::right, "", half, 0.1},
        {"lamps", "inside a solid", inside_solid, Expect::refused, "lies inside"},
        {"lamps", "outside of everything", with_lamp(at("[9, 1, 2]", "[10, 2, 3]", "[9.5, 1.5, 2.5]")),
         Expect::right},
        {"lamps", "sweeping through a doorway", doorway, Expect::right, "", half, 0.1},
        {"lamps", "power 10^-30 W", with_power("[1e-30, 1e-30, 1e-30]"), Expect::right, "", half},
        {"lamps", "power 10^30 W", with_power("[1e30, 1e30, 1e30]"), Expect::right, "", half},
        {"lamps", "power 0", with_power("[0, 0, 0]"), Expect::right, "", half},
        {"lamps", "power below 0", with_power("[-1, 1, 1]"), Expect::refused, "power"},
        {"lamps", "power that is no number", with_power("[nan, 1, 1]"), Expect::refused, "power"},
        {"lamps", "a place that is no number", with_lamp({.position = "[nan, 1, 1]"}), Expect::refused,
         "position"},
        {"lamps", "a domain turned inside out", with_lamp(at("[2, 2, 2]", "[1, 1, 1]", "[1.5, 1.5, 1.5]")),
         Expect::refused, "domain"},
        {"settings", "1 photon per position", with_bake("photons = 1\n"), Expect::warned,
         "ended on a surface"},
        {"settings", "a cell larger than the scene", with_grid("cell_size = 100\n"), Expect::right, "", half,
         0.1},
        {"settings", "cells of 1 µm", with_grid("cell_size = 1e-6\n"), Expect::refused, "cell"},
        {"settings", "cells of 6 cm on walls of one triangle pair", with_grid("cell_size = 0.0625\n"),
         Expect::right, "", half},
        {"settings", "degree 0", with_bake("photons = 4000\ndegree = 0\n"), Expect::right, "", half},
        {"settings", "degree 1", with_bake("photons = 4000\ndegree = 1\n"), Expect::right, "", half},
        {"settings", "degree 2", with_bake("photons = 4000\ndegree = 2\n"), Expect::right, "", half},
        {"settings", "a single lamp position", with_lamp({.more = "samples = 1\n"}), Expect::warned,
         "determine 1 of 20", half, 0.06},
        {"settings", "positions in two layers", with_lamp({.more = "samples = [4, 4, 2]\n"}), Expect::warned,
         "determine 16 of 20", half},
        {"settings", "more boxes than positions", with_lamp({.more = "samples = 4\nboxes = [3, 3, 3]\n"}),
         Expect::refused, "hold no lamp position"},
    };
}

class SceneCases : public testing::TestWithParam<std::size_t> {};

TEST_P(SceneCases, RightRefusedOrWarned) {
    const SceneCase c = scene_cases()[GetParam()];
    const Result r = bake(c.setup, fmt::format("case{}", GetParam()));
    const std::string& text = r.outcome.text;
    std::string figures = "-";
    if (c.expect == Expect::refused) {
        EXPECT_EQ(r.outcome.code, 1) << text;
        const std::size_t begin = text.rfind("error: ");
        ASSERT_NE(begin, std::string::npos) << text;
        figures = text.substr(begin + 7, text.find('\n', begin) - begin - 7);
        for (std::size_t at; (at = figures.find(test_folder().string())) != std::string::npos;)
            figures.erase(at, figures.find("a.", at) - at);
    } else {
        ASSERT_EQ(r.outcome.code, 0) << text;
        figures = fmt::format("flux {:.4g}", r.flux);
        if (c.flux) {
            figures += fmt::format(" of {:.4g}", *c.flux);
            EXPECT_NEAR(r.flux, *c.flux, c.tolerance * std::max(*c.flux, 1e-9)) << text;
        }
    }
    EXPECT_TRUE(r.outcome.names(c.word)) << "'" << c.word << "' in:\n" << text;
    if (c.expect == Expect::right) {
        EXPECT_FALSE(r.outcome.names("warning: ")) << text;
    }
    const char* names[] = {"right", "warned", "refused"};
    add_to_table("scenes", {c.group, c.name, names[int(c.expect)], figures});
}

INSTANTIATE_TEST_SUITE_P(All, SceneCases, testing::Range(std::size_t{0}, scene_cases().size()));

TEST(Settings, ABillionPhotonsArePlanned) {
    const fs::path description = write(with_bake("photons = 1000000000\n"), "billion");
    const Outcome plan = run_program("bake plan " + description.string() + " --json --quiet", test_folder());
    ASSERT_EQ(plan.code, 0) << plan.text;
    const auto p = nlohmann::json::parse(plan.text);
    EXPECT_EQ(p["photons_total"].get<double>(), 40e9);
    EXPECT_GT(p["seconds_estimate"].get<double>(), 1000);
    add_to_table("scenes", {"settings", "10^9 photons per position", "planned",
                            fmt::format("{:.2g} s", p["seconds_estimate"].get<double>())});
}

// ---- the same room at other sizes and places

// The room as glTF, its node scaled and moved: triangles with vertices of their own.
std::string room_gltf(double size, double shift) {
    constexpr int kFaces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                  {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    std::vector<float> corners;
    for (const auto& face : kFaces)
        for (const int corner : {0, 1, 2, 0, 2, 3}) {
            const int k = face[corner];
            corners.insert(corners.end(), {k & 1 ? 4.0f : 0, k & 2 ? 3.0f : 0, k & 4 ? 5.0f : 0});
        }
    return fmt::format(
        R"({{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0,"name":"room",)"
        R"("scale":[{0:.17g},{0:.17g},{0:.17g}],"translation":[{1:.17g},{1:.17g},{1:.17g}]}}],)"
        R"("meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"material":0}}]}}],)"
        R"("materials":[{{"pbrMetallicRoughness":{{"baseColorFactor":[0.5,0.5,0.5,1],"metallicFactor":0}}}}],)"
        R"("accessors":[{{"bufferView":0,"componentType":5126,"count":36,"type":"VEC3","min":[0,0,0],"max":[4,3,5]}}],)"
        R"("bufferViews":[{{"buffer":0,"byteLength":432}}],"buffers":[{{"byteLength":432,)"
        R"("uri":"data:application/octet-stream;base64,{2}"}}]}})",
        size, shift, base64(corners));
}

// A picture of the room; power grows with its area, so that radiance stays.
Image picture_of_room(double size, double shift, const std::string& name) {
    const fs::path folder = test_folder() / name;
    fs::create_directories(folder);
    std::ofstream(folder / "a.gltf") << room_gltf(size, shift);
    const auto place = [&](double x, double y, double z) {
        return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", x * size + shift, y * size + shift,
                           z * size + shift);
    };
    std::ofstream(folder / "a.toml") << fmt::format(
        "[scene]\ngeometry = \"a.gltf\"\n[grid]\ncells = 10\nreach_photons = 262144\n[bake]\nphotons = "
        "5000\n"
        "[[light]]\nname = \"lamp\"\npower = [{0:.17g}, {0:.17g}, {0:.17g}]\nposition = {1}\n"
        "domain = {{ min = {2}, max = {3} }}\nsamples = 40\n"
        "[[camera]]\nname = \"eye\"\neye = {4}\ntarget = {5}\nsize = [48, 48]\n",
        100 * size * size, place(2.25, 2, 2.5), place(1.5, 1.75, 2), place(2.5, 2.5, 3), place(0.5, 1.5, 0.5),
        place(2, 1.25, 4));
    const Outcome baked =
        run_program("bake run " + (folder / "a.toml").string() + " --overwrite --clean", test_folder());
    EXPECT_EQ(baked.code, 0) << baked.text;
    const fs::path picture = folder / "a.exr";
    const Outcome seen = run_program(
        "viewer " + (folder / "a.vdb").string() + " --spp 4 --vector-unit plain --output " + picture.string(),
        test_folder());
    EXPECT_EQ(seen.code, 0) << seen.text;
    return read_image(picture);
}

double difference(const Image& a, const Image& b) {
    EXPECT_EQ(a.pixels.size(), b.pixels.size());
    double squares = 0, whole = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i) {
        squares += double((a.pixels[i] - b.pixels[i]).length2());
        whole += double(b.pixels[i].length2());
    }
    return std::sqrt(squares / whole);
}

TEST(Scale, TheSamePictureAtAnySizeAndPlace) {
    const Image one = picture_of_room(1, 0, "size1");
    const auto expect = [&](const std::string& name, double size, double shift, double allowed) {
        const double d = difference(picture_of_room(size, shift, "moved"), one);
        EXPECT_LE(d, allowed) << name;
        add_to_table("scale", {name, fmt::format("{:.1e}", d),
                               allowed == 0 ? "the same" : fmt::format("{:g}", allowed)});
    };
    expect("2^-10", 0x1p-10, 0, 0);
    expect("2^10", 0x1p10, 0, 0);
    expect("2^20", 0x1p20, 0, 0);
    expect("10^-3", 1e-3, 0, 1e-3);
    expect("10^3", 1e3, 0, 1e-3);
    expect("10^6", 1e6, 0, 1e-3);
    expect("moved by 10^6 of its size", 1, 5e6, 1e-3);
}

}  // namespace
}  // namespace pim
