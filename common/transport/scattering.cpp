// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/transport/scattering.h"

#include <cmath>

#include "common/core/sampling.h"

namespace pim {
namespace {

// Veach's factor for delta scattering of flux with shading normals: |wi·ns| |wo·ng| / (|wi·ng| |wo·ns|).
float flux_correction(const SurfacePoint& s, const Vec3& in, const Vec3& out) {
    const float below = std::abs(in.dot(s.geometric_normal) * out.dot(s.shading_normal));
    return below > 0 ? std::abs(in.dot(s.shading_normal) * out.dot(s.geometric_normal)) / below : 0.0f;
}

std::optional<Scattered> scatter_at_glass(const SurfacePoint& s, const Vec3& in, Transport transport,
                                          RandomStream& random) {
    const GlassSplit split = split_at_glass(s, in);
    const bool reflects = random.next() < split.reflected_share;
    const Vec3 out = reflects ? split.reflected : split.refracted;
    float correction = 1;
    if ((out.dot(s.geometric_normal) > 0) != reflects)
        correction = 0;  // a shading normal's leak
    else if (transport == Transport::from_lamp)
        correction = flux_correction(s, in, out);
    // Radiance scales with the square of the index it travels in.
    else if (!reflects)
        correction = 1 / (split.relative_ior * split.relative_ior);
    return Scattered{Event::specular, out, Rgb(1), correction};
}

}  // namespace

float fresnel_reflectance(float cosine, float relative_ior) {
    const float sin2 = (1 - cosine * cosine) / (relative_ior * relative_ior);
    if (sin2 >= 1) return 1;
    const float transmitted = std::sqrt(1 - sin2);
    const float parallel = (relative_ior * cosine - transmitted) / (relative_ior * cosine + transmitted);
    const float perpendicular = (cosine - relative_ior * transmitted) / (cosine + relative_ior * transmitted);
    return 0.5f * (parallel * parallel + perpendicular * perpendicular);
}

Vec3 mirror(const Vec3& incoming, const Vec3& normal) {
    return incoming - normal * (2 * incoming.dot(normal));
}

GlassSplit split_at_glass(const SurfacePoint& s, const Vec3& incoming) {
    const Vec3& n = incoming.dot(s.shading_normal) < 0 ? s.shading_normal : s.geometric_normal;
    const float ior = s.material->ior;
    const float relative = s.side == Side::front ? ior : 1 / ior;
    const float cosine = std::min(1.0f, -incoming.dot(n));
    const float sin2 = (1 - cosine * cosine) / (relative * relative);
    const Vec3 refracted =
        sin2 < 1 ? incoming / relative + n * (cosine / relative - std::sqrt(1 - sin2)) : Vec3(0);
    return {fresnel_reflectance(cosine, relative), mirror(incoming, n), refracted.normalized(), relative};
}

float landing_factor(const SurfacePoint& s, const Vec3& incoming) {
    if (s.shading_normal == s.geometric_normal) return 1;
    const float landed = -incoming.dot(s.geometric_normal);
    return landed > 0 ? std::max(0.0f, -incoming.dot(s.shading_normal)) / landed : 0.0f;
}

float survival_probability(const SurfacePoint& s, const Rgb& throughput) {
    if (s.material->glass) return 1;
    const float most = max_channel(throughput);
    return most > 0 ? std::min(1.0f, max_channel(throughput * (s.diffuse + s.specular)) / most) : 0.0f;
}

std::optional<Scattered> scatter(const SurfacePoint& s, const Vec3& in, const Rgb& throughput, float survival,
                                 Transport transport, RandomStream& random) {
    if (s.material->glass) return scatter_at_glass(s, in, transport, random);
    const float u = random.next();
    if (u >= survival) return std::nullopt;
    const float diffuse = mean_channel(throughput * s.diffuse),
                specular = mean_channel(throughput * s.specular);
    if (!(diffuse + specular > 0)) return std::nullopt;
    const float diffuse_share = diffuse / (diffuse + specular);
    if (u < survival * diffuse_share) {
        // Gathered light counts with the shading normal's cosine; sent light leaves with the geometric one's.
        const Vec3& about = transport == Transport::from_eye ? s.shading_normal : s.geometric_normal;
        const float u1 = random.next(), u2 = random.next();
        const Vec3 out = Frame(about).to_world(sample_cosine_hemisphere(u1, u2));
        const float correction = out.dot(s.geometric_normal) > 0 ? 1.0f : 0.0f;
        return Scattered{Event::diffuse, out, s.diffuse / (survival * diffuse_share), correction};
    }
    const Vec3 out = mirror(in, s.shading_normal);
    float correction = out.dot(s.geometric_normal) > 0 ? 1.0f : 0.0f;
    // landing_factor has scaled sent light by |wi·ns|/|wi·ng|; the rest of Veach's factor is |wo·ng|/|wo·ns|.
    if (transport == Transport::from_lamp && s.shading_normal != s.geometric_normal)
        correction *= out.dot(s.geometric_normal) / std::max(out.dot(s.shading_normal), 1e-6f);
    return Scattered{Event::specular, out, s.specular / (survival * (1 - diffuse_share)), correction};
}

}  // namespace pim
