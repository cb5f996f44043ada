// SPDX-License-Identifier: GPL-3.0-or-later
// A window with an OpenGL 4.1 core context, and what a person does to it. One at a time, on the main thread.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/core/vector.h"
#include "viewer/display/gl.h"

namespace pim {

class Window {
  public:
    // Sizes in screen coordinates, >= 1. The ImGui context (ImguiContext) exists already and gets the
    // window's mouse, keyboard and clipboard. Throws Error where there is no display, or no OpenGL 4.1 core
    // on it.
    Window(const std::string& title, int width, int height);
    ~Window();

    const Gl& gl() const;

    bool should_close() const;
    void request_close();

    void poll();                // takes what has happened since the last call
    void wait(double seconds);  // the same, but sleeps until something happens, at most that long
    void wake();                // ends a wait; from any thread

    void begin_frame();  // size, time, mouse and keyboard to ImGui, and ImGui::NewFrame()
    void swap();         // shows what was drawn; waits for the monitor

    void set_title(const std::string& title);
    void set_clipboard(const std::string& text);
    Imath::V2i framebuffer_size() const;  // pixels; (0, 0) is possible while minimised
    bool minimised() const;               // nothing to draw on
    float panel_scale() const;  // how many times as large as on a plain monitor panels should be; >= 1
    void toggle_full_screen();  // and back to size and place before
    bool full_screen() const;
    std::vector<std::filesystem::path> take_dropped();  // files dropped on the window since the last call

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace pim
