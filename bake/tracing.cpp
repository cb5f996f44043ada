// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/tracing.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bake/sample_photons.h"
#include "common/core/error.h"
#include "common/core/log.h"
#include "common/core/parallel.h"
#include "common/core/progress.h"
#include "common/core/stopwatch.h"

namespace pim {

void check_receivers(const Scene& scene) {
    if (std::ranges::none_of(scene.geometry.triangles,
                             [&](const Triangle& t) { return scene.materials[t.material].receives(); }))
        throw Error(
            fmt::format("{}: all surfaces are mirrors or glass, which hold no irradiance; give some "
                        "of them a diffuse reflectance in [[material]]",
                        scene.description_file.string()));
}

Tracing::Tracing(Scene scene)
    : scene_(std::move(scene)), caster_(scene_.geometry, InstructionSet::pinned), solids_(solids_of(scene_)) {
    check_receivers(scene_);
}

void Tracing::open(const Workplace& place) {
    work_.emplace(place, trace_settings(scene_, caster_, solids_), scene_);
}

PositionFilter Tracing::outside_solids() const {
    return [this](const Vec3& position) { return solids_.containing(position).empty(); };
}

void Tracing::find_cells(std::optional<Cells> found) {
    const Stopwatch watch;
    if (auto known = work_->read_cells()) {
        cells_ = std::move(*known);
    } else {
        cells_ = found ? std::move(*found) : pim::find_cells(scene_, caster_, outside_solids());
        work_->write_cells(cells_);
        note_seconds("cells_seconds", watch.seconds());
    }
    if (cells_.patches.empty())
        throw Error("no light reaches any surface in the bounds; do lamps and bounds fit?");
    log_info(fmt::format("{} of {} cells hold surface that counts: {} patches, {:.4g} of {:.4g} m²",
                         cells_.index.cell_count(), cells_.grid.cell_count(), cells_.patches.size(),
                         cells_.counted_area, cells_.surface_area));
}

std::size_t Tracing::trace(const std::vector<LightSample>& samples) {
    const Stopwatch watch;
    std::vector<LightSample> missing;
    for (const LightSample& sample : samples)
        if (!work_->has(scene_, sample)) missing.push_back(sample);
    log_info(fmt::format("{} lamp positions to trace with {} photons each, {} done before", missing.size(),
                         scene_.bake.photons, samples.size() - missing.size()));
    const SurfaceCells surface(cells_.grid, scene_.geometry);
    Progress progress("tracing lamp positions", missing.size());
    parallel_for(missing.size(), [&](std::size_t i) {
        work_->write(scene_, cells_, missing[i], trace_density(scene_, caster_, cells_, surface, missing[i]));
        progress.advance();
    });
    if (!missing.empty()) note_seconds("trace_seconds", watch.seconds());
    return missing.size();
}

void Tracing::note_seconds(const char* key, double seconds) const {
    work_->update_run([&](nlohmann::json& run) {
        run[key] = run.value(key, 0.0) + seconds;
        double sum = 0;
        for (const char* part : {"choose_seconds", "cells_seconds", "trace_seconds", "fit_seconds"})
            sum += run.value(part, 0.0);
        run["bake_seconds"] = sum;
        run["threads"] = thread_count();
        run["settings"] = trace_settings(scene_, caster_, solids_);
    });
}

namespace {

struct Pace {
    double seconds, surfaces;  // per photon
};

Pace trace_some(const Scene& scene, const RayCaster& caster, const PositionFilter& allowed,
                uint64_t together) {
    constexpr std::size_t kBlocks = 64;
    constexpr uint64_t kPhotons = 512;
    std::vector<uint64_t> landings(kBlocks);
    const Stopwatch watch;
    parallel_for(kBlocks, [&](std::size_t block) {
        EnergyAccount ignored;
        for (uint64_t i = 0; i < kPhotons; i += together) {
            std::vector<RandomStream> random;
            for (uint64_t k = 0; k < together; ++k)
                random.emplace_back(scene.bake.seed, RandomPurpose::reach, 2, block << 20 | (i + k));
            const Light& light = scene.lights[i / together % scene.lights.size()];
            const Vec3 from = random_lamp_position(light, allowed, random[0]);
            trace_photons(
                scene, caster, sample_emission(light, from, random[0]), random,
                [&](const Landing&) { ++landings[block]; }, ignored);
        }
    });
    const double seconds = watch.seconds(), photons = double(kBlocks * kPhotons);
    uint64_t all = 0;
    for (const uint64_t n : landings) all += n;
    return {seconds / photons, double(all) / photons};
}

}  // namespace

PhotonTrial time_photons(const Scene& scene, const RayCaster& caster, const PositionFilter& allowed) {
    const auto together = uint64_t(photons_of_a_start(scene));
    trace_some(scene, caster, allowed, 1);  // wakes threads and caches
    const Pace alone = trace_some(scene, caster, allowed, 1);
    const Pace baked = together > 1 ? trace_some(scene, caster, allowed, together) : alone;
    return {baked.seconds, alone.seconds, alone.surfaces + 1 / double(together)};
}

Solids solids_of(const Scene& scene) {
    std::vector<Vec3> eyes;
    for (const Camera& camera : scene.cameras) eyes.push_back(camera.eye);
    return {scene.geometry, eyes};
}

}  // namespace pim
