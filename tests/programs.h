// SPDX-License-Identifier: GPL-3.0-or-later
// The programs as a user runs them.
#pragma once

#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "common/core/file.h"

namespace pim {

struct Outcome {
    int code;          // minus the signal, where one ended it
    std::string text;  // stdout and stderr

    bool names(const std::string& word) const { return text.find(word) != std::string::npos; }
};

// `command`: "bake ..." or "viewer ..."; what they say goes through a file in the folder.
inline Outcome run_program(const std::string& command, const std::filesystem::path& folder) {
    const std::filesystem::path log = folder / "log.txt";
    const int status =
        std::system((std::string(PIM_BIN) + "/" + command + " >" + log.string() + " 2>&1").c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status), read_text(log)};
}

}  // namespace pim
