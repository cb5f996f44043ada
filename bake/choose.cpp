// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/choose.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bake/bake.h"
#include "bake/choice.h"
#include "bake/choose_lamps.h"
#include "bake/tracing.h"
#include "common/core/error.h"
#include "common/core/log.h"
#include "common/render/path_radiance.h"

namespace pim {
namespace fs = std::filesystem;
namespace {

constexpr double kReferenceShare = 0.1;     // of a time budget that the held-out paths take
constexpr double kPathsFirst = 64;          // per pixel, before there are more pixels
constexpr double kFewestPixels = 0.0625;    // of those that a long bake takes
constexpr double kPhotonSecondsMore = 1.5;  // with counting them, than in the trial

// Photons that cost as much time as a reference of this size.
double photons_of(const Scene& scene, const HeldOut::Size& size) {
    return reference_photons(
        scene, {.lights = size.positions, .pixels = size.pixels, .paths = size.paths, .geometry = {}});
}

// More paths for a smaller error, or as many as the time allows. The reference's noise counts with its
// square: first come paths, then pixels.
HeldOut::Size held_out_size(const Scene& scene, const Goal& goal, double photon_seconds) {
    HeldOut::Size size;
    // Lamps' images in mirrors cost a position as much as many pixels.
    const bool dear = lamps_meet_specular(scene);
    if (dear) size.positions /= 2;
    if (goal.target() > 0)
        size.paths = int(std::clamp(256 * std::pow(0.02 / goal.target(), 2), 32.0, 4096.0));
    if (!goal.has_budget()) return size;
    const double all = std::min(4e6, 1e5 * goal.budget());
    if (dear && all < 1.7e6) size.positions /= 2;
    const auto affordable = [&] {  // paths per pixel
        const double seconds = photon_seconds * photons_of(scene, {size.positions, size.pixels, 1});
        return std::min(all / (size.positions * size.pixels), kReferenceShare * goal.budget() / seconds);
    };
    if (!dear) size.pixels = int(size.pixels * std::clamp(affordable() / kPathsFirst, kFewestPixels, 1.0));
    size.paths = std::max(16, int(affordable()) / 2 * 2);
    return size;
}

// Seconds for one of these photons, from a small reference.
double time_reference_photon(const Scene& scene, const RayCaster& caster, const Solids& solids) {
    const HeldOut::Size few{.positions = 8, .pixels = 500, .paths = 4};
    const Stopwatch watch;
    const HeldOut trial(scene, caster, solids, few);
    return watch.seconds() / photons_of(scene, few);
}

bool is_of_cells(const Setting& s) { return table_of_setting(s.key) == "grid" || s.key == "photons"; }

// What an earlier run chose for the cells holds for any goal.
CellChoice cells_of(const Choice& known) {
    CellChoice cells{.settings = {}, .grid = known.grid, .cells = {}};
    std::ranges::copy_if(known.settings, std::back_inserter(cells.settings), is_of_cells);
    log_info(
        fmt::format("cells of {:.3g} m were chosen before; --overwrite begins anew", known.grid.cell_size));
    return cells;
}

void append(std::vector<Setting>& settings, const std::vector<Setting>& more) {
    settings.insert(settings.end(), more.begin(), more.end());
}

// What is chosen anew would not fit.
void refuse_other_cells(const Scene& scene, const Workplace& place) {
    const Choices& c = scene.choices;
    if ((c.cells || c.photons || (c.reach_photons && c.time_budget)) &&
        fs::exists(place.folder / "cells.vdb"))
        throw other_settings(place.folder);
}

// All that is known before anything is traced for the map.
struct Start {
    double photon_seconds;
    HeldOut held_out;
    CellChoice cells;
};

void check_cameras(const Scene& scene, const HeldOut& held_out) {
    bool lit = false;
    for (std::size_t c = 0; c < scene.cameras.size(); ++c) {
        if (held_out.sees_light(int(c)))
            lit = true;
        else
            log_warning(
                fmt::format("camera '{}' sees no light: it counts as without error, as in `bake evaluate`",
                            scene.cameras[c].name));
    }
    if (!lit)
        throw Error(fmt::format(
            "{}: no camera sees any light, so that no error can be judged; aim one at lit surface, give the "
            "lamps power, or write the settings of [grid], [bake] and the lamps",
            scene.description_file.string()));
}

Start prepare(const Scene& scene, const Goal& goal, const std::optional<Choice>& known) {
    const RayCaster caster(scene.geometry, InstructionSet::pinned);
    const Solids solids = solids_of(scene);
    std::vector<std::string> said_later;
    all_light_samples(scene, solids, said_later);  // throws where a lamp is shut in
    const PositionFilter allowed = [&](const Vec3& p) { return solids.containing(p).empty(); };
    const PhotonTrial trial = goal.has_budget() ? time_photons(scene, caster, allowed) : PhotonTrial{};
    const PhotonSeconds seconds{.baked = kPhotonSecondsMore * trial.seconds_per_photon,
                                .alone = kPhotonSecondsMore * trial.seconds_alone};
    const double reference_photon = goal.has_budget() ? time_reference_photon(scene, caster, solids) : 0;
    HeldOut held_out(scene, caster, solids, held_out_size(scene, goal, reference_photon));
    check_cameras(scene, held_out);
    CellChoice cells =
        known ? cells_of(*known) : choose_cells(scene, goal, caster, allowed, held_out, seconds);
    return {seconds.baked, std::move(held_out), std::move(cells)};
}

}  // namespace

std::vector<Setting> choose_settings(Scene scene, const std::vector<Setting>& given, const Workplace& place,
                                     const Stopwatch& begun) {
    if (!scene.choices.target_error && !scene.choices.time_budget)
        scene.choices.target_error = kDefaultTargetError;
    check_receivers(scene);
    const Goal goal(scene.choices, begun);
    std::vector<Setting> settings = given;
    append(settings, {{"target_error", ""}, {"time_budget", ""}});  // met from here on

    auto known = read_choice(place.folder);
    if (known && known->open != open_choices(scene)) known.reset();
    if (known && known->finished && known->description == scene.description) {
        log_info("what was chosen before is kept; --overwrite begins anew");
        append(settings, known->settings);
        return settings;
    }

    if (!known) refuse_other_cells(scene, place);
    Start start = prepare(scene, goal, known);
    Choice choice{.description = scene.description,
                  .open = open_choices(scene),
                  .settings = start.cells.settings,
                  .grid = start.cells.grid,
                  .finished = false};
    write_choice(place.folder, choice);
    append(settings, start.cells.settings);
    const auto lamps = choose_lamps(scene, settings, goal, start.held_out, std::move(start.cells),
                                    start.photon_seconds, place);
    append(settings, lamps);
    append(choice.settings, lamps);
    choice.finished = true;
    write_choice(place.folder, choice);
    return settings;
}

}  // namespace pim
