// SPDX-License-Identifier: GPL-3.0-or-later
// Directions drawn from the distributions that light transport needs. Directions are unit vectors.
#pragma once

#include <cmath>

#include "common/core/random.h"
#include "common/core/vector.h"

namespace pim {

// Two unit vectors that complete the unit vector n to a right-handed orthonormal frame
// (Duff et al.: Building an Orthonormal Basis, Revisited, JCGT 2017).
struct Frame {
    Vec3 tangent, bitangent, normal;

    explicit Frame(const Vec3& n) : normal(n) {
        const float sign = std::copysign(1.0f, n.z);
        const float a = -1.0f / (sign + n.z);
        const float b = n.x * n.y * a;
        tangent = {1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x};
        bitangent = {b, sign + n.y * n.y * a, -n.y};
    }
    Vec3 to_world(const Vec3& v) const { return tangent * v.x + bitangent * v.y + normal * v.z; }
};

// Uniform over the sphere; density 1/(4 pi).
inline Vec3 sample_sphere(float u1, float u2) {
    const float z = 1.0f - 2.0f * u1;
    const float r = std::sqrt(std::max(0.0f, 1.0f - z * z));
    const float phi = 2.0f * kPi * u2;
    return {r * std::cos(phi), r * std::sin(phi), z};
}

// About +z with density cos(theta)/pi.
inline Vec3 sample_cosine_hemisphere(float u1, float u2) {
    const float r = std::sqrt(u1);
    const float phi = 2.0f * kPi * u2;
    return {r * std::cos(phi), r * std::sin(phi), std::sqrt(std::max(0.0f, 1.0f - u1))};
}

// k-th point of the d-dimensional additive recurrence on the generalised golden ratio, in [0,1)
// (M. Roberts: The Unreasonable Effectiveness of Quasirandom Sequences, 2018): `axis` < `dimensions` <= 3.
inline double golden_sequence(uint64_t k, int axis, int dimensions) {
    static constexpr double kRoot[4] = {0, 1.6180339887498949, 1.3247179572447460, 1.2207440846057596};
    const double step = std::pow(kRoot[dimensions], -double(axis + 1));
    const double x = 0.5 + step * double(k + 1);
    return x - std::floor(x);
}

// The same in two dimensions, without powers and with another start: for inner loops.
inline Imath::V2d golden_place(int64_t k) {
    const double x = (double(k) + 0.5) * 0.7548776662466927, y = (double(k) + 0.5) * 0.5698402909980532;
    return {x - std::floor(x), y - std::floor(y)};
}

}  // namespace pim
