// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/render/photon_map.h"

#include "common/core/parallel.h"
#include "common/transport/photon.h"

namespace pim {
namespace {

constexpr uint64_t kChunk = 4096;  // photons of one task, whatever the thread count
// Cosine that counts as facing the same way: at right angles but for rounding, floor and wall do not.
constexpr float kSameSide = 1e-3f;
constexpr float kMuchTheSame = 0.9f;  // within 26 degrees
constexpr std::size_t kProbes = 512;  // photons that decide the greatest radius
constexpr double kProbedShare = 0.9;
constexpr float kBeyondProbed = 2;

struct Task {
    std::size_t lamp;
    uint64_t begin, end;  // photons
    Rgb power;            // of each, W
};

// Whole numbers that add to the total: lamp l gets the photons between its bounds of the cumulated power.
std::vector<Task> share_out(const std::vector<LightState>& lights, uint64_t photons_per_lamp) {
    double power = 0;
    uint64_t shining = 0;
    for (const LightState& l : lights) power += mean_channel(l.power), shining += !is_black(l.power);
    const double all = double(photons_per_lamp * shining);
    std::vector<Task> tasks;
    double before = 0;
    for (std::size_t l = 0; l < lights.size(); ++l) {
        if (is_black(lights[l].power)) continue;
        const double after = before + mean_channel(lights[l].power);
        const auto share = uint64_t(std::llround(all * after / power) - std::llround(all * before / power));
        const uint64_t count = std::max<uint64_t>(1, share);
        for (uint64_t i = 0; i < count; i += kChunk)
            tasks.push_back({l, i, std::min(count, i + kChunk), lights[l].power / float(count)});
        before = after;
    }
    return tasks;
}

void shoot(const PathScene& s, const Task& task, uint64_t seed, ShotPhotons& shot) {
    const auto landed = [&](const Landing& landing) {
        const SurfacePoint& surface = landing.surface;
        if (!surface.material->receives()) return;
        auto& kind = landing.straight ? shot.straight : landing.caustic ? shot.caustic : shot.diffuse;
        kind.push_back({surface.position, surface.geometric_normal, landing.flux * task.power});
    };
    EnergyAccount ignored;
    for (uint64_t i = task.begin; i < task.end; ++i) {
        RandomStream random(seed, RandomPurpose::photon_map, uint32_t(task.lamp), i);
        trace_photon(s.scene, s.caster, s.scene.lights[task.lamp], s.lights[task.lamp].position, random,
                     landed, ignored);
    }
}

std::vector<StoredPhoton> joined(std::vector<ShotPhotons>& parts,
                                 std::vector<StoredPhoton> ShotPhotons::*kind) {
    std::vector<std::size_t> begin{0};
    for (const ShotPhotons& part : parts) begin.push_back(begin.back() + (part.*kind).size());
    std::vector<StoredPhoton> all(begin.back());
    parallel_for(parts.size(), [&](std::size_t i) {
        std::ranges::copy(parts[i].*kind, all.begin() + std::ptrdiff_t(begin[i]));
    });
    return all;
}

std::vector<Vec3> positions_of(const std::vector<StoredPhoton>& photons) {
    std::vector<Vec3> positions;
    positions.reserve(photons.size());
    for (const StoredPhoton& p : photons) positions.push_back(p.position);
    return positions;
}

}  // namespace

ShotPhotons shoot_photons(const PathScene& scene, uint64_t photons_per_lamp, uint64_t seed) {
    const std::vector<Task> tasks = share_out(scene.lights, photons_per_lamp);
    std::vector<ShotPhotons> parts(tasks.size());
    parallel_for(tasks.size(), [&](std::size_t i) { shoot(scene, tasks[i], seed, parts[i]); });
    return {joined(parts, &ShotPhotons::straight), joined(parts, &ShotPhotons::caustic),
            joined(parts, &ShotPhotons::diffuse)};
}

PhotonMap::PhotonMap(const std::vector<StoredPhoton>& photons, int nearest, Filter filter)
    : tree_(positions_of(photons)),
      carried_(tree_.numbers().size()),
      nearest_(std::size_t(nearest)),
      filter_(filter) {
    parallel_for((carried_.size() + kChunk - 1) / kChunk, [&](std::size_t chunk) {
        for (std::size_t i = chunk * kChunk; i < std::min(carried_.size(), (chunk + 1) * kChunk); ++i)
            if (const uint32_t number = tree_.numbers()[i]; number != PhotonTree::kNone)
                carried_[i] = {photons[number].normal, photons[number].flux};
    });
    greatest_radius_ = find_greatest_radius(photons);
}

void PhotonMap::find(const Vec3& position, const Vec3& normal, float radius,
                     std::vector<PhotonTree::Found>& found) const {
    found.reserve(nearest_);
    tree_.nearest(
        position, radius, nearest_,
        [&](uint32_t slot) { return carried_[slot].normal.dot(normal) > kSameSide; }, found);
}

// Twice the radius that nine tenths of the photons stay below in estimates where they lie: it suits the
// places that light reaches, and a place four times dimmer than those is still served by as many photons.
float PhotonMap::find_greatest_radius(const std::vector<StoredPhoton>& photons) const {
    if (photons.empty()) return 0;
    const std::size_t probes = std::min(kProbes, photons.size());
    std::vector<float> squared(probes);
    parallel_for(probes, [&](std::size_t i) {
        const StoredPhoton& photon = photons[i * photons.size() / probes];
        std::vector<PhotonTree::Found> found;
        find(photon.position, photon.normal, std::numeric_limits<float>::infinity(), found);
        squared[i] = std::max_element(found.begin(), found.end())->squared_distance;
    });
    const auto at = squared.begin() + std::ptrdiff_t(kProbedShare * double(probes - 1));
    std::nth_element(squared.begin(), at, squared.end());
    return kBeyondProbed * std::sqrt(*at);
}

// E = sum of flux / (pi r²) (the thesis, equation 3). The farthest photon found sets r and is left out: with
// it the estimate would be too large by nearest / (nearest - 1) (Loftsgaarden and Quesenberry 1965).
Rgb PhotonMap::irradiance(const Vec3& position, const Vec3& normal) const {
    std::vector<PhotonTree::Found> found;
    find(position, normal, greatest_radius_, found);
    float squared_radius = greatest_radius_ * greatest_radius_;
    if (found.size() == nearest_) {
        std::iter_swap(std::max_element(found.begin(), found.end()), found.end() - 1);
        squared_radius = found.back().squared_distance;
        found.pop_back();
    }
    if (!(squared_radius > 0)) return Rgb(0);
    Rgb sum(0);
    for (const auto& [squared, slot] : found) {
        const float weight = filter_ == Filter::cone ? 3 * (1 - std::sqrt(squared / squared_radius)) : 1.0f;
        sum += carried_[slot].flux * weight;  // the mean of 1 - d/r over the disk is 1/3
    }
    return sum / (kPi * squared_radius);
}

void PhotonMap::precompute_irradiance() {
    precomputed_.resize(carried_.size());
    parallel_for((carried_.size() + kChunk - 1) / kChunk, [&](std::size_t chunk) {
        for (std::size_t i = chunk * kChunk; i < std::min(carried_.size(), (chunk + 1) * kChunk); ++i)
            if (tree_.numbers()[i] != PhotonTree::kNone)
                precomputed_[i] = irradiance(tree_.position(uint32_t(i)), carried_[i].normal);
    });
}

Rgb PhotonMap::nearby_irradiance(const Vec3& position, const Vec3& normal) const {
    std::vector<PhotonTree::Found> found;
    tree_.nearest(
        position, greatest_radius_, 1,
        [&](uint32_t slot) { return carried_[slot].normal.dot(normal) > kMuchTheSame; }, found);
    return found.empty() ? Rgb(0) : precomputed_[found[0].slot];
}

}  // namespace pim
