// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/map/map_box.h"

#include <cmath>

namespace pim {
namespace {

constexpr double kRounding = 1e-6;

double ramp(double distance, double width) {
    if (width <= 0) return distance >= -kRounding ? 1 : 0;
    const double t = std::clamp(distance / width, 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

}  // namespace

Vec3d MapBox::normalised(const Vec3d& light) const {
    Vec3d u;
    for (int axis = 0; axis < 3; ++axis)
        u[axis] = half[axis] > 0 ? std::clamp((light[axis] - centre[axis]) / half[axis], -1.0, 1.0) : 0.0;
    return u;
}

bool MapBox::contains(const Vec3d& light) const {
    for (int axis = 0; axis < 3; ++axis)
        if (half[axis] > 0 && std::abs(light[axis] - centre[axis]) > half[axis] * (1 + kRounding))
            return false;
    return true;
}

double MapBox::weight(const Vec3d& light) const {
    if (!contains(light)) return 0;
    double product = 1;
    for (int axis = 0; axis < 3; ++axis) {
        if (overlap_low[axis] > 0)
            product *= ramp(light[axis] - (centre[axis] - half[axis]), overlap_low[axis]);
        if (overlap_high[axis] > 0)
            product *= ramp(centre[axis] + half[axis] - light[axis], overlap_high[axis]);
    }
    return product;
}

std::vector<MapBox> split_domain(const Box3& domain, const Index3& divisions) {
    std::vector<MapBox> boxes;
    Index3 k;
    for (k.x = 0; k.x < divisions.x; ++k.x)
        for (k.y = 0; k.y < divisions.y; ++k.y)
            for (k.z = 0; k.z < divisions.z; ++k.z) {
                MapBox box;
                for (int axis = 0; axis < 3; ++axis) {
                    const double low = domain.min[axis],
                                 width = (double(domain.max[axis]) - low) / divisions[axis];
                    const double overlap = kOverlap * width;
                    const bool first = k[axis] == 0, last = k[axis] == divisions[axis] - 1;
                    box.overlap_low[axis] = first ? 0 : overlap;
                    box.overlap_high[axis] = last ? 0 : overlap;
                    const double from = low + width * k[axis] - 0.5 * box.overlap_low[axis];
                    const double to = low + width * (k[axis] + 1) + 0.5 * box.overlap_high[axis];
                    box.centre[axis] = 0.5 * (from + to);
                    box.half[axis] = 0.5 * (to - from);
                }
                boxes.push_back(box);
            }
    return boxes;
}

std::vector<double> box_weights(const std::vector<MapBox>& boxes, const Vec3d& light) {
    std::vector<double> weights;
    double sum = 0;
    for (const MapBox& box : boxes) sum += weights.emplace_back(box.weight(light));
    for (double& w : weights) w = sum > 0 ? w / sum : 0;
    return weights;
}

}  // namespace pim
