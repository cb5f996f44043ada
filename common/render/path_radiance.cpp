// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/render/path_radiance.h"

#include <cmath>

#include "common/transport/scattering.h"

namespace pim {
namespace {

constexpr int kAlwaysSurvives = 3;  // surfaces before Russian roulette starts
constexpr int kLongestPath = 1000;

float power_heuristic(float own, float other) {
    if (!(own > 0)) return 0;
    const float ratio = other / own;
    return 1 / (1 + ratio * ratio);
}

struct LampSample {
    Rgb irradiance_term{0};  // contribution to outgoing radiance, before reflectance / pi
    float lamp_density = 0;  // per solid angle; 0 for a point lamp, which no ray can meet
    float sent_density = 0;  // per area of the surface, of light sent from the same place on the lamp
    Vec3 towards;
};

// Of a surface at this distance, from a density per solid angle.
float density_per_area(float density, float cosine, float distance) {
    const float square = distance * distance;
    return square > 0 ? density * std::max(0.0f, cosine) / square : 0;
}

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
    sample.sent_density = density_per_area(rectangle ? lamp_cosine / kPi : 1 / (4 * kPi),
                                           sample.towards.dot(surface.geometric_normal), distance);
    if (!rectangle) {
        sample.irradiance_term = state.power * (cosine * inverse_square / (4 * kPi));
        return sample;
    }
    sample.lamp_density = 1 / (inverse_square * lamp_cosine * rectangle->area());
    sample.irradiance_term = emitted_radiance(*rectangle, state.power) * (cosine / sample.lamp_density);
    return sample;
}

// Where light sent from a lamp lands first, as if all of the lamp's had been sent there.
struct SentLight {
    SurfacePoint surface;
    Rgb radiosity;      // W: flux · reflectance
    float density = 0;  // of landing there, per area
};

std::optional<SentLight> send_light(const PathScene& s, std::size_t l, RandomStream& random) {
    const Light& light = s.scene.lights[l];
    const Emission start = sample_emission(light, s.lights[l].position, random);
    const auto hit = s.caster.intersect({start.origin, start.direction});
    if (!hit) return std::nullopt;
    const SurfacePoint surface = surface_at(s.scene, *hit);
    const RectangleShape* rectangle = light.rectangle();
    const float density = rectangle ? start.direction.dot(rectangle->normal) / kPi : 1 / (4 * kPi);
    return SentLight{
        surface, s.lights[l].power * surface.diffuse * landing_factor(surface, start.direction),
        density_per_area(density, -start.direction.dot(surface.geometric_normal), hit->distance)};
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
            if (length == 0) begin_at(ray, hit->distance, surface);
            arrive(ray, hit->distance, surface);
            const float survival = length < kAlwaysSurvives ? 1 : survival_probability(surface, throughput_);
            const auto scattered =
                scatter(surface, ray.direction, throughput_, survival, Transport::from_eye, random_);
            if (!is_black(surface.diffuse)) {
                add_lamps_sampled(surface);
                add_light_sent(surface);
            }
            if (!scattered || !(scattered->correction > 0)) break;
            throughput_ *= scattered->weight * scattered->correction;
            note_event(*scattered, surface);
            if (length == 0) first_is_diffuse_ = scattered->event == Event::diffuse;
            ray = {surface.leave(scattered->direction, scene_.caster.surface_offset()), scattered->direction};
        }
        return seen_;
    }

  private:
    void add(const Rgb& radiance, bool straight_to_first_diffuse) {
        seen_.total += radiance;
        if (!straight_to_first_diffuse) seen_.indirect += radiance;
    }

    void begin_at(const Ray& ray, float distance, const SurfacePoint& surface) {
        seen_.surface = true;
        eye_distance_ = distance;
        eye_cosine_ = -ray.direction.dot(surface.geometric_normal);
    }

    bool comes_from_diffuse() const { return diffuse_events_ > 0 && !specular_since_diffuse_; }

    void arrive(const Ray& ray, float distance, const SurfacePoint& surface) {
        last_normal_ = surface.geometric_normal;
        gathered_density_ =
            comes_from_diffuse()
                ? density_per_area(density_, -ray.direction.dot(surface.geometric_normal), distance)
                : 0;
    }

    // Of scattering, where a mirror and a diffuse surface share a place.
    float diffuse_share(const SurfacePoint& surface, const Rgb& throughput) const {
        const float d = mean_channel(throughput * surface.diffuse);
        const float s = mean_channel(throughput * surface.specular);
        return d + s > 0 ? d / (d + s) : 1;
    }

    // The same light is found from the surface before, where lamps send it: what is left for the other ways.
    float not_sent(float sent) const {
        return gathered_density_ > 0 ? power_heuristic(gathered_density_, sent) : 1;
    }

    void note_event(const Scattered& scattered, const SurfacePoint& surface) {
        if (scattered.event == Event::diffuse) {
            ++diffuse_events_;
            density_ = std::max(0.0f, scattered.direction.dot(surface.shading_normal)) / kPi *
                       diffuse_share(surface, throughput_before_);
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
            if (first_is_diffuse_ && specular_since_diffuse_)
                weight -= light_image_share(scene_, l, eye_distance_, eye_cosine_);
            if (comes_from_diffuse()) {
                const float cosine = -ray.direction.dot(shape->normal);
                weight = power_heuristic(density_, *distance * *distance / (cosine * shape->area())) *
                         not_sent(density_per_area(cosine / kPi, ray.direction.dot(last_normal_), *distance));
            }
            add(throughput_ * emitted_radiance(*shape, state.power) * weight,
                diffuse_events_ <= 1 && !specular_since_diffuse_);
        }
    }

    void add_lamps_sampled(const SurfacePoint& surface) {
        for (std::size_t l = 0; l < scene_.lights.size(); ++l) {
            const LampSample sample = sample_lamp(scene_, l, surface, random_);
            if (is_black(sample.irradiance_term)) continue;
            float weight = not_sent(sample.sent_density);
            if (sample.lamp_density > 0)
                weight *= power_heuristic(
                    sample.lamp_density,
                    diffuse_share(surface, throughput_) * sample.towards.dot(surface.shading_normal) / kPi);
            add(throughput_ * surface.diffuse * sample.irradiance_term * (weight / kPi),
                diffuse_events_ == 0);
        }
    }

    // What lamps send to other surfaces and these to this one.
    void add_light_sent(const SurfacePoint& surface) {
        if (sent_.empty())
            for (std::size_t l = 0; l < scene_.lights.size(); ++l)
                sent_.push_back(send_light(scene_, l, random_));
        for (const auto& sent : sent_)
            if (sent && !is_black(sent->radiosity))
                add(throughput_ * surface.diffuse * irradiance_from(*sent, surface) / kPi, false);
    }

    Rgb irradiance_from(const SentLight& sent, const SurfacePoint& surface) const {
        const Vec3 path = sent.surface.position - surface.position;
        const float distance = path.length();
        if (!(distance > 0)) return Rgb(0);
        const Vec3 towards = path / distance;
        const float cosine = towards.dot(surface.shading_normal);
        if (cosine <= 0 || towards.dot(surface.geometric_normal) <= 0) return Rgb(0);
        const float cosine_there = -towards.dot(sent.surface.geometric_normal);
        const float density = density_per_area(cosine / kPi, cosine_there, distance);
        if (density <= 0 || !see_each_other(surface, sent.surface, towards)) return Rgb(0);
        return sent.radiosity * density *
               power_heuristic(sent.density, diffuse_share(surface, throughput_) * density);
    }

    bool see_each_other(const SurfacePoint& a, const SurfacePoint& b, const Vec3& towards) const {
        const float offset = scene_.caster.surface_offset();
        const Vec3 origin = a.leave(towards, offset), path = b.leave(-towards, offset) - origin;
        const float distance = path.length();
        return path.dot(towards) > 0 && !scene_.caster.occluded({origin, path / distance, distance});
    }

    const PathScene& scene_;
    RandomStream& random_;
    std::vector<std::optional<SentLight>> sent_;  // [lamp]
    Seen seen_;
    Rgb throughput_{1}, throughput_before_{1};
    int diffuse_events_ = 0;
    bool specular_since_diffuse_ = false;
    float density_ = 0;           // per solid angle, of the last diffuse event
    float gathered_density_ = 0;  // per area, of the last surface; 0 if not found by a diffuse event
    Vec3 last_normal_{0};
    float eye_distance_ = 0, eye_cosine_ = 0;  // of the first surface
    bool first_is_diffuse_ = false;            // the first event
};

}  // namespace

Seen path_radiance(const PathScene& scene, const Ray& ray, RandomStream& random) {
    return Path(scene, random).trace(ray);
}

float light_image_share(const PathScene& scene, std::size_t light, float distance, float cosine) {
    const RectangleShape* rectangle = scene.scene.lights[light].rectangle();
    if (!rectangle) return 1;
    return power_heuristic(scene.image_photons * distance * distance,
                           rectangle->area() * std::max(0.0f, cosine));
}

bool lamps_meet_specular(const Scene& scene) {
    return !scene.lights.empty() && std::ranges::any_of(scene.geometry.triangles, [&](const Triangle& t) {
        const Material& m = scene.materials[t.material];
        return m.glass || !is_black(m.specular);
    });
}

bool point_lamps_meet_specular(const Scene& scene) {
    return std::ranges::any_of(scene.lights, [](const Light& l) { return !l.rectangle(); }) &&
           lamps_meet_specular(scene);
}

}  // namespace pim
