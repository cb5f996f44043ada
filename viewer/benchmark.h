// SPDX-License-Identifier: GPL-3.0-or-later
// Frame times that anyone can repeat. A frame: from the change to 8-bit RGBA in memory.
#pragma once

#include "viewer/arguments.h"

namespace pim {

// Prints JSON: medians and 95th percentiles over 120 frames of each motion, in milliseconds. Throws as
// render_still does.
void print_benchmark(const Arguments& arguments);

}  // namespace pim
