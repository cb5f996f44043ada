// SPDX-License-Identifier: GPL-3.0-or-later
// Pixels to rays.
#pragma once

#include <optional>

#include "common/scene/camera.h"
#include "common/transport/ray_caster.h"

namespace pim {

class CameraRays {
  public:
    CameraRays(const Camera& camera, const Imath::V2i& size);
    // Through the image at (x, y) in pixels, (0, 0) its upper left corner.
    Ray through(float x, float y) const;
    // The same, not unit: its component along the viewing direction is 1.
    Vec3 direction(float x, float y) const {
        return forward_ + right_ * (x * (2 / float(size_.x)) - 1) + down_ * (y * (2 / float(size_.y)) - 1);
    }
    // Of several, axis by axis.
    template <std::size_t N>
    void directions(const float* x, const float* y, int count, float (*axes)[N]) const {
        const float sx = 2 / float(size_.x), sy = 2 / float(size_.y);
        for (int axis = 0; axis < 3; ++axis)
            for (int i = 0; i < count; ++i)
                axes[axis][i] =
                    forward_[axis] + right_[axis] * (x[i] * sx - 1) + down_[axis] * (y[i] * sy - 1);
    }
    // The pixel through which a place is seen, if the image holds it, and the solid angle of that pixel, sr.
    struct Pixel {
        int x, y;
        float solid_angle;
    };
    std::optional<Pixel> pixel_of(const Vec3& position) const;
    // Of a pixel in the middle, sr.
    float pixel_solid_angle() const {
        return 4 * right_.length() * down_.length() / (float(size_.x) * float(size_.y));
    }
    const Imath::V2i& size() const { return size_; }
    const Vec3& eye() const { return eye_; }

  private:
    Vec3 eye_, forward_, right_, down_;  // right_ and down_ span half the image at distance 1
    Imath::V2i size_;
};

}  // namespace pim
