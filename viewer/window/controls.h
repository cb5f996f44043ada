// SPDX-License-Identifier: GPL-3.0-or-later
// Mouse and keys over the picture: lamps dragged by their handles, the camera moved.
#pragma once

#include <optional>

#include "viewer/interaction/gizmo_drag.h"
#include "viewer/window/session.h"

namespace pim {

// What the keys ask of the program itself.
struct Requests {
    bool reopen = false, full_screen = false, close = false;
};

class Controls {
  public:
    bool show_help = false;
    bool show_panels = true;

    // Reads ImGui's mouse and keyboard of this frame, where no panel takes them. `seconds` since the last.
    Requests update(Session& session, const Imath::V2i& size, float seconds);

    std::optional<Handle> handle() const;  // held, else under the mouse
    bool is_dragging() const { return drag_.has_value(); }

  private:
    void use_mouse(Session& session, const Imath::V2i& size);
    void use_keys(Session& session, float seconds, Requests& requests);
    void nudge_lamp(Session& session);

    std::optional<GizmoDrag> drag_;
    std::optional<Handle> hovered_;
    bool moving_camera_ = false;
};

// For F1: keys and what they do.
struct KeyHelp {
    const char *keys, *what;
};
const std::vector<KeyHelp>& key_help();

}  // namespace pim
