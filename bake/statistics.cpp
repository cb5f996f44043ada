// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/statistics.h"

#include <algorithm>

namespace pim {
namespace {

constexpr double kNoDoubt = 1e6;  // times its doubt, a square is what was measured

}  // namespace

Doubtful combined(const Doubtful& a, const Doubtful& b) {
    const double weight = 1 / (1 + std::pow(b.doubt / a.doubt, 2));  // of b
    return {(1 - weight) * a.value + weight * b.value, a.doubt * std::sqrt(1 - weight)};
}

LikelyError likely_error(const Doubtful& square) {
    const auto [measured, doubt] = square;
    if (!(doubt > 0) || measured > kNoDoubt * doubt)
        return {std::sqrt(std::max(0.0, measured)), std::max(0.0, measured)};
    constexpr int kSteps = 400;
    const double t = std::max(-8.0, measured / doubt), unit = std::sqrt(doubt);
    const double low = std::sqrt(std::max(0.0, t - 8)), high = std::sqrt(std::max(0.0, t) + 8);
    double all = 0, first = 0, second = 0;
    for (int i = 0; i < kSteps; ++i) {
        const double x = low + (high - low) * (i + 0.5) / kSteps, beyond = t - x * x;
        const double likely = std::exp(-0.5 * beyond * beyond + (t < 0 ? 0.5 * t * t : 0));
        all += likely, first += likely * x, second += likely * x * x;
    }
    return {unit * first / all, doubt * second / all};
}

}  // namespace pim
