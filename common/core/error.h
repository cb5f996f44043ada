// SPDX-License-Identifier: GPL-3.0-or-later
// What goes wrong at the borders of the program, as one sentence: what, where, what to do.
#pragma once

#include <stdexcept>
#include <string>

namespace pim {

// The input, a file or the machine does not allow what was asked (exit code 1).
struct Error : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// The command line is wrong (exit code 2).
struct UsageError : Error {
    using Error::Error;
};

// The user stopped the program (exit code 130).
struct Interrupted : std::runtime_error {
    Interrupted() : std::runtime_error("interrupted; everything finished so far is kept") {}
};

enum ExitCode { kExitDone = 0, kExitFailed = 1, kExitUsage = 2, kExitInterrupted = 130 };

}  // namespace pim
