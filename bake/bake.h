// SPDX-License-Identifier: GPL-3.0-or-later
// The bake, from a scene description to a map:
// cells -> lamp positions -> photons -> density volumes -> fit -> map.
#pragma once

#include <filesystem>
#include <optional>

#include "bake/tracing.h"
#include "common/scene/scene_file.h"

namespace pim {

struct BakeOptions {
    std::optional<std::filesystem::path> output;  // default: the description's name with .vdb
    std::vector<Setting> settings = {};           // in place of what the description says
    bool overwrite = false;                       // begin anew, whatever the work folder holds
    bool clean = false;                           // remove the work folder at the end
    int part = 1, parts = 1;                      // of the lamp positions, for trace
};

std::filesystem::path default_output(const std::filesystem::path& description);

// Where the description leaves settings open, chooses them first (see choose.h).
void bake_run(const std::filesystem::path& description, BakeOptions options);
void bake_trace(const std::filesystem::path& description, const BakeOptions& options);
void bake_fit(const std::filesystem::path& description, const BakeOptions& options);

// What the settings and the scene made unnecessary, in words.
std::vector<std::string> left_out(const Scene& scene, const Cells& cells);

// Warns of light lost at the cut-off, of positions inside solids and so on; lamp positions of all lights.
std::vector<LightSample> all_light_samples(const Scene& scene, const Solids& solids,
                                           std::vector<std::string>& warnings);

}  // namespace pim
