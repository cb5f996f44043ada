// SPDX-License-Identifier: GPL-3.0-or-later
// Where a bake keeps what it has done: OUT.vdb.work/ with cells.vdb, one density volume per lamp position,
// and run.json. Every file is there whole or not at all, so a killed bake goes on where it stopped.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "bake/density.h"
#include "bake/volume_cache.h"
#include "common/core/error.h"
#include "common/map/vdb_file.h"
#include "common/scene/geometry_check.h"

namespace pim {

// All settings that decide what a density volume holds, in words; volumes of another one are not mixed.
std::string trace_settings(const Scene& scene, const RayCaster& caster, const Solids& solids);

// What a folder or file of another bake is refused with.
Error other_settings(const std::filesystem::path& path);

// Where a work folder is, and what of it is in memory: for all who open it in turn.
struct Workplace {
    std::filesystem::path folder;
    std::shared_ptr<VolumeCache> volumes = std::make_shared<VolumeCache>();
};

class WorkFolder {
  public:
    // `settings` from trace_settings. Creates the folder where needed. Throws Error: not writable.
    WorkFolder(const Workplace& place, std::string settings, const Scene& scene);

    static void create(const std::filesystem::path& path);                       // throws Error
    static std::filesystem::path beside(const std::filesystem::path& map_file);  // OUT.vdb.work

    std::optional<Cells> read_cells() const;  // none yet: empty. Throws Error: made with other settings
    void write_cells(const Cells& cells) const;

    bool has(const Scene& scene, const LightSample& sample) const;  // a volume of this very position
    void write(const Scene& scene, const Cells& cells, const LightSample& sample,
               const DensityVolume& volume) const;
    // One component of a volume. Throws Error: missing, or of other settings.
    DensityVolume::PerComponent read(const Scene& scene, const Cells& cells, const LightSample& sample,
                                     Component component) const;
    EnergyAccount read_account(const Scene& scene, const LightSample& sample) const;

    // Changes run.json, one process at a time: parts of a farm may end at once.
    void update_run(const std::function<void(nlohmann::json&)>& change) const;
    void remove() const;
    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path file_of(const Scene& scene, const LightSample& sample) const;
    DensityVolume::PerComponent read_file(const std::filesystem::path& file, const Cells& cells,
                                          Component component) const;

    std::filesystem::path path_;
    std::shared_ptr<VolumeCache> volumes_;
    std::shared_ptr<VdbTrees> trees_ = std::make_shared<VdbTrees>();
    std::string settings_;
    Vec3d origin_;
    int channels_;  // of a density: 1 where the scene is grey
};

}  // namespace pim
