// SPDX-License-Identifier: GPL-3.0-or-later
// Frame times that anyone can repeat. A frame: from the change to 8-bit RGBA in memory.
#pragma once

#include "viewer/arguments.h"

namespace pim {

// Prints JSON: `width`, `height`, `lamps`, `threads`, `vector_unit`, `seconds_to_first_picture`; of 120
// frames of each motion, `first_lap` (lamps, boxes being read), `lamp_moving` and `camera_moving`: {`frames`,
// `median_ms`, `p95_ms`, `longest_ms`, `frames_per_second`, `most_active_boxes`, `parts_ms` {`view`,
// `shadow_rays`, `evaluate`, `shade`}}; `points` (that are shaded), `patches_per_point`, `patches_in_view`,
// `cut_values`, `view_cache_bytes`, `coefficient_bytes`, `boxes_in_memory`, `peak_rss_bytes`, `display_ms`
// (of OSMesa). Throws as render_still does.
void print_benchmark(const Arguments& arguments);

}  // namespace pim
