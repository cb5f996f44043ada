// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/plan.h"

#include "bake/bake.h"
#include "bake/tracing.h"
#include "common/core/log.h"
#include "common/map/polynomial.h"
#include "common/scene/scene_file.h"

namespace pim {
namespace {

double bytes_of_map(const Scene& scene, std::size_t patches) {
    double numbers = 0;
    for (const Light& light : scene.lights) {
        const auto boxes = split_domain(light.domain, light.boxes);
        for (const MapBox& box : boxes)
            numbers += double(terms_of(scene.bake.degree, box.moves()).size()) *
                       double(scene.bake.components.size());
    }
    return numbers * double(patches) * (is_grey(scene) ? 1 : 3) * 4;
}

}  // namespace

nlohmann::json plan_bake(const std::filesystem::path& description, const std::vector<Setting>& settings) {
    const Scene scene = read_scene(description, {.settings = settings, .geometry = {}});
    const RayCaster caster(scene.geometry, InstructionSet::pinned);
    const Solids solids = solids_of(scene);
    std::vector<std::string> warnings;
    const auto samples = all_light_samples(scene, solids, warnings);
    const PositionFilter allowed = [&](const Vec3& p) { return solids.containing(p).empty(); };
    const Cells cells = find_cells(scene, caster, allowed);
    if (is_automatic(scene))
        warnings.push_back(
            "the bake chooses some of cells, photons, lamp positions, boxes and degree by itself as it goes; "
            "these figures are for the usual settings in their place");
    for (const Light& light : scene.lights) {
        const auto boxes = split_domain(light.domain, light.boxes);
        const auto terms = terms_of(scene.bake.degree, boxes[0].moves()).size();
        const auto own = std::ranges::count_if(
            samples, [&](const LightSample& s) { return &scene.lights[s.light] == &light; });
        const bool moves = light.domain.min != light.domain.max;
        if (moves && double(own) < 2.0 * double(terms * boxes.size()))
            warnings.push_back(
                fmt::format("light '{}': {} positions for {} boxes of {} terms are few; {} or more are "
                            "advised",
                            light.name, own, boxes.size(), terms, 4 * terms * boxes.size()));
    }
    const PhotonTrial trial = time_photons(scene, caster, allowed);
    const double photons = double(scene.bake.photons) * double(samples.size()),
                 patches = double(cells.patches.size());
    const double map_bytes = bytes_of_map(scene, cells.patches.size());
    const double volume_bytes = patches * 16 * double(scene.bake.components.size());
    return {
        {"grid", {cells.grid.size.x, cells.grid.size.y, cells.grid.size.z}},
        {"cells", cells.index.cell_count()},
        {"patches", cells.patches.size()},
        {"light_samples", samples.size()},
        {"photons_total", scene.bake.photons * samples.size()},
        {"rays_per_photon", trial.rays_per_photon},
        // Sums of one box in double and 32 volumes at a time, neighbourhoods, the map, one grid of OpenVDB.
        {"memory_bytes", uint64_t(patches * (3 * 8 * (kTermCount + 32) + 500) + map_bytes + 1e8)},
        {"disk_bytes", uint64_t(map_bytes + volume_bytes * double(samples.size()))},
        {"seconds_estimate",
         photons * trial.seconds_per_photon + 1e-8 * patches * 60 * double(samples.size())},
        {"left_out", left_out(scene, cells)},
        {"warnings", warnings}};
}

std::string plan_text(const nlohmann::json& p) {
    std::string text = fmt::format(
        "grid {} x {} x {}; {} cells with surface that counts, {} patches\n"
        "{} lamp positions, {:.4g} photons in all, {:.2f} rays each\n"
        "about {:.0f} s on this machine, {:.2f} GB of memory, {:.2f} GB of disk\n",
        p["grid"][0].get<int>(), p["grid"][1].get<int>(), p["grid"][2].get<int>(), p["cells"].get<uint64_t>(),
        p["patches"].get<uint64_t>(), p["light_samples"].get<uint64_t>(), p["photons_total"].get<double>(),
        p["rays_per_photon"].get<double>(), p["seconds_estimate"].get<double>(),
        p["memory_bytes"].get<double>() / 1e9, p["disk_bytes"].get<double>() / 1e9);
    for (const auto& line : p["left_out"]) text += "left out: " + line.get<std::string>() + "\n";
    for (const auto& line : p["warnings"]) text += "warning: " + line.get<std::string>() + "\n";
    return text;
}

}  // namespace pim
