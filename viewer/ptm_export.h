// SPDX-License-Identifier: GPL-3.0-or-later
// A view as a polynomial texture map, a rival of the illumination map that keeps a picture in place of the
// scene; and its error, measured as the map's is.
//
// The pictures are exposed alike, sRGB encoded, and cut at white, as photographs are. Automatic exposure fits
// the brightest that each pixel gets with the lamp in the corners and the middle of the square of (u, v).
// JSON keys:
//
//     lamp, u, v             the lamp; for u = -1 and 1, v = -1 and 1: {axis, from, to}, world, m
//     width, height, bytes   of the file
//     exposure               stops
//     lamp_positions         pictures that it was fitted to
//     singular_values, condition_number          of the design
//     quantisation_steps     of a0 ... a5; 1: full luminance
//     held_out_positions     spread evenly over the square of (u, v), their number
//     relrmse                ‖I − R‖/‖R‖ there, I decoded from the file to linear radiance, R a picture by
//     the
//                            same integrator, over all pixels; the mean over positions
//     relrmse_per_position
//     parts                  what I − R is made of, each as a share of ‖R‖: `clipping` at white,
//     `biquadratic`
//                            (what no biquadratic of each channel follows), `chromaticity` (one colour for
//                            each pixel), `quantisation` (to bytes)
//     relrmse_map            with `--integrator path`: the same of the illumination map's pictures
//     pictures_seconds, fit_seconds              (fit: with writing)
//
// With `--integrator path` R, and the map's picture, come twice with independent noise, and ‖I − R‖² is
// ⟨I₁ − R₁, I₂ − R₂⟩, which the noise does not bias. What noise the file has taken up from the pictures that
// it was fitted to is its own error.
#pragma once

#include <nlohmann/json.hpp>

#include "viewer/picture.h"
#include "viewer/ptm_fit.h"

namespace pim {

// Before the work. Throws UsageError: no .ptm, a lamp that moves on fewer than two axes, a view, a tone curve
// or an integrator that it cannot have; Error: not a place for a file.
LampPlane check_ptm(const std::filesystem::path& path, const Scene& scene, const PictureOptions& options,
                    std::size_t lamp);

// Writes the file, atomically, and returns the report. Throws Error.
nlohmann::json export_ptm(const std::filesystem::path& path, const BakedScene& baked, const RayCaster& caster,
                          const PictureOptions& options, std::size_t lamp, const LampPlane& plane);

}  // namespace pim
