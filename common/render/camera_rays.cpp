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

Ray CameraRays::through(float x, float y) const { return {eye_, direction(x, y).normalized()}; }

std::optional<CameraRays::Pixel> CameraRays::pixel_of(const Vec3& position) const {
    const Vec3 path = position - eye_;
    const float depth = path.dot(forward_);
    if (!(depth > 0)) return std::nullopt;
    const Vec3 on_plane = path / depth - forward_;  // at distance 1
    const float sx = on_plane.dot(right_) / right_.length2(), sy = on_plane.dot(down_) / down_.length2();
    const float x = 0.5f * (sx + 1) * float(size_.x), y = 0.5f * (sy + 1) * float(size_.y);
    if (!(x >= 0 && y >= 0 && x < float(size_.x) && y < float(size_.y))) return std::nullopt;
    const float cosine = depth / path.length();
    const float pixel_area = 4 * right_.length() * down_.length() / (float(size_.x) * float(size_.y));
    return Pixel{int(x), int(y), pixel_area * cosine * cosine * cosine};
}

}  // namespace pim
