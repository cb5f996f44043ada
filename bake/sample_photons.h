// SPDX-License-Identifier: GPL-3.0-or-later
// The photons of one lamp position: a pure function of scene, seed, position and number.
#pragma once

#include "bake/light_samples.h"
#include "common/transport/photon.h"

namespace pim {

// How many photons of a bake share a start from the lamp (see trace_photons): one where the first landing
// counts by itself (direct light), or where a mirror or glass would send all of them on along one way.
inline constexpr int kPhotonsOfAStart = 8;
int photons_of_a_start(const Scene& scene);

class SamplePhotons {
  public:
    // The arguments must outlive the photons.
    SamplePhotons(const Scene& scene, const RayCaster& caster, const LightSample& sample);
    // Photons `begin` to `end` - 1; `begin` is a multiple of kPhotonsOfAStart. May be called by several
    // threads.
    void trace(uint64_t begin, uint64_t end, const LandingFunction& landed, EnergyAccount& account) const;

  private:
    RandomStream stream(uint64_t number) const;
    Emission start(uint64_t number, RandomStream& random) const;

    const Scene& scene_;
    const RayCaster& caster_;
    const LightSample& sample_;
    uint64_t together_;  // photons of one start
    Imath::V2d shift_;   // of all starts
};

}  // namespace pim
