// SPDX-License-Identifier: GPL-3.0-or-later
// Means with standard errors, and bounds with a stated rate of false alarms. Seeds are fixed, so that an
// alarm comes from a change of the code, by bad luck at most that often.
#pragma once

#include <gtest/gtest.h>

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <vector>

namespace pim {

inline constexpr double kFalseAlarm = 1e-5;  // per test, whatever the number of its checks

// How many standard errors `checks` Gaussian numbers stay below, all of them, but for kFalseAlarm.
inline double sigmas(double checks = 1) {
    return boost::math::quantile(boost::math::complement(boost::math::normal(), kFalseAlarm / (2 * checks)));
}

// The same for a chi squared statistic.
inline double chi_squared_bound(double degrees_of_freedom, double checks = 1) {
    return boost::math::quantile(
        boost::math::complement(boost::math::chi_squared(degrees_of_freedom), kFalseAlarm / checks));
}

// Mean of independent numbers and its estimated standard error.
class Mean {
  public:
    void add(double value) {
        ++count_;
        const double step = value - mean_;
        mean_ += step / double(count_);
        squares_ += step * (value - mean_);
    }
    double value() const { return mean_; }
    double standard_error() const { return std::sqrt(squares_ / double(count_ - 1) / double(count_)); }

  private:
    long count_ = 0;
    double mean_ = 0, squares_ = 0;
};

// The mean agrees with `expected` within its noise and `slack`, the known rounding or discretisation.
inline void expect_mean(const Mean& mean, double expected, double slack = 0, double checks = 1) {
    EXPECT_NEAR(mean.value(), expected, sigmas(checks) * mean.standard_error() + slack);
}

// Two independent means agree.
inline void expect_same(const Mean& a, const Mean& b, double slack = 0, double checks = 1) {
    EXPECT_NEAR(a.value(), b.value(),
                sigmas(checks) * std::hypot(a.standard_error(), b.standard_error()) + slack);
}

// Counts in bins of equal probability.
inline double chi_squared(const std::vector<long>& counts) {
    double total = 0, sum = 0;
    for (const long n : counts) total += double(n);
    const double expected = total / double(counts.size());
    for (const long n : counts) sum += (double(n) - expected) * (double(n) - expected) / expected;
    return sum;
}

}  // namespace pim
