// SPDX-License-Identifier: GPL-3.0-or-later
// An open scene as the window uses it, with a clock of its own: `now` is what the test says.
#include "viewer/window/session.h"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <set>
#include <thread>

#include "common/core/error.h"
#include "measured.h"
#include "synthetic_maps.h"
#include "viewer/files/csv.h"
#include "viewer/files/lighting_setup.h"
#include "viewer/picture.h"
#include "viewer/tone/tone_curve.h"

namespace pim {
namespace {

const Imath::V2i kSize(96, 64);

Arguments open(const std::filesystem::path& map) {
    Arguments arguments;
    arguments.map = map;
    return arguments;
}

// A map that is soon read.
SyntheticOptions few_grids(const Index3& boxes) {
    SyntheticOptions options;
    options.facings = false;
    options.boxes = boxes;
    return options;
}

class SessionTest : public testing::Test {
  protected:
    explicit SessionTest(const Index3& boxes = {2, 1, 1}) : m_(scene_of_data("cornell"), few_grids(boxes)) {
        restart(open(m_.file));
    }
    void restart(const Arguments& arguments) {
        session_ = std::make_unique<Session>(arguments, [](float, const char*) {});
        now_ = 100;
    }
    bool advance(double seconds, const Imath::V2i& size = kSize) {
        now_ += seconds;
        return session_->advance(size, now_);
    }
    void finish(const Imath::V2i& size = kSize) {
        for (int i = 0; i < 20000 && !session_->is_finished(); ++i) advance(0.02, size);
        ASSERT_TRUE(session_->is_finished());
    }
    ViewState& state() { return session_->state; }
    LampControl& lamp() { return session_->state.lamps[0]; }
    const Box3& domain() const { return session_->scene().lights[0].domain; }
    std::vector<uint8_t> bytes() const { return session_->picture().rgba; }

    // The mean of so many passes by a relighter of the test's own.
    Image mean_of(int passes, const Imath::V2i& size) const {
        const MapFile map(m_.file);  // a file has one reader at a time
        Relighter relighter(map, m_.scene(), m_.caster, best_vector_unit());
        relighter.update(session_->state, size);
        Image sum = relighter.linear();
        for (int pass = 1; pass < passes; ++pass) relighter.add_pass(pass, sum);
        for (Rgb& pixel : sum.pixels) pixel /= float(passes);
        return sum;
    }
    // As bytes, by the exact curves; they may differ from the fast ones by one in a few of a thousand pixels.
    void expect_shows(const Image& linear) const {
        const Rgba8Image& picture = session_->picture();
        ASSERT_EQ(picture.width, linear.width);
        ASSERT_EQ(picture.height, linear.height);
        int off = 0;
        for (std::size_t i = 0; i < linear.pixels.size(); ++i)
            for (int c = 0; c < 3; ++c) {
                const int expected =
                    to_8bit(session_->state.tone_curve, linear.pixels[i][c] * session_->exposure());
                const int difference = std::abs(expected - picture.rgba[4 * i + std::size_t(c)]);
                ASSERT_LE(difference, 1) << i;
                off += difference;
            }
        EXPECT_LE(off, int(linear.pixels.size() * 3 / 200));
    }

    MappedScene m_;
    std::unique_ptr<Session> session_;
    double now_ = 100;
};

// --- pictures follow changes at once, and sharpen at rest ---

TEST_F(SessionTest, OpensAsTheSceneDescribes) {
    std::vector<std::pair<float, std::string>> stages;
    const Session session(open(m_.file),
                          [&](float progress, const char* what) { stages.emplace_back(progress, what); });
    ASSERT_GE(stages.size(), 3u);
    EXPECT_TRUE(std::ranges::is_sorted(stages));
    for (const auto& [progress, what] : stages) EXPECT_TRUE(progress >= 0 && progress <= 1 && !what.empty());
    EXPECT_EQ(session.state, initial_state(m_.scene(), m_.baked.map));
    EXPECT_EQ(session.path(), m_.file);
    EXPECT_EQ(session.animation(), nullptr);
    EXPECT_FALSE(session.is_finished());
}

TEST_F(SessionTest, ShowsEveryChangeAtOnce) {
    EXPECT_FALSE(session_->advance({0, 5}, now_)) << "minimised";
    ASSERT_TRUE(advance(0));
    EXPECT_EQ(session_->passes(), 1);
    expect_shows(mean_of(1, kSize));
    EXPECT_FALSE(advance(0)) << "nothing has changed";
    const std::vector<std::function<void()>> changes = {
        [&] { lamp().position = domain().min; },
        [&] { lamp().gain = 0.5f; },
        [&] { lamp().colour = Rgb(1, 0.5f, 0.2f); },
        [&] { state().direct = DirectLight::traced; },
        [&] { state().indirect = false; },
        [&] { state().tone_curve = ToneCurve::aces; },
        [&] { state().automatic_exposure = false, state().exposure = 1.5f; },
        [&] { state().camera.eye.x += 0.3f; },
        [&] { state().indirect = true; },
        [&] { state().view = View::direct; },
        [&] { lamp().on = false; },
        [&] { lamp().on = lamp().solo = true; },
    };
    for (std::size_t i = 0; i < changes.size(); ++i) {
        const auto before = bytes();
        changes[i]();
        ASSERT_TRUE(advance(0.001)) << i;
        // A camera that moves may cost sharpness.
        if (session_->picture().width == kSize.x) expect_shows(mean_of(1, kSize));
        EXPECT_NE(bytes(), before) << i;
        EXPECT_FALSE(advance(0.001)) << i;
    }
    ASSERT_TRUE(advance(0.001, {50, 40})) << "another size";
    EXPECT_EQ(session_->picture().width, 50);
    expect_shows(mean_of(1, {50, 40}));
}

TEST_F(SessionTest, SharpensAtRestAndThenRests) {
    state().direct = DirectLight::traced;
    ASSERT_TRUE(advance(0));
    int pictures = 1, last = 1;
    for (int i = 0; i < 20000 && !session_->is_finished(); ++i) {
        if (advance(0.02)) ++pictures;
        ASSERT_GE(session_->passes(), last);
        last = session_->passes();
    }
    EXPECT_TRUE(session_->is_finished());
    EXPECT_EQ(session_->passes(), Session::kPasses);
    EXPECT_EQ(Session::kPasses, 64);
    EXPECT_EQ(pictures, Session::kPasses);  // each whole pass is shown
    expect_shows(mean_of(Session::kPasses, kSize));
    const auto finished = bytes();
    EXPECT_FALSE(advance(1));
    EXPECT_FALSE(advance(100));
    EXPECT_EQ(bytes(), finished);
    lamp().gain = 2;
    ASSERT_TRUE(advance(0.01));
    EXPECT_EQ(session_->passes(), 1);
    EXPECT_FALSE(session_->is_finished());
}

// A pass of a large picture takes several slices; a change in between begins anew.
TEST_F(SessionTest, AChangeBetweenSlicesLeavesNoTrace) {
    const Imath::V2i large(640, 480);
    state().direct = DirectLight::traced;
    advance(0, large);
    while (session_->passes() < 3) advance(0.1, large);
    advance(0.1, large);  // part of the next, perhaps
    lamp().position = domain().max;
    ASSERT_TRUE(advance(0.01, large));
    while (session_->passes() < 3) advance(0.1, large);
    expect_shows(mean_of(3, large));
}

// Until 30 frames per second are lost a picture is whole; beyond, it has fewer pixels, until the camera
// rests.
TEST_F(SessionTest, AMovingCameraMayCostSharpnessNotFluency) {
    const Imath::V2i large(640, 480);
    for (int round = 0; round < 3; ++round) {
        if (round == 0) advance(0.5, large);  // with reading the map: slow for sure
        const double whole_picture = session_->frame_seconds();
        for (int frame = 0; frame < 4; ++frame) {
            state().camera.eye.x += 0.05f;
            ASSERT_TRUE(advance(0.016, large));
            const Rgba8Image& p = session_->picture();
            if (whole_picture < 1.5 / 30) {
                ASSERT_EQ(p.width, large.x) << whole_picture;
            } else if (whole_picture > 2.5 / 30) {
                ASSERT_LE(p.width, large.x / 2) << whole_picture;
            }
            ASSERT_GE(p.width, large.x / 4);
            const int divisor = (large.x + p.width - 1) / p.width;
            ASSERT_EQ(p.width, (large.x + divisor - 1) / divisor);
            ASSERT_EQ(p.height, (large.y + divisor - 1) / divisor) << "the same of both sides";
        }
        const double stopped = now_;
        while (session_->picture().width < large.x && now_ < stopped + 1) advance(0.016, large);
        EXPECT_EQ(session_->picture().width, large.x);
        EXPECT_LE(now_ - stopped, 0.2);
    }
    expect_shows(mean_of(1, large));
}

TEST_F(SessionTest, MovingLampsCostNoSharpness) {
    const Imath::V2i large(640, 480);
    advance(0, large);
    for (int i = 1; i < 4; ++i) {
        lamp().position = domain().min + (domain().max - domain().min) * (0.2f * float(i));
        ASSERT_TRUE(advance(0.016, large));
        EXPECT_EQ(session_->picture().width, large.x);
    }
}

// --- exposure and legend ---

TEST_F(SessionTest, ExposureStaysWhileLampsMove) {
    advance(0);
    const float first = session_->exposure();
    EXPECT_NEAR(first, automatic_exposure(mean_of(1, kSize)), 1e-5 * first);
    lamp().gain = 0.1f;
    lamp().position = domain().min;
    advance(0.01);
    EXPECT_EQ(session_->exposure(), first);
    finish();
    EXPECT_EQ(session_->exposure(), first);
    session_->measure_again();
    EXPECT_FALSE(session_->is_finished());
    ASSERT_TRUE(advance(0.1));
    const float second = session_->exposure();
    EXPECT_NEAR(second, automatic_exposure(mean_of(1, kSize)), 1e-5 * second);
    EXPECT_GT(second, 3 * first);
    state().automatic_exposure = false, state().exposure = -1;
    advance(0.1);
    EXPECT_EQ(session_->exposure(), 0.5f);
    state().exposure = 2;
    advance(0.1);
    EXPECT_EQ(session_->exposure(), 4);
}

TEST_F(SessionTest, LegendsFitOnceAndStay) {
    for (const View view : {View::irradiance, View::trust}) {
        state().view = view;
        lamp().gain = 1;
        ASSERT_TRUE(advance(0.1));
        ASSERT_TRUE(session_->scale());
        const Scale expected = automatic_scale(mean_of(1, kSize), false, "");
        const Scale scale = *session_->scale();
        EXPECT_NEAR(scale.high, expected.high, 1e-5f * expected.high);
        EXPECT_EQ(scale.unit, view == View::irradiance ? "W/m²" : "");
        lamp().gain = 3;
        advance(0.1);
        EXPECT_EQ(session_->scale()->high, scale.high);
        finish();
        EXPECT_EQ(session_->scale()->high, scale.high);
        session_->measure_again();
        advance(0.1);
        // Irradiance has grown with the lamp, its ratio to the residual has not.
        EXPECT_NEAR(session_->scale()->high, scale.high * (view == View::irradiance ? 3 : 1),
                    1e-4f * scale.high);
    }
}

TEST_F(SessionTest, OnlyViewsThatMeasureHaveALegend) {
    for (const bool automatic : {true, false}) {
        state().automatic_exposure = automatic;
        for (const View view :
             {View::radiance, View::irradiance, View::direct, View::trust, View::indirect, View::irradiance,
              View::density, View::irradiance, View::cells, View::normals, View::irradiance, View::albedo}) {
            state().view = view;
            ASSERT_TRUE(advance(0.1));
            EXPECT_EQ(session_->scale().has_value(), view == View::irradiance || view == View::trust)
                << "view " << int(view) << (automatic ? "" : ", exposure set by hand");
        }
    }
}

// --- other views ---

TEST_F(SessionTest, UnlitViewsAreExactAndDone) {
    for (const View view : {View::cells, View::normals, View::albedo}) {
        state().view = view;
        ASSERT_TRUE(advance(0.1));
        EXPECT_TRUE(session_->is_finished());
        EXPECT_FALSE(advance(1));
        EXPECT_EQ(session_->exposure(), 1);
        expect_shows(render_unlit(view, m_.scene(), m_.baked.map, m_.caster, state().camera, kSize, 1));
        EXPECT_FALSE(session_->read({0.5f, 0.5f}));
    }
    state().view = View::radiance;
    ASSERT_TRUE(advance(0.1));
    expect_shows(mean_of(1, kSize));
}

TEST_F(SessionTest, DensityIsGrey) {
    state().view = View::density;
    lamp().colour = Rgb(1, 0.3f, 0.1f);
    advance(0.1);
    const auto is_grey = [&] {
        for (std::size_t i = 0; i < bytes().size(); i += 4)
            if (bytes()[i] != bytes()[i + 1] || bytes()[i] != bytes()[i + 2]) return false;
        return true;
    };
    EXPECT_TRUE(is_grey());
    finish();
    EXPECT_TRUE(is_grey());
}

// --- lamps and camera ---

TEST_F(SessionTest, LampsStopAtTheBordersOfTheirDomain) {
    const Vec3d origin = m_.scene().geometry.origin;
    const Vec3 middle = domain().center();
    session_->move_lamp(middle);
    EXPECT_EQ(lamp().position, middle);
    EXPECT_EQ(session_->message, "");
    session_->move_lamp(middle + Vec3(0, 9, 0));
    EXPECT_EQ(lamp().position, Vec3(middle.x, domain().max.y, middle.z));
    EXPECT_EQ(session_->message,
              "y stops at 4.94 m: the map was baked up to there");  // cornell.toml's domain
    session_->move_lamp({middle.x - 50, middle.y, middle.z + 50});
    EXPECT_EQ(lamp().position, Vec3(domain().min.x, middle.y, domain().max.z));
    EXPECT_EQ(
        session_->message,
        "x stops at 0.83 m: the map was baked up to there; z stops at 4.75 m: the map was baked up to there");
    EXPECT_TRUE(advance(0.1));
    session_->move_lamp(middle);
    EXPECT_EQ(session_->message, "");
    EXPECT_NEAR(double(domain().max.y) + origin.y, 4.9392, 1e-5);
}

TEST_F(SessionTest, TheCameraFindsItsStart) {
    const Camera start = state().camera;
    state().camera.eye = Vec3(1), state().camera.vertical_fov = 80;
    advance(0.1);
    session_->reset_camera();
    EXPECT_EQ(state().camera, start);
}

TEST_F(SessionTest, PlaysAnimations) {
    Arguments arguments = open(m_.file);
    arguments.paths = {m_.folder.write("path.csv", "time,lamp,x,y,z,gain\n0,lamp,1,4,1,1\n2,lamp,3,4,2,0\n")};
    restart(arguments);
    ASSERT_TRUE(session_->animation());
    EXPECT_EQ(session_->animation()->duration(), 2);
    state().tone_curve = ToneCurve::reinhard;
    session_->play(1);
    const Vec3 expected = m_.scene().geometry.to_local({2, 4, 1.5});
    EXPECT_NEAR((lamp().position - expected).length(), 0, 1e-5f);
    EXPECT_NEAR(lamp().gain, 0.5f, 1e-6f);
    EXPECT_EQ(state().tone_curve, ToneCurve::reinhard) << "what is not animated stays";
    EXPECT_TRUE(advance(0.1));
}

// --- what is under the mouse ---

int run(const std::string& words) { return WEXITSTATUS(std::system(words.c_str())); }

// The floor's and the walls' normals are known: places seen by the camera, as a probe file.
TEST_F(SessionTest, ReadingsAreThoseOfProbes) {
    state().direct = DirectLight::traced;
    lamp().position = domain().min;
    lamp().colour = Rgb(0.9f, 0.6f, 0.3f);
    advance(0.1);
    std::string text = "x,y,z,nx,ny,nz\n";
    std::vector<Reading> readings;
    for (const Vec2& place : {Vec2(0.5f, 0.96f), Vec2(0.35f, 0.93f), Vec2(0.65f, 0.9f), Vec2(0.4f, 0.1f)}) {
        const auto reading = session_->read(place);
        ASSERT_TRUE(reading);
        const CameraRays rays(state().camera, kSize);
        const auto hit = m_.caster.intersect(rays.through(place.x * 96, place.y * 64));
        ASSERT_TRUE(hit);
        const SurfacePoint s = surface_at(m_.scene(), *hit);
        EXPECT_EQ(reading->object,
                  m_.scene().geometry.objects[m_.scene().geometry.triangles[hit->triangle].object]);
        EXPECT_NEAR((reading->position - m_.scene().geometry.to_world(s.position)).length(), 0, 1e-5);
        EXPECT_NEAR((reading->shown - s.diffuse * reading->irradiance / kPi).length(), 0, 1e-6f);
        readings.push_back(*reading);
        text += fmt::format("{},{},{},{},{},{}\n", reading->position.x, reading->position.y,
                            reading->position.z, s.shading_normal.x, s.shading_normal.y, s.shading_normal.z);
    }
    const auto points = m_.folder.write("points.csv", text), setup = m_.folder / "setup.toml",
               out = m_.folder / "out.csv";
    session_->save_setup(setup);
    ASSERT_EQ(run(fmt::format("{}/viewer {} --setup {} --probe {} --quiet > {}", PIM_BIN, m_.file.string(),
                              setup.string(), points.string(), out.string())),
              0);
    const CsvTable table = parse_csv(bytes_of(out), "out.csv");
    ASSERT_EQ(table.rows.size(), readings.size());
    Largest off("relative_difference");
    for (std::size_t i = 0; i < readings.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            const char* channels[] = {"red", "green", "blue"};
            const double probe = csv_number(table, table.rows[i], channels[c]);
            // Positions are floats: rounded by 2^-24 of some 10 m in cells of half a metre, where values
            // change by their size from cell to cell, and again in the file.
            EXPECT_NEAR(readings[i].irradiance[c], probe, 2e-5 * std::max(1.0, probe)) << i;
            off.add((readings[i].irradiance[c] - probe) / std::max(1e-3, probe));
        }
}

TEST_F(SessionTest, NothingIsUnderTheMouseBesideTheScene) {
    EXPECT_FALSE(session_->read({0.5f, 0.5f})) << "before the first picture";
    advance(0.1);
    EXPECT_TRUE(session_->read({0.5f, 0.5f}));
    state().camera.target = state().camera.eye * 2.0f - state().camera.target;
    advance(0.1);
    EXPECT_FALSE(session_->read({0.5f, 0.5f}));
}

// --- what is kept ---

TEST_F(SessionTest, PicturesAreSavedAsTheyAreShown) {
    state().tone_curve = ToneCurve::aces;
    for (const bool finished : {false, true}) {
        advance(0.1);
        if (finished) finish();
        const auto path = m_.folder / (finished ? "last" : "first");
        session_->save_picture(path);
        const Image exr = read_image(m_.folder / (finished ? "last.exr" : "first.exr"));
        EXPECT_EQ(exr.pixels, mean_of(finished ? Session::kPasses : 1, kSize).pixels);
        const Image png = read_image(m_.folder / (finished ? "last.png" : "first.png"));
        ASSERT_EQ(png.pixels.size(), exr.pixels.size());
        for (std::size_t i = 0; i < png.pixels.size(); ++i)
            for (int c = 0; c < 3; ++c)
                ASSERT_NEAR(255 * srgb_encode(png.pixels[i][c]), bytes()[4 * i + std::size_t(c)], 1.01);
        state().camera.eye.x += 0.2f;
    }
    EXPECT_THROW(session_->save_picture("/nowhere/picture"), Error);
}

// False colours keep their scale, which fitted another light.
TEST_F(SessionTest, FalseColoursAreSavedAsTheyAreShown) {
    for (const View view : {View::irradiance, View::trust}) {
        state().view = view;
        lamp().position = domain().min;
        advance(0.1);
        lamp().gain *= 3;
        lamp().position = domain().max;
        advance(0.1);
        session_->save_picture(m_.folder / "false");
        const Image png = read_image(m_.folder / "false.png");
        for (std::size_t i = 0; i < png.pixels.size(); ++i)
            for (int c = 0; c < 3; ++c)
                ASSERT_NEAR(255 * srgb_encode(png.pixels[i][c]), bytes()[4 * i + std::size_t(c)], 1.01);
    }
}

ViewState without_size(ViewState state) {
    state.camera.size = Imath::V2i(0);
    return state;
}

TEST_F(SessionTest, SetUpsComeBack) {
    lamp() = {domain().min, false, true, 0.3f, Rgb(0.1f, 0.7f, 0.9f)};
    state().camera.eye = Vec3(1.1f, 2.2f, 3.3f), state().camera.vertical_fov = 55.5f;
    state().view = View::irradiance, state().direct = DirectLight::none, state().show_lamps = true;
    state().automatic_exposure = false, state().exposure = 1.25f, state().tone_curve = ToneCurve::reinhard;
    advance(0.1);
    const ViewState kept = state();
    session_->save_setup(m_.folder / "kept.toml");
    restart(open(m_.file));
    EXPECT_NE(without_size(state()), without_size(kept));
    session_->load_setup(m_.folder / "kept.toml");
    EXPECT_EQ(without_size(state()), without_size(kept));
    EXPECT_TRUE(advance(0.1));
    const ViewState before = state();
    EXPECT_THROW(session_->load_setup(m_.folder / "missing.toml"), Error);
    EXPECT_EQ(state(), before);
}

// The command line of the picture makes it without a window, ray by ray: pixels may differ as relighter_test
// says, bytes by one.
TEST_F(SessionTest, TheCommandLineMakesThePicture) {
    state().direct = DirectLight::traced, state().tone_curve = ToneCurve::aces;
    state().camera.eye += Vec3(0.31f, -0.2f, 0.4f), state().camera.vertical_fov = 45;
    lamp().position = domain().min + (domain().max - domain().min) * 0.3f;
    lamp().gain = 1.7f, lamp().colour = Rgb(0.9f, 0.8f, 0.4f);
    advance(0.1);
    if (session_->picture().width < kSize.x) advance(0.1);
    ASSERT_EQ(session_->picture().width, kSize.x);
    session_->save_picture(m_.folder / "window");
    for (const char* extension : {".exr", ".png"}) {
        const auto output = m_.folder / (std::string("headless") + extension);
        const std::string line = session_->command_line(output);
        ASSERT_EQ(line.substr(0, 7), "viewer ");
        ASSERT_EQ(run(std::string(PIM_BIN) + "/" + line + " --spp 1 --quiet"), 0) << line;
        const Image headless = read_image(output),
                    window = read_image(m_.folder / (std::string("window") + extension));
        ASSERT_EQ(headless.width, kSize.x);
        ASSERT_EQ(headless.height, kSize.y);
        const bool linear = extension == std::string(".exr");
        double squares = 0, sum = 0;
        int apart = 0;
        for (std::size_t i = 0; i < headless.pixels.size(); ++i) {
            Rgb a = headless.pixels[i], b = window.pixels[i];
            for (int c = 0; c < 3 && !linear; ++c)
                a[c] = 255 * srgb_encode(a[c]), b[c] = 255 * srgb_encode(b[c]);
            const float d = (a - b).length();
            if (d > (linear ? 1e-4f : 1.8f))  // a step in each channel
                ++apart;
            else
                squares += double(d) * double(d);
            sum += double(b.length2());
        }
        EXPECT_LE(apart, int(headless.pixels.size() / 500)) << line;
        EXPECT_LT(std::sqrt(squares / sum), linear ? 2e-5 : 1e-3) << line;
        record(linear ? "relative_rms_exr" : "relative_rms_png", std::sqrt(squares / sum));
        record(linear ? "apart_exr" : "apart_png", apart);
    }
}

// The exposure that the window found is part of the command; an automatic one would fit the other picture.
TEST_F(SessionTest, TheCommandLineFixesTheExposure) {
    advance(0.1);
    const float exposure = session_->exposure();
    lamp().gain = 0.25f;
    advance(0.1);
    const std::string line = session_->command_line("x.png");
    const std::size_t at = line.find("--exposure ");
    ASSERT_NE(at, std::string::npos) << line;
    EXPECT_NEAR(std::exp2(std::stod(line.substr(at + 11))), exposure, 1e-5 * exposure);
    EXPECT_NE(line.find("--size 96x64"), std::string::npos) << line;
    EXPECT_NE(line.find("--gain lamp=0.25"), std::string::npos) << line;
}

// --- what goes wrong ---

class SessionOfManyBoxes : public SessionTest {
  protected:
    SessionOfManyBoxes() : SessionTest({8, 1, 1}) {}
};

TEST_F(SessionOfManyBoxes, AMapBakedAnewIsSaidOnce) {
    advance(0);
    EXPECT_EQ(session_->message, "");
    write_map(m_.file, m_.baked.map);
    advance(2);
    EXPECT_NE(session_->message.find("baked anew"), std::string::npos) << session_->message;
    session_->message.clear();
    lamp().position = domain().max;
    EXPECT_TRUE(advance(2));
    EXPECT_EQ(session_->message, "");
    lamp().position = domain().min;
    EXPECT_TRUE(advance(2));
    expect_shows(mean_of(1, kSize));  // the same map stands there now
}

TEST_F(SessionOfManyBoxes, WhatCannotBeReadLeavesTheLastPicture) {
    lamp().position = domain().min;
    advance(0);
    const ViewState good = state();
    for (int i = 0; i < 6000 && !session_->relighter().store().is_settled(); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    const auto shown = bytes();
    std::ofstream(m_.file, std::ios::binary) << "no map";
    advance(2);
    EXPECT_NE(session_->message.find("overwritten"), std::string::npos) << session_->message;
    session_->message.clear();
    lamp().position = domain().max;
    EXPECT_NO_THROW(advance(0.1));
    EXPECT_EQ(state(), good);
    EXPECT_NE(session_->message.find("overwritten"), std::string::npos) << session_->message;
    EXPECT_EQ(bytes(), shown);
    lamp().gain = 0.5f;  // what is in memory still shines
    EXPECT_TRUE(advance(0.1));
    EXPECT_NE(bytes(), shown);
}

TEST_F(SessionTest, LampsOutsideTheirDomainLeaveTheLastPicture) {
    advance(0);
    const ViewState good = state();
    const auto shown = bytes();
    lamp().position = Vec3(0, -5, 0);
    EXPECT_NO_THROW(advance(0.1));
    EXPECT_EQ(state(), good);
    EXPECT_NE(session_->message.find("lamp"), std::string::npos) << session_->message;
    EXPECT_EQ(bytes(), shown);
}

TEST_F(SessionTest, BadArgumentsAreSaidWhenItOpens) {
    const auto fails = [&](const Arguments& arguments) {
        return message_of<Error>([&] { Session(arguments, [](float, const char*) {}); });
    };
    EXPECT_NE(fails(open(m_.folder / "missing.vdb")).find("missing.vdb"), std::string::npos);
    Arguments arguments = open(m_.file);
    arguments.vector_unit = "mmx";
    EXPECT_NE(fails(arguments).find("mmx"), std::string::npos);
    arguments = open(m_.file);
    arguments.lights = {"sun=1,2,3"};
    EXPECT_NE(fails(arguments).find("sun"), std::string::npos);
}

}  // namespace
}  // namespace pim
