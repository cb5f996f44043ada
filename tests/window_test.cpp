// SPDX-License-Identifier: GPL-3.0-or-later
// On a display of the test's own: Xvfb, drawn by Mesa in software.
#include "viewer/display/window.h"

#include <gtest/gtest.h>
#include <imgui.h>

#include <chrono>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <thread>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "common/core/error.h"
#include "common/core/stopwatch.h"
#include "temporary_folder.h"
#include "viewer/display/display.h"
#include "viewer/display/imgui_context.h"
#include "viewer/display/offscreen.h"
#include "xvfb.h"

// Mesa's driver leaks and is unloaded with the window: its leaks have no name left by which to except them.
extern "C" int __lsan_is_turned_off() { return 1; }  // NOLINT(bugprone-reserved-identifier)

namespace pim {
namespace {

Rgba8Image test_picture(const Imath::V2i& size) {
    Rgba8Image image(size.x, size.y);
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            uint8_t* t = image.at(x, y);
            t[0] = uint8_t(x * 7 + y);
            t[1] = uint8_t(y * 5 + x * x);
            t[2] = uint8_t(x * y + 11);
            t[3] = 255;
        }
    return image;
}

// Whether the picture comes back from the window's back buffer as it was.
bool shows_exactly(Window& window, Display& display) {
    const Imath::V2i size = window.framebuffer_size();
    const Rgba8Image picture = test_picture(size);
    window.begin_frame();
    ImGui::Render();
    display.show(picture);
    display.draw(size.x, size.y, ImGui::GetDrawData());
    const bool same = display.read(size.x, size.y).rgba == picture.rgba;
    window.swap();
    return same && window.gl().GetError() == GL_NO_ERROR;
}

// Handles events until `condition` holds; false after ten seconds.
template <class Condition>
bool comes_true(Window& window, Condition condition) {
    const Stopwatch watch;
    while (!condition() && watch.seconds() < 10) window.wait(0.02);
    return condition();
}

TEST(Window, ShowsPicturesExactly) {
    START_DISPLAY(screen);
    const ImguiContext panels;
    Window window("pim", 640, 360);
    Display display(window.gl());
    EXPECT_EQ(window.framebuffer_size(), Imath::V2i(640, 360));
    EXPECT_FALSE(window.minimised());
    EXPECT_GE(window.panel_scale(), 1);
    EXPECT_LE(window.panel_scale(), 1.25f);  // Xvfb has about 96 dots per inch
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(shows_exactly(window, display));
    EXPECT_EQ(ImGui::GetIO().DisplaySize.x, 640);
    EXPECT_EQ(ImGui::GetIO().DisplaySize.y, 360);
}

TEST(Window, FollowsItsSizeDownToOnePixel) {
    START_DISPLAY(screen);
    const ImguiContext panels;
    Window window("pim", 1, 1);
    Display display(window.gl());
    EXPECT_EQ(window.framebuffer_size(), Imath::V2i(1, 1));
    EXPECT_TRUE(shows_exactly(window, display));
    for (const Imath::V2i& size : {Imath::V2i(300, 200), {1, 400}, {641, 3}, {1, 1}}) {
        glfwSetWindowSize(glfwGetCurrentContext(), size.x, size.y);
        EXPECT_TRUE(comes_true(window, [&] { return window.framebuffer_size() == size; }));
        EXPECT_TRUE(shows_exactly(window, display)) << size.x << " x " << size.y;
    }
}

TEST(Window, ClosesWhenAsked) {
    START_DISPLAY(screen);
    const ImguiContext panels;
    Window window("pim", 64, 64);
    window.set_title("pim: another");
    EXPECT_FALSE(window.should_close());
    window.request_close();
    EXPECT_TRUE(window.should_close());
}

TEST(Window, OpensAgain) {
    START_DISPLAY(screen);
    const ImguiContext panels;
    for (int i = 0; i < 2; ++i) {
        Window window("pim", 32, 32);
        Display display(window.gl());
        EXPECT_TRUE(shows_exactly(window, display));
    }
}

TEST(Window, FullScreenAndBack) {
    START_DISPLAY(screen);
    const ImguiContext panels;
    Window window("pim", 320, 200);
    Display display(window.gl());
    glfwSetWindowPos(glfwGetCurrentContext(), 100, 80);
    window.toggle_full_screen();
    EXPECT_TRUE(window.full_screen());
    EXPECT_TRUE(comes_true(window, [&] { return window.framebuffer_size() == Imath::V2i(1280, 800); }));
    EXPECT_TRUE(shows_exactly(window, display));
    window.toggle_full_screen();
    EXPECT_FALSE(window.full_screen());
    EXPECT_TRUE(comes_true(window, [&] { return window.framebuffer_size() == Imath::V2i(320, 200); }));
    EXPECT_TRUE(shows_exactly(window, display));
    int x = 0, y = 0;
    glfwGetWindowPos(glfwGetCurrentContext(), &x, &y);
    EXPECT_EQ(x, 100);
    EXPECT_EQ(y, 80);
}

TEST(Window, MinimisedDrawsNothingAndComesBack) {
    START_DISPLAY(screen);
    START_WINDOW_MANAGER(manager);
    const ImguiContext panels;
    Window window("pim", 320, 200);
    Display display(window.gl());
    glfwIconifyWindow(glfwGetCurrentContext());
    ASSERT_TRUE(comes_true(window, [&] { return window.minimised(); }));
    EXPECT_TRUE(shows_exactly(window, display) || window.framebuffer_size() == Imath::V2i(0, 0));
    glfwRestoreWindow(glfwGetCurrentContext());
    EXPECT_TRUE(comes_true(window, [&] { return !window.minimised(); }));
    EXPECT_TRUE(shows_exactly(window, display));
}

TEST(Window, WaitsUntilSomethingHappens) {
    START_DISPLAY(screen);
    const ImguiContext panels;
    Window window("pim", 64, 64);
    for (int i = 0; i < 20; ++i) window.wait(0.02);  // what opening it brought
    const std::clock_t processor = std::clock();
    const Stopwatch watch;
    while (watch.seconds() < 0.5) window.wait(0.5 - watch.seconds());
    EXPECT_LT(double(std::clock() - processor) / CLOCKS_PER_SEC, 0.2);
    std::thread waker([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
        window.wake();
    });
    const Stopwatch until_woken;
    window.wait(20);
    EXPECT_LT(until_woken.seconds(), 15);
    waker.join();
    window.wait(0);  // does not sleep
    window.poll();
}

TEST(Window, HandsOverDroppedFilesOnce) {
    START_DISPLAY(screen);
    const ImguiContext panels;
    Window window("pim", 64, 64);
    EXPECT_TRUE(window.take_dropped().empty());
    GLFWwindow* handle = glfwGetCurrentContext();
    const GLFWdropfun drop = glfwSetDropCallback(handle, nullptr);
    const char* paths[] = {"a.vdb", "with space/é.toml"};
    drop(handle, 2, paths);
    drop(handle, 1, paths);
    const std::vector<std::filesystem::path> expected{"a.vdb", "with space/é.toml", "a.vdb"};
    EXPECT_EQ(window.take_dropped(), expected);
    EXPECT_TRUE(window.take_dropped().empty());
}

TEST(Window, ClipboardGoesBothWays) {
    START_DISPLAY(screen);
    const ImguiContext panels;
    {
        Window window("pim", 64, 64);
        window.set_clipboard("lamp = [0, 2, 0]");
        EXPECT_STREQ(ImGui::GetClipboardText(), "lamp = [0, 2, 0]");
        ImGui::SetClipboardText("eye");
        EXPECT_STREQ(glfwGetClipboardString(glfwGetCurrentContext()), "eye");
    }
    ImGui::SetClipboardText("gone");  // no window is asked that no longer is
}

TEST(Window, MouseReachesThePanels) {
    START_DISPLAY(screen);
    const ImguiContext panels;
    Window window("pim", 300, 200);
    Display display(window.gl());
    glfwFocusWindow(glfwGetCurrentContext());
    glfwSetCursorPos(glfwGetCurrentContext(), 120, 70);
    EXPECT_TRUE(comes_true(window, [&] {
        glfwSetCursorPos(glfwGetCurrentContext(), 120, 70);
        shows_exactly(window, display);
        return ImGui::GetIO().MousePos.x == 120 && ImGui::GetIO().MousePos.y == 70;
    }));
}

TEST(Window, OffscreenBesideIt) {
    START_DISPLAY(screen);
    const ImguiContext panels;
    {
        Window window("pim", 64, 48);
        Display display(window.gl());
        EXPECT_TRUE(shows_exactly(window, display));
    }
    const Offscreen offscreen(31, 17);
    Display display(offscreen.gl());
    const Rgba8Image picture = test_picture({31, 17});
    display.show(picture);
    display.draw(31, 17, nullptr);
    EXPECT_TRUE(offscreen.read().rgba == picture.rgba);
}

std::string message_of_window() {
    const ImguiContext panels;
    return message_of<Error>([] { const Window window("pim", 64, 64); });
}

TEST(WindowErrors, NoDisplay) {
    ::unsetenv("DISPLAY");
    ::unsetenv("WAYLAND_DISPLAY");
    const std::string message = message_of_window();
    EXPECT_EQ(message.rfind("there is no display", 0), 0u) << message;
    EXPECT_NE(message.find("--output"), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

TEST(WindowErrors, DisplayThatDoesNotAnswer) {
    ::setenv("DISPLAY", ":59999", 1);
    ::unsetenv("WAYLAND_DISPLAY");
    const std::string message = message_of_window();
    ::unsetenv("DISPLAY");
    EXPECT_EQ(message.rfind("there is no display", 0), 0u) << message;
    EXPECT_NE(message.find(":59999"), std::string::npos) << message;
}

TEST(WindowErrors, DisplayWithoutOpenGl) {
    START_DISPLAY(screen, .more = {"-extension", "GLX"});
    const std::string message = message_of_window();
    for (const char* word : {"OpenGL 4.1", "offers none", "--output"})
        EXPECT_NE(message.find(word), std::string::npos) << message;
}

// In a process of its own, because Mesa reads the variable once.
TEST(WindowErrorsDeathTest, OlderOpenGlIsNamed) {
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    START_DISPLAY(screen);
    ::setenv("MESA_GL_VERSION_OVERRIDE", "3.3", 1);
    EXPECT_EXIT(
        {
            fputs(message_of_window().c_str(), stderr);
            std::_Exit(0);
        },
        testing::ExitedWithCode(0), "OpenGL 4.1 core, but this display offers 3.3.*--output");
    ::unsetenv("MESA_GL_VERSION_OVERRIDE");
}

}  // namespace
}  // namespace pim
