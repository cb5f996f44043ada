// SPDX-License-Identifier: GPL-3.0-or-later
// Maps of the Cornell box that are baked in a second or two, and the programs run on them.
#pragma once

#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <string>

#include "baked_scenes.h"
#include "common/core/file.h"

namespace pim {

enum class SmallMap {
    by_facing,  // cells split by the way their surfaces face, in which light's reach was looked for
    of_thesis   // whole cells: coarser, and baked in half a second
};

// One lamp, one camera, both parts of the light.
inline std::string small_description(SmallMap kind) {
    const bool thesis = kind == SmallMap::of_thesis;
    return std::string(thesis ? "preset = \"thesis\"\n" : "") + "[scene]\ngeometry = \"" + PIM_DATA +
           "/cornell/cornell.glb\"\n[grid]\ncells = " + (thesis ? "12" : "24") +
           "\n[bake]\nphotons = 3000\n" + (thesis ? "" : "components = [\"direct\", \"indirect\"]\n") +
           "[[light]]\nname = \"lamp\"\npower = [100, 100, 100]\nsamples = 60\n"
           "domain = { min = [1, 3.6, 1], max = [4, 4.9, 4] }\n"
           "[[camera]]\nname = \"front\"\neye = [2.78, 2.73, -8]\ntarget = [2.78, 2.73, 2.8]\n"
           "size = [64, 64]\n"
           "[[camera]]\nname = \"near\"\neye = [2.78, 1.2, -2]\ntarget = [2.9, 1.5, 2.8]\nsize = [64, 48]\n";
}

// Baked once in each process.
inline const Baked& small_map(SmallMap kind) {
    static std::map<SmallMap, std::unique_ptr<Baked>> all;
    auto& one = all[kind];
    if (one) return *one;
    const std::string name = kind == SmallMap::of_thesis ? "thesis" : "box";
    const fs::path description = test_folder() / (name + ".toml");
    std::ofstream(description) << small_description(kind);
    one = std::make_unique<Baked>(description, test_folder() / (name + ".vdb"));
    return *one;
}

struct Outcome {
    int code;                  // exit code, or minus the signal
    std::string text, errors;  // of stdout and stderr
};

// `arguments`: words of a shell after the name of a program of this project.
inline Outcome run_project(const std::string& arguments) {
    const fs::path text = test_folder() / "stdout.txt", errors = test_folder() / "stderr.txt";
    const int status = std::system(
        (std::string(PIM_BIN) + "/" + arguments + " >" + text.string() + " 2>" + errors.string()).c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status), read_text(text), read_text(errors)};
}

}  // namespace pim
