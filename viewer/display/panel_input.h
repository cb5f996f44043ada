// SPDX-License-Identifier: GPL-3.0-or-later
// Mouse, keyboard and clipboard of a window for the current ImGui context. ImGui 1.86 looks at keys, buttons
// and mouse only when a frame begins: a key tapped while one frame is drawn would be missed, a handle grasped
// where the mouse no longer is. So each frame gets one change of each key, and one of the buttons at the
// place where it happened; what came after that waits for the next frame.
#pragma once

#include <array>
#include <deque>
#include <vector>

#include "common/core/vector.h"

struct GLFWwindow;

namespace pim {

class PanelInput {
  public:
    // The context exists already, and goes after it. The window's callbacks for keys, buttons and the mouse's
    // place are to be set to the functions below.
    explicit PanelInput(GLFWwindow* window);
    ~PanelInput();
    PanelInput(const PanelInput&) = delete;
    PanelInput& operator=(const PanelInput&) = delete;

    // Arguments as GLFW hands them over.
    void note_key(int key, int scancode, int action, int modifiers);
    void note_button(int button, int action);
    void note_mouse(double x, double y) { mouse_ = Vec2(float(x), float(y)); }

    void before_events();                                                    // what has waited comes first
    bool is_waiting() const { return !keys_.empty() || !buttons_.empty(); }  // another frame is needed for it
    void begin_frame();                                                      // before ImGui::NewFrame()

  private:
    struct KeyEvent {
        int key, scancode, action, modifiers;
    };
    struct ButtonEvent {
        std::size_t button;
        bool down;
        Vec2 place;
    };
    GLFWwindow* window_;
    std::vector<int> changed_;  // keys, since the last frame
    bool pressed_ = false;      // one of them
    std::deque<KeyEvent> keys_;
    std::deque<ButtonEvent> buttons_;
    std::array<bool, 3> down_{};
    Vec2 mouse_{0};
    bool drawn_ = false;
};

}  // namespace pim
