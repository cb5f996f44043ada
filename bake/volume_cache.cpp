// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/volume_cache.h"

#include "bake/fragments.h"

namespace pim {
namespace {

constexpr double kMemoryShare = 0.25;

double bytes_of(const VolumeCache::Volume& volume) {
    double bytes = sizeof volume;
    for (const auto& component : volume.components)
        if (component) bytes += double(component->density.size() * (sizeof(Rgb) + sizeof(float)));
    return bytes;
}

}  // namespace

double VolumeCache::capacity() { return kMemoryShare * memory_there(); }

void VolumeCache::begin(const std::string& settings) {
    const std::scoped_lock lock(mutex_);
    if (settings == settings_) return;
    settings_ = settings;
    volumes_.clear();
    bytes_ = 0;
}

VolumeCache::Volume VolumeCache::find(const std::string& file) const {
    const std::scoped_lock lock(mutex_);
    const auto found = volumes_.find(file);
    return found == volumes_.end() ? Volume{} : found->second;
}

void VolumeCache::keep(const std::string& file, Volume volume) {
    const std::scoped_lock lock(mutex_);
    if (const auto known = volumes_.find(file); known != volumes_.end()) {
        bytes_ -= bytes_of(known->second);
        volumes_.erase(known);
    }
    const double bytes = bytes_of(volume);
    if (bytes_ + bytes > most_bytes_) return;
    bytes_ += bytes;
    volumes_.emplace(file, std::move(volume));
}

}  // namespace pim
