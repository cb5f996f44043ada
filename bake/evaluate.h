// SPDX-License-Identifier: GPL-3.0-or-later
// The error of a map against path tracing, at lamp positions that the fit never saw.
#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "common/render/photon_radiance.h"

namespace pim {

class Reference;

struct EvaluateOptions {
    int lights = 16;    // unseen lamp positions, uniform in the domains (all lamps at once)
    int pixels = 2000;  // per position, stratified over all cameras
    int paths = 256;    // reference paths per pixel, in two independent halves R1, R2
    std::optional<std::filesystem::path> geometry;
};

// What is held against the reference: the map, or another way to light its scene.
enum class Contestant { map, photon_map, whitted };
struct Contest {
    Contestant contestant = Contestant::map;
    PhotonMapOptions photon_map = {};
};

// Evaluates maps one after the other; what was traced for one serves the next of the same scene.
class Evaluator {
  public:
    explicit Evaluator(EvaluateOptions options);
    ~Evaluator();
    // relrmse = ||I - R|| / ||R|| over surface pixels in linear RGB radiance. The squared error is estimated
    // by <I - R1, I - R2>, which the reference's noise does not bias. Keys: relrmse, relrmse_indirect,
    // relrmse_p95, relrmse_per_position, reference_noise, confidence (half widths at 95 %), bake_seconds,
    // frame_seconds, notes. Throws Error: no map, geometry missing or changed.
    nlohmann::json evaluate(const std::filesystem::path& map_file, const Contest& contest = {});

  private:
    EvaluateOptions options_;
    std::unique_ptr<Reference> reference_;
    std::string reference_key_;
};

std::string evaluation_text(const nlohmann::json& evaluation);

}  // namespace pim
