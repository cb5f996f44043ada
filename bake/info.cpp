// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/info.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>

#include "bake/non_negative.h"
#include "common/core/parallel.h"
#include "common/map/map_file.h"

namespace pim {
namespace {

// Calls visit(polynomials) for every box and component.
template <class Visit>
void for_each_fit(const IlluminationMap& map, Visit visit) {
    for (const MapLight& light : map.lights)
        for (const auto& box : light.polynomials)
            for (const auto& p : box)
                if (p) visit(*p);
}

// Highest degree with a coefficient that is not 0.
int order_of(const Polynomials& p, std::size_t patch) {
    int order = 0;
    for (std::size_t t = 0; t < p.terms.size(); ++t)
        for (std::size_t c = 0; c < 3; ++c)
            if (p.coefficients[(patch * p.terms.size() + t) * 3 + c] != 0)
                order = std::max(order, degree(p.terms[t]));
    return order;
}

nlohmann::json residual_summary(const IlluminationMap& map) {
    std::vector<float> all;
    for_each_fit(
        map, [&](const Polynomials& p) { all.insert(all.end(), p.residuals.begin(), p.residuals.end()); });
    if (all.empty()) return {{"mean", 0}, {"p95", 0}, {"max", 0}};
    double sum = 0;
    for (const float r : all) sum += r;
    std::ranges::sort(all);
    return {{"mean", sum / double(all.size())},
            {"p95", all[std::size_t(0.95 * double(all.size() - 1))]},
            {"max", all.back()}};
}

// Fits of patches of which a channel is negative somewhere in its box.
uint64_t negative_fits(const IlluminationMap& map) {
    std::atomic<uint64_t> count = 0;
    for_each_fit(map, [&](const Polynomials& p) {
        parallel_for(map.patches.size(), [&](std::size_t patch) {
            bool negative = false;
            for (std::size_t c = 0; c < 3; ++c) {
                Cubic cubic{};
                for (std::size_t t = 0; t < p.terms.size(); ++t)
                    cubic[std::size_t(p.terms[t])] =
                        double(p.coefficients[(patch * p.terms.size() + t) * 3 + c]);
                negative = negative || lower_bound_in_box(cubic) < 0;
            }
            count += negative;
        });
    });
    return count;
}

// Shares of all fits of patches.
nlohmann::json status_summary(const IlluminationMap& map) {
    std::array<double, 4> orders{};
    std::array<double, 4> statuses{};
    constexpr std::array kBits{kRobust, kRobustFailed, kMended, kBlack};
    double fits = 0;
    for_each_fit(map, [&](const Polynomials& p) {
        for (std::size_t patch = 0; patch < map.patches.size(); ++patch) {
            ++fits;
            orders[std::size_t(order_of(p, patch))] += 1;
            for (std::size_t b = 0; b < kBits.size(); ++b)
                statuses[b] += !p.status.empty() && (p.status[patch] & kBits[b]) != 0;
        }
    });
    const auto share = [&](double n) { return fits > 0 ? n / fits : 0; };
    return {{"orders", {share(orders[0]), share(orders[1]), share(orders[2]), share(orders[3])}},
            {"robust", share(statuses[0])},
            {"robust_failed", share(statuses[1])},
            {"mended", share(statuses[2])},
            {"black", share(statuses[3])},
            {"negative", negative_fits(map)}};
}

double mean_of_term(int term) {
    Cubic cubic{};
    cubic[std::size_t(term)] = 1;
    return mean_over_box(cubic);
}

// What lands on all patches, W per watt, mean of the boxes and the channels.
double flux_of(const IlluminationMap& map, const MapLight& light) {
    double flux = 0;
    for (const auto& box : light.polynomials)
        for (const auto& component : box) {
            if (!component) continue;
            const float* c = component->coefficients.data();
            std::vector<double> means;
            for (const int term : component->terms) means.push_back(mean_of_term(term));
            for (const Patch& patch : map.patches)
                for (std::size_t t = 0; t < means.size(); ++t, c += 3)
                    flux += double(patch.area) * means[t] * double(c[0] + c[1] + c[2]) / 3;
        }
    return flux / double(light.boxes.size());
}

nlohmann::json light_info(const IlluminationMap& map, const MapLight& light) {
    int samples = 0;
    double condition = 0, raw_condition = 0;
    int rank = kTermCount, iterations = 0;
    std::size_t terms = 0;
    for (std::size_t b = 0; b < light.boxes.size(); ++b) {
        samples += light.fits[b].samples;
        condition = std::max(condition, light.fits[b].condition_number);
        raw_condition = std::max(raw_condition, light.fits[b].raw_condition_number);
        rank = std::min(rank, light.fits[b].rank);
        iterations += light.fits[b].iterations;
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
            {"rank", rank},
            {"condition_number", condition},
            {"raw_condition_number", raw_condition},
            {"robust_iterations", iterations},
            {"flux", flux_of(map, light)},
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
                        {"fits", status_summary(map)},
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
        text += fmt::format(
            "light '{}': {} in {} boxes from {} positions, {} terms of which {} are determined; "
            "condition number {:.3g} (of monomials of world coordinates {:.2g})\n",
            l["name"].get<std::string>(), l["components"].dump(), l["boxes"].get<int>(),
            l["samples"].get<int>(), l["terms"].get<int>(), l["rank"].get<int>(),
            l["condition_number"].get<double>(), l["raw_condition_number"].get<double>());
    const auto& r = i["residual"];
    text += fmt::format("residual: mean {:.3g}, 95 % below {:.3g}, at most {:.3g} W/m² per watt\n",
                        r["mean"].get<double>(), r["p95"].get<double>(), r["max"].get<double>());
    const auto& f = i["fits"];
    const auto percent = [&](const nlohmann::json& share) { return 100 * share.get<double>(); };
    text += fmt::format(
        "fits of patches: {:.1f} % of degree 3, {:.1f} % of 2, {:.1f} % of 1, {:.1f} % constant; {:.2g} % "
        "robust, {:.2g} % where that failed; {:.2g} % mended where they went below zero, {:.2g} % black for "
        "a "
        "negative mean; {} go below zero\n",
        percent(f["orders"][3]), percent(f["orders"][2]), percent(f["orders"][1]), percent(f["orders"][0]),
        percent(f["robust"]), percent(f["robust_failed"]), percent(f["mended"]), percent(f["black"]),
        f["negative"].get<uint64_t>());
    for (const auto& line : i["left_out"]) text += "left out: " + line.get<std::string>() + "\n";
    return text;
}

}  // namespace pim
