// SPDX-License-Identifier: GPL-3.0-or-later
// Scene descriptions (TOML). README.md lists every key. Unknown keys, wrong types and values out of range are
// errors that name file, line, key and what is allowed.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "common/scene/scene.h"

namespace pim {

// A key of [bake], [grid] or [[light]], such as "photons", and its value as TOML writes it. A target_error or
// time_budget frees all that the description says of cells, photons, degree, samples and boxes, to be chosen.
struct Setting {
    std::string key, value;  // an empty value: as if the description did not hold the key
    std::string light = {};  // that this is for; empty: for each
};

// "90", "90s", "10m", "8h": seconds; none if it is no such text.
std::optional<double> parse_duration(const std::string& text);

struct SceneOptions {
    std::vector<Setting> settings = {};             // in place of what the description says
    std::optional<std::filesystem::path> geometry;  // in place of [scene] geometry
};

// The table that a setting's key belongs to: "bake", "grid" or "light". Throws UsageError: no such key.
std::string table_of_setting(const std::string& key);

// Settings are written into Scene::description, so that it makes the same map by itself.
// Reads the description and everything it names; says what was mended and what is not rendered. Throws Error.
Scene read_scene(const std::filesystem::path& path, const SceneOptions& options = {});

// The same from a description's text; relative paths count from `folder`, `name` is for messages.
Scene read_scene_text(const std::string& text, const std::string& name, const std::filesystem::path& folder,
                      const SceneOptions& options = {});

}  // namespace pim
