// SPDX-License-Identifier: GPL-3.0-or-later
// Progress of long work on stderr: a bar with the time left on a terminal, a plain line now and then
// elsewhere.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>

namespace pim {

class Progress {
  public:
    Progress(std::string what, uint64_t total);
    ~Progress();
    void advance(uint64_t steps = 1);  // from any thread

  private:
    void show(uint64_t done);

    std::string what_;
    uint64_t total_;
    std::atomic<uint64_t> done_{0};
    std::chrono::steady_clock::time_point start_;
    std::atomic<double> next_show_;
    std::mutex mutex_;
    bool terminal_, shown_ = false;
};

}  // namespace pim
