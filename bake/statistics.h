// SPDX-License-Identifier: GPL-3.0-or-later
// Of independent values, and of values with normal errors.
#pragma once

#include <cmath>
#include <numeric>
#include <vector>

namespace pim {

inline double mean(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / double(values.size());
}

// Of the mean, from the values' scatter; 0 for fewer than two.
inline double standard_error(const std::vector<double>& values) {
    if (values.size() < 2) return 0;
    const double centre = mean(values), n = double(values.size());
    double squares = 0;
    for (const double x : values) squares += (x - centre) * (x - centre);
    return std::sqrt(squares / (n - 1) / n);
}

struct Doubtful {
    double value = 0, doubt = 0;  // standard error
};

// Of two independent values for the same, the first with a doubt that is not 0: the likeliest, weighted by
// their variances.
Doubtful combined(const Doubtful& a, const Doubtful& b);

// What an error can be whose square was measured, any error from 0 up as likely as any other before: its
// mean, and the mean of its square.
struct LikelyError {
    double mean, square;
};
LikelyError likely_error(const Doubtful& square);

}  // namespace pim
