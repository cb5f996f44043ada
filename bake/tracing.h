// SPDX-License-Identifier: GPL-3.0-or-later
// What photons make of a scene, kept in the work folder: the cells that count and a density volume per lamp
// position. What is there already is not done again.
#pragma once

#include <optional>

#include "bake/work_folder.h"

namespace pim {

class Tracing {
  public:
    // Throws Error: no surface that could hold irradiance.
    explicit Tracing(Scene scene);
    Tracing(const Tracing&) = delete;

    void open(const Workplace& place);  // before all that follows
    // `found`: by somebody else already, with the same settings.
    void find_cells(std::optional<Cells> found = std::nullopt);
    std::size_t trace(const std::vector<LightSample>& samples);  // what is missing; returns how many
    void note_seconds(const char* key, double seconds) const;    // adds to run.json

    const Scene& scene() const { return scene_; }
    const RayCaster& caster() const { return caster_; }
    const Solids& solids() const { return solids_; }
    const Cells& cells() const { return cells_; }
    const WorkFolder& work() const { return *work_; }
    PositionFilter outside_solids() const;

  private:
    Scene scene_;
    RayCaster caster_;
    Solids solids_;
    std::optional<WorkFolder> work_;
    Cells cells_;
};

Solids solids_of(const Scene& scene);
void check_receivers(const Scene& scene);  // throws Error: no surface that could hold irradiance

// What a photon costs on this machine, from some thousand of all lamps.
struct PhotonTrial {
    double seconds_per_photon;  // as a bake traces them
    double seconds_alone;       // each from a start of its own
    double rays_per_photon;     // of a bake
};
PhotonTrial time_photons(const Scene& scene, const RayCaster& caster, const PositionFilter& allowed);

}  // namespace pim
