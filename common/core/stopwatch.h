// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>

namespace pim {

class Stopwatch {
  public:
    // Already running for so long, s.
    explicit Stopwatch(double since = 0)
        : start_(std::chrono::steady_clock::now() -
                 std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                     std::chrono::duration<double>(since))) {}
    double seconds() const {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    }

  private:
    std::chrono::steady_clock::time_point start_;
};

}  // namespace pim
