// SPDX-License-Identifier: GPL-3.0-or-later
// What a bake that chooses for itself aims at: an error, a time, or an error within a time. Squares are of
// ||I-R||/||R||.
#pragma once

#include <cmath>
#include <optional>

#include "common/core/stopwatch.h"
#include "common/scene/scene.h"

namespace pim {

class Goal {
  public:
    // At least one of the two is given; the time runs since `begun`.
    Goal(const Choices& choices, const Stopwatch& begun)
        : watch_(begun), target_(choices.target_error.value_or(0)), budget_(choices.time_budget) {}

    double target() const { return target_; }  // 0: none
    double square() const { return kAimedShare * target_ * target_; }
    bool has_budget() const { return budget_.has_value(); }
    double budget() const { return *budget_; }  // s
    double seconds() const { return watch_.seconds(); }
    double left() const { return budget() - seconds(); }
    // That is hoped for: a minute of photons brings many rooms to 0.03, a hundred times as many to 0.01.
    double hoped_square() const { return has_budget() ? 1e-3 * std::sqrt(60 / budget()) : square(); }

  private:
    static constexpr double kAimedShare = 0.8;  // of the squared target: what is chosen by it looks too good

    Stopwatch watch_;
    double target_;
    std::optional<double> budget_;
};

}  // namespace pim
