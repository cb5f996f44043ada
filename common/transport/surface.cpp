// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/transport/surface.h"

namespace pim {

SurfacePoint surface_at(const Scene& scene, const Hit& hit) {
    const Geometry& g = scene.geometry;
    const auto corners = g.corners(hit.triangle);
    const Material& material = scene.materials[g.triangles[hit.triangle].material];
    const auto [diffuse, specular] = reflectance(scene, hit.triangle, hit.b1, hit.b2);
    return {.triangle = hit.triangle,
            .side = hit.side,
            .position = corners[0] * (1 - hit.b1 - hit.b2) + corners[1] * hit.b1 + corners[2] * hit.b2,
            .geometric_normal = geometric_normal(corners) * (hit.side == Side::front ? 1.0f : -1.0f),
            .shading_normal = shading_normal(g, hit.triangle, hit.side, hit.b1, hit.b2),
            .material = &material,
            .diffuse = diffuse,
            .specular = specular};
}

}  // namespace pim
