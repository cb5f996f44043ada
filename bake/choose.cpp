// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/choose.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <nlohmann/json.hpp>

#include "bake/choice.h"
#include "bake/lit_region.h"
#include "bake/trial_fits.h"
#include "common/core/log.h"
#include "common/core/parallel.h"
#include "common/core/stopwatch.h"
#include "common/map/polynomial.h"

namespace pim {
namespace fs = std::filesystem;
namespace {

constexpr double kMostPhotons = 4e9;  // in all, without a time budget
constexpr double kGridShare = 0.9;    // of the squared target error that cells alone may make
constexpr double kGoalShare = 0.8;    // of the squared target error that is aimed at
constexpr double kMetShare = 0.97;    // of the target: what was chosen by its error looks better than it is
constexpr double kWorthwhile = 0.97;  // a change must cut the cost at least to this
constexpr double kFastest = 4, kSlowest = 1.3;  // growth of the photons in one round
constexpr double kPositionsPerTerm = 3.2;       // in the first round
constexpr int kRounds = 4;  // of doubling, about, that the photons per position are planned for
constexpr double kMostPositions = 2000;
constexpr double kPhotonsOfAFile = 2e4;  // cost as much time as a file of a volume, several times over
constexpr double kPatchPhotons = 150;    // photons that cost as much time as keeping a patch in all volumes
constexpr double kReadSeconds = 7e-7;    // of the last fit, per lamp position and patch; about
constexpr double kMendSeconds = 5e-5;    // ... per box and patch
constexpr double kWriteSeconds = 3e-7;   // ... per box, patch and term
constexpr int kMostBoxes = 16;           // per axis
constexpr double kMostBoxesInAll = 512;

std::string text_of(const Index3& v) { return fmt::format("[{}, {}, {}]", v.x, v.y, v.z); }

std::string text_of(const std::vector<SampleGroup>& groups) {
    std::string text;
    for (const SampleGroup& group : groups)
        text += fmt::format("{}{{ boxes = {}, count = {} }}", text.empty() ? "" : ", ", text_of(group.boxes),
                            group.count);
    return "[" + text + "]";
}

int terms_at(const Light& light, int degree) {
    return int(terms_of(degree, split_domain(light.domain, light.boxes)[0].moves()).size());
}

// 1, 2 or 5 times a power of ten.
uint64_t round_number(double x) {
    const double power = std::pow(10.0, std::floor(std::log10(x)));
    const double digit = x / power;
    return uint64_t(std::lround(power * (digit < 1.4 ? 1 : digit < 3.2 ? 2 : digit < 7 ? 5 : 10)));
}

class Chooser {
  public:
    Chooser(Scene scene, const std::vector<Setting>& given, fs::path work_folder)
        : scene_(std::move(scene)), settings_(given), work_folder_(std::move(work_folder)) {
        settings_.push_back({"target_error", ""});
        settings_.push_back({"time_budget", ""});
        given_ = settings_.size();
        if (!scene_.choices.target_error && !scene_.choices.time_budget)
            scene_.choices.target_error = kDefaultTargetError;
    }

    std::vector<Setting> choose() {
        const auto known = read_choice(work_folder_);
        const bool fits = known && known->open == open_choices(scene_);
        if (fits && known->finished && known->description == scene_.description) {
            log_info("what was chosen before is kept; --overwrite begins anew");
            settings_.insert(settings_.end(), known->settings.begin(), known->settings.end());
            return settings_;
        }
        if (fits)
            keep_cells(*known);
        else
            choose_cells();
        keep(false);
        trace_and_judge();
        keep(true);
        return settings_;
    }

  private:
    // ---- goals

    bool has_budget() const { return scene_.choices.time_budget.has_value(); }
    double budget() const { return *scene_.choices.time_budget; }
    double left() const { return budget() - watch_.seconds(); }
    // Of the squared error; infinite effort where there is none.
    double goal() const {
        const double target = scene_.choices.target_error.value_or(0);
        return kGoalShare * target * target;
    }
    // The squared error that is hoped for: a minute of photons brings many rooms to 0.03, a hundred times as
    // many to 0.01.
    double wanted_square() const { return has_budget() ? 1e-3 * std::pow(60 / budget(), 0.5) : goal(); }
    int moving_terms() const {
        int terms = 1;
        for (const Light& light : scene_.lights) terms = std::max(terms, terms_at(light, 3));
        return terms;
    }

    HeldOut::Size held_out_size() const {
        HeldOut::Size size;
        if (scene_.choices.target_error)
            size.paths =
                int(std::clamp(256 * std::pow(0.02 / *scene_.choices.target_error, 2), 32.0, 4096.0));
        if (has_budget()) {
            const double paths = std::min(4e6, 6e4 * budget());  // a twentieth of the time or so
            size.positions = paths < 1e6 ? 16 : 32;
            size.pixels = 500;
            size.paths = std::max(16, int(paths / (size.positions * size.pixels)) / 2 * 2);
        }
        return size;
    }

    // ---- an earlier run

    void keep(bool finished) const {
        write_choice(work_folder_, {.description = scene_.description,
                                    .open = open_choices(scene_),
                                    .settings = {settings_.begin() + std::ptrdiff_t(given_), settings_.end()},
                                    .grid = grid_,
                                    .finished = finished});
    }

    void keep_cells(const Choice& known) {
        for (const Setting& s : known.settings)
            if (table_of_setting(s.key) == "grid" || s.key == "photons") settings_.push_back(s);
        grid_ = known.grid;
        log_info(
            fmt::format("cells of {:.3g} m were chosen before; --overwrite begins anew", grid_.cell_size));
        const RayCaster caster(scene_.geometry, InstructionSet::pinned);
        const Solids solids = solids_of(scene_);
        if (has_budget())
            photon_seconds_ = time_photons(scene_, caster, [&](const Vec3& p) {
                                  return solids.containing(p).empty();
                              }).seconds_per_photon;
        held_out_.emplace(scene_, caster, solids, held_out_size());
    }

    // ---- cells

    void choose_cells() {
        const RayCaster caster(scene_.geometry, InstructionSet::pinned);
        const Solids solids = solids_of(scene_);
        const PositionFilter allowed = [&](const Vec3& p) { return solids.containing(p).empty(); };
        if (scene_.choices.cells && !scene_.grid.bounds) choose_bounds(caster, allowed);
        held_out_.emplace(scene_, caster, solids, held_out_size());
        const Stopwatch watch;
        if (has_budget())  // and counting them
            photon_seconds_ = 1.5 * time_photons(scene_, caster, allowed).seconds_per_photon;
        choose_reach();
        GridSearch search(scene_, caster, allowed, *held_out_, wanted_square(), first_photons());
        double last = watch.seconds();
        const auto go_on = [&] {
            const double now = watch.seconds(), step = now - last;
            last = now;
            return !has_budget() || watch_.seconds() + 3 * step < 0.3 * budget();
        };
        const Box3 region = scene_.grid.bounds.value_or(bounds(scene_.geometry));
        const Vec3 size = region.size();
        if (scene_.choices.cells) {
            grid_ = search.search(
                double(std::max({size.x, size.y, size.z})), first_cells(),
                [&](const GridFigures& f) { return grid_cost(f); }, go_on);
            cells_ = search.take_cells();
            settings_.push_back({"cell_size", fmt::format("{:.17g}", grid_.cell_size)});
            settings_.push_back({"reach_photons", std::to_string(scene_.grid.reach_photons)});
            log_info(fmt::format("chose cells of {:.3g} m: {}", grid_.cell_size, grid_reason()));
        } else {
            grid_ = search.measure(make_grid(scene_).cell_size);
        }
        choose_photons();
    }

    // Looking for what light reaches is to take a twentieth of the time at most.
    void choose_reach() {
        if (!has_budget() || !scene_.choices.cells) return;
        const auto affordable = uint64_t(0.05 * budget() / photon_seconds_);
        scene_.grid.reach_photons =
            std::clamp(std::bit_floor(affordable), uint64_t{1} << 20, GridSettings{}.reach_photons);
    }

    // Along the longest side. Noise goes with one over the cells' area, the grid's error with their size or
    // so: the best size goes with the fourth root of the photons.
    double first_cells() const {
        return has_budget() ? 22 * std::pow(std::max(1.0, 0.6e-6 * budget() / photon_seconds_), 0.25) : 22;
    }

    // For the first grid: with a budget, a twentieth of the time at most.
    uint64_t first_photons() const {
        constexpr double kEnough = 1 << 14;
        if (!has_budget()) return uint64_t(kEnough);
        const double volumes = 2.0 * held_out_->positions() * double(scene_.lights.size());
        return uint64_t(std::clamp(0.05 * budget() / photon_seconds_ / volumes, 2048.0, kEnough));
    }

    void choose_bounds(const RayCaster& caster, const PositionFilter& allowed) {
        const auto region = lit_region(scene_, caster, allowed);
        if (!region) return;
        const Vec3d low = scene_.geometry.to_world(region->min), high = scene_.geometry.to_world(region->max);
        settings_.push_back(
            {"bounds",
             fmt::format("{{ min = [{:.17g}, {:.17g}, {:.17g}], max = [{:.17g}, {:.17g}, {:.17g}] }}", low.x,
                         low.y, low.z, high.x, high.y, high.z)});
        scene_.grid.bounds = Box3(scene_.geometry.to_local(low), scene_.geometry.to_local(high));
        log_info(
            fmt::format("chose bounds from {:.4g},{:.4g},{:.4g} to {:.4g},{:.4g},{:.4g}: little light lands "
                        "elsewhere",
                        low.x, low.y, low.z, high.x, high.y, high.z));
    }

    // Noise of the map for one photon in all: each fit spreads a term's worth of noise over the positions,
    // and shrinkage takes about half of it away again.
    double map_noise(const GridFigures& f) const { return 0.2 * double(moving_terms()) * f.noise; }

    // Photons that reach the target, or the squared error that the budget reaches.
    double grid_cost(const GridFigures& f) const {
        const double keeping = kPatchPhotons * double(f.patches), square = std::max(0.0, f.square);
        if (!has_budget()) {
            const double room = goal() - square;
            return square < kGridShare * goal() ? map_noise(f) / room + keeping : 1e18 * square / goal();
        }
        const double photons = 0.6 * budget() / photon_seconds_ - keeping;
        return photons > 0 ? square + map_noise(f) / photons : 1e18 * keeping;
    }

    std::string grid_reason() const {
        if (has_budget()) return "the least error for the time";
        return grid_.square < kGridShare * goal()
                   ? "the fewest photons for the target"
                   : "no others come nearer to the target, which they alone miss";
    }

    // So many per position that a few doublings of the first positions hold all that are needed.
    void choose_photons() {
        if (!scene_.choices.photons) return;
        double wanted = has_budget() ? 0.6 * budget() / photon_seconds_
                                     : map_noise(grid_) / std::max(goal() - grid_.square, 0.2 * goal());
        double positions = 0;
        for (const Light& light : scene_.lights)
            positions += light.choose_samples ? double(first_positions(light) << (kRounds - 2))
                                              : double(fixed_positions(light));
        const double fewest = std::max(2000.0, 0.2 * double(grid_.patches));
        // More positions serve more boxes, at the same noise; but each has its patches to keep.
        const double most = std::max({kPhotonsOfAFile, double(grid_.patches), wanted / kMostPositions});
        scene_.bake.photons = round_number(std::clamp(wanted / positions, fewest, most));
        settings_.push_back({"photons", std::to_string(scene_.bake.photons)});
        log_info(fmt::format("chose {} photons per lamp position", scene_.bake.photons));
    }

    static double fixed_positions(const Light& light) {
        if (const auto* grid = std::get_if<Index3>(&light.samples))
            return double(grid->x) * grid->y * grid->z;
        double sum = 0;
        for (const SampleGroup& group : sample_groups(light)) sum += group.count;
        return sum;
    }

    static int first_positions(const Light& light) {
        return std::max(4, int(kPositionsPerTerm * terms_at(light, 3)));
    }

    // ---- rounds

    void trace_and_judge() {
        std::vector<Setting> so_far = settings_;
        so_far.push_back({"degree", "3"});
        begin_lamps();
        append_lamps(so_far);
        const Stopwatch open_watch;
        tracing_.emplace(read_scene(scene_.description_file, {.settings = so_far, .geometry = {}}));
        scene_.bake.photons = tracing_->scene().bake.photons;
        open_seconds_ = open_watch.seconds();
        tracing_->open(work_folder_);
        tracing_->find_cells(std::exchange(cells_, std::nullopt));
        held_out_->set_cells(tracing_->scene(), tracing_->caster(), tracing_->cells());
        fits_.emplace(*tracing_, *held_out_);
        double traced_seconds = 0, traced = 0;
        for (int round = 1;; ++round) {
            const Stopwatch trace_watch;
            if (const std::size_t positions = trace_missing(); positions > 0) {
                traced += double(positions) * double(scene_.bake.photons);
                traced_seconds += trace_watch.seconds();
                photon_seconds_ = traced_seconds / traced;
            }
            const Stopwatch judge_watch;
            figures_ = fits_->measure(lights_, degree_);
            choose_boxes();
            judge_seconds_ = judge_watch.seconds();
            say(round);
            if (!grow()) break;
        }
        if (scene_.choices.degree) settings_.push_back({"degree", std::to_string(degree_)});
        append_lamps(settings_);
        tracing_->work().update_run([&](nlohmann::json& run) {
            run["estimated_error"] = {{"relrmse", figures_.error.relrmse},
                                      {"standard_error", figures_.error.standard_error},
                                      {"noise", std::sqrt(std::max(0.0, figures_.noise_sum()))},
                                      {"grid", std::sqrt(std::max(0.0, grid_.square))},
                                      {"floor", std::sqrt(std::max(0.0, figures_.floor()))}};
        });
        tracing_->note_seconds("choose_seconds", watch_.seconds() - noted_seconds());
    }

    double noted_seconds() const {
        double sum = 0;
        tracing_->work().update_run([&](nlohmann::json& run) {
            sum = run.value("cells_seconds", 0.0) + run.value("trace_seconds", 0.0);
        });
        return std::min(sum, watch_.seconds());
    }

    void begin_lamps() {
        lights_ = scene_.lights;
        for (Light& light : lights_)
            if (light.choose_samples)
                light.samples = std::vector<SampleGroup>{{light.boxes, first_positions(light)}};
    }

    // What is chosen for each lamp, as settings.
    void append_lamps(std::vector<Setting>& settings) const {
        for (const Light& light : lights_) {
            if (light.choose_boxes) settings.push_back({"boxes", text_of(light.boxes), light.name});
            if (light.choose_samples)
                settings.push_back({"samples", text_of(sample_groups(light)), light.name});
        }
    }

    double photons_in_all() const {
        double positions = 0;
        for (const Light& light : lights_) positions += fixed_positions(light);
        return positions * double(scene_.bake.photons);
    }

    // Returns how many positions there were to trace.
    std::size_t trace_missing() {
        std::size_t traced = 0;
        for (std::size_t l = 0; l < lights_.size(); ++l) {
            std::vector<std::string> warnings;
            const auto samples = light_samples(lights_[l], int(l), tracing_->solids(), warnings);
            traced += tracing_->trace(samples);
            fits_->add(int(l), samples);
        }
        return traced;
    }

    // Photons still needed as a multiple of those traced, or the squared error at the end of the budget.
    double cost(const TrialFigures& f) const { return cost(f.floor(), f.noise_sum()); }
    double cost(double floor, double noise) const {
        floor = std::max(0.0, floor);
        if (has_budget()) return floor + noise / std::max(1.0, affordable());
        return floor < 0.95 * goal() ? noise / (goal() - floor) : 1e6 * floor / goal();
    }

    // Photons in all that the budget allows, as a multiple of those traced.
    double affordable() const {
        const double patches = double(tracing_->cells().patches.size());
        double boxes = 0;
        for (const Light& light : lights_) boxes += double(light.boxes.x * light.boxes.y * light.boxes.z);
        const double positions = photons_in_all() / double(scene_.bake.photons);
        const double terms = moving_terms();
        const double end = open_seconds_ + 0.3 + patches * boxes * (kMendSeconds + kWriteSeconds * terms);
        const double as_far =
            positions * (photon_seconds_ * double(scene_.bake.photons) + kReadSeconds * patches);
        const double more = (left() - end - judge_seconds_) / (as_far + judge_seconds_);
        return 1 + std::max(0.0, more);
    }

    void choose_boxes() {
        while (const auto better = better_boxes()) {
            const auto before = std::pair(lights_, figures_);
            lights_[better->first].boxes = better->second;
            figures_ = fits_->measure(lights_, degree_);
            if (cost(figures_) < kWorthwhile * cost(before.second)) continue;
            lights_ = before.first;  // promised more than it holds
            figures_ = fits_->measure(lights_, degree_);
            break;
        }
        if (!scene_.choices.degree) return;
        for (const int degree : {2, 3}) {
            if (degree == degree_) continue;
            const auto figures = fits_->with_degree(degree);
            if (!figures || !(cost(*figures) < kWorthwhile * cost(figures_))) continue;
            degree_ = degree;
            figures_ = fits_->measure(lights_, degree_);
            break;
        }
    }

    // The change of one lamp's boxes that promises most, if it is worth it.
    std::optional<std::pair<std::size_t, Index3>> better_boxes() const {
        double least = kWorthwhile * cost(figures_);
        std::optional<std::pair<std::size_t, Index3>> best;
        for (std::size_t l = 0; l < lights_.size(); ++l)
            for (const Index3& boxes : other_boxes(lights_[l])) {
                // Boxes take nothing away of what cells alone make.
                const auto figures = fits_->with_boxes(
                    l, boxes, [&](double noise) { return cost(grid_.square, noise) < least; });
                if (!figures || !(cost(*figures) < least)) continue;
                least = cost(*figures);
                best = {l, boxes};
            }
        return best;
    }

    static std::vector<Index3> other_boxes(const Light& light) {
        std::vector<Index3> others;
        if (!light.choose_boxes) return others;
        for (int axis = 0; axis < 3; ++axis) {
            if (!(light.domain.max[axis] > light.domain.min[axis])) continue;
            for (const int step : {1, -1, light.boxes[axis]}) {
                Index3 boxes = light.boxes;
                boxes[axis] += step;
                const double all = double(boxes.x) * boxes.y * boxes.z;
                if (boxes[axis] < 1 || boxes[axis] > kMostBoxes || all > kMostBoxesInAll) continue;
                if (std::ranges::find(others, boxes) == others.end()) others.push_back(boxes);
            }
        }
        return others;
    }

    void say(int round) const {
        const auto root = [](double square) { return std::sqrt(std::max(0.0, square)); };
        std::string lamps;
        for (const Light& light : lights_)
            lamps += fmt::format("{}{} positions in {} x {} x {} boxes", lamps.empty() ? "" : "; ",
                                 int(fixed_positions(light)), light.boxes.x, light.boxes.y, light.boxes.z);
        log_info(fmt::format(
            "round {}: {}; degree {}: error {:.4f} ± {:.4f}; alone: noise {:.4f}, grid {:.4f}, "
            "polynomial {:.4f}",
            round, lamps, degree_, figures_.error.relrmse, 2 * figures_.error.standard_error,
            root(figures_.noise_sum()), root(grid_.square), root(figures_.floor() - grid_.square)));
    }

    // Plans the next round; false: this was the last.
    bool grow() {
        if (std::ranges::none_of(lights_, &Light::choose_samples)) return false;
        const double factor = has_budget() ? budget_growth() : target_growth();
        if (!(factor > 1)) return false;
        share_out(factor);
        return true;
    }

    // Beyond the doubt that is left of the figure.
    bool is_met() const {
        const double target = scene_.choices.target_error.value_or(0);
        const bool met = figures_.error.relrmse + figures_.error.standard_error <= kMetShare * target;
        if (met) log_info(fmt::format("the target of {} is met", target));
        return met;
    }

    double target_growth() {
        const double target = *scene_.choices.target_error, own = figures_.error.relrmse;
        if (is_met()) return 0;
        const double noise = figures_.noise_sum(), room = goal() - figures_.floor();
        if (photons_in_all() * kSlowest > kMostPhotons || (room < 0 && noise < 0.1 * figures_.square)) {
            log_warning(
                fmt::format("the target error of {} is not reached: it is {:.4f}, of which noise makes "
                            "{:.4f} and cells alone {:.4f}; finer cells or more boxes would be needed",
                            target, own, std::sqrt(noise), std::sqrt(std::max(0.0, grid_.square))));
            return 0;
        }
        const double needed = room > 0.2 * goal() ? 1.05 * noise / room : kFastest / 2;
        return std::clamp(needed, kSlowest, kFastest);
    }

    double budget_growth() {
        if (is_met()) return 0;
        const double more = affordable();
        if (more < 1.05) {
            const double noise = figures_.noise_sum(), square = figures_.square;
            log_info(
                fmt::format("the time is used: error {:.4f}; twice the photons would make it about {:.4f}",
                            figures_.error.relrmse,
                            figures_.error.relrmse * std::sqrt(std::max(0.0, 1 - 0.5 * noise / square))));
            return 0;
        }
        return std::min(more, kFastest);
    }

    // More positions to lamps whose noise is large: least noise in all for a given number of photons.
    void share_out(double factor) {
        double all = 0, weights = 0;
        const auto weight = [&](std::size_t l) {
            return std::sqrt(std::max(1e-12, figures_.noise[l]) * fixed_positions(lights_[l]));
        };
        for (std::size_t l = 0; l < lights_.size(); ++l)
            if (lights_[l].choose_samples) all += fixed_positions(lights_[l]), weights += weight(l);
        for (std::size_t l = 0; l < lights_.size(); ++l) {
            Light& light = lights_[l];
            if (!light.choose_samples) continue;
            const double wanted = factor * all * weight(l) / weights, has = fixed_positions(light);
            const int more = int(std::lround(std::min(wanted, kFastest * has) - has));
            if (more <= 0) continue;
            auto groups = sample_groups(light);
            if (groups.back().boxes == light.boxes)
                groups.back().count += more;
            else
                groups.push_back({light.boxes, more});
            light.samples = groups;
        }
    }

    Stopwatch watch_;
    Scene scene_;
    std::vector<Setting> settings_;
    std::size_t given_ = 0;  // so many of them
    fs::path work_folder_;
    std::optional<HeldOut> held_out_;
    GridFigures grid_;
    std::optional<Cells> cells_;  // if they were searched for
    double photon_seconds_ = 1e-6, open_seconds_ = 1, judge_seconds_ = 0;
    std::optional<Tracing> tracing_;
    std::optional<TrialFits> fits_;
    std::vector<Light> lights_;
    int degree_ = 3;
    TrialFigures figures_;
};

}  // namespace

std::vector<Setting> choose_settings(Scene scene, const std::vector<Setting>& given,
                                     const fs::path& work_folder) {
    return Chooser(std::move(scene), given, work_folder).choose();
}

}  // namespace pim
