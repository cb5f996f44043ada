// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/map/baked_scene.h"

#include <fmt/format.h>

#include "common/core/error.h"
#include "common/map/map_file.h"
#include "common/scene/scene_file.h"

namespace pim {

Scene scene_of(const IlluminationMap& map, const std::filesystem::path& map_file,
               const std::optional<std::filesystem::path>& geometry) {
    const std::filesystem::path folder = map_file.parent_path();
    const std::filesystem::path geometry_file = geometry.value_or(folder / map.geometry_path);
    if (!std::filesystem::exists(geometry_file))
        throw Error(fmt::format("{}: its geometry {} is not there; give the file's place with --geometry",
                                map_file.string(), geometry_file.string()));
    Scene scene = read_scene_text(map.description, map_file.string() + " (description)", folder,
                                  {.geometry = geometry_file});
    if (scene.geometry_hash != map.geometry_hash)
        throw Error(
            fmt::format("{}: was baked from another geometry than {} holds now; bake again or give the right "
                        "file with --geometry",
                        map_file.string(), geometry_file.string()));
    return scene;
}

BakedScene read_baked_scene(const std::filesystem::path& map_file,
                            const std::optional<std::filesystem::path>& geometry) {
    BakedScene baked{read_map(map_file), {}};
    baked.scene = scene_of(baked.map, map_file, geometry);
    return baked;
}

}  // namespace pim
