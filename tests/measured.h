// SPDX-License-Identifier: GPL-3.0-or-later
// What a test measured, beside what it allows: --gtest_output=xml shows it.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

namespace pim {

inline void record(const std::string& name, double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", value);
    testing::Test::RecordProperty(name, text);
}

// The largest magnitude of all that was added.
class Largest {
  public:
    explicit Largest(std::string name) : name_(std::move(name)) {}
    ~Largest() { record(name_, largest_); }
    Largest(const Largest&) = delete;
    Largest& operator=(const Largest&) = delete;
    void add(double value) { largest_ = std::max(largest_, std::abs(value)); }

  private:
    std::string name_;
    double largest_ = 0;
};

}  // namespace pim
