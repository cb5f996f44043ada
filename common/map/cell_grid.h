// SPDX-License-Identifier: GPL-3.0-or-later
// The uniform grid of cells, and the patches in it: a patch is the part of one cell's surface that faces one
// way. A map holds one polynomial per patch.
//
// Surfaces facing between the axes belong to up to three facings at once, by weights that add to 1, so that
// nothing jumps where a curved surface turns from one facing to the next.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/core/vector.h"
#include "common/scene/geometry.h"
#include "common/scene/scene.h"

namespace pim {

inline constexpr int kFacingCount = 6;  // px nx py ny pz nz; without facings, all surface is facing 0

// Where surfaces of one cell and facing stand one behind the other with a gap between (a board before its
// wall), they are two patches: the one in front and the one behind. A slot is a facing, of either layer.
inline constexpr int kSlotCount = 2 * kFacingCount;  // slot = facing + kFacingCount · (is behind)

// Cells are divided so many times per axis where it has to be decided which surface light can reach.
inline constexpr int kFinePerCell = 4;

struct CellGrid {
    Vec3d origin{0};       // local: corner of cell (0,0,0), m
    double cell_size = 1;  // m
    Index3 size{1};        // cells per axis
    bool facings = true;

    Vec3d corner(const Index3& cell) const { return origin + Vec3d(cell) * cell_size; }
    Vec3d centre(const Index3& cell) const { return corner(cell) + Vec3d(0.5 * cell_size); }
    bool contains(const Index3& c) const {
        return c.x >= 0 && c.y >= 0 && c.z >= 0 && c.x < size.x && c.y < size.y && c.z < size.z;
    }
    uint64_t cell_count() const { return uint64_t(size.x) * uint64_t(size.y) * uint64_t(size.z); }
};

// Throws Error: no surface in the bounds, a grid too fine to address (more than 4096 cells on an axis).
CellGrid make_grid(const Scene& scene);

std::string slot_name(const CellGrid& grid,
                      int slot);  // "px" ... "nz", "px_behind" ... "nz_behind", or "all"

inline constexpr float kFacingThreshold = 0.02f;  // of the squared components

struct FacingWeights {
    std::array<float, kFacingCount> weight{};  // sum 1
};
// By the squared components of a unit normal, less a small threshold so that surfaces within 8 degrees of an
// axis count for that axis alone.
FacingWeights facing_weights(const CellGrid& grid, const Vec3& normal);

// Which fine cell (kFinePerCell per cell and axis) a place on a triangle belongs to. A triangle that lies
// flat in one layer of cells is tied to one index on that axis, chosen on its lit side, whatever its points'
// last bits say.
class SurfaceCells {
  public:
    SurfaceCells(const CellGrid& grid, const Geometry& geometry);
    std::optional<Index3> fine_cell(uint32_t triangle, Side side, const Vec3& position) const;
    // The tied index of a triangle's side on an axis, if it lies flat there.
    std::optional<int> tied(uint32_t triangle, Side side, int axis) const;
    // Fine index of a coordinate; places on the grid's border count as inside.
    std::optional<int> fine_index(double coordinate, int axis) const;
    const CellGrid& grid() const { return grid_; }

  private:
    CellGrid grid_;
    std::vector<std::array<int32_t, 6>> ties_;  // [triangle][3 * side + axis]
};

inline Index3 cell_of_fine(const Index3& fine) {
    return {fine.x / kFinePerCell, fine.y / kFinePerCell, fine.z / kFinePerCell};
}

struct Patch {
    Index3 cell;
    int slot;
    float area;   // m², that counts
    Vec3 centre;  // centroid of that area, from the cell's centre, m
};

// Patches by cell and slot. Patches are sorted by cell (x slowest), then slot.
class PatchIndex {
  public:
    PatchIndex() = default;
    PatchIndex(const CellGrid& grid, const std::vector<Patch>& patches);
    // Number of the patch; -1 if there is none, also outside the grid.
    int find(const Index3& cell, int slot) const {
        const std::array<int32_t, kSlotCount>* all = find_cell(cell);
        return all ? (*all)[slot] : -1;
    }
    const std::array<int32_t, kSlotCount>* find_cell(const Index3& cell) const;
    std::size_t cell_count() const { return cells_.size(); }

  private:
    static constexpr int kBrick = 8;
    Index3 size_{0}, bricks_{0};
    std::vector<int32_t> brick_start_;  // -1: no cell in the brick
    std::vector<int32_t> cell_number_;  // per brick, 8³; -1: no patch
    std::vector<std::array<int32_t, kSlotCount>> cells_;
};

bool cell_before(const Index3& a, const Index3& b);
bool patch_before(const Patch& a, const Patch& b);

}  // namespace pim
