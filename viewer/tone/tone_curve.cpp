// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/tone/tone_curve.h"

#include <algorithm>
#include <cmath>

#include "common/core/image.h"

namespace pim {
namespace {

constexpr float kWhite = 100;  // all curves but Reinhard's are at 1 long before

// In double: 1 + x rounds to either side of large floats, and the curve would fall.
float reinhard(float x) { return float(x / (1.0 + x)); }

float aces(float x) { return x * (2.51f * x + 0.03f) / (x * (2.43f * x + 0.59f) + 0.14f); }

}  // namespace

float apply(ToneCurve curve, float exposed_linear) {
    if (!(exposed_linear > 0)) return 0;  // NaN too
    if (std::isinf(exposed_linear)) return 1;
    switch (curve) {
        case ToneCurve::none:
            return std::min(exposed_linear, 1.0f);
        case ToneCurve::reinhard:
            return reinhard(exposed_linear);
        case ToneCurve::aces:
            return std::min(aces(std::min(exposed_linear, kWhite)), 1.0f);
    }
    return 0;
}

uint8_t to_8bit(ToneCurve curve, float exposed_linear) {
    return uint8_t(std::lround(255.0f * srgb_encode(apply(curve, exposed_linear))));
}

std::string_view description(ToneCurve curve) {
    switch (curve) {
        case ToneCurve::none:
            return "none: linear, cut at white: min(x, 1)";
        case ToneCurve::reinhard:
            return "Reinhard 2002: x / (1 + x)";
        case ToneCurve::aces:
            return "ACES, fit by Narkowicz 2015: x (2.51 x + 0.03) / (x (2.43 x + 0.59) + 0.14), cut at 1";
    }
    return "";
}

}  // namespace pim
