// SPDX-License-Identifier: GPL-3.0-or-later
// The patches around eight cell centres that surfaces of some facings look up, and which of them places among
// these do not see: kept, because thousands of a picture's points share them.
#pragma once

#include "common/map/illumination_map.h"
#include "viewer/relight/kernels.h"

namespace pim {

using UnseenByAxis = std::array<Unseen, 3>;  // of a place's facings, of which each axis has one

class Stencil {
  public:
    Stencil() = default;
    // `low`: the lowest of the eight cells; `mask`: a bit for each facing.
    Stencil(const IlluminationMap& map, const Index3& low, int mask);

    const std::vector<StencilEntry>& entries() const { return entries_; }
    const std::vector<uint32_t>& patches() const { return patches_; }

    // What a place does not see. `home`: as in kCellRows. Null: depends on more, or is not known yet.
    const UnseenByAxis* known_unseen(int home) const {
        static constexpr UnseenByAxis kNothing{};
        if (sees_all_) return &kNothing;
        const bool is_known = !(layered_ >> (home % kCornerCount) & 1) && (known_ >> home & 1);
        return is_known ? &unseen_[std::size_t(home)] : nullptr;
    }
    // The same in all cases. `place`: in cells from the lowest centre.
    UnseenByAxis unseen_at(const IlluminationMap& map, int home, const Vec3& place, const Vec3& normal);

    uint32_t tile = 0, group = 0;  // the group that stands for it in a tile

  private:
    // What a part of a cell with two layers does not see: a place there sees as the nearer one does.
    struct LayeredSight {
        std::array<std::array<Unseen, 2>, 3> unseen{};  // [axis][in front, behind]
        std::array<std::array<Vec3, 2>, 3> centre;  // of the patches, in cells from the lowest of the eight
        uint8_t two = 0;                            // a bit for each axis that has both; others: [axis][0]

        UnseenByAxis at(const Vec3& place, const Vec3& normal) const;
    };

    void add_cell(const IlluminationMap& map, int corner, int facing);
    void add(const IlluminationMap& map, int patch, const Index3& step, int facing, bool is_paired, int bit);
    const LayeredSight& layers_of(const IlluminationMap& map, int home);

    Index3 low_{0};
    int mask_ = 0;
    std::vector<StencilEntry> entries_;
    std::vector<uint32_t> patches_;
    bool sees_all_ = true;  // all of it from wherever in it
    uint8_t layered_ = 0;   // a bit for each of the eight cells: it has two layers
    uint64_t known_ = 0;    // a bit for each part of them of which `unseen_` is filled in
    std::vector<UnseenByAxis> unseen_;
    std::vector<std::pair<int, LayeredSight>> layers_;  // by part, of those with two layers that were met
};

}  // namespace pim
