// SPDX-License-Identifier: GPL-3.0-or-later
// Density volumes of a work folder that this process has traced or read, as far as memory allows: the fit
// reads each of them several times, and a file takes longer to open than to read.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "bake/density.h"

namespace pim {

class VolumeCache {
  public:
    static double capacity();  // bytes: a share of this machine's memory
    explicit VolumeCache(double most_bytes = capacity()) : most_bytes_(most_bytes) {}
    struct Volume {
        Vec3 position{0};  // of the lamp
        std::optional<EnergyAccount> account;
        std::array<std::shared_ptr<const DensityVolume::PerComponent>, kComponentCount> components;
    };

    // Forgets volumes of other settings.
    void begin(const std::string& settings);
    // By the file's name; an empty one where nothing is held.
    Volume find(const std::string& file) const;
    // In place of what was held; does nothing where memory is short.
    void keep(const std::string& file, Volume volume);

  private:
    mutable std::mutex mutex_;
    std::string settings_;
    std::map<std::string, Volume> volumes_;
    double most_bytes_, bytes_ = 0;
};

}  // namespace pim
