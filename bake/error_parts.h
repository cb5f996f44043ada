// SPDX-License-Identifier: GPL-3.0-or-later
// Where a map's error comes from, by controlled experiment: pictures of the same pixels, in each of which one
// cause of error is gone, down to the reference.
//
//     map           as it is
//     other photons the mean of maps baked likewise from other random numbers: no noise
//     own volume    a density volume for the very lamp position instead of polynomials: no misfit of those
//     what is seen  the same photons, but only those that landed where the surface looked at can see them
//     reference     path tracing: no cells
//
// The steps between them are the parts: noise, polynomial, leak, grid. Each experiment is made twice with
// independent random numbers, a and b; with d_j the steps of a pixel, the shares G_jk = <d_j(a), d_k(b)> are
// free of the experiments' own noise in expectation, and sum to <map - reference(a), map - reference(b)>, the
// squared error, exactly. One sample of the noise in each experiment remains: a part scatters by the noise's
// square over the root of the number of patches in view.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "bake/evaluate.h"

namespace pim {

struct ErrorPartsOptions {
    EvaluateOptions evaluate;
    int photons = 16;                               // of an own volume, times those of the bake per position
    std::optional<std::filesystem::path> pictures;  // a folder for the first position's pictures
};

// Keys: parts (names), relative_squares (matrix G over ||reference||², mean of all positions and cameras),
// confidence (half widths of its diagonal at 95 %), relative_square (their sum), relrms (of each part alone),
// worst (pixels: position, camera, place, material, lamp_distance, map, reference, steps), seconds. Throws
// Error: no map, geometry changed, cells that are not this version's.
nlohmann::json error_parts(const std::filesystem::path& map_file, const ErrorPartsOptions& options);
std::string error_parts_text(const nlohmann::json& parts);

}  // namespace pim
