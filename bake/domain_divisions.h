// SPDX-License-Identifier: GPL-3.0-or-later
// Divisions of a lamp's domain into boxes.
#pragma once

#include <vector>

#include "common/scene/light.h"

namespace pim {

double count_of(const Index3& boxes);

// Those to try next: one box more or fewer along an axis on which the lamp moves, or twice as many. None
// where the boxes are given.
std::vector<Index3> other_divisions(const Light& light);

}  // namespace pim
