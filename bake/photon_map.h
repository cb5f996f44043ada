// SPDX-License-Identifier: GPL-3.0-or-later
// Photons in a k-d tree, to ask which lie near a point (the thesis, 2.3.1; Jensen 2001).
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "common/core/vector.h"

namespace pim {

class PhotonMap {
  public:
    explicit PhotonMap(const std::vector<Vec3>& positions);
    ~PhotonMap();
    // Numbers of the photons at most `radius` from `centre`, in ascending order.
    std::vector<std::size_t> within(const Vec3d& centre, double radius) const;

  private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

}  // namespace pim
