// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/sweep.h"

#include <fmt/format.h>
#include <pim_version.h>

#include "bake/bake.h"
#include "bake/info.h"
#include "bake/reference.h"
#include "common/core/error.h"
#include "common/core/file.h"
#include "common/core/log.h"

namespace pim {
namespace fs = std::filesystem;
namespace {

using Settings = std::vector<Setting>;

// All combinations, the last axis fastest.
std::vector<Settings> combinations(const std::vector<Axis>& axes) {
    std::vector<Settings> all{{}};
    for (const Axis& axis : axes) {
        std::vector<Settings> longer;
        for (const Settings& settings : all)
            for (const std::string& value : axis.values) {
                longer.push_back(settings);
                longer.back().push_back({axis.key, value});
            }
        all = std::move(longer);
    }
    return all;
}

// A file name that tells settings apart and can be read.
std::string name_of(const Settings& settings) {
    std::string name;
    for (const Setting& s : settings) {
        name += (name.empty() ? "" : "_") + s.key + "-";
        for (const char c : s.value)
            if (std::isalnum(static_cast<unsigned char>(c)) || c == '.')
                name += c;
            else if (c == ',')
                name += 'x';
    }
    return name;
}

nlohmann::json to_json(const Settings& settings) {
    nlohmann::json json = nlohmann::json::object();
    for (const Setting& s : settings)  // values are TOML: plain ones are JSON too
        json[s.key] =
            nlohmann::json::accept(s.value) ? nlohmann::json::parse(s.value) : nlohmann::json(s.value);
    return json;
}

nlohmann::json read_json(const fs::path& file) {
    return fs::exists(file) ? nlohmann::json::parse(read_text(file), nullptr, false) : nlohmann::json();
}

class Sweep {
  public:
    Sweep(fs::path description, const SweepOptions& options)
        : description_(std::move(description)), options_(options), evaluator_(options.evaluate) {
        std::error_code problem;
        fs::create_directories(options.folder, problem);
        if (problem)
            throw Error(fmt::format("{}: the folder cannot be created: {}", options.folder.string(),
                                    problem.message()));
    }

    nlohmann::json measure(const Settings& settings) {
        const fs::path map = options_.folder / (name_of(settings) + ".vdb"),
                       kept = fs::path(map).replace_extension(".json");
        const std::string key = key_of(settings);
        if (auto known = read_json(kept); known.is_object() && known.value("key", "") == key) return known;
        bake_run(description_, {.output = map, .settings = settings});
        nlohmann::json result{{"key", key}, {"settings", to_json(settings)}, {"map", map.string()}};
        result.update(evaluator_.evaluate(map));
        const auto info = map_info(map);
        for (const char* name : {"cells", "patches", "bytes"}) result[name] = info[name];
        const fs::path work = WorkFolder::beside(map);
        const auto run = read_json(work / "run.json");
        result["photons_total"] = run["photons"]["emitted"];
        for (const char* name : {"cells_seconds", "trace_seconds", "fit_seconds"}) result[name] = run[name];
        write_text_atomically(kept, result.dump(2) + "\n");
        fs::remove_all(work);
        return result;
    }

  private:
    // Of the scene, its settings and how it is evaluated.
    std::string key_of(const Settings& settings) const {
        const Scene scene = read_scene(description_, {.settings = settings, .geometry = {}});
        ContentHash hash;
        hash.feed(kVersion + scene.description + Reference::key(scene, options_.evaluate));
        return hash.hex();
    }

    fs::path description_;
    const SweepOptions& options_;
    Evaluator evaluator_;
};

}  // namespace

Axis parse_axis(const std::string& text) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 >= text.size())
        throw UsageError(fmt::format("--axis: '{}' must look like KEY=a,b,c", text));
    Axis axis{text.substr(0, equals), {""}};
    table_of_setting(axis.key);  // throws where there is none
    int depth = 0;
    for (const char c : text.substr(equals + 1)) {
        depth += int(c == '[') - int(c == ']');
        if (c == ',' && depth == 0)
            axis.values.emplace_back();
        else
            axis.values.back() += c;
    }
    for (const std::string& value : axis.values)
        if (value.empty()) throw UsageError(fmt::format("--axis: '{}' holds an empty value", text));
    return axis;
}

nlohmann::json sweep(const fs::path& description, const SweepOptions& options) {
    const auto all = combinations(options.axes);
    for (const Settings& settings : all)  // mistakes are found before the work
        read_scene(description, {.settings = settings, .geometry = {}});
    Sweep sweeping(description, options);
    nlohmann::json results = nlohmann::json::array();
    for (std::size_t i = 0; i < all.size(); ++i) {
        log_info(fmt::format("sweep: {} of {}: {}", i + 1, all.size(), name_of(all[i])));
        results.push_back(sweeping.measure(all[i]));
    }
    return results;
}

std::string sweep_text(const nlohmann::json& results) {
    std::string text = fmt::format("{:<40} {:>9} {:>9} {:>18} {:>18}\n", "settings", "baked, s", "MB",
                                   "relrmse", "indirect");
    for (const auto& r : results) {
        std::string settings;
        for (const auto& [key, value] : r["settings"].items())
            settings += (settings.empty() ? "" : " ") + key + "=" + value.dump();
        const auto number = [&](const nlohmann::json& v) { return v.get<double>(); };
        text += fmt::format("{:<40} {:>9.1f} {:>9.1f} {:>9.4f} ± {:.4f} {:>9.4f} ± {:.4f}\n", settings,
                            number(r["bake_seconds"]), number(r["bytes"]) / 1e6, number(r["relrmse"]),
                            number(r["confidence"]["relrmse"]), number(r["relrmse_indirect"]),
                            number(r["confidence"]["relrmse_indirect"]));
    }
    return text;
}

}  // namespace pim
