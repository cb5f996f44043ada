// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/trial_fits.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "bake/statistics.h"
#include "common/core/parallel.h"

namespace pim {
namespace {

constexpr double kPositionsPerTerm = 2;  // fewer in a box are too few to try it
constexpr int kGroups = 5;

}  // namespace

double TrialFigures::noise_sum() const { return std::accumulate(noise.begin(), noise.end(), 0.0); }

TrialFigures TrialFigures::with_noise(double share) const {
    TrialFigures figures = *this;
    if (!(square > 0)) return figures;
    const double less = std::max(0.0, 1 - (1 - share) * std::min(noise_sum(), square) / square);
    figures.square *= less;
    figures.error.relrmse *= std::sqrt(less);
    for (double& n : figures.noise) n *= share;
    return figures;
}

TrialFits::TrialFits(const Tracing& tracing, const HeldOut& held_out)
    : tracing_(tracing),
      held_out_(held_out),
      shared_(neighbourhoods(tracing.scene(), tracing.cells(), held_out.patches())),
      lamps_(tracing.scene().lights.size()) {}

void TrialFits::add(int light, const std::vector<LightSample>& samples) {
    Lamp& lamp = lamps_[std::size_t(light)];
    const std::size_t known = lamp.samples.size();
    lamp.samples = samples;
    lamp.volumes.resize(samples.size());
    const auto& patches = held_out_.patches();
    parallel_for(samples.size() - known, [&](std::size_t i) {
        for (const Component c : tracing_.scene().bake.components) {
            const auto all = tracing_.work().read(tracing_.scene(), tracing_.cells(), samples[known + i], c);
            auto& own = lamp.volumes[known + i].components[std::size_t(c)];
            for (const uint32_t p : patches) {
                own.density.push_back(all.density[p]);
                own.variance.push_back(all.variance[p]);
            }
        }
    });
}

TrialFits::AtPositions TrialFits::fitted(std::size_t light, const Light& as, int degree,
                                         const std::vector<LightSample>& samples) const {
    const Lamp& lamp = lamps_[light];
    BakeSettings settings = tracing_.scene().bake;
    settings.degree = degree;
    settings.robust = Robust::off;  // these cost more than the fit, and change the error by a percent or two
    settings.mend_signs = false;
    IlluminationMap map;
    map.patches.resize(held_out_.patches().size());
    map.mend_signs = false;
    const auto density = [&](const LightSample& sample, Component c) {
        const auto found = std::ranges::lower_bound(lamp.samples, sample.number, {}, &LightSample::number);
        return lamp.volumes[std::size_t(found - lamp.samples.begin())].components[std::size_t(c)];
    };
    map.lights.push_back(fit_light(as, settings, samples, map.patches.size(), shared_, density));
    AtPositions at(std::size_t(held_out_.positions()));
    parallel_for(at.size(), [&](std::size_t i) {
        at[i] = patch_irradiance(map, settings.components, {held_out_.lamps(int(i))[light]});
    });
    return at;
}

std::vector<double> TrialFits::leverage(std::size_t light, const Light& as, int degree) const {
    std::vector<Vec3d> at;
    for (int i = 0; i < held_out_.positions(); ++i) at.emplace_back(held_out_.lamps(i)[light].position);
    std::vector<double> sums(at.size(), 0);
    const auto boxes = split_domain(as.domain, as.boxes);
    for (std::size_t b = 0; b < boxes.size(); ++b) {
        std::vector<Vec3> inside;
        for (const LightSample& s : lamps_[light].samples)
            if (boxes[b].contains(Vec3d(s.position))) inside.push_back(s.position);
        const auto own = leverages(boxes[b], inside, degree, at);
        for (std::size_t i = 0; i < at.size(); ++i) {
            const double weight = box_weights(boxes, at[i])[b];
            if (weight > 0) sums[i] += weight * weight * own[i];
        }
    }
    return sums;
}

bool TrialFits::enough(std::size_t light, const Light& as, int degree) const {
    return std::ranges::all_of(split_domain(as.domain, as.boxes), [&](const MapBox& box) {
        const auto inside = std::ranges::count_if(
            lamps_[light].samples, [&](const LightSample& s) { return box.contains(Vec3d(s.position)); });
        const auto moves = box.moves();
        const bool still = std::ranges::none_of(moves, std::identity{});
        return double(inside) >= (still ? 1 : kPositionsPerTerm * double(terms_of(degree, moves).size()));
    });
}

TrialFits::AtPositions TrialFits::sum_of(const std::vector<const AtPositions*>& parts) const {
    AtPositions sum = *parts[0];
    const bool mend = tracing_.scene().bake.mend_signs;
    for (std::size_t i = 0; i < sum.size(); ++i)
        for (std::size_t p = 0; p < sum[i].size(); ++p) {
            for (std::size_t k = 1; k < parts.size(); ++k) sum[i][p] += (*parts[k])[i][p];
            for (int c = 0; c < 3 && mend; ++c) sum[i][p][c] = std::max(0.0f, sum[i][p][c]);
        }
    return sum;
}

TrialFits::AtPositions TrialFits::total(std::size_t replaced, const AtPositions& by) const {
    std::vector<const AtPositions*> parts;
    for (std::size_t l = 0; l < lamps_.size(); ++l) parts.push_back(l == replaced ? &by : &lamps_[l].whole);
    return sum_of(parts);
}

// Positions of each box in turn: every group covers the domain.
std::vector<int> TrialFits::groups_of(std::size_t light) const {
    const auto boxes = split_domain(lights_[light].domain, lights_[light].boxes);
    std::vector<int> taken(boxes.size(), 0), groups;
    for (const LightSample& s : lamps_[light].samples) {
        const auto weight = [&](const MapBox& box) { return box.weight(Vec3d(s.position)); };
        const auto home = std::ranges::max_element(boxes, {}, weight) - boxes.begin();
        groups.push_back(taken[std::size_t(home)]++ % kGroups);
    }
    return groups;
}

double TrialFits::noise(std::size_t light) const {
    const Lamp& lamp = lamps_[light];
    const std::vector<int> groups = groups_of(light);
    std::vector<AtPositions> without;
    for (int g = 0; g < kGroups; ++g) {
        std::vector<LightSample> kept;
        for (std::size_t i = 0; i < groups.size(); ++i)
            if (groups[i] != g) kept.push_back(lamp.samples[i]);
        if (kept.empty() || kept.size() == groups.size()) return 0;
        without.push_back(total(light, fitted(light, lights_[light], degree_, kept)));
    }
    double sum = 0;  // over pairs: K times the sum of squares about the mean
    for (int g = 0; g < kGroups; ++g)
        for (int h = g + 1; h < kGroups; ++h) sum += held_out_.difference(without[g], without[h]);
    return sum * (kGroups - 1) / (kGroups * kGroups);
}

double TrialFits::below_zero() const {
    std::size_t below = 0, all = 0;
    for (const Lamp& lamp : lamps_)
        for (const HeldOut::Values& values : lamp.whole) {
            all += 3 * values.size();
            for (const Rgb& value : values)
                for (int c = 0; c < 3; ++c) below += value[c] < 0;
        }
    return double(below) / double(std::max<std::size_t>(1, all));
}

void TrialFits::add_figures(const AtPositions& all, TrialFigures& figures) const {
    figures.square = held_out_.square(all, all);
    figures.error = held_out_.error(all);
}

TrialFigures TrialFits::measure(const std::vector<Light>& lights, int degree) {
    lights_ = lights;
    degree_ = degree;
    for (std::size_t l = 0; l < lamps_.size(); ++l) {
        lamps_[l].whole = fitted(l, lights[l], degree, lamps_[l].samples);
        lamps_[l].leverage = leverage(l, lights[l], degree);
    }
    TrialFigures figures;
    add_figures(total(lamps_.size(), {}), figures);
    for (std::size_t l = 0; l < lamps_.size(); ++l) figures.noise.push_back(noise(l));
    figures.below_zero = below_zero();
    measured_ = figures;
    return figures;
}

std::optional<TrialFits::BoxTrial> TrialFits::with_boxes(std::size_t light, const Index3& boxes) const {
    Light as = lights_[light];
    as.boxes = boxes;
    if (!enough(light, as, degree_)) return std::nullopt;
    BoxTrial trial{light, boxes, measured_, fitted(light, as, degree_, lamps_[light].samples)};
    TrialFigures& figures = trial.figures;
    add_figures(total(light, trial.whole), figures);
    const double others = measured_.noise_sum() - measured_.noise[light];
    const double growth = mean(leverage(light, as, degree_)) / mean(lamps_[light].leverage);
    figures.noise[light] = std::clamp(figures.square - others, 0.0, growth * measured_.noise[light]);
    return trial;
}

void TrialFits::change_boxes(BoxTrial trial) {
    measured_ = std::move(trial.figures);
    Lamp& lamp = lamps_[trial.light];
    lamp.whole = std::move(trial.whole);
    lights_[trial.light].boxes = trial.boxes;
    lamp.leverage = leverage(trial.light, lights_[trial.light], degree_);
}

std::optional<TrialFigures> TrialFits::with_degree(int degree) const {
    TrialFigures figures = measured_;
    std::vector<AtPositions> parts;
    for (std::size_t l = 0; l < lamps_.size(); ++l) {
        if (!enough(l, lights_[l], degree)) return std::nullopt;
        parts.push_back(fitted(l, lights_[l], degree, lamps_[l].samples));
        figures.noise[l] *= mean(leverage(l, lights_[l], degree)) / mean(lamps_[l].leverage);
    }
    std::vector<const AtPositions*> all;
    for (const AtPositions& part : parts) all.push_back(&part);
    add_figures(sum_of(all), figures);
    return figures;
}

}  // namespace pim
