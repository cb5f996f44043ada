// SPDX-License-Identifier: GPL-3.0-or-later
// A place where light meets a surface, with all that scattering needs to know.
#pragma once

#include "common/scene/scene.h"
#include "common/transport/ray_caster.h"

namespace pim {

struct SurfacePoint {
    uint32_t triangle;
    Side side;
    Vec3 position;          // local, on the triangle
    Vec3 geometric_normal;  // unit, on the side that the ray met
    Vec3 shading_normal;    // unit, within 90 degrees of geometric_normal
    const Material* material;
    Rgb diffuse, specular;  // reflectance

    // Start of a ray that leaves in `direction`, off the surface on that side.
    Vec3 leave(const Vec3& direction, float surface_offset) const {
        return position +
               geometric_normal * (direction.dot(geometric_normal) > 0 ? surface_offset : -surface_offset);
    }
};

SurfacePoint surface_at(const Scene& scene, const Hit& hit);

}  // namespace pim
