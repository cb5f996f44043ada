// SPDX-License-Identifier: GPL-3.0-or-later
// From the eye to the diffuse surfaces that it sees, straight and by way of mirrors and glass.
#pragma once

#include "common/transport/scattering.h"

namespace pim {

// Follows every branch: both ways at glass, the mirror's part beside the diffuse one. Visitor has
//     bool segment(const Ray&, float until, const Rgb& throughput)   a stretch that meets nothing before
//         `until`; true: the walk ends on it (at a lamp, say)
//     void diffuse(const SurfacePoint&, const Rgb& throughput)
template <class Visitor>
class SpecularWalk {
  public:
    SpecularWalk(const Scene& scene, const RayCaster& caster, Visitor& visitor)
        : scene_(scene), caster_(caster), visitor_(visitor) {}

    void follow(const Ray& ray, const Rgb& throughput, int depth = 0) {
        const auto hit = caster_.intersect(ray);
        const float until = hit ? hit->distance : std::numeric_limits<float>::infinity();
        if (visitor_.segment(ray, until, throughput) || !hit) return;
        const SurfacePoint surface = surface_at(scene_, *hit);
        if (!is_black(surface.diffuse)) visitor_.diffuse(surface, throughput);
        leave(surface, ray.direction, throughput, depth);
    }

    // On from a surface that `in` (unit) met.
    void leave(const SurfacePoint& surface, const Vec3& in, const Rgb& throughput, int depth = 0) {
        if (depth == kDeepest) return;
        if (!surface.material->glass) {
            go_on(surface, mirror(in, surface.shading_normal), throughput * surface.specular, depth);
            return;
        }
        const GlassSplit split = split_at_glass(surface, in);
        go_on(surface, split.reflected, throughput * split.reflected_share, depth);
        const float scale = 1 / (split.relative_ior * split.relative_ior);
        if (split.reflected_share < 1)
            go_on(surface, split.refracted, throughput * ((1 - split.reflected_share) * scale), depth);
    }

  private:
    static constexpr int kDeepest = 12;
    static constexpr float kLeastShare = 1e-3f;  // reflections that contribute less are not followed

    void go_on(const SurfacePoint& surface, const Vec3& direction, const Rgb& throughput, int depth) {
        if (max_channel(throughput) < kLeastShare) return;
        follow({surface.leave(direction, caster_.surface_offset()), direction}, throughput, depth + 1);
    }

    const Scene& scene_;
    const RayCaster& caster_;
    Visitor& visitor_;
};

}  // namespace pim
