// SPDX-License-Identifier: GPL-3.0-or-later
// Which of the patches around it each part of a patch sees. The two sides of a wall lie in neighbouring cells
// and may face the same way, and yet their light has nothing in common.
#pragma once

#include <cstdint>
#include <vector>

#include "common/map/cell_grid.h"

namespace pim {

inline constexpr int kPartCount = kFinePerCell * kFinePerCell * kFinePerCell;  // of a cell: its fine cells
inline constexpr int kCornerCount = 8;  // cells around a place; bits 0, 1, 2: the upper one on x, y, z

// Patches of one facing that are not seen: bit corner + kCornerCount · (is behind). Corners are those of the
// eight cells between whose centres the part lies.
using Unseen = uint16_t;

class PatchSight {
  public:
    struct Entry {
        uint32_t patch;
        int part;  // x + 4y + 16z
        Unseen unseen;
    };
    PatchSight() = default;
    // An entry for each part that holds surface, of the patches that do not see everything; in any order.
    PatchSight(std::size_t patches, std::vector<Entry> entries);

    // `facing`: of the patch. A part without surface, next to one with it, sees what that one does: rounding
    // may take a place there.
    Unseen unseen(std::size_t patch, int part, int facing) const;
    // Of two patches of one cell and facing that do not see each other: the one whose surface a part holds;
    // -1 if it holds both or none of them.
    int owner(int patch, int other, int part) const;
    bool sees_all(std::size_t patch) const { return patches_.empty() || patches_[patch].parts == 0; }
    bool sees_all() const { return unseen_.empty(); }
    std::vector<Entry> entries() const;  // by patch, then part

  private:
    struct Parts {
        uint64_t parts = 0;  // a bit for each that has an entry
        uint32_t first = 0;  // where they begin
    };
    const Unseen* find(std::size_t patch, int part) const;

    std::vector<Parts> patches_;
    std::vector<Unseen> unseen_;
};

// Where a place stands that has the eight cells around it.
struct Home {
    int corner;  // its own cell
    int part;    // of that cell
    Index3 step() const { return {corner & 1, corner >> 1 & 1, corner >> 2}; }
};
// `place`: in cells from the lowest of the eight centres, 0 to 1 on each axis. A place on a border belongs to
// the cell that the surface's normal points into.
Home home_of(const Vec3& place, const Vec3& normal);

// The eight cells of a part: their lowest, from its own cell.
Index3 lowest_around(int part);

}  // namespace pim
