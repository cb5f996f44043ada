// SPDX-License-Identifier: GPL-3.0-or-later
// What the viewer does without a window, as a user runs it: pictures of all views, probes, films, set-ups,
// the benchmark, and what it says to bad input.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "common/render/camera_rays.h"
#include "screen_shot.h"
#include "small_maps.h"
#include "viewer/files/command_text.h"
#include "viewer/files/csv.h"
#include "viewer/files/lighting_setup.h"
#include "viewer/files/names.h"
#include "viewer/files/probe.h"
#include "viewer/relight/kernels.h"
#include "viewer/tone/tone_curve.h"
#include "viewer/view_state.h"

namespace pim {
namespace {

const Baked& map() { return small_map(SmallMap::of_thesis); }

std::string in_folder(const std::string& name) { return (test_folder() / name).string(); }

std::string written(const std::string& name, const std::string& text) {
    std::ofstream(test_folder() / name, std::ios::binary) << text;
    return in_folder(name);
}

Outcome view(const std::string& options, const Baked& baked = map()) {
    return run_project("viewer " + baked.map_file.string() + " " + options);
}

// Of a job that must succeed; what it wrote to stdout.
std::string done(const std::string& options, const Baked& baked = map()) {
    const Outcome outcome = view(options + " --quiet", baked);
    EXPECT_EQ(outcome.code, 0) << options << "\n" << outcome.errors;
    return outcome.text;
}

void expect_refusal(const std::string& options, int code, const std::vector<std::string>& words) {
    const Outcome outcome = view(options);
    EXPECT_EQ(outcome.code, code) << options << "\n" << outcome.errors;
    for (const std::string& word : words)
        EXPECT_NE(outcome.errors.find(word), std::string::npos)
            << options << " should name '" << word << "':\n"
            << outcome.errors;
    EXPECT_LE(std::ranges::count(outcome.errors, '\n'), 1) << outcome.errors;
}

// ---- single pictures

TEST(ViewerJobs, EveryViewIsAPictureOfItsOwn) {
    std::set<std::string> pictures;
    for (const std::string& name : view_names()) {
        const std::string file = in_folder(name + ".png");
        done("--view " + name + " --size 40x30 --output " + file);
        const Image image = read_image(file);
        EXPECT_EQ(image.width, 40) << name;
        EXPECT_EQ(image.height, 30) << name;
        EXPECT_TRUE(std::ranges::any_of(image.pixels, [](const Rgb& p) { return luminance(p) > 0.05f; }))
            << name << " is black";
        pictures.insert(read_text(file));
    }
    EXPECT_EQ(pictures.size(), view_names().size());
}

TEST(ViewerJobs, ToneCurvesAreWhatTheyAreSaidToBe) {
    const std::string options = "--size 40x30 --exposure 1.5 --output ";
    done(options + in_folder("linear.exr"));
    const Image linear = read_image(in_folder("linear.exr"));
    for (const std::string& name : tone_curve_names()) {
        done(options + in_folder("curve.png") + " --tone-curve " + name);
        Image expected = linear;
        for (Rgb& pixel : expected.pixels)
            for (int c = 0; c < 3; ++c) pixel[c] = apply(parse_tone_curve(name), std::exp2(1.5f) * pixel[c]);
        write_image(in_folder("expected.png"), expected, 1);
        EXPECT_LE(compare(read_png(in_folder("curve.png")), read_png(in_folder("expected.png"))).largest, 1)
            << name;
    }
}

// ---- light meters

TEST(ViewerJobs, ProbesMeasureWhatTheIrradiancePictureShows) {
    const Baked& baked = small_map(SmallMap::by_facing);
    const Camera& camera = baked.baked.scene.cameras.front();
    const Imath::V2i size(48, 48);
    std::string points = "x,y,z,nx,ny,nz\n";
    std::vector<std::size_t> pixels;
    for (int y = 3; y < size.y; y += 6)
        for (int x = 3; x < size.x; x += 6) {
            const Ray ray = CameraRays(camera, size).through(float(x) + 0.5f, float(y) + 0.5f);
            const auto hit = baked.caster.intersect(ray);
            if (!hit) continue;
            const SurfacePoint s = surface_at(baked.baked.scene, *hit);
            const Vec3d place = baked.baked.scene.geometry.to_world(s.position);
            points += fmt::format("{},{},{},{},{},{}\n", place.x, place.y, place.z, s.shading_normal.x,
                                  s.shading_normal.y, s.shading_normal.z);
            pixels.push_back(std::size_t(y * size.x + x));
        }
    ASSERT_GT(pixels.size(), 30u);
    const std::string file = written("points.csv", points);
    for (const std::string direct : {"baked", "traced"}) {
        const std::string options = " --light lamp=2.2,4.1,1.7 --direct " + direct;
        done("--spp 1 --view irradiance --size 48x48 --output " + in_folder("e.exr") + options, baked);
        const Image picture = read_image(in_folder("e.exr"));
        const CsvTable table = parse_csv(done("--probe " + file + options, baked), "stdout");
        ASSERT_EQ(table.rows.size(), pixels.size());
        for (std::size_t i = 0; i < pixels.size(); ++i) {
            const auto value = [&](const char* column) {
                return float(csv_number(table, table.rows[i], column));
            };
            const Rgb measured(value("red"), value("green"), value("blue")),
                shown = picture.pixels[pixels[i]];
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(measured[c], shown[c], 1e-4f * (1 + shown[c])) << direct << ", point " << i;
            EXPECT_NEAR(value("lux"), 683 * luminance(measured), 1e-3f * (1 + value("lux"))) << i;
        }
    }
}

// ---- films

const std::string kLampPath = "time,lamp,x,y,z\n0,lamp,1.2,4.2,1.2\n1,lamp,3.8,4.2,3.6\n";
const std::string kCameraPath =
    "time,eye_x,eye_y,eye_z,target_x,target_y,target_z\n0,2.78,2.73,-8,2.78,2.73,2.8\n"
    "1.5,2.2,2.4,-7,2.78,2.73,2.8\n";

struct Film {
    fs::path folder;
    std::string options;

    explicit Film(const std::string& name, const std::string& more, int fps = 4)
        : folder(test_folder() / name) {
        fs::create_directories(folder);
        options = fmt::format("--size 40x30 --fps {} --output {} {}", fps,
                              (folder / "frame_%03d.png").string(), more);
    }
    fs::path frame(int number) const { return folder / fmt::format("frame_{:03}.png", number); }
    int count() const {
        int frames = 0;
        for (const auto& entry : fs::directory_iterator(folder)) frames += entry.path().extension() == ".png";
        return frames;
    }
};

TEST(ViewerJobs, AFilmHasAFrameForEachMoment) {
    const std::string lamp = written("lamp.csv", kLampPath), camera = written("camera.csv", kCameraPath);
    const std::string options = "--exposure 0.5 --spp 256 ";
    const Film film("film", options + "--path " + lamp + " --path " + camera);
    done(film.options);
    EXPECT_EQ(film.count(), 7);  // 0, 0.25, ... 1.5 s
    // Films and stills have renderers and samples of their own; at this size half of the pixels see an edge.
    // Measured with 16, 64, 256, 1024 samples: mean difference 1.1, 0.5, 0.13, 0.05, the largest 40, 15,
    // 5, 2.
    const auto expect_close = [](const Difference& d) {
        EXPECT_LT(d.mean, 0.4) << d;
        EXPECT_LE(d.largest, 15) << d;
    };
    const std::string still = options + "--size 40x30 --output " + in_folder("still.png");
    done(still + " --light lamp=1.2,4.2,1.2");
    expect_close(compare(read_png(film.frame(0)), read_png(in_folder("still.png"))));
    done(still + " --light lamp=3.8,4.2,3.6 --eye 2.2,2.4,-7");
    const Rgba8Image end = read_png(in_folder("still.png"));
    expect_close(compare(read_png(film.frame(6)), end));
    EXPECT_GT(compare(read_png(film.frame(0)), end).mean, 5);
    EXPECT_GT(compare(read_png(film.frame(4)), end).mean, 2);  // the lamp has arrived, the camera has not
}

TEST(ViewerJobs, AFilmGoesOnWhereItStopped) {
    const std::string lamp = written("lamp.csv", kLampPath);
    const Film film("stopped", "--path " + lamp);
    done(film.options);
    ASSERT_EQ(film.count(), 5);
    const std::string lost = read_text(film.frame(3)), kept = read_text(film.frame(2));
    fs::remove(film.frame(3));
    written("stopped/frame_002.png", "touched");
    EXPECT_NE(view(film.options).errors.find("1 frames to render, 4 done before"), std::string::npos);
    EXPECT_EQ(read_text(film.frame(3)), lost);
    EXPECT_EQ(read_text(film.frame(2)), "touched");

    expect_refusal(film.options + " --gain lamp=2", 1, {"frame_%03d.png.record", "--overwrite"});
    written("lamp.csv", kLampPath + "2,lamp,3.8,4.2,1.2\n");
    expect_refusal(film.options, 1, {"frame_%03d.png.record", "--overwrite"});
    EXPECT_EQ(read_text(film.frame(3)), lost);
    done(film.options + " --overwrite");
    EXPECT_EQ(film.count(), 9);
    EXPECT_NE(read_text(film.frame(2)), "touched");
    const Film strange("strange", "--path " + lamp);
    written("strange/frame_000.png", "somebody's");
    expect_refusal(strange.options, 1, {"frame_000.png", "--overwrite"});
    EXPECT_EQ(read_text(strange.frame(0)), "somebody's");
}

// One exposure or scale for all frames, or nobody would see the lamp grow dim.
TEST(ViewerJobs, AFilmKeepsTheScaleOfItsFirstFrame) {
    const std::string gains = written("gain.csv", "time,lamp,gain\n0,lamp,1\n1,lamp,0.25\n");
    for (const std::string name : {"radiance", "irradiance", "density"}) {
        const Film film("dimmed_" + name, "--view " + name + " --path " + gains, 1);
        done(film.options);
        EXPECT_GT(compare(read_png(film.frame(0)), read_png(film.frame(1))).mean, 8) << name;
    }
    const Image density = read_image(test_folder() / "dimmed_density" / "frame_000.png");
    for (const Rgb& pixel : density.pixels) EXPECT_EQ(pixel, Rgb(pixel.x));  // grey
}

TEST(ViewerJobs, AllVectorUnitsMakeTheSameFilm) {
    const std::string lamp = written("lamp.csv", kLampPath);
    const Film plain("plain", "--spp 2 --direct traced --vector-unit plain --path " + lamp);
    done(plain.options);
    for (const VectorUnit unit : {VectorUnit::avx2, VectorUnit::avx512}) {
        if (!is_supported(unit)) continue;
        const Film film(name(unit), "--spp 2 --direct traced --vector-unit " + std::string(name(unit)) +
                                        " --path " + lamp);
        done(film.options);
        for (int i = 0; i < plain.count(); ++i)
            EXPECT_LE(compare(read_png(plain.frame(i)), read_png(film.frame(i))).largest, 1) << i;
    }
}

// ---- set-ups

ViewState unusual_state() {
    const Scene& scene = map().baked.scene;
    ViewState state = initial_state(scene, map().baked.map);
    state.camera = scene.cameras[1];
    state.camera.vertical_fov = 55;
    state.lamps[0] = {
        .position = scene.geometry.to_local({1.3, 4.7, 3.1}), .gain = 1.7f, .colour = Rgb(1, 0.6f, 0.3f)};
    state.view = View::indirect;
    state.automatic_exposure = false;
    state.exposure = 1.25f;
    state.tone_curve = ToneCurve::aces;
    return state;
}

TEST(ViewerJobs, ASetUpEqualsItsOptionsByteForByte) {
    const Scene& scene = map().baked.scene;
    save_setup(test_folder() / "setup.toml", scene, unusual_state());
    for (const std::string extension : {".exr", ".png"}) {
        const std::string by_setup = in_folder("by_setup" + extension),
                          by_options = in_folder("by_options" + extension);
        done("--setup " + in_folder("setup.toml") + " --size 48x36 --output " + by_setup);
        done(
            "--camera near --fov 55 --light lamp=1.3,4.7,3.1 --gain lamp=1.7 --colour lamp=1,0.6,0.3 "
            "--view indirect --exposure 1.25 --tone-curve aces --size 48x36 --output " +
            by_options);
        EXPECT_EQ(read_text(by_setup), read_text(by_options)) << extension;
    }
    const std::string command = headless_command(scene, map().baked.map, unusual_state(), {48, 36},
                                                 {map().map_file, in_folder("by_command.png"), {}});
    EXPECT_EQ(run_project(command).code, 0) << command;
    EXPECT_EQ(read_text(in_folder("by_command.png")), read_text(in_folder("by_setup.png"))) << command;
}

TEST(ViewerJobs, OptionsGoOverTheSetUp) {
    save_setup(test_folder() / "setup.toml", map().baked.scene, unusual_state());
    const std::string options = "--setup " + in_folder("setup.toml") + " --size 48x36 --output ";
    done(options + in_folder("one.png"));
    done(options + in_folder("other.png") + " --gain lamp=3.4");
    const double ratio = compare(read_png(in_folder("one.png")), read_png(in_folder("other.png"))).mean;
    EXPECT_GT(ratio, 5);
    expect_refusal("--output x.png --setup " + written("bad.toml", "view = \"sideways\"\n"), 1,
                   {"bad.toml:1", "view", "sideways", "irradiance"});
}

// ---- benchmark

TEST(ViewerJobs, TheBenchmarkIsJsonWithTheKeysThatOthersRead) {
    const auto json = nlohmann::json::parse(done("--benchmark --size 32x24"));
    for (const char* key : {"width", "height", "lamps", "threads", "vector_unit", "seconds_to_first_picture",
                            "points", "patches_per_point", "patches_in_view", "view_cache_bytes",
                            "coefficient_bytes", "boxes_in_memory", "peak_rss_bytes", "display_ms"})
        EXPECT_TRUE(json.contains(key)) << key;
    EXPECT_EQ(json["width"], 32);
    EXPECT_EQ(json["height"], 24);
    for (const char* motion : {"first_lap", "lamp_moving", "camera_moving"}) {
        const auto& m = json.at(motion);
        for (const char* key :
             {"median_ms", "p95_ms", "longest_ms", "frames_per_second", "most_active_boxes"})
            EXPECT_TRUE(m.contains(key)) << motion << " " << key;
        for (const char* key : {"view", "shadow_rays", "evaluate", "shade"})
            EXPECT_TRUE(m.at("parts_ms").contains(key)) << motion << " " << key;
        EXPECT_GE(m["frames"], 100) << motion;
        EXPECT_LE(m["median_ms"], m["p95_ms"]) << motion;
        EXPECT_LE(m["p95_ms"], m["longest_ms"]) << motion;
        EXPECT_NEAR(m["frames_per_second"].get<double>() * m["median_ms"].get<double>(), 1000, 1) << motion;
    }
}

// ---- bad input

TEST(ViewerJobs, BadOptionsAreWrongUsage) {
    const std::string out = " --output " + in_folder("out.png");
    expect_refusal("--view sideways" + out, 2, {"--view", "sideways", "radiance", "trust"});
    expect_refusal("--tone-curve film" + out, 2, {"--tone-curve", "film", "reinhard"});
    expect_refusal("--fov 200" + out, 2, {"--fov", "200", "0.1 to 179"});
    expect_refusal("--fov wide" + out, 2, {"--fov", "wide"});
    expect_refusal("--eye 1,2" + out, 2, {"--eye", "1,2"});
    expect_refusal("--eye 0,0,0 --target 0,1,0" + out, 2, {"--eye", "--target", "--up", "line"});
    expect_refusal("--colour lamp=1,-1,0" + out, 2, {"--colour", "negative"});
    expect_refusal("--exposure bright" + out, 2, {"--exposure", "bright"});
    expect_refusal("--vector-unit sse" + out, 2, {"--vector-unit", "sse", "plain"});
    expect_refusal("--integrator guess" + out, 2, {"--integrator", "guess"});
    expect_refusal("--overwrite" + out, 2, {"--overwrite"});
    EXPECT_FALSE(fs::exists(in_folder("out.png")));
}

TEST(ViewerJobs, JobsThatCannotBeAreWrongUsage) {
    const std::string lamp = written("lamp.csv", kLampPath);
    expect_refusal("--ui", 2, {"--ui", "--output"});
    expect_refusal("--ui --output shot.exr", 2, {"--ui", ".png"});
    expect_refusal("--benchmark --probe x.csv", 2, {"--benchmark", "--probe"});
    expect_refusal("--benchmark --output x.png", 2, {"--output", "stdout"});
    expect_refusal("--path " + lamp + " --output frame.png", 2, {"frame.png", "%04d"});
    expect_refusal("--path " + lamp + " --output frame_%d.png --fps 0", 2, {"0"});
    expect_refusal("--path " + lamp + " --output frame_%d.png --integrator path", 2, {"--integrator"});
    expect_refusal("--path " + lamp + " --output frame_%d.png --stats x.json", 2, {"--stats"});
}

TEST(ViewerJobs, BadTablesAreNamedWithTheirLine) {
    const auto film = [](const std::string& table) {
        return "--path " + written("bad.csv", table) + " --output " + in_folder("bad_%d.png");
    };
    expect_refusal(film("time,lamp,x,y,z\n0,sun,1,4,1\n"), 1, {"bad.csv:2", "sun"});
    expect_refusal(film("time,lamp,x,y,z\n0,lamp,1,4,1\n0,lamp,2,4,1\n"), 1, {"bad.csv:3", "time"});
    expect_refusal(film("time,lamp,x,y,z\n0,lamp,one,4,1\n"), 1, {"bad.csv:2", "x", "one"});
    expect_refusal(film("time,lamp,x,y,z\n0,lamp,9,4,1\n"), 1, {"bad.csv:2", "x"});
    expect_refusal(film("time,colour\n0,red\n"), 1, {"bad.csv:1", "time,lamp", "time,eye_x"});
    expect_refusal(film(""), 1, {"bad.csv"});
    expect_refusal("--probe " + written("bad.csv", "x,y,z\n1,2,3\n"), 1, {"bad.csv:1", "nx"});
    expect_refusal("--probe " + written("bad.csv", "x,y,z,nx,ny,nz\n1,2,3,0,0,0\n"), 1,
                   {"bad.csv:2", "normal"});
    expect_refusal("--probe /nowhere/points.csv", 1, {"/nowhere/points.csv"});
    EXPECT_FALSE(fs::exists(in_folder("bad_0.png")));
}

}  // namespace
}  // namespace pim
