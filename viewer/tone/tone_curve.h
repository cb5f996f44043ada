// SPDX-License-Identifier: GPL-3.0-or-later
// Linear light to what a display shows. The whole way of a channel:
//     display = srgb_encode(apply(curve, exposure · linear)), exposure a factor: 2^stops.
// All curves work channel by channel, rise from 0 to 1, and never fall.
//     none      min(x, 1)
//     reinhard  x / (1 + x): Reinhard et al. 2002, "Photographic tone reproduction for digital images", eq.
//     3,
//               of a channel in place of the luminance
//     aces      x (2.51 x + 0.03) / (x (2.43 x + 0.59) + 0.14), cut at 1: Narkowicz 2015, "ACES filmic tone
//               mapping curve", his fit of the Academy's reference rendering for sRGB displays
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "viewer/view_state.h"

namespace pim {

inline constexpr std::array kToneCurves{ToneCurve::none, ToneCurve::reinhard, ToneCurve::aces};

// Of exposed linear light, into 0..1. Less than 0 and NaN give 0, infinity 1.
float apply(ToneCurve curve, float exposed_linear);

// What a display of 8 bits gets; without a curve the bytes that write_image writes.
uint8_t to_8bit(ToneCurve curve, float exposed_linear);

std::string_view description(ToneCurve curve);  // a line for people, with the formula

}  // namespace pim
