// SPDX-License-Identifier: GPL-3.0-or-later
// The look-up of the map with photons in hand, so that a place takes only what landed where it can see it.
#pragma once

#include "bake/density.h"
#include "common/map/illumination_map.h"

namespace pim {

// A photon's share in a patch.
struct Landed {
    uint32_t patch;
    Vec3 position;   // lifted off the surface, local
    Rgb irradiance;  // of the patch by it, W/m²
};

// All photons of one lamp position, as trace_density counts them.
std::vector<Landed> landed_light(const Scene& scene, const RayCaster& caster, const Cells& cells,
                                 const SurfaceCells& surface, const LightSample& sample, const Rgb& power);

class VisibleLight {
  public:
    VisibleLight(const Scene& scene, const Cells& cells, const SurfaceCells& surface);
    void set(std::vector<Landed> landed);
    std::vector<Rgb> patch_values() const;  // W/m², of all that landed
    // Irradiance at a surface: the look-up's weights, but of each patch only the part that the place can see
    // counts, its photons and its area; segments run a tenth of a cell above both surfaces. Nearly 0 where
    // the place sees nothing of what it looks up.
    Rgb irradiance(const IlluminationMap& map, const RayCaster& caster, const SurfacePoint& surface) const;

  private:
    struct Place {
        Vec3 position;
        float share;
    };
    float lift_;
    std::vector<uint32_t> first_landed_, first_place_;  // [patch]
    std::vector<Landed> landed_;
    std::vector<Place> places_;  // a fragment's each
};

}  // namespace pim
