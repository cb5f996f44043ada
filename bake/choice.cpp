// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/choice.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "common/core/file.h"

namespace pim {
namespace fs = std::filesystem;
namespace {

fs::path file_in(const fs::path& work_folder) { return work_folder / "choice.json"; }

}  // namespace

std::string open_choices(const Scene& scene) {
    const Choices& c = scene.choices;
    std::string open = fmt::format("geometry {} cells {} reach {} photons {}", scene.geometry_hash, c.cells,
                                   c.reach_photons, c.photons);
    if (const auto& bounds = scene.grid.bounds)
        open += fmt::format(" bounds {:.9g} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g}", bounds->min.x, bounds->min.y,
                            bounds->min.z, bounds->max.x, bounds->max.y, bounds->max.z);
    return open;
}

std::optional<Choice> read_choice(const fs::path& work_folder) {
    if (!fs::exists(file_in(work_folder))) return std::nullopt;
    try {
        const auto json = nlohmann::json::parse(read_text(file_in(work_folder)));
        Choice choice{
            .description = json.at("description"), .open = json.at("open"), .settings = {}, .grid = {}};
        for (const auto& s : json.at("settings")) choice.settings.push_back({s.at(0), s.at(1), s.at(2)});
        const auto& grid = json.at("grid");
        choice.grid = {.cell_size = grid.at("cell_size"),
                       .square = grid.at("square"),
                       .doubt = grid.at("doubt"),
                       .noise = grid.at("noise"),
                       .patches = grid.at("patches")};
        choice.finished = json.at("finished");
        return choice;
    } catch (const nlohmann::json::exception&) {
        return std::nullopt;  // damaged: chosen again
    }
}

void write_choice(const fs::path& work_folder, const Choice& choice) {
    nlohmann::json json{{"description", choice.description},
                        {"open", choice.open},
                        {"settings", nlohmann::json::array()},
                        {"grid",
                         {{"cell_size", choice.grid.cell_size},
                          {"square", choice.grid.square},
                          {"doubt", choice.grid.doubt},
                          {"noise", choice.grid.noise},
                          {"patches", choice.grid.patches}}},
                        {"finished", choice.finished}};
    for (const Setting& s : choice.settings) json["settings"].push_back({s.key, s.value, s.light});
    write_text_atomically(file_in(work_folder), json.dump(2) + "\n");
}

}  // namespace pim
