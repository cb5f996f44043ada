// SPDX-License-Identifier: GPL-3.0-or-later
// Of independent values.
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

}  // namespace pim
