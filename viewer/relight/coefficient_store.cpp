// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/relight/coefficient_store.h"

#include <cmath>
#include <utility>

#include "common/core/error.h"

namespace pim {
namespace {

// Distance of a place from a box, in half widths of the box; 0 inside.
double distance_from(const MapBox& box, const Vec3d& place) {
    double most = 0;
    for (int axis = 0; axis < 3; ++axis)
        if (box.half[axis] > 0)
            most = std::max(most, std::abs(place[axis] - box.centre[axis]) / box.half[axis] - 1);
    return most;
}

// Half widths of a box: nearer ones are read in the background, farther ones dropped. A box that shares a
// corner with the lamp's own is always near.
constexpr double kNear = 2, kFar = 4;

}  // namespace

CoefficientStore::CoefficientStore(const MapFile& map, std::vector<Component> components)
    : map_(map), components_(std::move(components)) {
    for (const MapLight& light : map.outline().lights) slots_.emplace_back(light.boxes.size());
    background_ = std::jthread([this](const std::stop_token& stop) { work(stop); });
}

CoefficientStore::~CoefficientStore() = default;

std::shared_ptr<const PackedBox> CoefficientStore::read(std::size_t light, std::size_t box) const {
    auto packed = std::make_shared<PackedBox>();
    PackedBox& p = *packed;
    const std::size_t patches = map_.outline().patches.size();
    p.terms = map_.terms(light, box);
    p.channels = map_.outline().grey ? 1 : 3;
    p.coefficients.assign((patches + kLanes - 1) / kLanes * p.block_length(), 0);
    p.residuals.resize(patches);
    for (const Component c : components_) {
        map_.read_terms(
            light, box, c, p.channels,
            [&](std::size_t term, const std::vector<uint32_t>& numbers, const std::vector<float>& values) {
                for (std::size_t i = 0; i < numbers.size(); ++i) {
                    float* at =
                        &p.coefficients[numbers[i] / kLanes * p.block_length() +
                                        term * std::size_t(p.channels) * kLanes + numbers[i] % kLanes];
                    for (int channel = 0; channel < p.channels; ++channel)
                        at[channel * kLanes] += values[i * std::size_t(p.channels) + channel];
                }
            });
        const auto residuals = map_.residuals(light, box, c);
        for (std::size_t i = 0; i < patches; ++i) p.residuals[i] = std::hypot(p.residuals[i], residuals[i]);
    }
    map_.release_pages();
    return packed;
}

std::shared_ptr<const PackedBox> CoefficientStore::get(std::size_t light, std::size_t box) {
    const auto held = [&] {
        const std::lock_guard lock(mutex_);
        return slots_[light][box].box;
    };
    if (auto packed = held()) return packed;
    const std::lock_guard one_at_a_time(reading_);
    if (auto packed = held()) return packed;  // the other thread was reading it
    auto packed = read(light, box);
    const std::lock_guard lock(mutex_);
    slots_[light][box].box = packed;
    return packed;
}

void CoefficientStore::plan(std::size_t light, const Vec3d& position) {
    const auto& boxes = map_.outline().lights[light].boxes;
    const std::lock_guard lock(mutex_);
    for (std::size_t b = 0; b < boxes.size(); ++b)
        slots_[light][b].distance = distance_from(boxes[b], position);
    changed_.notify_one();
}

void CoefficientStore::drop_far() {
    const std::lock_guard lock(mutex_);
    for (auto& light : slots_)
        for (Slot& slot : light)
            if (slot.distance > kFar) slot.box.reset();
}

void CoefficientStore::work(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    const auto next = [&]() -> std::optional<std::pair<std::size_t, std::size_t>> {  // the nearest
        std::optional<std::pair<std::size_t, std::size_t>> best;
        double least = kNear;
        for (std::size_t l = 0; l < slots_.size(); ++l)
            for (std::size_t b = 0; b < slots_[l].size(); ++b)
                if (const Slot& s = slots_[l][b]; !s.box && !s.failed && s.distance < least) {
                    least = s.distance;
                    best = {l, b};
                }
        return best;
    };
    while (changed_.wait(lock, stop, [&] { return next().has_value(); })) {
        const auto [light, box] = *next();
        lock.unlock();
        std::string problem;
        try {
            get(light, box);
        } catch (const std::exception& e) {
            problem = e.what();
        }
        lock.lock();
        slots_[light][box].failed = !problem.empty();
        if (!problem.empty()) problem_ = problem;
    }
}

std::vector<ActiveBox> CoefficientStore::active(const std::vector<LightState>& lights) {
    std::vector<ActiveBox> all;
    for (std::size_t l = 0; l < lights.size(); ++l) {
        const MapLight& light = map_.outline().lights[l];
        check_in_domain(light.name, light.domain, lights[l].position, map_.outline().origin);
        const Vec3d position = clamped(light.domain, lights[l].position);
        plan(l, position);
        if (is_black(lights[l].power) || components_.empty()) continue;
        const std::vector<double> weights = box_weights(light.boxes, position);
        for (std::size_t b = 0; b < light.boxes.size(); ++b) {
            if (!(weights[b] > 0)) continue;
            ActiveBox& active =
                all.emplace_back(get(l, b), std::vector<float>{}, lights[l].power * float(weights[b]));
            const auto m = monomials(Vec3(light.boxes[b].normalised(position)));
            for (const int term : active.box->terms) active.monomials.push_back(m[term]);
        }
    }
    drop_far();  // last: where reading fails, the light before can still be shown
    return all;
}

bool CoefficientStore::is_settled() const {
    const std::lock_guard lock(mutex_);
    return std::ranges::all_of(slots_, [](const std::vector<Slot>& light) {
        return std::ranges::all_of(light,
                                   [](const Slot& s) { return s.box || s.failed || !(s.distance < kNear); });
    });
}

std::size_t CoefficientStore::bytes() const {
    const std::lock_guard lock(mutex_);
    std::size_t sum = 0;
    for (const auto& light : slots_)
        for (const Slot& slot : light)
            if (slot.box) sum += slot.box->bytes();
    return sum;
}

std::size_t CoefficientStore::boxes() const {
    const std::lock_guard lock(mutex_);
    std::size_t count = 0;
    for (const auto& light : slots_)
        count += std::size_t(std::ranges::count_if(light, [](const Slot& s) { return s.box != nullptr; }));
    return count;
}

std::string CoefficientStore::take_problem() {
    const std::lock_guard lock(mutex_);
    return std::exchange(problem_, {});
}

}  // namespace pim
