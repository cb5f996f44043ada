// SPDX-License-Identifier: GPL-3.0-or-later
// Some patches' densities over all lamp positions, as traced and as fitted.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace pim {

// For each lamp and component `count` patches: the worst by residual over mean, then others at even ranks of
// that ratio down to the median. A list of {light, component, patch, cell, facing, centre (world, m), mean,
// residual, samples: [{position (world, m), measured, fitted}]}; values are means of the channels, W/m² per
// watt. Needs the work folder beside the map. Throws Error: it is gone, or is another bake's.
nlohmann::json fit_samples(const std::filesystem::path& map_file, int count);
std::string fit_samples_text(const nlohmann::json& samples);

}  // namespace pim
