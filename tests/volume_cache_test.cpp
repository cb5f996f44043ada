// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/volume_cache.h"

#include <gtest/gtest.h>

namespace pim {
namespace {

constexpr auto kIndirect = std::size_t(Component::indirect);

VolumeCache::Volume volume_of(std::size_t patches, float density) {
    VolumeCache::Volume volume{Vec3(density), EnergyAccount{}, {}};
    volume.components[kIndirect] = std::make_shared<DensityVolume::PerComponent>(
        DensityVolume::PerComponent{std::vector<Rgb>(patches, Rgb(density)), std::vector<float>(patches)});
    return volume;
}

TEST(VolumeCache, HoldsWhatWasKeptLast) {
    VolumeCache cache;
    cache.begin("settings");
    EXPECT_FALSE(cache.find("lamp.000001.vdb").account);
    cache.keep("lamp.000001.vdb", volume_of(10, 1));
    cache.keep("lamp.000001.vdb", volume_of(10, 2));
    const auto held = cache.find("lamp.000001.vdb");
    ASSERT_TRUE(held.components[kIndirect]);
    EXPECT_EQ(held.position, Vec3(2));
    EXPECT_EQ(held.components[kIndirect]->density, std::vector<Rgb>(10, Rgb(2)));
    EXPECT_FALSE(held.components[std::size_t(Component::direct)]);
}

TEST(VolumeCache, OtherSettingsBeginAnew) {
    VolumeCache cache;
    cache.begin("one");
    cache.keep("a", volume_of(10, 1));
    cache.begin("one");
    EXPECT_TRUE(cache.find("a").account);
    cache.begin("another");
    EXPECT_FALSE(cache.find("a").account);
}

// Of 100 volumes of 1000 patches, 16 bytes each, less than 8 fit into 128 kB.
TEST(VolumeCache, KeepsWithinItsMemory) {
    VolumeCache cache(128e3);
    for (int i = 0; i < 100; ++i) cache.keep(std::to_string(i), volume_of(1000, float(i)));
    int held = 0;
    for (int i = 0; i < 100; ++i) held += cache.find(std::to_string(i)).account.has_value();
    EXPECT_EQ(held, 7);
    for (int i = 0; i < 7; ++i) cache.keep(std::to_string(i), volume_of(1000, -1));  // in place of the old
    EXPECT_EQ(cache.find("6").position, Vec3(-1));
}

}  // namespace
}  // namespace pim
