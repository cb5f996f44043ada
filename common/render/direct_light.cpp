// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/render/direct_light.h"

#include <cmath>

namespace pim {
namespace {

// Cosine at the surface over squared distance towards `target`; 0 in shadow or from behind. `towards` gets
// the unit direction to the target.
float geometry_term(const RayCaster& caster, const SurfacePoint& s, const Vec3& target, Vec3& towards) {
    const Vec3 path = target - s.position;
    const float distance = path.length();
    if (!(distance > 0)) return 0;
    towards = path / distance;
    const float cosine = towards.dot(s.shading_normal);
    if (towards.dot(s.geometric_normal) <= 0 || cosine <= 0) return 0;
    const Vec3 origin = s.leave(towards, caster.surface_offset());
    const Vec3 rest = target - origin;
    const float length = rest.length();
    if (!(length > 0) || caster.occluded({origin, rest / length, length})) return 0;
    return cosine / (distance * distance);
}

}  // namespace

Rgb direct_irradiance(const RayCaster& caster, const Light& light, const LightState& state,
                      const SurfacePoint& surface, int samples, RandomStream& random) {
    Vec3 towards;
    const RectangleShape* rectangle = light.rectangle();
    if (!rectangle)  // E = (power / 4 pi) cos / d²
        return state.power * (geometry_term(caster, surface, state.position, towards) / (4 * kPi));
    const int rows = std::max(1, int(std::lround(std::sqrt(float(samples))))),
              columns = (samples + rows - 1) / rows;
    const float u = random.next(), v = random.next();
    float sum = 0;
    for (int i = 0; i < rows; ++i)
        for (int j = 0; j < columns; ++j) {
            const float a = (float(i) + u) / float(rows) - 0.5f, b = (float(j) + v) / float(columns) - 0.5f;
            const Vec3 target = state.position + rectangle->axes[0] * (a * rectangle->size.x) +
                                rectangle->axes[1] * (b * rectangle->size.y);
            const float term = geometry_term(caster, surface, target, towards);
            if (term > 0) sum += term * std::max(0.0f, -towards.dot(rectangle->normal));
        }
    // E = L A mean(cos cos' / d²), L A = power / pi
    return state.power * (sum / (kPi * float(rows * columns)));
}

Rgb direct_irradiance(const RayCaster& caster, const std::vector<Light>& lights,
                      const std::vector<LightState>& states, const SurfacePoint& surface, int samples,
                      RandomStream& random) {
    Rgb sum(0);
    for (std::size_t l = 0; l < lights.size(); ++l)
        sum += direct_irradiance(caster, lights[l], states[l], surface, samples, random);
    return sum;
}

}  // namespace pim
