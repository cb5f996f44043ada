// SPDX-License-Identifier: GPL-3.0-or-later
// What a bake that chooses for itself has chosen, kept in its work folder: the same command goes on from
// there, and one with another goal keeps the cells.
#pragma once

#include <filesystem>
#include <optional>

#include "bake/grid_search.h"
#include "common/scene/scene_file.h"

namespace pim {

struct Choice {
    std::string description;        // that it was made for, goal and all
    std::string open;               // of the cells' settings; what is chosen for others does not fit
    std::vector<Setting> settings;  // bounds, cells and photons; once finished, all
    GridFigures grid;
    bool finished = false;
};

// Geometry, bounds if they are given, and which settings of cells and photons a scene leaves open.
std::string open_choices(const Scene& scene);

// None if there is none that can be read.
std::optional<Choice> read_choice(const std::filesystem::path& work_folder);
// Throws Error.
void write_choice(const std::filesystem::path& work_folder, const Choice& choice);

}  // namespace pim
