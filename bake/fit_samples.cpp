// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/fit_samples.h"

#include <fmt/format.h>

#include <cmath>

#include "bake/bake.h"
#include "common/core/error.h"
#include "common/map/baked_scene.h"
#include "common/map/irradiance.h"

namespace pim {
namespace fs = std::filesystem;
namespace {

nlohmann::json to_json(const Vec3d& v) { return {v.x, v.y, v.z}; }

class FitSamples {
  public:
    explicit FitSamples(const fs::path& map_file)
        : baked_(read_baked_scene(map_file, {})),
          caster_(baked_.scene.geometry, InstructionSet::pinned),
          solids_(solids_of(baked_.scene)),
          work_(open_work(map_file)) {
        auto cells = work_.read_cells();
        if (!cells)
            throw Error(fmt::format("{}: holds no cells; bake again without --clean", work_.path().string()));
        cells_ = std::move(*cells);
        std::vector<std::string> warnings;
        samples_ = all_light_samples(baked_.scene, solids_, warnings);
    }

    nlohmann::json run(int count) {
        nlohmann::json all = nlohmann::json::array();
        for (std::size_t l = 0; l < baked_.map.lights.size(); ++l)
            for (const Component c : baked_.map.components) add(int(l), c, count, all);
        return all;
    }

  private:
    WorkFolder open_work(const fs::path& map_file) const {
        const fs::path folder = WorkFolder::beside(map_file);
        if (!fs::exists(folder))
            throw Error(fmt::format("{}: is not there; bake again without --clean", folder.string()));
        return {{folder}, trace_settings(baked_.scene, caster_, solids_), baked_.scene};
    }

    // [sample][patch]
    using Table = std::vector<std::vector<float>>;

    void add(int light, Component component, int count, nlohmann::json& all) {
        std::vector<LightSample> own;
        Table measured, fitted;
        for (const LightSample& sample : samples_) {
            if (sample.light != light) continue;
            own.push_back(sample);
            measured.push_back(means(work_.read(baked_.scene, cells_, sample, component).density));
            fitted.push_back(fit_at(light, component, sample.position));
        }
        const std::size_t patches = cells_.patches.size();
        std::vector<double> mean(patches, 0), residual(patches, 0);
        for (std::size_t s = 0; s < own.size(); ++s)
            for (std::size_t p = 0; p < patches; ++p) {
                mean[p] += double(measured[s][p]) / double(own.size());
                const double d = double(measured[s][p]) - double(fitted[s][p]);
                residual[p] += d * d / double(own.size());
            }
        for (const std::size_t p : chosen(mean, residual, count)) {
            nlohmann::json entry{
                {"light", baked_.map.lights[std::size_t(light)].name},
                {"component", name(component)},
                {"patch", p},
                {"cell", {cells_.patches[p].cell.x, cells_.patches[p].cell.y, cells_.patches[p].cell.z}},
                {"facing", slot_name(cells_.grid, cells_.patches[p].slot)},
                {"centre", to_json(cells_.grid.centre(cells_.patches[p].cell) + baked_.map.origin)},
                {"mean", mean[p]},
                {"residual", std::sqrt(residual[p])},
                {"samples", nlohmann::json::array()}};
            for (std::size_t s = 0; s < own.size(); ++s)
                entry["samples"].push_back(
                    {{"position", to_json(baked_.scene.geometry.to_world(own[s].position))},
                     {"measured", measured[s][p]},
                     {"fitted", fitted[s][p]}});
            all.push_back(entry);
        }
    }

    // Of patches that get a fair share of light: a hundredth of the brightest, at least.
    static std::vector<std::size_t> chosen(const std::vector<double>& mean,
                                           const std::vector<double>& residual, int count) {
        const double brightest = *std::ranges::max_element(mean);
        std::vector<std::size_t> order;
        for (std::size_t p = 0; p < mean.size(); ++p)
            if (mean[p] > 0.01 * brightest) order.push_back(p);
        std::ranges::stable_sort(order, std::greater<>(),
                                 [&](std::size_t p) { return residual[p] / (mean[p] * mean[p]); });
        std::vector<std::size_t> some;
        for (int i = 0; i < count && !order.empty(); ++i)
            some.push_back(order[std::size_t(0.5 * double(order.size() - 1) * i / std::max(1, count - 1))]);
        return some;
    }

    static std::vector<float> means(const std::vector<Rgb>& channels) {
        std::vector<float> values;
        for (const Rgb& v : channels) values.push_back(mean_channel(v));
        return values;
    }

    std::vector<float> fit_at(int light, Component component, const Vec3& position) const {
        std::vector<LightState> lamps;
        for (std::size_t l = 0; l < baked_.scene.lights.size(); ++l)
            lamps.push_back({baked_.scene.lights[l].position, Rgb(0)});
        lamps[std::size_t(light)] = {position, Rgb(1)};
        std::vector<float> values;
        for (const Rgb& e : patch_irradiance(baked_.map, {component}, lamps))
            values.push_back(mean_channel(e));
        return values;
    }

    BakedScene baked_;
    RayCaster caster_;
    Solids solids_;
    WorkFolder work_;
    Cells cells_;
    std::vector<LightSample> samples_;
};

}  // namespace

nlohmann::json fit_samples(const fs::path& map_file, int count) { return FitSamples(map_file).run(count); }

std::string fit_samples_text(const nlohmann::json& all) {
    std::string text = fmt::format("{:<12} {:<10} {:>7} {:>14} {:>6} {:>11} {:>11} {:>9}\n", "lamp",
                                   "component", "patch", "cell", "facing", "mean", "residual", "relative");
    for (const auto& e : all) {
        const double mean = e["mean"].get<double>(), residual = e["residual"].get<double>();
        text += fmt::format("{:<12} {:<10} {:>7} {:>14} {:>6} {:>11.4g} {:>11.4g} {:>9.3f}\n",
                            e["light"].get<std::string>(), e["component"].get<std::string>(),
                            e["patch"].get<int>(), e["cell"].dump(), e["facing"].get<std::string>(), mean,
                            residual, residual / mean);
    }
    return text;
}

}  // namespace pim
