// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/render/path_radiance.h"

#include <cmath>

#include "common/transport/scattering.h"

namespace pim {
namespace {

constexpr int kAlwaysSurvives = 3;  // surfaces before Russian roulette starts
constexpr int kLongestPath = 1000;

float power_heuristic(float own, float other) {
    const float a = own * own, b = other * other;
    return a + b > 0 ? a / (a + b) : 0;
}

struct LampSample {
    Rgb irradiance_term{0};  // contribution to outgoing radiance, before reflectance / pi
    float lamp_density = 0;  // per solid angle; 0 for a point lamp, which nothing else can find
    Vec3 towards;
};

// One sample of one lamp from a surface.
LampSample sample_lamp(const PathScene& s, std::size_t l, const SurfacePoint& surface, RandomStream& random) {
    const LightState& state = s.lights[l];
    const RectangleShape* rectangle = s.scene.lights[l].rectangle();
    Vec3 target = state.position;
    if (rectangle)
        target += rectangle->axes[0] * ((random.next() - 0.5f) * rectangle->size.x) +
                  rectangle->axes[1] * ((random.next() - 0.5f) * rectangle->size.y);
    const Vec3 path = target - surface.position;
    const float distance = path.length();
    LampSample sample;
    if (!(distance > 0)) return sample;
    sample.towards = path / distance;
    const float cosine = sample.towards.dot(surface.shading_normal);
    if (cosine <= 0 || sample.towards.dot(surface.geometric_normal) <= 0) return sample;
    const float lamp_cosine = rectangle ? -sample.towards.dot(rectangle->normal) : 1.0f;
    if (lamp_cosine <= 0) return sample;
    const Vec3 origin = surface.leave(sample.towards, s.caster.surface_offset());
    const Vec3 rest = target - origin;
    const float length = rest.length();
    if (!(length > 0) || s.caster.occluded({origin, rest / length, length})) return sample;
    const float inverse_square = 1 / (distance * distance);
    if (!rectangle) {
        sample.irradiance_term = state.power * (cosine * inverse_square / (4 * kPi));
        return sample;
    }
    sample.lamp_density = 1 / (inverse_square * lamp_cosine * rectangle->area());
    sample.irradiance_term = emitted_radiance(*rectangle, state.power) * (cosine / sample.lamp_density);
    return sample;
}

class Path {
  public:
    Path(const PathScene& scene, RandomStream& random) : scene_(scene), random_(random) {}

    Seen trace(Ray ray) {
        for (int length = 0; length < kLongestPath; ++length) {
            const auto hit = scene_.caster.intersect(ray);
            add_lamps_met(ray, hit ? hit->distance : std::numeric_limits<float>::infinity());
            if (!hit) break;
            const SurfacePoint surface = surface_at(scene_.scene, *hit);
            if (length == 0) seen_.surface = true;
            if (!is_black(surface.diffuse)) add_lamps_sampled(surface);
            const float survival = length < kAlwaysSurvives ? 1 : survival_probability(surface, throughput_);
            const auto scattered =
                scatter(surface, ray.direction, throughput_, survival, Transport::from_eye, random_);
            if (!scattered || !(scattered->correction > 0)) break;
            throughput_ *= scattered->weight * scattered->correction;
            note_event(*scattered, surface);
            ray = {surface.leave(scattered->direction, scene_.caster.surface_offset()), scattered->direction};
        }
        return seen_;
    }

  private:
    void add(const Rgb& radiance, bool straight_to_first_diffuse) {
        seen_.total += radiance;
        if (!straight_to_first_diffuse) seen_.indirect += radiance;
    }

    void note_event(const Scattered& scattered, const SurfacePoint& surface) {
        if (scattered.event == Event::diffuse) {
            ++diffuse_events_;
            density_ = std::max(0.0f, scattered.direction.dot(surface.shading_normal)) / kPi;
            // Mirror and diffuse share a surface: the chance of having chosen diffuse is part of the density.
            const float d = mean_channel(throughput_before_ * surface.diffuse);
            const float s = mean_channel(throughput_before_ * surface.specular);
            density_ *= d + s > 0 ? d / (d + s) : 1;
            specular_since_diffuse_ = false;
        } else {
            specular_since_diffuse_ = true;
        }
        throughput_before_ = throughput_;
    }

    // Rectangular lamps that the ray runs into. They are no geometry: the ray goes on behind them.
    void add_lamps_met(const Ray& ray, float limit) {
        if (diffuse_events_ == 0 && !scene_.show_lamps) return;
        for (std::size_t l = 0; l < scene_.lights.size(); ++l) {
            const RectangleShape* shape = scene_.scene.lights[l].rectangle();
            if (!shape) continue;
            const LightState& state = scene_.lights[l];
            const auto distance = intersect(*shape, state.position, ray.origin, ray.direction);
            if (!distance || *distance >= limit) continue;
            float weight = 1;
            if (diffuse_events_ > 0 && !specular_since_diffuse_) {
                const float cosine = -ray.direction.dot(shape->normal);
                weight = power_heuristic(density_, *distance * *distance / (cosine * shape->area()));
            }
            add(throughput_ * emitted_radiance(*shape, state.power) * weight,
                diffuse_events_ <= 1 && !specular_since_diffuse_);
        }
    }

    void add_lamps_sampled(const SurfacePoint& surface) {
        for (std::size_t l = 0; l < scene_.lights.size(); ++l) {
            const LampSample sample = sample_lamp(scene_, l, surface, random_);
            if (is_black(sample.irradiance_term)) continue;
            float weight = 1;
            if (sample.lamp_density > 0) {
                const float d = mean_channel(throughput_ * surface.diffuse),
                            s = mean_channel(throughput_ * surface.specular);
                const float share = d + s > 0 ? d / (d + s) : 1;
                weight = power_heuristic(sample.lamp_density,
                                         share * sample.towards.dot(surface.shading_normal) / kPi);
            }
            add(throughput_ * surface.diffuse * sample.irradiance_term * (weight / kPi),
                diffuse_events_ == 0);
        }
    }

    const PathScene& scene_;
    RandomStream& random_;
    Seen seen_;
    Rgb throughput_{1}, throughput_before_{1};
    int diffuse_events_ = 0;
    bool specular_since_diffuse_ = false;
    float density_ = 0;  // per solid angle, of the last diffuse event
};

}  // namespace

Seen path_radiance(const PathScene& scene, const Ray& ray, RandomStream& random) {
    return Path(scene, random).trace(ray);
}

bool point_lamps_meet_specular(const Scene& scene) {
    const bool point = std::ranges::any_of(scene.lights, [](const Light& l) { return !l.rectangle(); });
    return point && std::ranges::any_of(scene.geometry.triangles, [&](const Triangle& t) {
               const Material& m = scene.materials[t.material];
               return m.glass || !is_black(m.specular);
           });
}

}  // namespace pim
