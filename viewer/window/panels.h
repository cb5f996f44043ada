// SPDX-License-Identifier: GPL-3.0-or-later
// What is drawn over the picture with Dear ImGui: the panel with all settings, lamps and their handles, the
// legend, the reading under the mouse, help.
#pragma once

#include <functional>

#include "viewer/window/controls.h"
#include "viewer/window/session.h"

namespace pim {

class Panels {
  public:
    using Clipboard = std::function<void(const std::string&)>;
    explicit Panels(Clipboard clipboard) : clipboard_(std::move(clipboard)) {}

    // Between ImGui's NewFrame and Render. `size` in ImGui's units, which are the picture's pixels.
    void draw(Session& session, Controls& controls, const Imath::V2i& size, double now);

  private:
    void draw_lamps(Session& session);
    void draw_lamp(Session& session, std::size_t lamp);
    void draw_camera(Session& session);
    void draw_picture(Session& session);
    void draw_keeping(Session& session);
    void draw_animation(Session& session, double now);
    void draw_statistics(const Session& session);
    template <class Action>
    void attempt(Session& session, const std::string& done, Action action);

    Clipboard clipboard_;
    std::string name_;  // of files to keep
    bool playing_ = false;
    double play_time_ = 0, last_now_ = 0;
    Reading reading_;
};

// While a map is being opened, or after that failed.
void draw_loading(const std::string& what, float progress, const std::string& problem);

}  // namespace pim
