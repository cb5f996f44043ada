// SPDX-License-Identifier: GPL-3.0-or-later
// The second half of a bake that chooses for itself: in rounds, more lamp positions, boxes where the
// polynomial asks for them, and the degree. Cells and photons per position stay as they are, so that every
// volume traced counts to the end.
#pragma once

#include "bake/choose_cells.h"
#include "bake/work_folder.h"

namespace pim {

constexpr double kMostPhotonsInAll = 4e9;  // without a time budget

// Terms of a cubic over one box of the lamp that moves most.
int terms_of_cubic(const Scene& scene);
// Of one lamp, after the rounds that are usual.
double planned_positions(const Light& light);

// `settings`: given and chosen so far. Traces into the work folder, looks at no clock without a time budget.
// Returns what was chosen.
std::vector<Setting> choose_lamps(const Scene& scene, const std::vector<Setting>& settings, const Goal& goal,
                                  HeldOut& held_out, CellChoice cells, double photon_seconds,
                                  const Workplace& place);

}  // namespace pim
