// SPDX-License-Identifier: GPL-3.0-or-later
// A baked map on disk: docs/format.md says what stands where.
#pragma once

#include <filesystem>
#include <functional>

#include "common/map/illumination_map.h"
#include "common/map/vdb_file.h"

namespace pim {

inline constexpr int kFormatVersion = 2;

// Atomic; same map, same bytes. Throws Error.
void write_map(const std::filesystem::path& path, const IlluminationMap& map);

// Throws Error: no map, another format version, grids missing.
IlluminationMap read_map(const std::filesystem::path& path);

// Patches of a grid as they stand in maps and in work folders: grids area/<facing> and centre/<facing>.
using PatchGridVisitor = std::function<void(const std::string& name, const std::vector<Index3>& cells,
                                            const std::vector<float>& values, int channels)>;
void write_patches(const std::vector<Patch>& patches, const CellGrid& grid, const PatchGridVisitor& write);
std::vector<Patch> read_patches(const VdbReader& file, const CellGrid& grid);  // sorted by patch_before

// World-space transform of a cell grid's centres.
VdbTransform transform_of(const CellGrid& grid, const Vec3d& origin);

// Patches of each slot: their numbers and cells, in the order of the patches.
struct SlotCells {
    std::vector<uint32_t> patches;
    std::vector<Index3> cells;
};
std::array<SlotCells, kSlotCount> cells_by_slot(const std::vector<Patch>& patches);

}  // namespace pim
