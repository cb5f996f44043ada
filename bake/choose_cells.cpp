// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/choose_cells.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "bake/choose_lamps.h"
#include "bake/lit_region.h"
#include "common/core/log.h"

namespace pim {
namespace {

constexpr double kGridShare = 0.5;     // of the squared target error that cells alone may make
constexpr double kSearchShare = 0.35;  // of the time for all cells that are tried
constexpr double kReachShare = 0.025;  // of the time for what light reaches, with each of these cells
constexpr uint64_t kFewestReach = 1 << 19;
constexpr double kTraceShare = 0.6;      // ... that is left for photons in the end
constexpr double kLeftShare = 0.75;      // ... of the time that the search has left
constexpr double kPatchPhotons = 150;    // photons that cost as much time as keeping a patch in all volumes
constexpr double kPhotonsOfAFile = 2e4;  // cost as much time as a file of a volume, several times over
constexpr double kPhotonsOfAPatch = 7;   // cost as much as it does at a position whenever fits are judged
constexpr double kMostPositions = 2000;
constexpr double kJudgeMemory = 0.3;       // of the memory, for the volumes that fits are judged by
constexpr double kMostPerPosition = 1e12;  // photons that a description may ask for
// Boxes ask for positions, and the larger the photons' number, the more error stands in too few boxes.
constexpr double kPositionsOfAMillion = 80;  // at least, with the root of the millions
constexpr uint64_t kFirstPhotons = 1 << 14;  // per lamp, position and half, to measure the first cells by
constexpr double kMeasureShare = 0.05;       // ... of a time budget instead, for each size
constexpr double kNoiseLeft = 0.35;          // by filter and shrinkage, about; of a fit's noise
constexpr double kFirstCells = 22;           // along the longest side
constexpr double kCellsOfAMillion = 14;      // ... with a time for a million photons

// One digit times a power of ten.
uint64_t round_number(double x) {
    const double power = std::pow(10.0, std::floor(std::log10(x)));
    return uint64_t(std::lround(std::round(x / power) * power));
}

class CellChooser {
  public:
    CellChooser(const Scene& scene, const Goal& goal, const RayCaster& caster, const PositionFilter& allowed,
                HeldOut& held_out, const PhotonSeconds& photon_seconds)
        : scene_(scene),
          goal_(goal),
          caster_(caster),
          allowed_(allowed),
          held_out_(held_out),
          photon_seconds_(photon_seconds),
          grid_(scene.grid) {}

    CellChoice choose() {
        if (scene_.choices.cells && !scene_.grid.bounds) choose_bounds();
        if (scene_.choices.reach_photons && goal_.has_budget()) choose_reach();
        Scene scene = scene_;
        scene.grid = grid_;
        const uint64_t most = goal_.has_budget() ? affordable_volume() : GridSearch::kMostPhotons;
        GridSearch search(std::move(scene), caster_, allowed_, held_out_, goal_.hoped_square(),
                          goal_.has_budget() ? most : kFirstPhotons, most);
        if (scene_.choices.cells)
            choose_grid(search);
        else
            choice_.grid = search.measure_given();
        choice_.cells = search.take_cells();
        if (scene_.choices.photons) choose_photons();
        return std::move(choice_);
    }

  private:
    void choose_bounds() {
        const auto region = lit_region(scene_, caster_, allowed_);
        if (!region) return;
        const Vec3d low = scene_.geometry.to_world(region->min), high = scene_.geometry.to_world(region->max);
        choice_.settings.push_back(
            {"bounds",
             fmt::format("{{ min = [{:.17g}, {:.17g}, {:.17g}], max = [{:.17g}, {:.17g}, {:.17g}] }}", low.x,
                         low.y, low.z, high.x, high.y, high.z)});
        grid_.bounds = Box3(scene_.geometry.to_local(low), scene_.geometry.to_local(high));
        log_info(
            fmt::format("chose bounds from {:.4g},{:.4g},{:.4g} to {:.4g},{:.4g},{:.4g}: little light lands "
                        "elsewhere",
                        low.x, low.y, low.z, high.x, high.y, high.z));
    }

    void choose_reach() {
        const double affordable = kReachShare * goal_.budget() / photon_seconds_.alone;
        const auto most = GridSettings{}.reach_photons;
        grid_.reach_photons =
            std::bit_floor(uint64_t(std::clamp(affordable, double(kFewestReach), double(most))));
        choice_.settings.push_back({"reach_photons", std::to_string(grid_.reach_photons)});
    }

    void choose_grid(GridSearch& search) {
        const Vec3 size = grid_.bounds.value_or(bounds(scene_.geometry)).size();
        choice_.grid =
            search.search(double(std::max({size.x, size.y, size.z})), first_cells(),
                          [&](const GridFigures& f, double seconds) { return grid_cost(f, seconds); });
        choice_.settings.push_back({"cell_size", fmt::format("{:.17g}", choice_.grid.cell_size)});
        log_info(fmt::format("chose cells of {:.3g} m: {}", choice_.grid.cell_size, grid_reason()));
    }

    // Along the longest side. Noise goes with one over the cells' area, the grid's error with their size or
    // so: the best size goes with the fourth root of the photons. With a budget rather too large at first:
    // large cells are soon found.
    double first_cells() const {
        return goal_.has_budget()
                   ? kCellsOfAMillion * std::pow(std::max(1.0, affordable_photons() / 1e6), 0.25)
                   : kFirstCells;
    }

    uint64_t affordable_volume() const {  // photons
        const double volumes = 2.0 * held_out_.positions() * double(scene_.lights.size());
        const double affordable = kMeasureShare * goal_.budget() / photon_seconds_.baked;
        return uint64_t(std::clamp(affordable / volumes, double(GridSearch::kFewestPhotons),
                                   double(GridSearch::kMostPhotons)));
    }

    double affordable_photons() const { return kTraceShare * goal_.budget() / photon_seconds_.baked; }

    // After so many seconds more.
    double photons_left(double seconds) const {
        return std::min(affordable_photons(),
                        kLeftShare * std::max(0.0, goal_.left() - seconds) / photon_seconds_.baked);
    }

    // Of the map for one photon in all: each fit spreads a term's worth of noise over the positions, and
    // lamps share the photons.
    double map_noise(const GridFigures& f) const {
        return kNoiseLeft * double(terms_of_cubic(scene_)) * double(scene_.lights.size()) * f.noise;
    }

    // Photons that reach the target, or the squared error that the budget reaches after so many seconds more.
    double grid_cost(const GridFigures& f, double seconds) const {
        const double keeping = kPatchPhotons * double(f.patches), square = std::max(0.0, f.square);
        if (!goal_.has_budget()) {
            const double room = goal_.square() - square / kGridShare;
            return room > 0 ? map_noise(f) / room + keeping : 1e18 * square / goal_.square();
        }
        if (seconds > 0 && goal_.seconds() + seconds > kSearchShare * goal_.budget())
            return std::numeric_limits<double>::infinity();
        const double photons = photons_left(seconds) - keeping;
        return photons > 0 ? square + map_noise(f) / photons : 1e18 * keeping;
    }

    std::string grid_reason() const {
        if (goal_.has_budget()) return "the least error for the time";
        return choice_.grid.square < kGridShare * goal_.square()
                   ? "the fewest photons for the target"
                   : "no others come nearer to the target, which they alone miss";
    }

    // So many per position that the planned positions hold all that are needed.
    void choose_photons() {
        const GridFigures& grid = choice_.grid;
        // The polynomial may make as much of the error as the grid.
        const double room = std::max(goal_.square() - 2 * grid.square, 0.2 * goal_.square());
        const double wanted =
            goal_.has_budget() ? photons_left(0) : std::min(map_noise(grid) / room, kMostPhotonsInAll);
        double positions = 0;
        for (const Light& light : scene_.lights) positions += planned_positions(light);
        const double fewest = std::max(2000.0, 0.2 * double(grid.patches));
        // More positions serve more boxes, at the same noise; but each has its patches to keep and to judge.
        const double serving = kPositionsOfAMillion * std::sqrt(std::max(1.0, wanted / 1e6));
        double most =
            std::max({kPhotonsOfAFile, std::min(kPhotonsOfAPatch * double(grid.patches), wanted / serving),
                      wanted / most_positions(), fewest});
        if (std::ranges::none_of(scene_.lights, &Light::choose_samples))
            most = std::max(fewest, kMostPerPosition);  // only photons can be more
        const uint64_t photons = round_number(std::clamp(wanted / positions, fewest, most));
        choice_.settings.push_back({"photons", std::to_string(photons)});
        log_info(fmt::format("chose {} photons per lamp position", photons));
    }

    // A target alone does not depend on the machine.
    double most_positions() const {
        if (!goal_.has_budget()) return kMostPositions;
        const double bytes = double(choice_.grid.patches) * double(sizeof(Rgb) + sizeof(float));
        return std::min(kMostPositions, std::max(1.0, kJudgeMemory * double(memory_there()) / bytes));
    }

    const Scene& scene_;
    const Goal& goal_;
    const RayCaster& caster_;
    const PositionFilter& allowed_;
    HeldOut& held_out_;
    PhotonSeconds photon_seconds_;
    GridSettings grid_;  // as far as it is chosen
    CellChoice choice_;
};

}  // namespace

CellChoice choose_cells(const Scene& scene, const Goal& goal, const RayCaster& caster,
                        const PositionFilter& allowed, HeldOut& held_out,
                        const PhotonSeconds& photon_seconds) {
    return CellChooser(scene, goal, caster, allowed, held_out, photon_seconds).choose();
}

}  // namespace pim
