// SPDX-License-Identifier: GPL-3.0-or-later
// The error of a map against path tracing, at lamp positions that the fit never saw.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace pim {

struct EvaluateOptions {
    int lights = 16;    // unseen lamp positions, uniform in the domains (all lamps at once)
    int pixels = 2000;  // per position, stratified over all cameras
    int paths = 256;    // reference paths per pixel, in two independent halves R1, R2
    std::optional<std::filesystem::path> geometry;
};

// relrmse = ||I - R|| / ||R|| over surface pixels in linear RGB radiance. The squared error is estimated by
// <I - R1, I - R2>, which the reference's noise does not bias. Keys: relrmse, relrmse_indirect, relrmse_p95,
// relrmse_per_position, reference_noise, confidence (half widths at 95 %), bake_seconds, frame_seconds,
// notes.
nlohmann::json evaluate_map(const std::filesystem::path& map_file, const EvaluateOptions& options);
std::string evaluation_text(const nlohmann::json& evaluation);

}  // namespace pim
