// SPDX-License-Identifier: GPL-3.0-or-later
// A set-up: lamps, camera and view as a person left them in the window, kept as a TOML file. World
// coordinates, metres.
//
//     view = "radiance"          # see names.h
//     direct = "traced"          # none, traced, baked
//     indirect = true
//     show_lamps = false
//     exposure = "auto"          # or stops
//     tone_curve = "none"        # none, reinhard, aces
//     [camera]                   # a camera of the scene by name, and what differs from it
//     name = "front"
//     eye = [0.0, 1.0, 3.0]
//     target = [0.0, 1.0, 0.0]
//     up = [0.0, 1.0, 0.0]
//     vertical_fov = 40.0        # degrees
//     [[light]]                  # a lamp of the scene by name
//     name = "lamp"
//     position = [0.0, 2.0, 0.0]
//     on = true
//     solo = false
//     gain = 1.0                 # times the described power
//     colour = [1.0, 1.0, 1.0]
//
// All may be left out but a lamp's name.
#pragma once

#include <filesystem>
#include <string>

#include "viewer/view_state.h"

namespace pim {

// All of the state but the size of its picture, all lamps. The camera keeps its name only if the scene knows
// it.
std::string setup_text(const Scene& scene, const ViewState& state);

// Atomic. Throws Error.
void save_setup(const std::filesystem::path& path, const Scene& scene, const ViewState& state);

// What the file leaves out is as in initial_state. Reads back exactly what setup_text wrote. Throws Error
// with file, line, key and what is allowed: also for lamps and cameras that the scene lacks, lamps outside
// their domains, and parts of the light that the map lacks.
ViewState load_setup(const std::filesystem::path& path, const Scene& scene, const IlluminationMap& map);

}  // namespace pim
