// SPDX-License-Identifier: GPL-3.0-or-later
// What a baked file holds.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace pim {

// Keys: cells, patches, lights [{name, samples, boxes, terms, condition_number, components, facings}], bytes,
// residual {mean, p95, max} (W/m² per watt), left_out. Throws Error.
nlohmann::json map_info(const std::filesystem::path& map_file);
// The description that was baked, as text. Throws Error: no map.
std::string map_description(const std::filesystem::path& map_file);
std::string info_text(const nlohmann::json& info);

}  // namespace pim
