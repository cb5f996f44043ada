// SPDX-License-Identifier: GPL-3.0-or-later
// What a bake would do and cost, before it is done.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "common/scene/scene_file.h"

namespace pim {

// Keys: grid, cells, patches, light_samples, photons_total, rays_per_photon, memory_bytes, disk_bytes,
// seconds_estimate, left_out, warnings. Traces a few photons to know their speed. Throws Error.
nlohmann::json plan_bake(const std::filesystem::path& description, const std::vector<Setting>& settings = {});
std::string plan_text(const nlohmann::json& plan);

}  // namespace pim
