// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/display/window.h"

#include <fmt/format.h>
#include <imgui.h>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/core/error.h"
#include "common/core/log.h"
#include "viewer/display/panel_input.h"

namespace pim {
namespace {

// GLFW's words on what failed last.
std::string last_error() {
    const char* description = nullptr;
    glfwGetError(&description);
    return description ? description : "GLFW gives no reason";
}

struct Library {
    Library() {
        if (!glfwInit())
            throw Error(
                fmt::format("there is no display to open a window on ({}); `viewer FILE.vdb --output "
                            "FRAME.png` needs none",
                            last_error()));
    }
    ~Library() { glfwTerminate(); }
    Library(const Library&) = delete;
    Library& operator=(const Library&) = delete;
};

struct Destroy {
    void operator()(GLFWwindow* window) const { glfwDestroyWindow(window); }
};
using Handle = std::unique_ptr<GLFWwindow, Destroy>;

void* resolve(const char* name) { return reinterpret_cast<void*>(glfwGetProcAddress(name)); }

// Of whatever context the display does offer, for the error's sentence.
std::string found_opengl() {
    glfwDefaultWindowHints();
    glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
    const Handle probe(glfwCreateWindow(16, 16, "", nullptr, nullptr));
    if (!probe) return "none";
    glfwMakeContextCurrent(probe.get());
    const auto get_string = reinterpret_cast<PFNGLGETSTRINGPROC>(resolve("glGetString"));
    const GLubyte *version = get_string(GL_VERSION), *renderer = get_string(GL_RENDERER);
    if (!version || !renderer) return "none";
    return fmt::format("{} ({})", reinterpret_cast<const char*>(version),
                       reinterpret_cast<const char*>(renderer));
}

Handle create_window(const std::string& title, int width, int height) {
    glfwDefaultWindowHints();
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 1);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
    glfwWindowHint(GLFW_DEPTH_BITS, 0);
    glfwWindowHint(GLFW_STENCIL_BITS, 0);
    Handle window(glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr));
    if (window) return window;
    const std::string reason = last_error();
    throw Error(fmt::format("a window needs OpenGL 4.1 core, but this display offers {} ({}); {}",
                            found_opengl(), reason, kWithoutOpenGl));
}

struct Place {
    int x = 0, y = 0, width = 1, height = 1;  // screen coordinates
};

Place place_of(GLFWwindow* window) {
    Place place;
    glfwGetWindowPos(window, &place.x, &place.y);
    glfwGetWindowSize(window, &place.width, &place.height);
    return place;
}

int overlap(int a, int a_size, int b, int b_size) {
    return std::max(0, std::min(a + a_size, b + b_size) - std::max(a, b));
}

// The one that shows most of the window; nullptr where the display has none.
GLFWmonitor* monitor_of(const Place& place) {
    int count = 0;
    GLFWmonitor** monitors = glfwGetMonitors(&count);
    GLFWmonitor* best = glfwGetPrimaryMonitor();
    long most = 0;
    for (int i = 0; i < count; ++i) {
        int x = 0, y = 0;
        glfwGetMonitorPos(monitors[i], &x, &y);
        const GLFWvidmode* mode = glfwGetVideoMode(monitors[i]);
        if (!mode) continue;
        const long area = long(overlap(place.x, place.width, x, mode->width)) *
                          overlap(place.y, place.height, y, mode->height);
        if (area > most) best = monitors[i];
        most = std::max(most, area);
    }
    return best;
}

}  // namespace

struct Window::State {
    Library library;
    Handle window;
    PanelInput input;  // goes before the window
    Gl gl;
    Place before_full_screen;
    std::vector<std::filesystem::path> dropped;

    State(const std::string& title, int width, int height)
        : window(create_window(title, width, height)), input(window.get()) {}

    static State& of(GLFWwindow* w) { return *static_cast<State*>(glfwGetWindowUserPointer(w)); }

    void connect_input() {
        glfwSetKeyCallback(window.get(), [](GLFWwindow* w, int key, int scancode, int action, int modifiers) {
            of(w).input.note_key(key, scancode, action, modifiers);
        });
        glfwSetMouseButtonCallback(window.get(), [](GLFWwindow* w, int button, int action, int) {
            of(w).input.note_button(button, action);
        });
        glfwSetCursorPosCallback(window.get(),
                                 [](GLFWwindow* w, double x, double y) { of(w).input.note_mouse(x, y); });
    }
};

Window::Window(const std::string& title, int width, int height)
    : state_(std::make_unique<State>(title, width, height)) {
    GLFWwindow* window = state_->window.get();
    glfwMakeContextCurrent(window);
    state_->gl = load_gl(resolve);
    glfwSwapInterval(1);
    // Black in place of garbage; and Mesa asks for the window's size only after a swap, so that a window
    // manager's size would miss the first frame.
    state_->gl.Clear(GL_COLOR_BUFFER_BIT);
    swap();
    glfwSetWindowUserPointer(window, state_.get());
    glfwSetDropCallback(window, [](GLFWwindow* target, int count, const char** paths) {
        auto& dropped = State::of(target).dropped;
        dropped.insert(dropped.end(), paths, paths + count);
    });
    state_->connect_input();
    // From here on nothing that fails is worth more than a note: a title, the clipboard.
    glfwSetErrorCallback(
        [](int, const char* description) { log_debug(fmt::format("window: {}", description)); });
}

Window::~Window() { glfwSetErrorCallback(nullptr); }

const Gl& Window::gl() const { return state_->gl; }

bool Window::should_close() const { return glfwWindowShouldClose(state_->window.get()); }

void Window::request_close() { glfwSetWindowShouldClose(state_->window.get(), GLFW_TRUE); }

void Window::poll() {
    state_->input.before_events();
    glfwPollEvents();
}

void Window::wait(double seconds) {
    state_->input.before_events();
    if (seconds > 0 && (minimised() || !state_->input.is_waiting()))
        glfwWaitEventsTimeout(seconds);
    else
        glfwPollEvents();
}

void Window::wake() { glfwPostEmptyEvent(); }

void Window::begin_frame() {
    state_->input.begin_frame();
    ImGui::NewFrame();
}

void Window::swap() { glfwSwapBuffers(state_->window.get()); }

void Window::set_title(const std::string& title) { glfwSetWindowTitle(state_->window.get(), title.c_str()); }

void Window::set_clipboard(const std::string& text) {
    glfwSetClipboardString(state_->window.get(), text.c_str());
}

Imath::V2i Window::framebuffer_size() const {
    Imath::V2i size(0);
    glfwGetFramebufferSize(state_->window.get(), &size.x, &size.y);
    return size;
}

bool Window::minimised() const {
    const Imath::V2i size = framebuffer_size();
    return size.x < 1 || size.y < 1 || glfwGetWindowAttrib(state_->window.get(), GLFW_ICONIFIED);
}

float Window::panel_scale() const {
    float content = 1, ignored = 1;
    glfwGetWindowContentScale(state_->window.get(), &content, &ignored);
    const Place place = place_of(state_->window.get());
    // Where a screen coordinate is several pixels (Wayland), ImGui's units are magnified already.
    const float magnified = std::max(1.0f, float(framebuffer_size().x) / float(std::max(place.width, 1)));
    const float quarters = std::round(4 * content / magnified);
    return std::clamp(quarters / 4, 1.0f, 4.0f);
}

void Window::toggle_full_screen() {
    GLFWwindow* window = state_->window.get();
    if (full_screen()) {
        const Place& place = state_->before_full_screen;
        glfwSetWindowMonitor(window, nullptr, place.x, place.y, place.width, place.height, GLFW_DONT_CARE);
        return;
    }
    const Place place = place_of(window);
    GLFWmonitor* monitor = monitor_of(place);
    const GLFWvidmode* mode = monitor ? glfwGetVideoMode(monitor) : nullptr;
    if (!mode) return;
    state_->before_full_screen = place;
    glfwSetWindowMonitor(window, monitor, 0, 0, mode->width, mode->height, mode->refreshRate);
}

bool Window::full_screen() const { return glfwGetWindowMonitor(state_->window.get()) != nullptr; }

std::vector<std::filesystem::path> Window::take_dropped() { return std::exchange(state_->dropped, {}); }

}  // namespace pim
