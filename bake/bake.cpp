// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/bake.h"

#include <ctime>
#include <nlohmann/json.hpp>

#include "bake/choose.h"
#include "bake/fit.h"
#include "bake/tracing.h"
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

fs::path output_of(const Scene& scene, const BakeOptions& options) {
    return options.output.value_or(default_output(scene.description_file));
}

// Any other name is likely to be that of a file which the bake reads.
fs::path checked_output(fs::path output) {
    if (output.extension() != ".vdb")
        throw Error(fmt::format("{}: a map's name ends in .vdb; nothing was written", output.string()));
    check_output(output);
    return output;
}

Scene scene_of(const fs::path& description, const BakeOptions& options) {
    return read_scene(description, {.settings = options.settings, .geometry = {}});
}

// A farm's parts must agree on settings before the first photon.
void check_settled(const Scene& scene) {
    if (is_automatic(scene))
        throw Error(fmt::format(
            "{}: leaves settings to be chosen, which `bake run` does; to trace or fit by parts, take what it "
            "chose (`bake info FILE.vdb --description`) or write cells, photons, samples and boxes",
            scene.description_file.string()));
}

// A bake in progress: what photons make, and the map fitted to it.
constexpr uint64_t kFewPhotons = 1000;

class Bake {
  public:
    Bake(Scene scene, const BakeOptions& options, std::optional<Workplace> place = std::nullopt)
        : options_(options), output_(checked_output(output_of(scene, options))), tracing_(std::move(scene)) {
        check_settled(scene_);
        std::vector<std::string> warnings;
        samples_ = all_light_samples(scene_, tracing_.solids(), warnings);
        check_boxes();
        for (const std::string& warning : warnings) log_warning(warning);
        if (!place) place = Workplace{WorkFolder::beside(output_)};
        if (options.overwrite) fs::remove_all(place->folder);
        tracing_.open(*place);
        tracing_.find_cells();
    }

    void trace() { tracing_.trace(part_of_samples()); }

    void fit() {
        const Stopwatch watch;
        const auto missing =
            std::ranges::count_if(samples_, [&](const LightSample& s) { return !work().has(scene_, s); });
        if (missing > 0)
            throw Error(fmt::format(
                "{}: {} of {} lamp positions are not traced yet; run `bake trace` for the missing "
                "parts",
                work().path().string(), missing, samples_.size()));
        IlluminationMap map = empty_map();
        const Neighbourhoods shared = neighbourhoods(scene_, cells_);
        for (std::size_t l = 0; l < scene_.lights.size(); ++l)
            map.lights.push_back(fit_light(int(l), shared));
        map.left_out = left_out(scene_, cells_);
        write_map(output_, map);
        tracing_.note_seconds("fit_seconds", watch.seconds());
        report_account();
        log_info(fmt::format("wrote {} ({:.1f} MB)", output_.string(), double(fs::file_size(output_)) / 1e6));
        if (options_.clean) work().remove();
    }

  private:
    const WorkFolder& work() const { return tracing_.work(); }

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
        IlluminationMap map = map_without_lights(cells_);
        map.origin = scene_.geometry.origin;
        map.grey = is_grey(scene_);
        map.mend_signs = scene_.bake.mend_signs;
        map.components = scene_.bake.components;
        map.description = scene_.description;
        const fs::path folder = fs::absolute(output_).parent_path();
        map.geometry_path = fs::relative(fs::absolute(scene_.geometry_file), folder).generic_string();
        map.geometry_hash = scene_.geometry_hash;
        return map;
    }

    MapLight fit_light(int number, const Neighbourhoods& shared) const {
        std::vector<LightSample> own;
        for (const LightSample& s : samples_)
            if (s.light == number) own.push_back(s);
        MapLight light = pim::fit_light(
            scene_.lights[number], scene_.bake, own, cells_.patches.size(), shared,
            [&](const LightSample& s, Component c) { return work().read(scene_, cells_, s, c); });
        for (std::size_t b = 0; b < light.boxes.size(); ++b) {
            const int terms = int(terms_of(scene_.bake.degree, light.boxes[b].moves()).size());
            if (light.fits[b].rank < terms)
                log_warning(fmt::format(
                    "light '{}', box {}: its {} positions determine {} of {} terms; the others are 0",
                    light.name, b, light.fits[b].samples, light.fits[b].rank, terms));
            note_conditioning(own, light, b);
        }
        return light;
    }

    void note_conditioning(const std::vector<LightSample>& samples, MapLight& light, std::size_t box) const {
        std::vector<Vec3> inside;
        for (const LightSample& s : samples)
            if (light.boxes[box].contains(Vec3d(s.position))) inside.push_back(s.position);
        FitStatistics& fit = light.fits[box];
        fit.raw_condition_number =
            raw_condition_number(light.boxes[box], inside, scene_.bake.degree, scene_.geometry.origin);
        if (fit.condition_number > kBadCondition)
            log_warning(fmt::format(
                "light '{}', box {}: its lamp positions hardly determine the polynomial (condition number "
                "{:.2g}; up to {:.0g} is sound): noise grows; give it more positions, or fewer boxes",
                light.name, box, fit.condition_number, kBadCondition));
    }

    void report_account() {
        EnergyAccount total;
        for (const LightSample& s : samples_) total.add(work().read_account(scene_, s));
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
        if (total.absorbed < kFewPhotons)
            log_warning(fmt::format(
                "few photons ended on a surface, {} of {}: the map holds little but noise; does the "
                "lamp shine on the scene, and are there enough photons?",
                total.absorbed, total.emitted));
        if (std::max({c.x, c.y, c.z}) > 0.01)
            log_warning(
                fmt::format("photons were cut off after {} surfaces with {:.1f} % of the flux: surfaces "
                            "reflect nearly all light; expect the picture to be too dark by that",
                            kMaxPhotonBounces, 100 * std::max({c.x, c.y, c.z})));
        const auto rgb = [](const Vec3d& v) { return nlohmann::json{v.x, v.y, v.z}; };
        work().update_run([&](nlohmann::json& run) {
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
    Tracing tracing_;
    const Scene& scene_ = tracing_.scene();
    const Cells& cells_ = tracing_.cells();
    std::vector<LightSample> samples_;
};

}  // namespace

fs::path default_output(const fs::path& description) {
    return fs::path(description).replace_extension(".vdb");
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
    const double counted = cells.counted_area;
    lines.push_back(fmt::format("{} of {} cells: no surface that light reaches",
                                cells.grid.cell_count() - kept, cells.grid.cell_count()));
    if (counted < cells.surface_area * (1 - 1e-6))
        lines.push_back(fmt::format(
            "{:.4g} of {:.4g} m² of surface (both sides): no light reaches it ({} photons looked "
            "for it beforehand; the last doubling of them moved {:.2g} m²)",
            cells.surface_area - counted, cells.surface_area, cells.deciding_photons, cells.moved_area));
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
    double area = 0;
    for (uint32_t t = 0; t < scene.geometry.triangles.size(); ++t)
        area += 2 * double(pim::area(scene.geometry.corners(t)));
    if (cells.surface_area < 0.999 * area)
        lines.push_back(fmt::format(
            "{:.4g} of {:.4g} m² of surface (both sides): outside the bounds, or of mirrors and glass",
            area - cells.surface_area, area));
    if (std::ranges::all_of(scene.materials,
                            [](const Material& m) { return !m.glass && is_black(m.specular); }))
        lines.push_back("reflected and refracted views: no surface is a mirror or glass");
    if (is_grey(scene)) lines.push_back("two of three colour channels: the scene is grey");
    return lines;
}

void bake_run(const fs::path& description, BakeOptions options) {
    const Stopwatch begun(double(std::clock()) / CLOCKS_PER_SEC);  // since libraries were loaded
    Scene scene = scene_of(description, options);
    const Workplace place{WorkFolder::beside(checked_output(output_of(scene, options)))};
    if (is_automatic(scene)) {
        if (options.overwrite) fs::remove_all(place.folder);
        options.overwrite = false;  // what is traced while choosing stays
        WorkFolder::create(place.folder);
        options.settings = choose_settings(std::move(scene), options.settings, place, begun);
        scene = scene_of(description, options);
    }
    Bake bake(std::move(scene), options, place);
    bake.trace();
    bake.fit();
}

void bake_trace(const fs::path& description, const BakeOptions& options) {
    Bake(scene_of(description, options), options).trace();
}

void bake_fit(const fs::path& description, const BakeOptions& options) {
    Bake(scene_of(description, options), options).fit();
}

}  // namespace pim
