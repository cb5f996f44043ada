// SPDX-License-Identifier: GPL-3.0-or-later
// The words that files and the command line use for what is shown and how.
#pragma once

#include <string>
#include <vector>

#include "viewer/view_state.h"

namespace pim {

// In the order of the enumerators.
const std::vector<std::string>& view_names();          // radiance, irradiance, ...
const std::vector<std::string>& direct_light_names();  // none, traced, baked
const std::vector<std::string>& tone_curve_names();    // none, reinhard, aces

const std::string& name(View view);
const std::string& name(DirectLight direct);
const std::string& name(ToneCurve curve);

// Throw UsageError naming `option` and what is allowed.
View parse_view(const std::string& text, const std::string& option = "--view");
DirectLight parse_direct_light(const std::string& text, const std::string& option = "--direct");
ToneCurve parse_tone_curve(const std::string& text, const std::string& option = "--tone-curve");

}  // namespace pim
