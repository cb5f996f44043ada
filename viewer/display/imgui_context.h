// SPDX-License-Identifier: GPL-3.0-or-later
// Dear ImGui's state, with the viewer's looks: dark panels that let the picture shine through.
#pragma once

struct ImGuiContext;

namespace pim {

// Made before Window and Display, gone after them. Writes no imgui.ini.
class ImguiContext {
  public:
    ImguiContext();
    ~ImguiContext();
    ImguiContext(const ImguiContext&) = delete;
    ImguiContext& operator=(const ImguiContext&) = delete;

    // Font, margins and roundings become `scale` times as large as on a plain monitor: Window::panel_scale().
    // Between frames only.
    void set_scale(float scale);

    // Starts a frame of that size in pixels without mouse and keyboard, `seconds` (> 0) after the last one;
    // its end is ImGui::Render(). In a window: Window::begin_frame().
    void begin_frame_headless(int width, int height, float seconds);

  private:
    ImGuiContext* context_;
};

}  // namespace pim
