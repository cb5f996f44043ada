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
    std::vector<Found> all;
    for (const Fragment& f : cut_into_fragments(scene, surface)) {
        const Index3 cell = cell_of(cells.grid, f.key);
        const auto* patches = cells.left_out.contains(f.key) ? nullptr : cells.index.find_cell(cell);
        if (!patches) continue;
        const Vec3 from_centre(Vec3d(f.centre) - cells.grid.centre(cell));
        const Vec3 above = f.centre + plane_normal(scene.geometry, f) * lift_;
        for (int k = 0; k < kFacingCount; ++k) {
            const int patch = f.facing_area[k] > 0 ? cells.patch_at(*patches, k, from_centre) : -1;
            if (patch >= 0) all.push_back({uint32_t(patch), {above, f.facing_area[k]}});
        }
    }
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
