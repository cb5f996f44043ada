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

// Traces the photons of one lamp position and gathers them. Same bytes at any thread count.
DensityVolume trace_density(const Scene& scene, const RayCaster& caster, const Cells& cells,
                            const SurfaceCells& surface, const LightSample& sample);

}  // namespace pim
