// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/render/camera_rays.h"

#include <cmath>

namespace pim {

CameraRays::CameraRays(const Camera& camera, const Imath::V2i& size) : eye_(camera.eye), size_(size) {
    forward_ = (camera.target - camera.eye).normalized();
    const Vec3 right = forward_.cross(camera.up).normalized();
    const float half_height = std::tan(0.5f * camera.vertical_fov * kPi / 180);
    down_ = right.cross(forward_) * -half_height;
    right_ = right * (half_height * float(size.x) / float(size.y));
}

Ray CameraRays::through(float x, float y) const {
    const float sx = 2 * x / float(size_.x) - 1, sy = 2 * y / float(size_.y) - 1;
    return {eye_, (forward_ + right_ * sx + down_ * sy).normalized()};
}

}  // namespace pim
