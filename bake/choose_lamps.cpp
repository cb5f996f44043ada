// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/choose_lamps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "bake/domain_divisions.h"
#include "bake/trial_fits.h"
#include "common/core/log.h"
#include "common/map/polynomial.h"

namespace pim {
namespace {

constexpr double kMetShare = 0.97;    // of the target: what was chosen by its error looks better than it is
constexpr double kWorthwhile = 0.97;  // a change must cut the cost at least to this
constexpr double kFastest = 4, kSlowest = 1.3;  // growth of the photons in one round
constexpr double kHalfway = 3;                  // growth in all from which there is a round before the last
constexpr double kPositionsPerTerm = 3.2;       // in the first round
constexpr double kPositionsPerBox = 1.2;        // ... per term and box where more boxes are given
constexpr int kFewestPositions = 5;             // whose scatter tells noise
constexpr double kMostPositions = 20000;        // per lamp: more files and fits than their photons are worth
constexpr int kRounds = 4;               // of doubling, about, that the photons per position are planned for
constexpr double kFitSeconds = 1.5e-7;   // of the last fit, per lamp position and patch; about
constexpr double kReadSeconds = 6e-7;    // ... more, where volumes must be read from their files
constexpr double kBoxSeconds = 4e-6;     // ... per box and patch
constexpr double kMendSeconds = 8e-4;    // ... of which all would have to be mended
constexpr double kWriteSeconds = 3e-7;   // ... per box, patch and term
constexpr double kLeastGrowth = 0.05;    // of the photons: less is not worth another round
constexpr double kLastShare = 0.8;       // of the time left for photons that are not judged any more
constexpr double kMeasuresOfARound = 3;  // fits that are tried, in times that one measure takes

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

double fixed_positions(const Light& light) {
    if (const auto* grid = std::get_if<Index3>(&light.samples)) {
        double count = 1;
        for (int axis = 0; axis < 3; ++axis)
            if (light.domain.max[axis] > light.domain.min[axis]) count *= (*grid)[axis];
        return count;
    }
    double sum = 0;
    for (const SampleGroup& group : sample_groups(light)) sum += group.count;
    return sum;
}

int first_positions(const Light& light) {
    const double per_term = std::max(kPositionsPerTerm, kPositionsPerBox * count_of(light.boxes));
    return std::clamp(int(per_term * terms_at(light, 3)), kFewestPositions, int(kMostPositions));
}

class LampChooser {
  public:
    LampChooser(const Scene& scene, const std::vector<Setting>& settings, const Goal& goal, HeldOut& held_out,
                const GridFigures& grid, double photon_seconds)
        : scene_(scene),
          settings_(settings),
          goal_(goal),
          held_out_(held_out),
          grid_(grid),
          photon_seconds_(photon_seconds),
          degree_(scene.choices.degree ? 3 : scene.bake.degree) {}

    std::vector<Setting> choose(std::optional<Cells> cells, const Workplace& place) {
        begin_lamps();
        open(std::move(cells), place);
        int round = 1;
        do {
            trace_missing();
            judge();
            say(round++);
        } while (grow());
        note_estimate();
        std::vector<Setting> chosen;
        if (scene_.choices.degree) chosen.push_back({"degree", std::to_string(degree_)});
        append_lamps(chosen);
        return chosen;
    }

  private:
    void open(std::optional<Cells> cells, const Workplace& place) {
        const Stopwatch watch;
        std::vector<Setting> so_far = settings_;
        if (scene_.choices.degree) so_far.push_back({"degree", std::to_string(degree_)});
        append_lamps(so_far);
        tracing_.emplace(read_scene(scene_.description_file, {.settings = so_far, .geometry = {}}));
        open_seconds_ = watch.seconds();
        tracing_->open(place);
        noted_before_ = noted_seconds();
        tracing_->find_cells(std::move(cells));
        held_out_.set_cells(tracing_->scene(), tracing_->caster(), tracing_->cells());
        fits_.emplace(*tracing_, held_out_);
    }

    void judge() {
        measure();
        const auto lights = lights_;
        const int degree = degree_;
        const double cost_before = cost(figures_);
        const bool boxes_changed = choose_boxes(), degree_changed = choose_degree();
        if (!boxes_changed && !degree_changed) return;
        // The error of other boxes is measured already; their noise matters where more photons follow.
        if (!degree_changed && goal_.has_budget() && std::max(affordable(), last_growth()) < kSlowest) return;
        measure();
        if (cost(figures_) < kWorthwhile * cost_before) return;
        lights_ = lights, degree_ = degree;  // promised more than it holds
        measure();
    }

    void note_estimate() const {
        tracing_->work().update_run([&](nlohmann::json& run) {
            run["estimated_error"] = {{"relrmse", figures_.error.relrmse},
                                      {"standard_error", figures_.error.standard_error},
                                      {"noise", std::sqrt(std::max(0.0, figures_.noise_sum()))},
                                      {"grid", std::sqrt(std::max(0.0, grid_.square))},
                                      {"floor", std::sqrt(std::max(0.0, figures_.floor()))}};
        });
        tracing_->note_seconds("choose_seconds", goal_.seconds() - (noted_seconds() - noted_before_));
    }

    double noted_seconds() const {  // by this run and others
        double sum = 0;
        tracing_->work().update_run([&](nlohmann::json& run) {
            sum = run.value("cells_seconds", 0.0) + run.value("trace_seconds", 0.0);
        });
        return sum;
    }

    void begin_lamps() {
        lights_ = scene_.lights;
        for (Light& light : lights_)
            if (light.choose_samples)
                light.samples = std::vector<SampleGroup>{{light.boxes, first_positions(light)}};
            else if (light.choose_boxes && !std::holds_alternative<Index3>(light.samples))
                light.samples = sample_groups(light);  // which other boxes do not move
    }

    // What is chosen for each lamp, as settings.
    void append_lamps(std::vector<Setting>& settings) const {
        for (const Light& light : lights_) {
            if (light.choose_boxes) settings.push_back({"boxes", text_of(light.boxes), light.name});
            if (const auto* groups = std::get_if<std::vector<SampleGroup>>(&light.samples);
                groups && (light.choose_samples || light.choose_boxes))
                settings.push_back({"samples", text_of(*groups), light.name});
        }
    }

    double photons_in_all() const {
        double positions = 0;
        for (const Light& light : lights_) positions += fixed_positions(light);
        return positions * photons();
    }

    void trace_missing() {
        const Stopwatch watch;
        std::size_t traced = 0;
        for (std::size_t l = 0; l < lights_.size(); ++l) {
            std::vector<std::string> warnings;
            const auto samples = light_samples(lights_[l], int(l), tracing_->solids(), warnings);
            traced += tracing_->trace(samples);
            fits_->add(int(l), samples);
        }
        if (traced == 0) return;
        traced_photons_ += double(traced) * photons();
        traced_seconds_ += watch.seconds();
        photon_seconds_ = traced_seconds_ / traced_photons_;
    }

    double photons() const { return double(tracing_->scene().bake.photons); }  // per position

    // Photons still needed as a multiple of those traced, or the squared error at the end of the budget.
    double cost(const TrialFigures& f) const {
        const double square = std::max(0.0, f.square), noise = std::min(f.noise_sum(), square);
        const double floor = square - noise;
        if (goal_.has_budget()) return floor + noise / std::max(1.0, affordable());
        return floor < 0.95 * goal_.square() ? noise / (goal_.square() - floor)
                                             : 1e6 * floor / goal_.square();
    }

    // Photons in all that the budget allows, as a multiple of those traced.
    double affordable() const {
        const double judging = kMeasuresOfARound * measure_seconds_;
        const double more = (goal_.left() - end_seconds() - judging) / (seconds_of_as_many() + judging);
        return 1 + std::max(0.0, more);
    }

    // To trace and fit as many photons again as there are.
    double seconds_of_as_many() const {
        const double positions = photons_in_all() / photons(), patches = patch_count();
        return positions * (photon_seconds_ * photons() + read_seconds(patches * positions) * patches);
    }

    // Of the last fit and the map.
    double end_seconds() const {
        const double positions = photons_in_all() / photons(), patches = patch_count();
        double boxes = 0;
        for (const Light& light : lights_) boxes += count_of(light.boxes);
        return open_seconds_ + 0.3 + patches * positions * read_seconds(patches * positions) +
               patches * boxes *
                   (kBoxSeconds + kMendSeconds * figures_.below_zero +
                    kWriteSeconds * terms_of_cubic(scene_));
    }

    double patch_count() const { return double(tracing_->cells().patches.size()); }

    bool has_time_to_judge() const {
        return !goal_.has_budget() || goal_.left() > end_seconds() + 1.5 * measure_seconds_;
    }

    void measure() {
        const Stopwatch watch;
        figures_ = fits_->measure(lights_, degree_);
        measure_seconds_ = watch.seconds();
    }

    // Per lamp position and patch.
    static double read_seconds(double values) {
        const double bytes = values * double(sizeof(Rgb) + sizeof(float));
        return kFitSeconds + (bytes < VolumeCache::capacity() ? 0 : kReadSeconds);
    }

    // Whether anything was changed.
    bool choose_boxes() {
        tried_ = {boxes_now()};
        bool changed = false;
        while (auto better = better_boxes()) {
            lights_[better->light].boxes = better->boxes;
            figures_ = better->figures;
            fits_->change_boxes(std::move(*better));
            changed = true;
        }
        return changed;
    }

    bool choose_degree() {
        if (!scene_.choices.degree) return false;
        const int other = degree_ == 3 ? 2 : 3;
        const auto figures = fits_->with_degree(other);
        if (!figures || !(cost(*figures) < kWorthwhile * cost(figures_))) return false;
        degree_ = other;
        return true;
    }

    std::vector<Index3> boxes_now() const {  // of each lamp
        std::vector<Index3> all;
        for (const Light& light : lights_) all.push_back(light.boxes);
        return all;
    }

    // The change of one lamp's boxes that promises most, if it is worth it.
    std::optional<TrialFits::BoxTrial> better_boxes() {
        double least = kWorthwhile * cost(figures_);
        std::optional<TrialFits::BoxTrial> best;
        for (std::size_t l = 0; l < lights_.size(); ++l)
            for (const Index3& boxes : other_divisions(lights_[l])) {
                if (!has_time_to_judge()) return best;
                std::vector<Index3> all = boxes_now();
                all[l] = boxes;
                if (std::ranges::find(tried_, all) != tried_.end()) continue;
                tried_.push_back(std::move(all));
                auto trial = fits_->with_boxes(l, boxes);
                if (!trial || !(cost(trial->figures) < least)) continue;
                least = cost(trial->figures);
                best = std::move(trial);
            }
        return best;
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
        if (std::ranges::none_of(lights_, &Light::choose_samples)) {
            if (!is_met()) warn_of_miss("more samples, photons or boxes");
            return false;
        }
        const double factor = goal_.has_budget() ? budget_growth() : target_growth();
        const double before = photons_in_all();
        if (factor > 1) share_out(factor);
        if (photons_in_all() > before) return true;
        if (goal_.has_budget() && !met_)
            use_what_is_left();
        else if (factor > 1)
            warn_of_miss("more photons per lamp position");
        return false;
    }

    void warn_of_miss(const char* mend) const {
        if (!(goal_.target() > 0)) return;
        log_warning(fmt::format(
            "the target error of {} is not reached: it is {:.4f}, of which noise makes {:.4f} and cells "
            "alone "
            "{:.4f}; {} would be needed",
            goal_.target(), figures_.error.relrmse, std::sqrt(std::max(0.0, figures_.noise_sum())),
            std::sqrt(std::max(0.0, grid_.square)), mend));
    }

    double last_growth() const {
        return 1 + kLastShare * (goal_.left() - end_seconds()) / seconds_of_as_many();
    }

    // Too little to judge another round: more positions for what was chosen.
    void use_what_is_left() {
        const double factor = last_growth();
        if (factor > 1 + kLeastGrowth) {
            const double before = photons_in_all();
            share_out(factor);
            trace_missing();
            figures_ = figures_.with_noise(before / photons_in_all());
        }
        log_info(fmt::format("the time is used: error {:.4f}; twice the photons would make it about {:.4f}",
                             figures_.error.relrmse, figures_.with_noise(0.5).error.relrmse));
    }

    // Beyond the doubt that is left of the figure.
    bool is_met() {
        const double target = goal_.target();
        met_ = target > 0 && figures_.error.relrmse + figures_.error.standard_error <= kMetShare * target;
        if (met_) log_info(fmt::format("the target of {} is met", target));
        return met_;
    }

    double target_growth() {
        if (is_met()) return 0;
        const double noise = figures_.noise_sum(), room = goal_.square() - figures_.floor();
        const bool futile = room < 0 && noise < 0.1 * figures_.square;
        if (futile || photons_in_all() * kSlowest > kMostPhotonsInAll) {
            warn_of_miss(futile ? "finer cells or more boxes" : "a time budget, which allows more photons,");
            return 0;
        }
        const double needed = room > 0.2 * goal_.square() ? 1.05 * noise / room : kFastest / 2;
        return std::clamp(needed, kSlowest, kFastest);
    }

    double budget_growth() {
        if (is_met()) return 0;
        const double more = affordable();
        if (more < 1 + kLeastGrowth) return 0;
        if (more > 2 * kFastest) return kFastest;
        return more > kHalfway ? more / 2 : more;  // boxes are chosen while there is time for it
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
            const double most = std::min(kMostPositions, std::max(factor, kFastest) * has);
            const int more = int(std::lround(std::min(wanted, most) - has));
            if (more <= 0) continue;
            auto groups = sample_groups(light);
            if (groups.back().boxes == light.boxes)
                groups.back().count += more;
            else
                groups.push_back({light.boxes, more});
            light.samples = groups;
        }
    }

    const Scene& scene_;
    const std::vector<Setting>& settings_;
    const Goal& goal_;
    HeldOut& held_out_;
    GridFigures grid_;
    double photon_seconds_, open_seconds_ = 1, measure_seconds_ = 0;
    double traced_photons_ = 0, traced_seconds_ = 0, noted_before_ = 0;
    std::optional<Tracing> tracing_;
    std::optional<TrialFits> fits_;
    std::vector<Light> lights_;
    int degree_;
    bool met_ = false;  // the target
    TrialFigures figures_;
    std::vector<std::vector<Index3>> tried_;  // boxes of all lamps, in this round
};

}  // namespace

int terms_of_cubic(const Scene& scene) {
    int terms = 1;
    for (const Light& light : scene.lights) terms = std::max(terms, terms_at(light, 3));
    return terms;
}

double planned_positions(const Light& light) {
    return light.choose_samples ? double(first_positions(light) << (kRounds - 2)) : fixed_positions(light);
}

std::vector<Setting> choose_lamps(const Scene& scene, const std::vector<Setting>& settings, const Goal& goal,
                                  HeldOut& held_out, CellChoice cells, double photon_seconds,
                                  const Workplace& place) {
    LampChooser chooser(scene, settings, goal, held_out, cells.grid, photon_seconds);
    return chooser.choose(std::move(cells.cells), place);
}

}  // namespace pim
