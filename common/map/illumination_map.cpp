// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/map/illumination_map.h"

#include <fmt/format.h>

#include "common/core/error.h"
#include "common/core/parallel.h"

namespace pim {
namespace {

constexpr std::size_t kBlock = 4096;

void add_box(const Polynomials& p, const std::array<float, kTermCount>& m, const Rgb& power,
             std::vector<Rgb>& sum) {
    const std::size_t terms = p.terms.size();
    parallel_for((sum.size() + kBlock - 1) / kBlock, [&](std::size_t block) {
        const std::size_t end = std::min(sum.size(), (block + 1) * kBlock);
        for (std::size_t patch = block * kBlock; patch < end; ++patch) {
            const float* a = &p.coefficients[patch * terms * 3];
            Rgb value(0);
            for (std::size_t t = 0; t < terms; ++t, a += 3) value += Rgb(a[0], a[1], a[2]) * m[p.terms[t]];
            sum[patch] += value * power;
        }
    });
}

std::size_t cut_negative(std::vector<Rgb>& values) {
    std::size_t cut = 0;
    for (Rgb& value : values)
        for (int c = 0; c < 3; ++c) {
            cut += value[c] < 0;
            value[c] = std::max(value[c], 0.0f);
        }
    return cut;
}

}  // namespace

bool IlluminationMap::has(Component component) const {
    return std::ranges::find(components, component) != components.end();
}

void check_in_domain(const std::string& light, const Box3& domain, const Vec3& position,
                     const Vec3d& origin) {
    float largest = 0;
    for (int axis = 0; axis < 3; ++axis)
        largest = std::max({largest, std::abs(domain.min[axis]), std::abs(domain.max[axis])});
    const float rounding = 1e-5f * (domain.max - domain.min).length() + 0x1p-21f * largest;
    for (int axis = 0; axis < 3; ++axis)
        if (!(position[axis] >= domain.min[axis] - rounding &&
              position[axis] <= domain.max[axis] + rounding)) {
            const Vec3d p = Vec3d(position) + origin, a = Vec3d(domain.min) + origin,
                        b = Vec3d(domain.max) + origin;
            throw UsageError(
                fmt::format("light '{}' at {:.6g},{:.6g},{:.6g} is outside its domain: the map knows it "
                            "from {:.6g},{:.6g},{:.6g} to {:.6g},{:.6g},{:.6g}",
                            light, p.x, p.y, p.z, a.x, a.y, a.z, b.x, b.y, b.z));
        }
}

Vec3d clamped(const Box3& domain, const Vec3& position) {
    Vec3d inside(position);
    for (int axis = 0; axis < 3; ++axis)
        inside[axis] = std::clamp(inside[axis], double(domain.min[axis]), double(domain.max[axis]));
    return inside;
}

std::vector<Rgb> patch_irradiance(const IlluminationMap& map, const std::vector<Component>& components,
                                  const std::vector<LightState>& lights, std::size_t* cut) {
    std::vector<Rgb> sum(map.patches.size(), Rgb(0));
    for (std::size_t l = 0; l < lights.size(); ++l) {
        const MapLight& light = map.lights[l];
        check_in_domain(light.name, light.domain, lights[l].position, map.origin);
        const Vec3d position = clamped(light.domain, lights[l].position);
        const std::vector<double> weights = box_weights(light.boxes, position);
        for (std::size_t b = 0; b < light.boxes.size(); ++b) {
            if (!(weights[b] > 0)) continue;
            const auto m = monomials(Vec3(light.boxes[b].normalised(position)));
            for (const Component c : components)
                if (const auto& polynomials = light.polynomials[b][int(c)])
                    add_box(*polynomials, m, lights[l].power * float(weights[b]), sum);
        }
    }
    const std::size_t negative = map.mend_signs ? cut_negative(sum) : 0;
    if (cut) *cut = negative;
    return sum;
}

}  // namespace pim
