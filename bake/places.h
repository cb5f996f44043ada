// SPDX-License-Identifier: GPL-3.0-or-later
// Places on surface to draw from in proportion to area, and lines of sight between them.
#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "bake/fragments.h"
#include "common/core/sampling.h"
#include "common/transport/ray_caster.h"

namespace pim {

inline constexpr float kSightLift = 0.3f;  // cells: what is lower hides nothing from what lies beside it

// The open middle of a fragment, lifted off its side, but halfway at most to what lies above it.
Vec3 lifted_centre(const Scene& scene, const RayCaster& caster, const CellGrid& grid,
                   const Fragment& fragment);

// A fragment's part of its triangle's plane.
class FragmentPlane {
  public:
    FragmentPlane(const Geometry& geometry, const Fragment& fragment);
    bool is_degenerate() const { return normal_ == Vec3(0); }
    const Vec3& normal() const { return normal_; }  // towards the triangle's front
    Vec3 flat(Vec3 p) const;                        // moved onto the plane
    // Up to `most` places spread over the fragment; another number, other places.
    std::vector<Vec3> places(int number, int most = RayPacket::kSize) const;

  private:
    std::optional<Vec3> place_at(const Imath::V2d& share) const;  // of the box; none off the fragment

    const Fragment& fragment_;
    std::array<Vec3, 3> corners_;
    Vec3 normal_;
};

class Places {
  public:
    void add(const Vec3& position, float area) {
        positions_.push_back(position);
        sums_.push_back((sums_.empty() ? 0 : sums_.back()) + double(area));
    }
    bool empty() const { return sums_.empty(); }
    // `share`, 0 to 1, of the area.
    const Vec3& at(double share) const {
        const auto i = std::size_t(std::ranges::upper_bound(sums_, share * sums_.back()) - sums_.begin());
        return positions_[std::min(i, positions_.size() - 1)];
    }

  private:
    std::vector<Vec3> positions_;
    std::vector<double> sums_;
};

// Lines between places of both, well spread; another number, other lines. Lengths count in them: 1.
RayPacket lines_between(const Places& from, const Places& to, int packet_number);

}  // namespace pim
