// SPDX-License-Identifier: GPL-3.0-or-later
// A bake that chooses for itself: cells, photons, lamp positions, boxes and degree for an error or a time.
//
// It measures its error at lamp positions of its own that stay out of the fit (see held_out.h), tells grid,
// polynomial and noise apart, and spends on the largest. First the cells, by photons of those positions;
// then, in rounds, more lamp positions, and boxes where the polynomial asks for them. Photons per position
// and cells stay as they are from then on, so that every volume traced counts to the end.
#pragma once

#include "bake/work_folder.h"
#include "common/core/stopwatch.h"
#include "common/scene/scene_file.h"

namespace pim {

// Traces into the work folder and returns all settings for the bake that ends it: `given` and what was
// chosen, written so that the description holds no open choice any more. With a target error alone, looks at
// no clock; a time budget runs since `begun`.
std::vector<Setting> choose_settings(Scene scene, const std::vector<Setting>& given, const Workplace& place,
                                     const Stopwatch& begun);

}  // namespace pim
