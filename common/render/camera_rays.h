// SPDX-License-Identifier: GPL-3.0-or-later
// Pixels to rays.
#pragma once

#include "common/scene/camera.h"
#include "common/transport/ray_caster.h"

namespace pim {

class CameraRays {
  public:
    CameraRays(const Camera& camera, const Imath::V2i& size);
    // Through the image at (x, y) in pixels, (0, 0) its upper left corner.
    Ray through(float x, float y) const;
    const Imath::V2i& size() const { return size_; }

  private:
    Vec3 eye_, forward_, right_, down_;   // right_ and down_ span half the image at distance 1
    Imath::V2i size_;
};

}  // namespace pim
