// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/domain_divisions.h"

#include <algorithm>

namespace pim {
namespace {

constexpr int kMostBoxes = 16;  // per axis
constexpr int kMostBoxesInAll = 512;

}  // namespace

double count_of(const Index3& boxes) { return double(boxes.x) * boxes.y * boxes.z; }

std::vector<Index3> other_divisions(const Light& light) {
    std::vector<Index3> others;
    if (!light.choose_boxes) return others;
    for (int axis = 0; axis < 3; ++axis) {
        if (!(light.domain.max[axis] > light.domain.min[axis])) continue;
        for (const int step : {1, -1, light.boxes[axis]}) {
            Index3 boxes = light.boxes;
            boxes[axis] += step;
            if (boxes[axis] < 1 || boxes[axis] > kMostBoxes || count_of(boxes) > kMostBoxesInAll) continue;
            if (std::ranges::find(others, boxes) == others.end()) others.push_back(boxes);
        }
    }
    return others;
}

}  // namespace pim
