// SPDX-License-Identifier: GPL-3.0-or-later
// One picture to a file, without display or GPU.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace pim {

// As on the command line; docs in `viewer --help`. Empty: the scene's own.
struct HeadlessOptions {
    std::filesystem::path map, output;
    std::optional<std::filesystem::path> geometry, stats, volume;
    std::vector<std::string> lights;  // NAME=x,y,z (world, m)
    std::vector<std::string> gains;   // NAME=g
    std::string camera, size, direct, indirect, exposure = "auto";
    std::string integrator = "polynomial", view = "radiance";
    int samples = 4;
    bool show_lamps = false;
};

// Throws UsageError and Error.
void render_headless(const HeadlessOptions& options);

}  // namespace pim
