// SPDX-License-Identifier: GPL-3.0-or-later
// Rows of the tables in docs/stability.md: tests say what they measured, scripts/stability collects it.
#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <string>
#include <vector>

namespace pim {

inline void add_to_table(const std::string& table, const std::vector<std::string>& row) {
    fmt::print("stability|{}|{}\n", table, fmt::join(row, "|"));
    std::fflush(stdout);
}

}  // namespace pim
