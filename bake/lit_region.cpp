// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/lit_region.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "common/core/parallel.h"
#include "common/transport/photon.h"

namespace pim {
namespace {

constexpr uint64_t kPhotons = uint64_t{1} << 18, kPhotonBlock = 4096;
constexpr int kBins = 16;            // along the longest side of where most of the light lands
constexpr std::size_t kEvery = 8;    // landing tells the extent of where most of it lands
constexpr double kTail = 0.05;       // of the flux on each side that "most" leaves out
constexpr float kWorthwhile = 0.8f;  // bounds that keep more than this of every side are not worth setting

struct Flux {
    Vec3 position;
    float value;
};

std::vector<Flux> landings(const Scene& scene, const RayCaster& caster, const PositionFilter& allowed) {
    std::vector<std::vector<Flux>> parts(kPhotons / kPhotonBlock);
    parallel_for(parts.size(), [&](std::size_t block) {
        EnergyAccount ignored;
        for (uint64_t photon = block * kPhotonBlock; photon < (block + 1) * kPhotonBlock; ++photon) {
            const Light& light = scene.lights[photon % scene.lights.size()];
            RandomStream random(scene.bake.seed, RandomPurpose::reach, 1, photon);
            const Vec3 from = random_lamp_position(light, allowed, random);
            trace_photon(
                scene, caster, light, from, random,
                [&](const Landing& l) {
                    parts[block].push_back({l.surface.position, mean_channel(l.flux)});
                },
                ignored);
        }
    });
    std::vector<Flux> all;
    for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
    return all;
}

// Where most of the light lands, on one axis: its extent.
float main_extent(const std::vector<Flux>& all, int axis) {
    std::vector<std::pair<float, float>> places;  // and flux
    double whole = 0, sum = 0;
    for (std::size_t i = 0; i < all.size(); i += kEvery) {
        places.emplace_back(all[i].position[axis], all[i].value);
        whole += double(all[i].value);
    }
    std::ranges::sort(places);
    float low = places.front().first, high = places.back().first;
    for (const auto& [place, value] : places) {
        const double before = sum;
        sum += double(value);
        if (before < kTail * whole) low = place;
        if (before < (1 - kTail) * whole) high = place;
    }
    return high - low;
}

}  // namespace

std::optional<Box3> lit_region(const Scene& scene, const RayCaster& caster, const PositionFilter& allowed) {
    const std::vector<Flux> all = landings(scene, caster, allowed);
    if (all.empty()) return std::nullopt;
    std::array<float, 3> extents;
    parallel_for(3, [&](std::size_t axis) { extents[axis] = main_extent(all, int(axis)); });
    const float longest = *std::ranges::max_element(extents);
    if (!(longest > 0)) return std::nullopt;
    const float size = longest / kBins;
    const auto place = [&](float x) { return int64_t(std::floor(x / size)); };
    struct Bin {
        double flux = 0;
        Box3 box;
    };
    std::map<std::array<int64_t, 3>, Bin> bins;
    for (const Flux& f : all) {
        Bin& bin = bins[{place(f.position.x), place(f.position.y), place(f.position.z)}];
        bin.flux += double(f.value);
        bin.box.extendBy(f.position);
    }
    double flux = 0, squares = 0;
    for (const auto& [_, bin] : bins) flux += bin.flux, squares += bin.flux * bin.flux;
    Box3 region;
    for (const auto& [_, bin] : bins)
        if (bin.flux >= kDimmest * squares / flux) region.extendBy(bin.box);
    const Box3 whole = bounds(scene.geometry);
    bool worthwhile = false;
    for (int axis = 0; axis < 3; ++axis) {
        region.min[axis] = std::max(whole.min[axis], region.min[axis] - 0.5f * size);
        region.max[axis] = std::min(whole.max[axis], region.max[axis] + 0.5f * size);
        worthwhile = worthwhile || region.size()[axis] < kWorthwhile * whole.size()[axis];
    }
    return worthwhile ? std::optional(region) : std::nullopt;
}

}  // namespace pim
