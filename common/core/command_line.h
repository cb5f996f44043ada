// SPDX-License-Identifier: GPL-3.0-or-later
// What both programs do alike on the command line: common options, exit codes, one sentence for each error.
#pragma once

#include <array>
#include <functional>
#include <string>

namespace pim {

struct CommonOptions {
    int threads = 0;  // 0: all cores
    bool quiet = false;
    std::string log_level = "info";
};

// Runs `work` with those options; maps exceptions to a line on stderr and an exit code.
int run_program(const CommonOptions& options, const std::function<void()>& work);

// Three numbers "x,y,z" or the like. Throws UsageError naming `option`.
std::array<double, 3> parse_triple(const std::string& text, const std::string& option);

}  // namespace pim
