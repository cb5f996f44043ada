// SPDX-License-Identifier: GPL-3.0-or-later
// The photon map (Jensen: Realistic Image Synthesis Using Photon Mapping, 2001; the thesis, 2.3.1): photons
// kept where they land on diffuse surfaces, and irradiance from those nearest to a place.
#pragma once

#include "common/render/path_radiance.h"
#include "common/render/photon_tree.h"

namespace pim {

struct StoredPhoton {
    Vec3 position;
    Vec3 normal;  // geometric, of the side on which it landed
    Rgb flux;     // W, as the shading normal sees it
};

struct ShotPhotons {
    std::vector<StoredPhoton> straight;  // from a lamp, having met nothing
    std::vector<StoredPhoton> caustic;   // by way of mirrors and glass alone
    std::vector<StoredPhoton> diffuse;   // all the rest: reflected diffusely at least once
};

// Shoots `photons_per_lamp` for each lamp that shines, shared out in proportion to the lamps' power, so that
// photons of all lamps carry the same power. Same photons in the same order at any thread count.
ShotPhotons shoot_photons(const PathScene& scene, uint64_t photons_per_lamp, uint64_t seed);

// How photons are weighted within the radius r of an estimate: alike, or by a cone 1 - d/r (Jensen 2001,
// section 7.2.1), sharper and noisier.
enum class Filter { none, cone };

class PhotonMap {
  public:
    // `nearest` >= 2: photons per estimate.
    PhotonMap(const std::vector<StoredPhoton>& photons, int nearest, Filter filter);
    std::size_t size() const { return tree_.size(); }

    // Irradiance of the side of a surface on which the unit vector `normal` stands, W/m²: from the nearest
    // photons that landed on sides facing within 90 degrees of it, none beyond greatest_radius().
    Rgb irradiance(const Vec3& position, const Vec3& normal) const;
    // From where on a place counts as dim: there all photons within this radius count, fewer than `nearest`.
    float greatest_radius() const { return greatest_radius_; }

    // Estimates at all photons, for nearby_irradiance (Christensen: Faster Photon Map Global Illumination,
    // 1999).
    void precompute_irradiance();
    // The estimate of the nearest photon on a side facing much the same way: cheap, a little farther off.
    Rgb nearby_irradiance(const Vec3& position, const Vec3& normal) const;

  private:
    struct Carried {
        Vec3 normal;
        Rgb flux;
    };
    float find_greatest_radius(const std::vector<StoredPhoton>& photons) const;
    void find(const Vec3& position, const Vec3& normal, float radius,
              std::vector<PhotonTree::Found>& found) const;

    PhotonTree tree_;
    std::vector<Carried> carried_;  // [slot]
    std::vector<Rgb> precomputed_;  // [slot], W/m²
    std::size_t nearest_;
    Filter filter_;
    float greatest_radius_;
};

}  // namespace pim
