// SPDX-License-Identifier: GPL-3.0-or-later
// What is seen in the window as a command line that renders it without one.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "viewer/view_state.h"

namespace pim {

// `text` as one word of a POSIX shell.
std::string shell_word(const std::string& text);

struct CommandFiles {
    std::filesystem::path map, output;
    std::optional<std::filesystem::path> geometry;  // as in --geometry, where that was given
};

// `viewer MAP --output ... --size WxH ...` with every option that differs from what the command does anyway
// (see initial_state); numbers are exact. The camera goes by name where it equals one of the scene.
std::string headless_command(const Scene& scene, const IlluminationMap& map, const ViewState& state,
                             const Imath::V2i& size, const CommandFiles& files);

}  // namespace pim
