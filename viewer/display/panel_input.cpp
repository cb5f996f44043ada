// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/display/panel_input.h"

#include <imgui.h>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>

#include <algorithm>
#include <utility>

namespace pim {

PanelInput::PanelInput(GLFWwindow* window) : window_(window) {
    ImGui_ImplGlfw_InitForOpenGL(window, true);
    double x = 0, y = 0;
    glfwGetCursorPos(window, &x, &y);
    note_mouse(x, y);
}

PanelInput::~PanelInput() {
    ImGui_ImplGlfw_Shutdown();
    ImGuiIO& io = ImGui::GetIO();  // which keeps pointers to the window's clipboard
    io.SetClipboardTextFn = nullptr;
    io.GetClipboardTextFn = nullptr;
    io.ClipboardUserData = nullptr;
}

void PanelInput::note_key(int key, int scancode, int action, int modifiers) {
    if (action == GLFW_REPEAT) return;               // ImGui repeats by itself
    const bool is_release = action == GLFW_RELEASE;  // of Ctrl after Q, say: both are held for one frame
    if (!keys_.empty() || std::ranges::count(changed_, key) || (is_release && pressed_)) {
        keys_.push_back({key, scancode, action, modifiers});
        return;
    }
    changed_.push_back(key);
    pressed_ |= !is_release;
    ImGui_ImplGlfw_KeyCallback(window_, key, scancode, action, modifiers);
}

void PanelInput::note_button(int button, int action) {
    if (button < 0 || std::size_t(button) >= down_.size()) return;
    buttons_.push_back({std::size_t(button), action == GLFW_PRESS, mouse_});
}

void PanelInput::before_events() {
    if (!std::exchange(drawn_, false)) return;
    changed_.clear();
    pressed_ = false;
    for (const KeyEvent& e : std::exchange(keys_, {})) note_key(e.key, e.scancode, e.action, e.modifiers);
}

void PanelInput::begin_frame() {
    ImGui_ImplGlfw_NewFrame();
    ImGuiIO& io = ImGui::GetIO();
    drawn_ = true;
    if (buttons_.empty()) {
        std::ranges::copy(down_, io.MouseDown);
        return;
    }
    // Let go: the button is still down where it was held last, so that what it drags arrives there.
    const ButtonEvent event = buttons_.front();
    buttons_.pop_front();
    io.MousePos = {event.place.x, event.place.y};
    down_[event.button] |= event.down;
    std::ranges::copy(down_, io.MouseDown);
    down_[event.button] = event.down;
}

}  // namespace pim
