// SPDX-License-Identifier: GPL-3.0-or-later
// The one parallel loop. Results must not depend on the order of the calls.
#pragma once

#include <cstddef>
#include <functional>

namespace pim {

// Threads for all loops from here on; 0: all cores. Keep the object alive.
class ThreadLimit {
  public:
    explicit ThreadLimit(int threads);
    ~ThreadLimit();
    ThreadLimit(const ThreadLimit&) = delete;
    ThreadLimit& operator=(const ThreadLimit&) = delete;

  private:
    void* control_;
};

int thread_count();

// Calls body(i) for i in [0, count), several at a time. Throws what a body threw, or Interrupted.
void parallel_for(std::size_t count, const std::function<void(std::size_t)>& body);

}  // namespace pim
