// SPDX-License-Identifier: GPL-3.0-or-later
// The viewer's window as a person uses it: the real program on a display of the test's own (Xvfb), mouse and
// keys by xdotool, the screen read from Xvfb's file. What must be seen comes from a session in the test's
// process, which is told what the person did, and from the headless renderer.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <regex>

#include "screen_shot.h"
#include "small_maps.h"
#include "viewer/files/number_text.h"
#include "viewer/interaction/gizmo_drag.h"
#include "viewer/interaction/navigation.h"
#include "viewer/interaction/projection.h"
#include "viewer/window/session.h"
#include "xvfb.h"

namespace pim {
namespace {

constexpr double kPatience = 120;           // s, for slow machines and sanitizers
const std::string kScreen = "1400x900x24";  // leaves room beside the window, where the mouse rests
const Imath::V2i kAside(1390, 890);
const Imath::V2i kOpened(1280, 800), kSmall(320, 250);  // windows: as it opens, and one that is soon drawn

// ---- the program and its user

std::string output_of(const std::string& command) {
    std::string text;
    std::array<char, 256> buffer{};
    FILE* pipe = ::popen((command + " 2>/dev/null").c_str(), "r");
    while (pipe && std::fgets(buffer.data(), int(buffer.size()), pipe)) text += buffer.data();
    if (pipe) ::pclose(pipe);
    return text.substr(0, text.find_last_not_of('\n') + 1);
}

bool is_installed(const std::string& program) { return !output_of("command -v " + program).empty(); }

std::vector<std::string> viewer_words(const fs::path& map, const std::vector<std::string>& more) {
    std::vector<std::string> words{std::string(PIM_BIN) + "/viewer", map.string()};
    words.insert(words.end(), more.begin(), more.end());
    return words;
}

// `viewer MAP`, beside the test.
class Viewer {
  public:
    explicit Viewer(const fs::path& map, const std::vector<std::string>& more = {})
        : log_(test_folder() / "viewer.log"), process_(viewer_words(map, more), -1, log_) {}

    // Whether its window shows the scene, which its title tells: "box - 1280 x 800 - 17 frames/s - pim".
    bool opens() {
        const std::string search =
            "xdotool search --onlyvisible --name ' - [0-9]+ x [0-9]+ - [0-9]+ frames/s - pim$'";
        std::optional<int> ended;
        comes_true(kPatience, [&] {
            return !(window_ = output_of(search)).empty() || (ended = process_.ends_within(0));
        });
        act(fmt::format("mousemove {} {}", kAside.x, kAside.y));
        return !window_.empty();
    }

    // Commands of xdotool, WINDOW being the viewer's.
    void act(const std::string& commands) const {
        output_of("xdotool " + std::regex_replace(commands, std::regex("WINDOW"), window_));
    }
    void press(const std::string& key) const { act("windowfocus WINDOW key " + key); }
    void resize(const Imath::V2i& size) const { act(fmt::format("windowsize WINDOW {} {}", size.x, size.y)); }
    // From the first place to the last, all at once, or with `pause` seconds at each.
    void drag(const std::vector<Vec2>& places, double pause) const {
        std::string commands;
        for (const Vec2& p : places) {
            commands += fmt::format("mousemove --window WINDOW {} {} ", p.x, p.y);
            if (&p == &places.front()) commands += "mousedown 1 ";
            if (pause > 0) commands += fmt::format("sleep {} ", pause);
        }
        act(commands + fmt::format("mouseup 1 mousemove {} {}", kAside.x, kAside.y));
    }
    void turn_wheel(const Vec2& place) const {
        act(fmt::format("mousemove --window WINDOW {} {} click 4 mousemove {} {}", place.x, place.y, kAside.x,
                        kAside.y));
    }

    // Of its upper left corner.
    Imath::V2i place() const {
        const std::string shell =
            output_of("xdotool mousemove --window " + window_ + " 0 0 getmouselocation --shell");
        Imath::V2i at(0);
        std::sscanf(shell.c_str(), "X=%d Y=%d", &at.x, &at.y);
        act(fmt::format("mousemove {} {}", kAside.x, kAside.y));
        return at;
    }
    bool comes_to_be_titled(const std::string& part) const {
        return comes_true(kPatience, [&] {
            return output_of("xdotool getwindowname " + window_).find(part) != std::string::npos;
        });
    }
    bool is_seen() const {
        return output_of("xdotool search --onlyvisible --name ' - pim$'").find(window_) != std::string::npos;
    }
    std::optional<int> ends(double seconds = kPatience) { return process_.ends_within(seconds); }
    void signal(int number) const { process_.signal(number); }
    std::string words() const { return read_text(log_); }

  private:
    fs::path log_;
    std::string window_;
    Companion process_;
};

// A display that keeps its screen in a file.
struct Desk {
    VirtualDisplay display{{.screen = kScreen, .more = {"-fbdir", test_folder().string()}}};

    Desk() {
        // The graphics driver leaks as it is unloaded; of the rest sanitizers still tell.
        const char* options = std::getenv("ASAN_OPTIONS");
        ::setenv("ASAN_OPTIONS", ((options ? std::string(options) + ":" : "") + "detect_leaks=0").c_str(), 1);
    }

    Rgba8Image shot(const Imath::V2i& size, const Imath::V2i& place = {0, 0}) const {
        return cut_out(parse_dump(read_text(test_folder() / "Xvfb_screen0")), place, size);
    }
    // Whether a window there comes to look like that, but for one step of 255.
    testing::AssertionResult shows(const Rgba8Image& picture, const PixelRegion& left_out,
                                   const Imath::V2i& place = {0, 0}) const {
        Difference least;
        const bool same = comes_true(kPatience, [&] {
            const Difference now = compare(shot({picture.width, picture.height}, place), picture, left_out);
            if (now.mean < least.mean) least = now;
            return now.largest <= 1;
        });
        return (same ? testing::AssertionSuccess() : testing::AssertionFailure()) << least;
    }
};

#define START_DESK(desk)                                                                          \
    const Desk desk;                                                                              \
    if (!desk.display.installed())                                                                \
        GTEST_SKIP() << "Xvfb is not installed (Debian package xvfb): no window can open";        \
    if (!is_installed("xdotool"))                                                                 \
        GTEST_SKIP() << "xdotool is not installed (Debian package xdotool): nobody uses a mouse"; \
    ASSERT_TRUE(desk.display.runs()) << "Xvfb does not start"

// ---- what must be seen

// A session that is told what the person did.
class Twin {
  public:
    Session session;

    explicit Twin(const Baked& map) : session(arguments(map), [](float, const char*) {}) {
        session.advance(kOpened, now_ += 1);
    }
    // The picture when all rests in a window of that size.
    const Rgba8Image& rests(const Imath::V2i& size = kSmall) {
        do session.advance(size, now_ += 1);
        while (!session.is_finished());
        return session.picture();
    }
    const Camera& camera() const { return session.state.camera; }
    Vec3& lamp() { return session.state.lamps[0].position; }
    const Box3& domain() const { return session.scene().lights[0].domain; }

    // Where the lamp's mark, name, handles and domain are drawn.
    PixelRegion marks(const Imath::V2i& size = kSmall) {
        Box3 box;
        const auto add = [&](const Vec2& p) { box.extendBy(Vec3(p.x, p.y, 0)); };
        for (const Edge& edge : domain_edges(camera(), size, domain())) add(edge[0]), add(edge[1]);
        for (const HandleShape& handle : gizmo_shape(camera(), size, lamp(), domain()).handles)
            for (const Vec2& p : handle.area) add(p);
        const Vec2 mark = *project(camera(), size, lamp());
        add(mark - Vec2(14, 30)), add(mark + Vec2(70, 14));
        return {int(box.min.x) - 3, int(box.min.y) - 3, int(box.max.x) + 4, int(box.max.y) + 4};
    }

  private:
    static Arguments arguments(const Baked& map) {
        Arguments a;
        a.map = map.map_file;
        return a;
    }
    double now_ = 0;
};

// Whole pixels that grasp that arrow.
Vec2 place_on_arrow(Twin& twin, int axis) {
    const Handle arrow{Handle::Kind::axis, axis};
    for (const HandleShape& shape : gizmo_shape(twin.camera(), kSmall, twin.lamp(), twin.domain()).handles) {
        if (!(shape.handle == arrow)) continue;
        const Vec2 middle = (shape.line.at(0) + shape.line.at(1)) / 2;
        const Vec2 place(std::round(middle.x), std::round(middle.y));
        if (pick(twin.camera(), kSmall, twin.lamp(), twin.domain(), place) == arrow) return place;
    }
    throw Error("the arrow is not seen");
}

// Where the lamp is when that arrow has been dragged.
Vec3 dragged(Twin& twin, int axis, const Vec2& from, const Vec2& to) {
    Grip grip{{Handle::Kind::axis, axis}, twin.lamp(), twin.domain(), Vec3d(0), from};
    return GizmoDrag(twin.camera(), kSmall, grip).move(to);
}

std::string lamp_option(Twin& twin) {
    return " --light lamp=" + commas(world_texts(twin.session.scene().geometry, twin.lamp()));
}

// `viewer MAP --output` with those options.
Rgba8Image headless(const Baked& map, const std::string& options) {
    const fs::path file = test_folder() / "headless.png";
    const Outcome outcome =
        run_project("viewer " + map.map_file.string() + " --output " + file.string() + " --spp 64" + options);
    if (outcome.code != 0) throw Error(outcome.errors);
    return read_png(file);
}

// ---- tests

TEST(ViewerWindow, ADraggedLampLightsTheRoomAsTheHeadlessRendererSays) {
    const Baked& map = small_map(SmallMap::by_facing);
    START_DESK(desk);
    Viewer viewer(map.map_file);
    ASSERT_TRUE(viewer.opens()) << viewer.words();
    viewer.resize(kSmall);
    viewer.press("F2");  // panels off
    Twin twin(map);
    const Rgba8Image before = twin.rests();
    ASSERT_TRUE(desk.shows(before, twin.marks()));
    const auto drag = [&](int axis, const Vec2& way, double pause) {
        const Vec2 from = place_on_arrow(twin, axis);
        viewer.drag({from, from + way / 2, from + way}, pause);
        twin.lamp() = dragged(twin, axis, from, from + way);
        return desk.shows(twin.rests(), twin.marks());
    };
    EXPECT_TRUE(drag(0, {24, 4}, 0.03));
    EXPECT_TRUE(drag(1, {-2, 12}, 0));  // between two frames
    EXPECT_TRUE(drag(0, {200, 4}, 0));  // past the domain
    EXPECT_EQ(twin.lamp().x, twin.domain().min.x);

    // Two sets of 8 x 8 stratified samples: where an edge crosses a pixel, it crosses about 15 strata, of
    // which each decides with a variance of up to 1/4: σ = √(15/4)/64 = 0.03 of the edge's contrast for one
    // picture, 0.043 for their difference; four times that of half the range, which is what edges here have
    // at most, are 22 of 255.
    const std::string options =
        fmt::format(" --size {}x{} --exposure {}", kSmall.x, kSmall.y, std::log2(twin.session.exposure()));
    const Rgba8Image after = desk.shot(kSmall);
    const Difference same = compare(after, headless(map, options + lamp_option(twin)), twin.marks());
    twin.lamp().x += 0.06f;  // 2 % of the domain, not quite 5 pixels
    const Difference beside = compare(after, headless(map, options + lamp_option(twin)), twin.marks());
    std::cout << "against the headless renderer: " << same << "; 6 cm beside: " << beside << "\n";
    EXPECT_LE(same.largest, 22);
    EXPECT_LE(same.share_above_8, 0.002);
    EXPECT_LE(same.mean, 0.2);
    EXPECT_GE(beside.mean, 4 * same.mean);
    viewer.press("ctrl+q");
    EXPECT_EQ(viewer.ends(), 0) << viewer.words();
}

TEST(ViewerWindow, KeysAndWheel) {
    const Baked& map = small_map(SmallMap::of_thesis);
    START_DESK(desk);
    Viewer viewer(map.map_file);
    ASSERT_TRUE(viewer.opens()) << viewer.words();
    viewer.resize(kSmall);
    viewer.press("F2");
    Twin twin(map);
    ViewState& state = twin.session.state;
    const auto seen = [&] { return desk.shows(twin.rests(), twin.marks()); };
    const Vec3 extent = twin.domain().max - twin.domain().min;

    viewer.press("Right");  // the camera looks along z: its right is -x
    twin.session.move_lamp(twin.lamp() + Vec3(-0.02f, 0, 0) * extent);
    EXPECT_TRUE(seen()) << "arrow";
    viewer.press("shift+Prior");
    twin.session.move_lamp(twin.lamp() + Vec3(0, 0.1f, 0) * extent);
    EXPECT_TRUE(seen()) << "page up";
    viewer.press("equal");
    state.automatic_exposure = false, state.exposure = std::log2(twin.session.exposure()) + 0.5f;
    EXPECT_TRUE(seen()) << "exposure";
    viewer.turn_wheel({250, 220});
    zoom(state.camera, 1);
    EXPECT_TRUE(seen()) << "wheel";
    viewer.press("Home");
    twin.session.reset_camera();
    EXPECT_TRUE(seen()) << "home";
    viewer.press("4");
    state.view = View::indirect;
    EXPECT_TRUE(seen()) << "indirect light";

    const Rgba8Image without_help = desk.shot(kSmall);
    viewer.press("F1");
    EXPECT_TRUE(comes_true(kPatience, [&] {
        return compare(desk.shot(kSmall), without_help, twin.marks()).share_above_8 > 0.5;
    }));
    viewer.press("F1");
    EXPECT_TRUE(seen()) << "help is gone";
    viewer.press("ctrl+q");
    EXPECT_EQ(viewer.ends(), 0) << viewer.words();
}

TEST(ViewerWindow, FollowsItsSizeDownToOnePixel) {
    const Baked& map = small_map(SmallMap::of_thesis);
    START_DESK(desk);
    Viewer viewer(map.map_file);
    ASSERT_TRUE(viewer.opens()) << viewer.words();
    for (const Imath::V2i& size : {Imath::V2i(1, 1), {700, 3}, {2, 500}, {1, 1}}) {
        viewer.resize(size);
        EXPECT_TRUE(viewer.comes_to_be_titled(fmt::format(" {} x {} ", size.x, size.y)));
    }
    viewer.press("F2");
    Twin twin(map);
    for (const Imath::V2i& size : {Imath::V2i(300, 201), kSmall}) {
        viewer.resize(size);
        EXPECT_TRUE(desk.shows(twin.rests(size), twin.marks(size))) << size.x << " x " << size.y;
    }
    viewer.signal(SIGTERM);
    EXPECT_EQ(viewer.ends(), kExitInterrupted) << viewer.words();
}

// No keys here but the last: the manager may take the focus away at any time.
TEST(ViewerWindow, MinimisedItComesBackAndClosesAsWindowsDo) {
    const Baked& map = small_map(SmallMap::of_thesis);
    START_DESK(desk);
    START_WINDOW_MANAGER(manager);
    Viewer viewer(map.map_file, {"--exposure", "0.5"});
    ASSERT_TRUE(viewer.opens()) << viewer.words();
    const Imath::V2i place = viewer.place();
    const auto shows_all = [&](const Imath::V2i& size) {
        EXPECT_TRUE(viewer.comes_to_be_titled(fmt::format(" {} x {} ", size.x, size.y)));
        const std::string options = fmt::format(" --ui --exposure 0.5 --size {}x{}", size.x, size.y);
        return desk.shows(headless(map, options), {}, place);
    };
    viewer.resize({500, 300});
    EXPECT_TRUE(shows_all({500, 300}));
    viewer.act("windowminimize WINDOW");
    EXPECT_TRUE(comes_true(kPatience, [&] { return !viewer.is_seen(); }));
    viewer.act("windowmap WINDOW");
    EXPECT_TRUE(comes_true(kPatience, [&] { return viewer.is_seen() && viewer.place() == place; }));
    EXPECT_TRUE(shows_all({500, 300}));
    viewer.resize({400, 350});
    EXPECT_TRUE(shows_all({400, 350}));
    std::optional<int> code;
    comes_true(kPatience, [&] {
        viewer.press("alt+F4");
        return (code = viewer.ends(2)).has_value();
    });
    EXPECT_EQ(code, 0) << viewer.words();
}

// Panels, handles and legend, drawn by two libraries.
TEST(ViewerWindow, OffscreenMesaShowsTheSame) {
    const Baked& map = small_map(SmallMap::of_thesis);
    START_DESK(desk);
    Viewer viewer(map.map_file, {"--exposure", "0.5"});
    ASSERT_TRUE(viewer.opens()) << viewer.words();
    viewer.resize({640, 400});
    viewer.press("shift+Up");
    Twin twin(map);
    twin.session.move_lamp(twin.lamp() + Vec3(0, 0, 0.1f) * (twin.domain().max - twin.domain().min));
    const std::string options = " --ui --exposure 0.5 --size 640x400" + lamp_option(twin);
    EXPECT_TRUE(desk.shows(headless(map, options), {}));
    viewer.press("2");
    EXPECT_TRUE(desk.shows(headless(map, options + " --view irradiance"), {}));
}

TEST(ViewerWindow, AMapThatCannotBeOpenedEndsItWithASentence) {
    START_DESK(desk);
    std::ofstream(test_folder() / "broken.vdb") << "no map at all";
    Viewer viewer(test_folder() / "broken.vdb");
    EXPECT_EQ(viewer.ends(), kExitFailed);
    EXPECT_NE(viewer.words().find("broken.vdb"), std::string::npos) << viewer.words();
    EXPECT_EQ(std::ranges::count(viewer.words(), '\n'), 1) << viewer.words();
}

TEST(ViewerWindow, WithoutADisplayItSaysWhatWorks) {
    const Baked& map = small_map(SmallMap::of_thesis);
    ::unsetenv("DISPLAY");
    ::unsetenv("WAYLAND_DISPLAY");
    const Outcome outcome = run_project("viewer " + map.map_file.string());
    EXPECT_EQ(outcome.code, kExitFailed);
    for (const char* part : {"no display", "--output"})
        EXPECT_NE(outcome.errors.find(part), std::string::npos) << outcome.errors;
    EXPECT_EQ(std::ranges::count(outcome.errors, '\n'), 1) << outcome.errors;
    const Outcome missing = run_project("viewer /nowhere/map.vdb");
    EXPECT_EQ(missing.code, kExitFailed);
    EXPECT_NE(missing.errors.find("/nowhere/map.vdb: there is no such file"), std::string::npos)
        << missing.errors;
}

}  // namespace
}  // namespace pim
