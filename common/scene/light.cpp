// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/light.h"

#include "common/core/sampling.h"

namespace pim {

RectangleShape::RectangleShape(Vec2 s, Vec3 n) : size(s), normal(n.normalized()) {
    const Vec3 up = std::abs(normal.y) > 0.99f ? Vec3(0, 0, 1) : Vec3(0, 1, 0);
    axes[0] = up.cross(normal).normalized();
    axes[1] = normal.cross(axes[0]);
}

Emission sample_emission(const Light& light, const Vec3& position, RandomStream& random) {
    const float u1 = random.next(), u2 = random.next();
    return sample_emission(light, position, {u1, u2}, random);
}

Emission sample_emission(const Light& light, const Vec3& position, const Vec2& direction,
                         RandomStream& random) {
    const RectangleShape* rectangle = light.rectangle();
    if (!rectangle) return {position, sample_sphere(direction.x, direction.y)};
    const float s = random.next() - 0.5f, t = random.next() - 0.5f;
    const Vec3 origin = position + rectangle->axes[0] * (s * rectangle->size.x) +
                        rectangle->axes[1] * (t * rectangle->size.y);
    return {origin, Frame(rectangle->normal).to_world(sample_cosine_hemisphere(direction.x, direction.y))};
}

Rgb emitted_radiance(const RectangleShape& shape, const Rgb& power) { return power / (kPi * shape.area()); }

std::optional<float> intersect(const RectangleShape& shape, const Vec3& centre, const Vec3& origin,
                               const Vec3& direction) {
    const float cosine = -direction.dot(shape.normal);
    if (cosine <= 0) return std::nullopt;
    const float distance = (origin - centre).dot(shape.normal) / cosine;
    if (distance <= 0) return std::nullopt;
    const Vec3 offset = origin + direction * distance - centre;
    if (std::abs(offset.dot(shape.axes[0])) > 0.5f * shape.size.x ||
        std::abs(offset.dot(shape.axes[1])) > 0.5f * shape.size.y)
        return std::nullopt;
    return distance;
}

}  // namespace pim
