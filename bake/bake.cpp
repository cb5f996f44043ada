// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/bake.h"

#include <nlohmann/json.hpp>

#include "bake/fit.h"
#include "common/core/error.h"
#include "common/core/file.h"
#include "common/core/log.h"
#include "common/core/parallel.h"
#include "common/core/progress.h"
#include "common/core/stopwatch.h"
#include "common/map/map_file.h"
#include "common/scene/scene_file.h"

namespace pim {
namespace fs = std::filesystem;
namespace {

// A bake in progress: the scene, what rays need, and where results are kept.
class Bake {
  public:
    Bake(const fs::path& description, const BakeOptions& options)
        : options_(options),
          output_(options.output.value_or(default_output(description))),
          scene_(read_scene(description, {.settings = options.settings, .geometry = {}})),
          caster_(scene_.geometry, InstructionSet::pinned),
          solids_(solids_of(scene_)),
          work_(begin_work()) {
        for (const std::string& warning : warnings_) log_warning(warning);
    }

    // Which surface counts, from the work folder or anew.
    void find_cells() {
        const Stopwatch watch;
        if (auto known = work_.read_cells()) {
            cells_ = std::move(*known);
        } else {
            cells_ = pim::find_cells(scene_, caster_,
                                     [&](const Vec3& p) { return solids_.containing(p).empty(); });
            work_.write_cells(cells_);
            note_seconds("cells_seconds", watch.seconds());
        }
        if (cells_.patches.empty())
            throw Error("no light reaches any surface in the bounds; do lamps and bounds fit?");
        log_info(fmt::format("{} of {} cells hold surface that counts: {} patches, {:.4g} of {:.4g} m²",
                             cells_.index.cell_count(), cells_.grid.cell_count(), cells_.patches.size(),
                             cells_.counted_area, cells_.surface_area));
    }

    void trace() {
        const Stopwatch watch;
        std::vector<LightSample> missing;
        for (const LightSample& sample : part_of_samples())
            if (!work_.has(scene_, sample)) missing.push_back(sample);
        log_info(fmt::format("{} lamp positions to trace with {} photons each, {} done before",
                             missing.size(), scene_.bake.photons, part_of_samples().size() - missing.size()));
        const SurfaceCells surface(cells_.grid, scene_.geometry);
        Progress progress("tracing lamp positions", missing.size());
        parallel_for(missing.size(), [&](std::size_t i) {
            work_.write(scene_, cells_, missing[i],
                        trace_density(scene_, caster_, cells_, surface, missing[i]));
            progress.advance();
        });
        if (!missing.empty()) note_seconds("trace_seconds", watch.seconds());
    }

    void fit() {
        const Stopwatch watch;
        const auto missing =
            std::ranges::count_if(samples_, [&](const LightSample& s) { return !work_.has(scene_, s); });
        if (missing > 0)
            throw Error(fmt::format(
                "{}: {} of {} lamp positions are not traced yet; run `bake trace` for the missing "
                "parts",
                work_.path().string(), missing, samples_.size()));
        if (scene_.bake.robust == Robust::automatic)
            log_debug("robust = \"auto\": no robust fit exists yet, so it is off");
        IlluminationMap map = empty_map();
        for (std::size_t l = 0; l < scene_.lights.size(); ++l) map.lights.push_back(fit_light(int(l)));
        map.left_out = left_out(scene_, cells_);
        write_map(output_, map);
        note_seconds("fit_seconds", watch.seconds());
        report_account();
        log_info(fmt::format("wrote {} ({:.1f} MB)", output_.string(), double(fs::file_size(output_)) / 1e6));
        if (options_.clean) work_.remove();
    }

  private:
    WorkFolder begin_work() {
        check_output(output_);
        check_receivers();
        samples_ = all_light_samples(scene_, solids_, warnings_);
        check_boxes();
        const fs::path folder = WorkFolder::beside(output_);
        if (options_.overwrite) fs::remove_all(folder);
        return {folder, trace_settings(scene_, caster_, solids_), scene_};
    }

    void check_receivers() const {
        if (std::ranges::none_of(scene_.geometry.triangles,
                                 [&](const Triangle& t) { return scene_.materials[t.material].receives(); }))
            throw Error(
                fmt::format("{}: all surfaces are mirrors or glass, which hold no irradiance; give some "
                            "of them a diffuse reflectance in [[material]]",
                            scene_.description_file.string()));
    }

    // Before anything is traced: a box without positions could not be fitted.
    void check_boxes() const {
        for (std::size_t l = 0; l < scene_.lights.size(); ++l) {
            const auto boxes = split_domain(scene_.lights[l].domain, scene_.lights[l].boxes);
            const auto empty = std::ranges::count_if(boxes, [&](const MapBox& box) {
                return std::ranges::none_of(samples_, [&](const LightSample& s) {
                    return s.light == int(l) && box.contains(Vec3d(s.position));
                });
            });
            if (empty > 0)
                throw Error(fmt::format(
                    "{}: light '{}': {} of its {} boxes hold no lamp position; raise samples or lower "
                    "boxes",
                    scene_.description_file.string(), scene_.lights[l].name, empty, boxes.size()));
        }
    }

    std::vector<LightSample> part_of_samples() const {
        std::vector<LightSample> part;
        for (std::size_t i = 0; i < samples_.size(); ++i)
            if (int(i % std::size_t(options_.parts)) == options_.part - 1) part.push_back(samples_[i]);
        return part;
    }

    IlluminationMap empty_map() const {
        IlluminationMap map;
        map.origin = scene_.geometry.origin;
        map.grid = cells_.grid;
        map.patches = cells_.patches;
        map.index = cells_.index;
        map.sight = cells_.sight;
        map.grey = is_grey(scene_);
        map.mend_signs = scene_.bake.mend_signs;
        map.components = scene_.bake.components;
        map.description = scene_.description;
        const fs::path folder = fs::absolute(output_).parent_path();
        map.geometry_path = fs::relative(fs::absolute(scene_.geometry_file), folder).generic_string();
        map.geometry_hash = scene_.geometry_hash;
        return map;
    }

    MapLight fit_light(int number) const {
        std::vector<LightSample> own;
        for (const LightSample& s : samples_)
            if (s.light == number) own.push_back(s);
        const Neighbourhoods shared =
            scene_.bake.shrinkage ? neighbourhoods(cells_.index, cells_.patches) : Neighbourhoods{};
        MapLight light = pim::fit_light(
            scene_.lights[number], scene_.bake, own, cells_.patches.size(), shared,
            [&](const LightSample& s, Component c) { return work_.read_density(scene_, cells_, s, c); });
        for (std::size_t b = 0; b < light.boxes.size(); ++b) {
            const int terms = int(terms_of(scene_.bake.degree, light.boxes[b].moves()).size());
            if (light.fits[b].rank < terms)
                log_warning(fmt::format(
                    "light '{}', box {}: its {} positions determine {} of {} terms; the others are 0",
                    light.name, b, light.fits[b].samples, light.fits[b].rank, terms));
        }
        return light;
    }

    void note_seconds(const char* key, double seconds) {
        work_.update_run([&](nlohmann::json& run) {
            run[key] = run.value(key, 0.0) + seconds;
            run["bake_seconds"] = run.value("cells_seconds", 0.0) + run.value("trace_seconds", 0.0) +
                                  run.value("fit_seconds", 0.0);
            run["threads"] = thread_count();
            run["settings"] = trace_settings(scene_, caster_, solids_);
        });
    }

    void report_account() {
        EnergyAccount total;
        for (const LightSample& s : samples_) total.add(work_.read_account(scene_, s));
        const auto share = [&](const Vec3d& v) { return v / double(total.emitted); };
        const Vec3d a = share(total.absorbed_flux), e = share(total.escaped_flux),
                    c = share(total.cut_off_flux), n = share(total.normals_flux),
                    sum = share(total.total_flux()), error = total.standard_error();
        log_info(fmt::format("photons: {} emitted = {} absorbed + {} escaped + {} cut off", total.emitted,
                             total.absorbed, total.escaped, total.cut_off));
        log_info(fmt::format(
            "flux of red, green, blue: {:.4f} {:.4f} {:.4f} absorbed, {:.4f} {:.4f} {:.4f} escaped, "
            "{:.4f} {:.4f} {:.4f} cut off, sum {:.4f} {:.4f} {:.4f} (standard error {:.4f} {:.4f} {:.4f})",
            a.x, a.y, a.z, e.x, e.y, e.z, c.x, c.y, c.z, sum.x, sum.y, sum.z, error.x, error.y, error.z));
        if (std::max({c.x, c.y, c.z}) > 0.01)
            log_warning(
                fmt::format("photons were cut off after {} surfaces with {:.1f} % of the flux: surfaces "
                            "reflect nearly all light; expect the picture to be too dark by that",
                            kMaxPhotonBounces, 100 * std::max({c.x, c.y, c.z})));
        const auto rgb = [](const Vec3d& v) { return nlohmann::json{v.x, v.y, v.z}; };
        work_.update_run([&](nlohmann::json& run) {
            run["photons"] = {{"emitted", total.emitted},
                              {"absorbed", total.absorbed},
                              {"escaped", total.escaped},
                              {"cut_off", total.cut_off}};
            run["flux"] = {{"absorbed", rgb(a)},        {"escaped", rgb(e)}, {"cut_off", rgb(c)},
                           {"shading_normals", rgb(n)}, {"sum", rgb(sum)},   {"standard_error", rgb(error)}};
        });
    }

    BakeOptions options_;
    fs::path output_;
    Scene scene_;
    RayCaster caster_;
    Solids solids_;
    std::vector<LightSample> samples_;
    std::vector<std::string> warnings_;
    WorkFolder work_;
    Cells cells_;
};

}  // namespace

fs::path default_output(const fs::path& description) {
    return fs::path(description).replace_extension(".vdb");
}

Solids solids_of(const Scene& scene) {
    std::vector<Vec3> eyes;
    for (const Camera& camera : scene.cameras) eyes.push_back(camera.eye);
    return {scene.geometry, eyes};
}

std::vector<LightSample> all_light_samples(const Scene& scene, const Solids& solids,
                                           std::vector<std::string>& warnings) {
    std::vector<LightSample> all;
    for (std::size_t l = 0; l < scene.lights.size(); ++l) {
        const Light& light = scene.lights[l];
        const auto samples = light_samples(light, int(l), solids, warnings);
        if (samples.empty())
            throw Error(
                fmt::format("light '{}': every position lies inside '{}'; move the lamp or its domain",
                            light.name, solids.containing(light.position)));
        if (const std::string solid = solids.containing(light.position); !solid.empty())
            warnings.push_back(fmt::format("light '{}': its position lies inside '{}'", light.name, solid));
        all.insert(all.end(), samples.begin(), samples.end());
    }
    return all;
}

std::vector<std::string> left_out(const Scene& scene, const Cells& cells) {
    std::vector<std::string> lines;
    const uint64_t kept = cells.index.cell_count();
    const double area = cells.counted_area;
    lines.push_back(fmt::format("{} of {} cells: no surface that light reaches",
                                cells.grid.cell_count() - kept, cells.grid.cell_count()));
    if (area < cells.surface_area * (1 - 1e-6))
        lines.push_back(fmt::format(
            "{:.4g} of {:.4g} m² of surface (both sides): no light reaches it ({} photons looked "
            "for it beforehand; the last doubling of them moved {:.2g} m²)",
            cells.surface_area - area, cells.surface_area, cells.deciding_photons, cells.moved_area));
    const auto facings = cells_by_slot(cells.patches);
    for (int f = 0; cells.grid.facings && f < kFacingCount; ++f)
        if (facings[f].cells.empty())
            lines.push_back(fmt::format("facing {}: occurs nowhere", slot_name(cells.grid, f)));
    for (const Light& light : scene.lights) {
        const auto moves = split_domain(light.domain, light.boxes)[0].moves();
        const auto terms = terms_of(scene.bake.degree, moves).size();
        if (terms < std::size_t(kTermCount))
            lines.push_back(fmt::format("light '{}': {} of {} polynomial terms are enough", light.name, terms,
                                        kTermCount));
    }
    if (is_grey(scene)) lines.push_back("two of three colour channels: the scene is grey");
    return lines;
}

void bake_run(const fs::path& description, const BakeOptions& options) {
    Bake bake(description, options);
    bake.find_cells();
    bake.trace();
    bake.fit();
}

void bake_trace(const fs::path& description, const BakeOptions& options) {
    Bake bake(description, options);
    bake.find_cells();
    bake.trace();
}

void bake_fit(const fs::path& description, const BakeOptions& options) {
    Bake bake(description, options);
    bake.find_cells();
    bake.fit();
}

}  // namespace pim
