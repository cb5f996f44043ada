// SPDX-License-Identifier: GPL-3.0-or-later
// The viewer with panels: in a window, or drawn once into memory.
#pragma once

#include "viewer/arguments.h"

namespace pim {

// Until the window is closed. Throws Error: no display, no OpenGL 4.1, a map that cannot be opened.
void run_window(const Arguments& arguments);

// `--ui --output`: the sharpened picture with its panels as a PNG, drawn by OSMesa. Throws UsageError and
// Error.
void render_panels(const Arguments& arguments);

}  // namespace pim
