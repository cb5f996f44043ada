// SPDX-License-Identifier: GPL-3.0-or-later
// Lamps of glTF 2 files: the extension KHR_lights_punctual (Khronos), read from the file itself, because
// Assimp hands over one lamp per definition, wherever and however often it hangs in the scene.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/core/vector.h"

namespace pim {

struct GltfLight {
    std::string name;  // the node's if no other lamp's node has it, else the definition's, else "lamp"
    std::string type;  // "point", "spot", "directional"
    Rgb intensity;     // colour times intensity; candela for "point"
    Vec3d position;    // world space, the file's units
};

// One per node of the default scene that refers to a lamp, depth first; names may repeat. `path` is a .gltf
// or .glb. Throws Error: no valid JSON, a lamp or node that does not exist.
std::vector<GltfLight> read_gltf_lights(const std::filesystem::path& path);

}  // namespace pim
