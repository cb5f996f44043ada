// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/grid_search.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bake/density.h"
#include "common/core/log.h"
#include "common/core/parallel.h"
#include "common/core/stopwatch.h"

namespace pim {
namespace {

constexpr int kOwn = 1 << 18;                       // numbers of lamp positions that no bake uses
constexpr int kFewestCells = 4, kMostCells = 2048;  // along the longest side
// Squared noise of a volume, in squared errors that are wanted: the noise of two halves is independent and
// averages out over thousands of patches.
constexpr double kNoiseAllowed = 10;
constexpr double kWorthwhile = 0.97;  // hopes for a cost that is hardly lower are not looked into
constexpr double kTimeGrowth = 0.5;   // power of the patches with which the time for a size grows, about
constexpr double kErrorGrowth = 1.4;  // ... of the cells' size with which their squared error grows, about
constexpr double kGrowthDoubt = 0.4;  // of that power

}  // namespace

GridSearch::GridSearch(Scene scene, const RayCaster& caster, const PositionFilter& allowed, HeldOut& held_out,
                       double wanted, uint64_t first_photons, uint64_t most_photons)
    : scene_(std::move(scene)),
      caster_(caster),
      allowed_(allowed),
      held_out_(held_out),
      wanted_(wanted),
      first_photons_(first_photons),
      most_photons_(most_photons) {}

const GridFigures& GridSearch::measure(double cell_size) {
    scene_.grid.resolution = CellSize{cell_size};
    return measure_as_set(cell_size);
}

const GridFigures& GridSearch::measure_given() {
    const GridFigures& figures = measure_as_set(make_grid(scene_).cell_size);
    cells_ = std::move(measured_);
    return figures;
}

const GridFigures& GridSearch::measure_as_set(double cell_size) {
    const Stopwatch watch;
    scene_.bake.photons = photons_for(cell_size);
    measured_ = find_cells(scene_, caster_, allowed_);
    held_out_.set_cells(scene_, caster_, measured_);
    const auto a = own_volumes(measured_, 1), b = own_volumes(measured_, 2);
    const auto square = with_expected(held_out_.doubtful_square(a, b), cell_size);
    GridFigures& figures = known_[cell_size];
    figures = {.cell_size = cell_size,
               .square = std::max(likely_error(square).square, least_square(cell_size)),
               .doubt = square.doubt,
               .noise = held_out_.usual_difference(a, b) / 2 * double(scene_.bake.photons),
               .patches = measured_.patches.size()};
    const double error = std::sqrt(figures.square);
    log_info(fmt::format(
        "cells of {:.3g} m: {} patches, error of the grid {:.4f} ± {:.4f}, noise of a million photons "
        "per lamp {:.4f}",
        cell_size, figures.patches, error, std::sqrt(figures.square + 2 * figures.doubt) - error,
        std::sqrt(figures.noise / 1e6)));
    seconds_ = watch.seconds();
    return figures;
}

const GridFigures& GridSearch::nearest(double cell_size) const {
    const auto distance = [&](const auto& entry) { return std::abs(std::log(entry.first / cell_size)); };
    return std::ranges::min_element(known_, {}, distance)->second;
}

// The error falls with the cells' size at best, as larger ones say: a lucky draw of rare bright photons does
// not decide.
double GridSearch::least_square(double cell_size) const {
    double least = 0;
    for (auto larger = known_.upper_bound(cell_size); larger != known_.end(); ++larger)
        least = std::max(least, larger->second.square * std::pow(cell_size / larger->first, 2));
    return least;
}

// What the nearest size lets expect counts too, each by its doubt: rare bright photons in small patches make
// that of a measure large.
Doubtful GridSearch::with_expected(const Doubtful& measured, double cell_size) const {
    if (known_.empty() || !(nearest(cell_size).square > 0)) return measured;
    const GridFigures near = nearest(cell_size), expected = hoped_at(cell_size);
    const double growth = kGrowthDoubt * std::log(near.cell_size / cell_size);
    return combined({expected.square, expected.square * std::hypot(near.doubt / near.square, growth)},
                    measured);
}

// Noise goes with one over the cells' area, patches with less: edges hold more of them in large cells.
GridFigures GridSearch::hoped_at(double cell_size) const {
    if (const auto found = known_.find(cell_size); found != known_.end()) return found->second;
    const GridFigures& near = nearest(cell_size);
    const double ratio = near.cell_size / cell_size;
    const double square = std::max(least_square(cell_size), near.square * std::pow(ratio, -kErrorGrowth));
    return {.cell_size = cell_size,
            .square = square,
            .noise = near.noise * ratio * ratio,
            .patches = std::size_t(double(near.patches) * std::min(ratio * ratio, std::pow(ratio, 1.5)))};
}

uint64_t GridSearch::photons_for(double cell_size) const {
    if (known_.empty()) return first_photons_;
    const double needed = hoped_at(cell_size).noise / (kNoiseAllowed * wanted_);
    return uint64_t(std::clamp(needed, double(kFewestPhotons), double(most_photons_)));
}

std::vector<HeldOut::Values> GridSearch::own_volumes(const Cells& cells, int half) const {
    Scene scene = scene_;
    scene.bake.seed += uint64_t(half) * 0x9e3779b97f4a7c15u;
    const SurfaceCells surface(cells.grid, scene.geometry);
    const auto& patches = held_out_.patches();
    std::vector<HeldOut::Values> values(std::size_t(held_out_.positions()));
    parallel_for(values.size(), [&](std::size_t i) {
        values[i].assign(patches.size(), Rgb(0));
        for (std::size_t l = 0; l < scene.lights.size(); ++l) {
            const LightState& state = held_out_.lamps(int(i))[l];
            const auto volume =
                trace_density(scene, caster_, cells, surface, {int(l), kOwn + int(i), state.position});
            for (const auto& component : volume.components)
                for (std::size_t p = 0; p < patches.size() && !component.density.empty(); ++p)
                    values[i][p] += component.density[patches[p]] * state.power;
        }
    });
    return values;
}

GridFigures GridSearch::search(double longest_side, double first_cells, const Cost& cost) {
    const auto size_at = [&](double steps) { return longest_side / (first_cells * std::exp2(0.5 * steps)); };
    const auto allowed = [&](double size) {
        const double cells = longest_side / size;
        if (known_.contains(size) || cells < kFewestCells || cells > kMostCells) return false;
        scene_.grid.resolution = CellSize{size};
        return fragment_bytes(scene_, make_grid(scene_)) < 0.5 * memory_there();
    };
    double best = 0;
    while (!allowed(size_at(best)) && longest_side / size_at(best) > kFewestCells) --best;
    measure(size_at(best));
    cells_ = std::move(measured_);
    const auto least = [&] { return cost(known_.at(size_at(best)), 0); };
    const auto hoped_cost = [&](double steps) {
        const GridFigures hoped = hoped_at(size_at(steps));
        const double growth = double(hoped.patches) / double(nearest(size_at(steps)).patches);
        return cost(hoped, seconds_ * std::pow(growth, kTimeGrowth));
    };
    for (;;) {
        std::map<double, double> worthwhile;  // cost, steps
        for (const double step : {2, 1, -1, -2})
            if (const double there = best + step; allowed(size_at(there)))
                worthwhile.emplace(hoped_cost(there), there);
        if (worthwhile.empty() || !(worthwhile.begin()->first < kWorthwhile * least())) break;
        const double there = worthwhile.begin()->second;
        if (!(cost(measure(size_at(there)), 0) < least())) continue;
        best = there;
        cells_ = std::move(measured_);
    }
    return known_.at(size_at(best));
}

}  // namespace pim
