// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/info.h"

#include <fmt/format.h>

#include <algorithm>

#include "common/map/map_file.h"

namespace pim {
namespace {

nlohmann::json residual_summary(const IlluminationMap& map) {
    std::vector<float> all;
    for (const MapLight& light : map.lights)
        for (const auto& box : light.polynomials)
            for (const auto& p : box)
                if (p) all.insert(all.end(), p->residuals.begin(), p->residuals.end());
    if (all.empty()) return {{"mean", 0}, {"p95", 0}, {"max", 0}};
    double sum = 0;
    for (const float r : all) sum += r;
    std::ranges::sort(all);
    return {{"mean", sum / double(all.size())},
            {"p95", all[std::size_t(0.95 * double(all.size() - 1))]},
            {"max", all.back()}};
}

nlohmann::json light_info(const IlluminationMap& map, const MapLight& light) {
    int samples = 0;
    double condition = 0;
    std::size_t terms = 0;
    for (std::size_t b = 0; b < light.boxes.size(); ++b) {
        samples += light.fits[b].samples;
        condition = std::max(condition, light.fits[b].condition_number);
        terms = std::max(terms, light.polynomials[b][int(map.components[0])]->terms.size());
    }
    nlohmann::json components = nlohmann::json::array(), facings = nlohmann::json::array();
    for (const Component c : map.components) components.push_back(name(c));
    const auto cells = cells_by_slot(map.patches);
    for (int f = 0; f < kSlotCount; ++f)
        if (!cells[f].cells.empty()) facings.push_back(slot_name(map.grid, f));
    return {{"name", light.name},
            {"samples", samples},
            {"boxes", light.boxes.size()},
            {"terms", terms},
            {"condition_number", condition},
            {"components", components},
            {"facings", facings}};
}

}  // namespace

nlohmann::json map_info(const std::filesystem::path& map_file) {
    const IlluminationMap map = read_map(map_file);
    nlohmann::json info{{"cells", map.index.cell_count()},
                        {"patches", map.patches.size()},
                        {"grid", {map.grid.size.x, map.grid.size.y, map.grid.size.z}},
                        {"cell_size", map.grid.cell_size},
                        {"bytes", std::filesystem::file_size(map_file)},
                        {"residual", residual_summary(map)},
                        {"left_out", map.left_out},
                        {"lights", nlohmann::json::array()}};
    for (const MapLight& light : map.lights) info["lights"].push_back(light_info(map, light));
    return info;
}

std::string map_description(const std::filesystem::path& map_file) {
    return MapFile(map_file).outline().description;
}

std::string info_text(const nlohmann::json& i) {
    std::string text = fmt::format("{} cells of a {} x {} x {} grid ({:.4g} m each), {} patches, {:.1f} MB\n",
                                   i["cells"].get<int>(), i["grid"][0].get<int>(), i["grid"][1].get<int>(),
                                   i["grid"][2].get<int>(), i["cell_size"].get<double>(),
                                   i["patches"].get<int>(), i["bytes"].get<double>() / 1e6);
    for (const auto& l : i["lights"])
        text +=
            fmt::format("light '{}': {} in {} boxes from {} positions, {} terms, condition number {:.3g}\n",
                        l["name"].get<std::string>(), l["components"].dump(), l["boxes"].get<int>(),
                        l["samples"].get<int>(), l["terms"].get<int>(), l["condition_number"].get<double>());
    const auto& r = i["residual"];
    text += fmt::format("residual: mean {:.3g}, 95 % below {:.3g}, at most {:.3g} W/m² per watt\n",
                        r["mean"].get<double>(), r["p95"].get<double>(), r["max"].get<double>());
    for (const auto& line : i["left_out"]) text += "left out: " + line.get<std::string>() + "\n";
    return text;
}

}  // namespace pim
