// SPDX-License-Identifier: GPL-3.0-or-later
// A baked map on disk: docs/format.md says what stands where.
#pragma once

#include <filesystem>

#include "common/map/illumination_map.h"
#include "common/map/vdb_file.h"

namespace pim {

inline constexpr int kFormatVersion = 1;

// `origin`: of the geometry, world space. Atomic; same map, same bytes. Throws Error.
void write_map(const std::filesystem::path& path, const IlluminationMap& map, const Vec3d& origin);

// Throws Error: no map, another format version, grids missing.
IlluminationMap read_map(const std::filesystem::path& path);

// World-space transform of a cell grid's centres.
VdbTransform transform_of(const CellGrid& grid, const Vec3d& origin);

// Patches of each facing: their numbers and cells, in the order of the patches.
struct FacingCells {
    std::vector<uint32_t> patches;
    std::vector<Index3> cells;
};
std::array<FacingCells, kFacingCount> cells_by_facing(const std::vector<Patch>& patches);

}  // namespace pim
