// SPDX-License-Identifier: GPL-3.0-or-later
// What the process takes.
#pragma once

#include <sys/resource.h>

#include <cstdint>

namespace pim {

// The most that was ever resident, bytes; pages of mapped files count while they are.
inline uint64_t peak_memory() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return uint64_t(usage.ru_maxrss) * 1024;
}

}  // namespace pim
