// SPDX-License-Identifier: GPL-3.0-or-later
// Geometry files (anything Assimp reads) to triangles, materials, textures and lamps.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/core/image.h"
#include "common/scene/geometry.h"
#include "common/scene/light.h"
#include "common/scene/material.h"

namespace pim {

struct GeometryFile {
    Geometry geometry;
    std::vector<Material> materials;
    std::vector<Image> textures;
    std::vector<Light> lights;  // point lamps of the file, standing still, local positions
    std::vector<std::string> warnings;
};

// Node transforms are composed in double, and scaled by metres_per_unit; materials map to diffuse, mirror or
// glass. Throws Error: file missing or broken, no triangles, a texture that cannot be read.
GeometryFile read_geometry(const std::filesystem::path& path, double metres_per_unit);

}  // namespace pim
