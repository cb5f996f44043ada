// SPDX-License-Identifier: GPL-3.0-or-later
// Quantities as colours, with their legend: irradiance, trust, density.
//
// Units. Light is in W per colour channel. One watt in each of the three channels counts as 683 lm, as it
// does where photometric lamps of glTF are read; so the illuminance of an irradiance E is
//     E_v = 683 lm/W · luminance(E), luminance(E) = 0.2126 E_r + 0.7152 E_g + 0.0722 E_b.
// A picture of irradiance shows luminance(E) in W/m²; its legend counts in W/m² and, 683 times that, in lux.
#pragma once

#include <string>
#include <vector>

#include "common/core/image.h"
#include "common/scene/light.h"

namespace pim {

inline float lux(const Rgb& irradiance) { return kLumensPerWatt * luminance(irradiance); }  // of W/m²

// low < high, both finite; low > 0 where logarithmic. Of any other scale all values stand in the middle, and
// it has no ticks.
struct Scale {
    float low = 0, high = 1;
    bool logarithmic = false;
    std::string unit = "W/m²";  // empty: a ratio
};

// Where a value stands between low (0) and high (1), clamped.
float place(const Scale& scale, float value);

// The map at a place 0..1, linear Rec. 709 for srgb_encode alone: no exposure, no tone curve. From dark blue
// over green to yellow; CIE 1976 lightness L* rises in proportion to the place from 14 to 91, so that the
// order remains in grey and to colour-blind eyes.
Rgb colour_at(float place);

// Of a value; black where there is none: 0, less, or NaN.
Rgb colour(const Scale& scale, float value);

// All of a picture, the luminance of each pixel being its value.
Image false_colours(const Image& values, const Scale& scale);

struct Tick {
    float value;
    std::string label;  // the number alone; the unit is the scale's
    float place;        // 0..1, rising from tick to tick
};

// Round numbers inside the scale: 1, 2 or 5 times powers of ten apart; on logarithmic scales such numbers
// themselves, or powers of ten alone where these are many. At most about ten.
std::vector<Tick> ticks(const Scale& scale);

// The same colours counted in lux, for the other side of the legend; of a scale in W/m² only.
Scale in_lux(const Scale& scale);

// A value as text: "2.31 W/m² (1578 lx)", "0.0340".
std::string label(const Scale& scale, float value);

// That fits the luminances of a picture: linear from 0 to the 99th percentile of those above 0, logarithmic
// from the 1st to the 99th. A black picture gets 0..1, or 0.1..1.
Scale automatic_scale(const Image& values, bool logarithmic, const std::string& unit);

}  // namespace pim
