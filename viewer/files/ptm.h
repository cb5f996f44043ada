// SPDX-License-Identifier: GPL-3.0-or-later
// Polynomial texture maps (Malzbender, Gelb, Wolters 2001): a picture whose luminance is in each pixel a
// biquadratic of where the lamp is, (u, v) in [-1, 1]²,
//     L = a0 u² + a1 v² + a2 uv + a3 u + a4 v + a5                        (the thesis' 2.4)
// times a constant colour ("LRGB"). The file that viewers of such pictures open:
//
//     PTM_1.2
//     PTM_FORMAT_LRGB
//     width
//     height
//     six scales
//     six biases, whole numbers
//     6 bytes for each pixel, row by row from the bottom: a_i = (byte - bias_i) · scale_i, 255 being full
//     3 bytes for each pixel, in the same order: red, green, blue
//
// The layout is that of version 1.2 of Malzbender's and Gelb's description of the format, as viewers read it.
// They show min(colour · L / 255, 255) in each channel as it is. So both are values of a display, sRGB
// encoded, as the photographs are that other such files are made from. Some viewers cut a_i to whole numbers,
// and all have (u, v) as the direction to a light, u to the right and v up, in the unit disk.
#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include "common/core/image.h"

namespace pim {

inline constexpr int kPtmTerms = 6;

inline std::array<float, kPtmTerms> ptm_terms(float u, float v) { return {u * u, v * v, u * v, u, v, 1}; }

// Rows from the top, as in Image. Luminance and colours: 1 is full.
struct Ptm {
    int width = 0, height = 0;
    std::vector<std::array<float, kPtmTerms>> luminance;  // a0 ... a5 of each pixel
    std::vector<Rgb> colours;
};

// What a display shows, sRGB encoded, in 0..1.
Image relit(const Ptm& ptm, float u, float v);

// How far apart the values are that the file can hold of each coefficient: the written one is off by half of
// that at most, and L by half the sum at most. 0 where all are 0.
std::array<float, kPtmTerms> ptm_steps(const Ptm& ptm);

// Atomic. Colours are cut to 0..1. Throws Error.
void write_ptm(const std::filesystem::path& path, const Ptm& ptm);

// Throws Error: no such file, another format, damaged.
Ptm read_ptm(const std::filesystem::path& path);

}  // namespace pim
