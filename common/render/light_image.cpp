// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/render/light_image.h"

#include <cmath>

#include "common/core/parallel.h"
#include "common/transport/photon.h"

namespace pim {
namespace {

constexpr std::size_t kBlocks = 16;  // images summed in order, whatever the thread count

class Splatter {
  public:
    Splatter(const PathScene& scene, const Camera& camera, const Imath::V2i& size, float photons)
        : scene_(scene), rays_(camera, size), photons_(photons), image_(size.x, size.y) {}

    void add(const Landing& landing, std::size_t light) {
        const SurfacePoint& s = landing.surface;
        if (!landing.begins_specular || is_black(s.diffuse)) return;
        const auto seen = rays_.pixel_of(s.position);
        if (!seen) return;
        const Vec3 path = rays_.eye() - s.position;
        const float distance = path.length();
        const Vec3 towards = path / distance;
        const float cosine = towards.dot(s.geometric_normal);
        if (cosine <= 0) return;
        const Vec3 origin = s.leave(towards, scene_.caster.surface_offset());
        if (scene_.caster.occluded({origin, towards, (rays_.eye() - origin).length()})) return;
        // flux · rho/pi · cos / d², spread over the pixel's solid angle
        const float share = light_image_share(scene_, light, distance, cosine);
        image_.at(seen->x, seen->y) +=
            scene_.lights[light].power * landing.flux * s.diffuse *
            (share * cosine / (kPi * distance * distance * seen->solid_angle * photons_));
    }
    const Image& image() const { return image_; }

  private:
    const PathScene& scene_;
    CameraRays rays_;
    float photons_;
    Image image_;
};

}  // namespace

Image light_image(const PathScene& scene, const Camera& camera, const Imath::V2i& size,
                  uint64_t photons_per_lamp, uint64_t seed, uint32_t stream) {
    std::vector<Splatter> splatters(kBlocks, Splatter(scene, camera, size, float(photons_per_lamp)));
    const auto& lights = scene.scene.lights;
    parallel_for(kBlocks, [&](std::size_t block) {
        EnergyAccount ignored;
        for (std::size_t l = 0; l < lights.size(); ++l) {
            if (lights[l].rectangle() && !(scene.image_photons > 0)) continue;
            for (uint64_t photon = block; photon < photons_per_lamp; photon += kBlocks) {
                RandomStream random(seed, RandomPurpose::light_image, stream << 8 ^ uint32_t(l), photon);
                trace_photon(
                    scene.scene, scene.caster, lights[l], scene.lights[l].position, random,
                    [&](const Landing& landing) { splatters[block].add(landing, l); }, ignored);
            }
        }
    });
    Image sum(size.x, size.y);
    for (const Splatter& splatter : splatters)
        for (std::size_t i = 0; i < sum.pixels.size(); ++i) sum.pixels[i] += splatter.image().pixels[i];
    return sum;
}

}  // namespace pim
