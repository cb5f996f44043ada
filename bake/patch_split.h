// SPDX-License-Identifier: GPL-3.0-or-later
// Where the surface of one cell and facing is two patches: a board before its wall, or a floor that runs on
// under a partition. What they receive has nothing in common.
#pragma once

#include <limits>
#include <optional>
#include <span>

#include "bake/fragments.h"
#include "common/transport/ray_caster.h"

namespace pim {

// A plane between them.
struct PatchSplit {
    Vec3 normal{0};
    float offset = -std::numeric_limits<float>::infinity();  // m, from the cell's centre; -inf: one patch

    bool is_behind(const Vec3& from_centre) const { return normal.dot(from_centre) < offset; }
    bool passes(const Box3& box, const Vec3d& centre) const;  // through the box
};

class PatchSplitter {
  public:
    // The arguments must outlive it.
    PatchSplitter(const Scene& scene, const RayCaster& caster, const CellGrid& grid,
                  const std::vector<Fragment>& fragments)
        : scene_(scene), caster_(caster), grid_(grid), fragments_(fragments) {}

    // Of a cell's fragments: by layers one behind the other, or else by what hides one side of something from
    // the other.
    PatchSplit find(std::span<const std::size_t> of_cell, int facing, const Vec3d& centre) const;

  private:
    PatchSplit by_layers(std::span<const std::size_t> of_cell, int facing, const Vec3d& centre) const;
    PatchSplit by_sight(std::span<const std::size_t> of_cell, int facing, const Vec3d& centre) const;
    std::optional<PatchSplit> between(const Vec3& from, const Vec3& to, int facing,
                                      const Vec3d& centre) const;

    const Scene& scene_;
    const RayCaster& caster_;
    const CellGrid& grid_;
    const std::vector<Fragment>& fragments_;
};

}  // namespace pim
