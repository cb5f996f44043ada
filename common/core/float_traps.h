// SPDX-License-Identifier: GPL-3.0-or-later
// Floating-point exceptions that end the program where they happen, for tests: invalid operation, division by
// zero, overflow. Only where the environment variable PIM_TRAP_FLOATS is set; else these objects do nothing.
#pragma once

namespace pim {

// Of this thread, as long as it lives. On in every body of a parallel loop; off around calls of libraries,
// which may compute with infinities.
class FloatTraps {
  public:
    enum State { off, on };
    explicit FloatTraps(State state);
    ~FloatTraps();
    FloatTraps(const FloatTraps&) = delete;
    FloatTraps& operator=(const FloatTraps&) = delete;

  private:
    int before_ = 0;
};

}  // namespace pim
