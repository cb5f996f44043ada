// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/sample_photons.h"

#include <algorithm>
#include <cmath>

#include "common/core/sampling.h"

namespace pim {
namespace {

constexpr uint64_t kNoPhoton = ~uint64_t{0};

// Streams of lamp positions.
uint32_t stream_of(const LightSample& sample) {
    return (uint32_t(sample.light) << 20 ^ uint32_t(sample.number)) & 0x3ffffff;
}

float fraction(double x) { return std::min(float(x - std::floor(x)), 0x1.fffffep-1f); }

}  // namespace

int photons_of_a_start(const Scene& scene) {
    const bool only_indirect = scene.bake.components == std::vector{Component::indirect};
    const bool all_diffuse = std::ranges::all_of(
        scene.materials, [](const Material& m) { return !m.glass && is_black(m.specular); });
    return only_indirect && all_diffuse ? kPhotonsOfAStart : 1;
}

SamplePhotons::SamplePhotons(const Scene& scene, const RayCaster& caster, const LightSample& sample)
    : scene_(scene), caster_(caster), sample_(sample), together_(uint64_t(photons_of_a_start(scene))) {
    RandomStream random = stream(kNoPhoton);
    shift_.x = double(random.next()), shift_.y = double(random.next());
}

RandomStream SamplePhotons::stream(uint64_t number) const {
    return {scene_.bake.seed, RandomPurpose::photons, stream_of(sample_), number};
}

// Starts that are shared are spread evenly: what comes of one lights all of the scene, and no filter among
// patches would take such noise away.
Emission SamplePhotons::start(uint64_t number, RandomStream& random) const {
    const Light& light = scene_.lights[sample_.light];
    if (together_ == 1) return sample_emission(light, sample_.position, random);
    const Imath::V2d place = golden_place(int64_t(number)) + shift_;
    return sample_emission(light, sample_.position, {fraction(place.x), fraction(place.y)}, random);
}

void SamplePhotons::trace(uint64_t begin, uint64_t end, const LandingFunction& landed,
                          EnergyAccount& account) const {
    std::vector<RandomStream> random;
    for (uint64_t first = begin; first < end; first += together_) {
        random.clear();
        for (uint64_t photon = first; photon < std::min(end, first + together_); ++photon)
            random.push_back(stream(photon));
        trace_photons(scene_, caster_, start(first / together_, random[0]), random, landed, account);
    }
}

}  // namespace pim
