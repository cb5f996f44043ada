// SPDX-License-Identifier: GPL-3.0-or-later
// Error against settings: bakes and evaluates a scene for every combination of some settings' values.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bake/evaluate.h"

namespace pim {

// "photons=10000,20000" or "boxes=[1,1,1],[2,1,2]": a setting (see table_of_setting) and its values.
struct Axis {
    std::string key;
    std::vector<std::string> values;
};
Axis parse_axis(const std::string& text);  // throws UsageError

struct SweepOptions {
    std::vector<Axis> axes;
    std::filesystem::path folder;  // maps and results are kept here; what is there already is not done again
    EvaluateOptions evaluate;
};

// A list of {settings, map, cells, patches, bytes, photons_total, trace_seconds, fit_seconds, peak_rss_bytes}
// and all that Evaluator says, the last axis fastest. Throws UsageError and Error.
nlohmann::json sweep(const std::filesystem::path& description, const SweepOptions& options);
std::string sweep_text(const nlohmann::json& results);

}  // namespace pim
