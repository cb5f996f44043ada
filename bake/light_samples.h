// SPDX-License-Identifier: GPL-3.0-or-later
// Where a lamp is put to learn how the light follows it.
#pragma once

#include <vector>

#include "common/map/map_box.h"
#include "common/scene/geometry_check.h"
#include "common/scene/light.h"

namespace pim {

struct LightSample {
    int light;      // index into Scene::lights
    int number;     // within that light, from 0
    Vec3 position;  // local, m
};

// A regular grid over the domain, or well-spread positions: group by group, in each the boxes in turn, in
// each box a low-discrepancy sequence with arcsine density per axis, as Chebyshev nodes have, which keeps the
// fit well conditioned. The first n of a longer list are the list of n, whether its last group grew or one
// was added. Positions inside solids are left out; `inside` gets a sentence for each solid.
std::vector<LightSample> light_samples(const Light& light, int light_number, const Solids& solids,
                                       std::vector<std::string>& inside);

// Of a lamp whose samples are no grid.
std::vector<SampleGroup> sample_groups(const Light& light);

}  // namespace pim
