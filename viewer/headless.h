// SPDX-License-Identifier: GPL-3.0-or-later
// What the viewer does without a window: one picture, a film, measurements at points, files for others.
#pragma once

#include "viewer/arguments.h"

namespace pim {

// All throw UsageError and Error.
void render_still(const Arguments& arguments);
void render_film(const Arguments& arguments);        // --path, numbered frames
void print_probe(const Arguments& arguments);        // --probe, CSV to stdout
void write_scene(const Arguments& arguments);        // --export-scene
void write_texture_map(const Arguments& arguments);  // --export-ptm, JSON to stdout or --stats

}  // namespace pim
