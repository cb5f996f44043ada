// SPDX-License-Identifier: GPL-3.0-or-later
// A map together with the scene that it belongs to.
#pragma once

#include <filesystem>
#include <optional>

#include "common/map/illumination_map.h"
#include "common/scene/scene.h"

namespace pim {

struct BakedScene {
    IlluminationMap map;
    Scene scene;
};

// The scene that a map was baked from, without its polynomials being needed; `geometry` and errors as below.
Scene scene_of(const IlluminationMap& map, const std::filesystem::path& map_file,
               const std::optional<std::filesystem::path>& geometry);

// `geometry`: in place of the path kept in the map. Throws Error, also where the geometry is not the one that
// was baked.
BakedScene read_baked_scene(const std::filesystem::path& map_file,
                            const std::optional<std::filesystem::path>& geometry);

}  // namespace pim
