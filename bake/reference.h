// SPDX-License-Identifier: GPL-3.0-or-later
// What a map is held against: pixels and lamp positions that no fit has seen, and the radiance that path
// tracing finds there.
#pragma once

#include <functional>

#include "bake/evaluate.h"
#include "common/core/random.h"
#include "common/render/map_radiance.h"
#include "common/scene/geometry_check.h"
#include "common/transport/ray_caster.h"

namespace pim {

struct ReferencePixel {
    Vec2 place{0};         // in the image, 0 to 1
    bool surface = false;  // is any seen?
    // Radiance, W/(m² sr), from two independent halves of the paths; all of it, and without the lamps' own.
    std::array<Rgb, 2> all{Rgb(0), Rgb(0)}, indirect{Rgb(0), Rgb(0)};
};

class Reference {
  public:
    // Traces the paths. The arguments need not outlive it.
    Reference(const Scene& scene, const RayCaster& caster, const Solids& solids,
              const EvaluateOptions& options);
    // At other lamp positions, with other random numbers than those of evaluations.
    Reference(const Scene& scene, const RayCaster& caster, std::vector<std::vector<LightState>> lamps,
              const EvaluateOptions& options, uint64_t seed);

    int positions() const { return int(lamps_.size()); }
    int cameras() const { return int(cameras_.size()); }
    const std::vector<LightState>& lamps(int position) const { return lamps_[std::size_t(position)]; }
    Imath::V2i size(int camera) const;  // of the raster of pixels
    const std::vector<ReferencePixel>& pixels(int position, int camera) const {
        return pixels_[std::size_t(view(position, camera))];
    }
    // The same camera rays again, in parallel. Same random numbers at every call.
    using Visitor = std::function<void(std::size_t pixel, const Ray&, RandomStream&)>;
    void for_each_ray(int position, int camera, const Visitor& visit) const;
    // What another way of rendering sees along them.
    using Renderer = std::function<Rgb(const Ray&, RandomStream&)>;
    std::vector<Rgb> seen(int position, int camera, const Renderer& renderer) const;

    // Of all that decides what stands here.
    static std::string key(const Scene& scene, const EvaluateOptions& options);

  private:
    int view(int position, int camera) const { return position * cameras() + camera; }
    void trace(const Scene& scene, const RayCaster& caster, int position, int camera);

    EvaluateOptions options_;
    uint64_t seed_;
    std::vector<Camera> cameras_;
    std::vector<std::vector<LightState>> lamps_;       // [position]
    std::vector<std::vector<ReferencePixel>> pixels_;  // [view]
};

// So many photons take about as long as a reference.
double reference_photons(const Scene& scene, const EvaluateOptions& options);

// Of rectangular lamps in evaluations: the map's error, not that of soft shadows.
inline constexpr int kEvaluationShadowSamples = 256;

// A map's light as evaluations see it, patches not evaluated yet: direct light from the map where it has it.
Moment evaluated_moment(const Scene& scene, const RayCaster& caster, const IlluminationMap& map,
                        const std::vector<LightState>& lamps);

// All lamps at once, uniform in their domains, outside solids.
std::vector<LightState> unseen_lamps(const Scene& scene, const Solids& solids, int position);

}  // namespace pim
