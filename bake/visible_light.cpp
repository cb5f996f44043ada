// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/visible_light.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "bake/sample_photons.h"
#include "common/core/parallel.h"
#include "common/map/irradiance.h"

namespace pim {
namespace {

constexpr float kLift = 0.1f;  // cells
constexpr uint64_t kPlacesPerPatch = 64;
constexpr float kLeastSeen = 0.05f;
constexpr uint64_t kChunk = 1 << 16;

Vec3 lifted(const SurfacePoint& s, float lift) { return s.position + s.geometric_normal * lift; }

// Sorts by patch; first[p] is where patch p begins, with one more at the end.
template <class Item, class PatchOf>
std::vector<uint32_t> sort_by_patch(std::vector<Item>& items, std::size_t patches, PatchOf patch_of) {
    std::ranges::stable_sort(items, {}, patch_of);
    std::vector<uint32_t> first(patches + 1, 0);
    for (const Item& item : items) ++first[std::invoke(patch_of, item) + 1];
    for (std::size_t p = 0; p < patches; ++p) first[p + 1] += first[p];
    return first;
}

// Places spread uniformly over the area of all surfaces, both sides.
class Spread {
  public:
    explicit Spread(const Scene& scene) : scene_(scene) {
        for (uint32_t t = 0; t < scene.geometry.triangles.size(); ++t)
            sums_.push_back((sums_.empty() ? 0 : sums_.back()) + area(scene.geometry.corners(t)));
    }
    SurfacePoint place(uint64_t k) const {
        RandomStream random(0, RandomPurpose::evaluation, 0xa4ea, k);
        const double at = (double(random.next()) + double(random.next()) * 0x1p-24) * sums_.back();
        const auto triangle =
            std::min(std::size_t(std::ranges::upper_bound(sums_, at) - sums_.begin()), sums_.size() - 1);
        const float root = std::sqrt(random.next()), v = random.next();
        return surface_at(scene_, {uint32_t(triangle), 0, root * (1 - v), root * v,
                                   random.next() < 0.5f ? Side::front : Side::back});
    }

  private:
    const Scene& scene_;
    std::vector<double> sums_;
};

}  // namespace

std::vector<Landed> landed_light(const Scene& scene, const RayCaster& caster, const Cells& cells,
                                 const SurfaceCells& surface, const LightSample& sample, const Rgb& power) {
    const uint64_t photons = scene.bake.photons, chunks = (photons + kChunk - 1) / kChunk;
    const float lift = kLift * float(cells.grid.cell_size);
    std::vector<std::vector<Landed>> parts(chunks);
    const SamplePhotons source(scene, caster, sample);
    parallel_for(chunks, [&](std::size_t chunk) {
        EnergyAccount account;
        const auto landed = [&](const Landing& landing) {
            const Component component = landing.straight ? Component::direct : Component::indirect;
            const auto& wanted = scene.bake.components;
            if (std::ranges::find(wanted, component) == wanted.end()) return;
            const SurfacePoint& s = landing.surface;
            const auto flux = stored_flux(landing, scene.bake.store);
            const auto cell = flux ? counted_cell(cells, surface, s) : std::nullopt;
            if (!cell) return;
            for_each_patch_at(cells, *cell, s, [&](std::size_t patch, float share) {
                const float scale = share / (float(photons) * cells.patches[patch].area);
                parts[chunk].push_back({uint32_t(patch), lifted(s, lift), *flux * power * scale});
            });
        };
        source.trace(chunk * kChunk, std::min(photons, (chunk + 1) * kChunk), landed, account);
    });
    std::vector<Landed> all;
    for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
    return all;
}

VisibleLight::VisibleLight(const Scene& scene, const Cells& cells, const SurfaceCells& surface)
    : lift_(kLift * float(cells.grid.cell_size)) {
    struct Found {
        uint32_t patch;
        Place place;
    };
    const Spread spread(scene);
    const uint64_t count = kPlacesPerPatch * cells.patches.size(), chunks = (count + kChunk - 1) / kChunk;
    std::vector<std::vector<Found>> parts(chunks);
    parallel_for(chunks, [&](std::size_t chunk) {
        for (uint64_t k = chunk * kChunk; k < std::min(count, (chunk + 1) * kChunk); ++k) {
            const SurfacePoint s = spread.place(k);
            const auto cell = counted_cell(cells, surface, s);
            if (!cell) continue;
            for_each_patch_at(cells, *cell, s, [&](std::size_t patch, float share) {
                parts[chunk].push_back({uint32_t(patch), {lifted(s, lift_), share}});
            });
        }
    });
    std::vector<Found> all;
    for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
    first_place_ = sort_by_patch(all, cells.patches.size(), &Found::patch);
    for (const Found& found : all) places_.push_back(found.place);
}

void VisibleLight::set(std::vector<Landed> landed) {
    landed_ = std::move(landed);
    first_landed_ = sort_by_patch(landed_, first_place_.size() - 1, &Landed::patch);
}

std::vector<Rgb> VisibleLight::patch_values() const {
    std::vector<Rgb> values;
    for (std::size_t p = 0; p + 1 < first_landed_.size(); ++p) {
        Vec3d sum(0);
        for (uint32_t i = first_landed_[p]; i < first_landed_[p + 1]; ++i)
            sum += Vec3d(landed_[i].irradiance);
        values.emplace_back(sum);
    }
    return values;
}

Rgb VisibleLight::irradiance(const IlluminationMap& map, const RayCaster& caster,
                             const SurfacePoint& s) const {
    const Vec3 from = lifted(s, lift_);
    const auto sees = [&](const Vec3& place) {
        const Vec3 way = place - from;
        const float length = way.length();
        return !(length > 0) || !caster.occluded({from, way / length, length});
    };
    std::vector<PatchShare> shares;
    look_up(map, s.position, s.shading_normal, shares);
    Rgb sum(0);
    float seen = 0, all = 0;
    for (const PatchShare& share : shares) {
        if (!(share.weight > 0)) continue;
        all += share.weight;
        float area = 0, seen_area = 0;
        for (uint32_t i = first_place_[share.patch]; i < first_place_[share.patch + 1]; ++i) {
            area += places_[i].share;
            if (sees(places_[i].position)) seen_area += places_[i].share;
        }
        seen += share.weight * (area > 0 ? seen_area / area : 1);
        for (uint32_t i = first_landed_[share.patch]; i < first_landed_[share.patch + 1]; ++i)
            if (sees(landed_[i].position)) sum += landed_[i].irradiance * share.weight;
    }
    return sum * (all > 0 ? all / std::max(seen, kLeastSeen * all) : 0);
}

}  // namespace pim
