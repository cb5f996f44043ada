// SPDX-License-Identifier: GPL-3.0-or-later
// One density volume: the irradiance of every patch for one lamp position, from photons.
#pragma once

#include "bake/cells.h"
#include "bake/light_samples.h"
#include "common/transport/photon.h"

namespace pim {

// Multiple of the cell's size that is the `sphere` estimator's radius unless told otherwise.
inline constexpr double kDefaultRadius = 1.0;

struct DensityVolume {
    struct PerComponent {
        std::vector<Rgb> density;     // [patch], W/m² per watt and channel
        std::vector<float> variance;  // [patch], of the channels' mean: sum of squared photon weights
    };
    std::array<PerComponent, kComponentCount> components;  // empty where not asked for
    EnergyAccount account;
};

// The cell of a place on a surface; none where it does not count: outside the grid, of a mirror or glass, out
// of the light's reach.
std::optional<Index3> counted_cell(const Cells& cells, const SurfaceCells& surface, const SurfacePoint& s);

// Calls visit(patch, share) for each patch that a place of a counted cell belongs to; share: of the patch's
// facing in the surface there.
template <class Visit>
void for_each_patch_at(const Cells& cells, const Index3& cell, const SurfacePoint& s, Visit visit) {
    const FacingWeights facing = facing_weights(cells.grid, s.shading_normal);
    const Vec3 from_centre(Vec3d(s.position) - cells.grid.centre(cell));
    for (int f = 0; f < kFacingCount; ++f) {
        if (!(facing.weight[f] > 0)) continue;
        const int patch = cells.patch_at(*cells.index.find_cell(cell), f, from_centre);
        if (patch >= 0) visit(std::size_t(patch), facing.weight[f]);
    }
}

// What a landing leaves, of a photon that started with 1 per channel; none where it is not stored.
std::optional<Rgb> stored_flux(const Landing& landing, Store store);

// Traces the photons of one lamp position and gathers them. Same bytes at any thread count.
DensityVolume trace_density(const Scene& scene, const RayCaster& caster, const Cells& cells,
                            const SurfaceCells& surface, const LightSample& sample);

}  // namespace pim
