// SPDX-License-Identifier: GPL-3.0-or-later
// Where a bake keeps what it has done: OUT.vdb.work/ with cells.vdb, one density volume per lamp position,
// and run.json. Every file is there whole or not at all, so a killed bake goes on where it stopped.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "bake/density.h"

namespace pim {

// All settings that decide what a density volume holds, in words; volumes of another one are not mixed.
std::string trace_settings(const Scene& scene, const RayCaster& caster);

class WorkFolder {
  public:
    // `settings` from trace_settings. Creates the folder where needed. Throws Error: not writable.
    WorkFolder(std::filesystem::path path, std::string settings, const Vec3d& origin);

    static std::filesystem::path beside(const std::filesystem::path& map_file);  // OUT.vdb.work

    std::optional<Cells> read_cells() const;  // none yet: empty. Throws Error: made with other settings
    void write_cells(const Cells& cells) const;

    bool has(const Scene& scene, const LightSample& sample) const;  // a volume of this very position
    void write(const Scene& scene, const Cells& cells, const LightSample& sample,
               const DensityVolume& volume) const;
    // Density of one component, [patch][channel]. Throws Error: missing, or of other settings.
    std::vector<float> read_density(const Scene& scene, const Cells& cells, const LightSample& sample,
                                    Component component) const;
    EnergyAccount read_account(const Scene& scene, const LightSample& sample) const;

    nlohmann::json read_run() const;  // empty object if there is none
    void write_run(const nlohmann::json& run) const;
    void remove() const;
    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path file_of(const Scene& scene, const LightSample& sample) const;

    std::filesystem::path path_;
    std::string settings_;
    Vec3d origin_;
};

}  // namespace pim
