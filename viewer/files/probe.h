// SPDX-License-Identifier: GPL-3.0-or-later
// Light meters: points on surfaces come from a CSV file with the columns x,y,z,nx,ny,nz, and the irradiance
// found there goes to another.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/scene/scene.h"

namespace pim {

struct ProbePoint {
    Vec3d world;    // m, as in the file
    Vec3 position;  // local, m
    Vec3 normal;    // of the lit side of the surface, unit
};

// Throws Error with file, line and column; every point needs its normal, of any length but 0.
std::vector<ProbePoint> read_probe(const std::filesystem::path& path, const Scene& scene);

// `irradiance`: W/m² per channel, one for each point. Columns: x,y,z,nx,ny,nz, then red,green,blue (W/m²),
// irradiance (W/m²: the channels weighted as luminance is) and lux (683 lm/W times that).
std::string probe_text(const std::vector<ProbePoint>& points, const std::vector<Rgb>& irradiance);

}  // namespace pim
