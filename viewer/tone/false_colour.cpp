// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/tone/false_colour.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace pim {
namespace {

constexpr float kDarkest = 14, kLightest = 91;  // L*

// a* and b* of the map: a cubic Bézier curve, found by search for the most colourful path through the sRGB
// gamut whose steps are about alike.
constexpr float kCurve[4][2] = {{44, -61}, {-12, -35}, {-106, 55}, {-10, 87}};

float bezier(int coordinate, float t) {
    const float u = 1 - t, weights[4] = {u * u * u, 3 * u * u * t, 3 * u * t * t, t * t * t};
    float sum = 0;
    for (int i = 0; i < 4; ++i) sum += weights[i] * kCurve[i][coordinate];
    return sum;
}

// The inverse of CIELAB's f (CIE 15): the cube root above (6/29)³, a line below.
float tristimulus(float f) { return f > 6.0f / 29 ? f * f * f : 108.0f / 841 * (f - 4.0f / 29); }

// L*, a*, b* under the white of Rec. 709 (D65) to XYZ, and by the matrix of IEC 61966-2-1 to linear RGB.
Rgb from_lab(float l, float a, float b) {
    const float y = (l + 16) / 116;
    const Vec3 xyz(0.95047f * tristimulus(y + a / 500), tristimulus(y), 1.08883f * tristimulus(y - b / 200));
    return {3.2404542f * xyz.x - 1.5371385f * xyz.y - 0.4985314f * xyz.z,
            -0.9692660f * xyz.x + 1.8760108f * xyz.y + 0.0415560f * xyz.z,
            0.0556434f * xyz.x - 0.2040259f * xyz.y + 1.0572252f * xyz.z};
}

bool valid(const Scale& s) {
    return std::isfinite(s.low) && std::isfinite(s.high) && s.low < s.high && (!s.logarithmic || s.low > 0);
}

// 1, 2 or 5 times a power of ten, not below `least`.
double round_up(double least) {
    const double decade = std::pow(10.0, std::floor(std::log10(least)));
    for (const double digit : {1.0, 2.0, 5.0})
        if (digit * decade >= least * (1 - 1e-9)) return digit * decade;
    return 10 * decade;
}

// Three digits or all before the point; the width stays while a value changes a little.
std::string digits(double value) {
    const double magnitude = std::abs(value);
    if (!(magnitude >= 1e-4 && magnitude < 1e7)) return fmt::format("{:.3g}", value);
    return fmt::format("{:.{}f}", value, std::max(0, 2 - int(std::floor(std::log10(magnitude)))));
}

void add(std::vector<Tick>& found, const Scale& scale, double value) {
    const double largest = std::max(std::abs(scale.low), std::abs(scale.high));
    const double rounding = 1e-6 * (scale.logarithmic ? value : largest);  // of the scale's floats
    if (!(value >= scale.low - rounding && value <= scale.high + rounding)) return;
    const float inside = std::clamp(float(value), scale.low, scale.high);
    found.push_back({inside, fmt::format("{:.7g}", value), place(scale, inside)});
}

std::vector<Tick> even_ticks(const Scale& scale) {
    constexpr double kMost = 8;
    const double step = round_up((double(scale.high) - scale.low) / kMost);
    std::vector<Tick> found;
    const double last = std::floor(scale.high / step * (1 + 1e-9)) + 1;
    for (double i = std::ceil(scale.low / step * (1 + 1e-9)) - 1; i <= last; ++i) add(found, scale, i * step);
    return found;
}

// Of every decade the numbers 1, 2, 5, or 1 alone of each k-th decade.
std::vector<Tick> decade_ticks(const Scale& scale) {
    const double first = std::floor(std::log10(scale.low)), last = std::ceil(std::log10(scale.high));
    const bool all_digits = std::log10(scale.high) - std::log10(scale.low) <= 3;
    const double every = std::max(1.0, std::ceil((last - first) / 8));
    std::vector<Tick> found;
    for (double decade = first; decade <= last; decade += every)
        for (const double digit : {1.0, 2.0, 5.0})
            if (digit == 1 || all_digits) add(found, scale, digit * std::pow(10.0, decade));
    return found;
}

}  // namespace

float place(const Scale& scale, float value) {
    if (!valid(scale) || std::isnan(value)) return 0.5f;
    const float v = std::clamp(value, scale.low, scale.high);
    const double low = scale.low, high = scale.high;
    return float(scale.logarithmic ? std::log(v / low) / std::log(high / low) : (v - low) / (high - low));
}

Rgb colour_at(float place) {
    const float t = std::clamp(place, 0.0f, 1.0f);
    return from_lab(kDarkest + (kLightest - kDarkest) * t, bezier(0, t), bezier(1, t));
}

Rgb colour(const Scale& scale, float value) { return value > 0 ? colour_at(place(scale, value)) : Rgb(0); }

Image false_colours(const Image& values, const Scale& scale) {
    Image coloured(values.width, values.height);
    std::ranges::transform(values.pixels, coloured.pixels.begin(),
                           [&](const Rgb& pixel) { return colour(scale, luminance(pixel)); });
    return coloured;
}

std::vector<Tick> ticks(const Scale& scale) {
    if (!valid(scale)) return {};
    if (!scale.logarithmic) return even_ticks(scale);
    std::vector<Tick> found = decade_ticks(scale);
    return found.size() < 3 ? even_ticks(scale) : found;
}

Scale in_lux(const Scale& scale) {
    return {scale.low * kLumensPerWatt, scale.high * kLumensPerWatt, scale.logarithmic, "lx"};
}

std::string label(const Scale& scale, float value) {
    std::string text = digits(value);
    if (!scale.unit.empty()) text += " " + scale.unit;
    if (scale.unit == "W/m²") text += " (" + digits(double(value) * kLumensPerWatt) + " lx)";
    return text;
}

Scale automatic_scale(const Image& values, bool logarithmic, const std::string& unit) {
    std::vector<float> above;
    for (const Rgb& pixel : values.pixels)
        if (const float y = luminance(pixel); y > 0 && std::isfinite(y)) above.push_back(y);
    if (above.empty()) return {logarithmic ? 0.1f : 0, 1, logarithmic, unit};
    const auto percentile = [&](double fraction) {
        const auto at = above.begin() + std::ptrdiff_t(fraction * double(above.size() - 1));
        std::ranges::nth_element(above, at);
        return *at;
    };
    const float high = percentile(0.99);
    const float low = logarithmic ? std::min(percentile(0.01), 0.1f * high) : 0;  // a decade at least
    return {low, high, logarithmic, unit};
}

}  // namespace pim
