// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/light_samples.h"

#include <fmt/format.h>

#include <cmath>
#include <map>

#include "common/core/sampling.h"

namespace pim {
namespace {

constexpr double kTau = 6.283185307179586;

// k-th position in a box; `shift` decorrelates the boxes.
Vec3d spread_position(const MapBox& box, uint64_t k, double shift) {
    const auto moves = box.moves();
    const int dimensions = int(moves[0]) + int(moves[1]) + int(moves[2]);
    Vec3d position = box.centre;
    for (int axis = 0, dimension = 0; axis < 3; ++axis) {
        if (!moves[axis]) continue;
        double t = golden_sequence(k, dimension++, dimensions) + shift;
        t -= std::floor(t);
        position[axis] += box.half[axis] * -std::cos(0.5 * kTau * t);  // arcsine density
    }
    return position;
}

std::vector<Vec3d> spread_positions(const Light& light, const std::vector<SampleGroup>& groups) {
    std::vector<Vec3d> positions;
    for (std::size_t g = 0; g < groups.size(); ++g) {
        const auto boxes = split_domain(light.domain, groups[g].boxes);
        for (int i = 0; i < groups[g].count; ++i) {
            const std::size_t b = std::size_t(i) % boxes.size();
            const double shift = 0.6180339887 * double(b) + 0.7548776662 * double(g);
            positions.push_back(spread_position(boxes[b], uint64_t(i) / boxes.size(), shift));
        }
    }
    return positions;
}

std::vector<Vec3d> grid_positions(const Light& light, const Index3& count) {
    std::vector<Vec3d> positions;
    const Vec3d low(light.domain.min), size = Vec3d(light.domain.max) - low;
    const auto place = [&](int i, int axis) {
        return low[axis] + size[axis] * (count[axis] > 1 ? double(i) / (count[axis] - 1) : 0.5);
    };
    const auto moving = [&](int axis) { return size[axis] > 0 ? count[axis] : 1; };
    for (int x = 0; x < moving(0); ++x)
        for (int y = 0; y < moving(1); ++y)
            for (int z = 0; z < moving(2); ++z) positions.push_back({place(x, 0), place(y, 1), place(z, 2)});
    return positions;
}

}  // namespace

std::vector<SampleGroup> sample_groups(const Light& light) {
    const int* count = std::get_if<int>(&light.samples);
    if (count) return {{light.boxes, *count}};
    return std::get<std::vector<SampleGroup>>(light.samples);
}

std::vector<LightSample> light_samples(const Light& light, int light_number, const Solids& solids,
                                       std::vector<std::string>& inside) {
    const auto* grid = std::get_if<Index3>(&light.samples);
    const auto positions =
        grid ? grid_positions(light, *grid) : spread_positions(light, sample_groups(light));
    std::vector<LightSample> samples;
    std::map<std::string, int> lost;
    for (std::size_t i = 0; i < positions.size(); ++i) {
        const Vec3 position(positions[i]);
        if (const std::string solid = solids.containing(position); !solid.empty())
            ++lost[solid];
        else
            samples.push_back({light_number, int(i), position});
    }
    for (const auto& [solid, n] : lost)
        inside.push_back(fmt::format("light '{}': {} of {} positions lie inside '{}' and are left out",
                                     light.name, n, positions.size(), solid));
    return samples;
}

}  // namespace pim
