// SPDX-License-Identifier: GPL-3.0-or-later
// Maps with made-up light: patches where a scene has surfaces, polynomials at random. They hold what a bake
// would hardly give — all twenty terms alike, negative values, layers everywhere, neighbours that have
// nothing in common — and take a fraction of a second.
#pragma once

#include <unistd.h>

#include <cmath>
#include <map>

#include "common/core/log.h"
#include "common/map/baked_scene.h"
#include "common/map/map_file.h"
#include "common/scene/scene_file.h"
#include "common/transport/ray_caster.h"
#include "temporary_folder.h"

namespace pim {

class Dice {
  public:
    explicit Dice(uint64_t seed) : random_(seed, RandomPurpose::evaluation, 0, 0) {}
    float between(float low, float high) { return low + (high - low) * random_.next(); }
    int below(int count) { return int(random_.next() * float(count)); }
    bool chance(float probability) { return random_.next() < probability; }
    Vec3 inside(const Box3& box) {
        const float x = random_.next(), y = random_.next(), z = random_.next();
        return box.min + (box.max - box.min) * Vec3(x, y, z);
    }
    Vec3 direction() {
        for (;;) {
            const Vec3 v = inside({Vec3(-1), Vec3(1)});
            if (v.length2() > 0.01f && v.length2() < 1) return v.normalized();
        }
    }

  private:
    RandomStream random_;
};

struct SyntheticLight {
    float level = 0.01f;     // of the constant terms, W/m² per watt; others are up to 0.15 of it
    float negative = 0.05f;  // share of patches whose constant is negative
};

inline Polynomials random_polynomials(std::size_t patches, const std::vector<int>& terms, bool grey,
                                      Dice& dice, const SyntheticLight& o = {}) {
    Polynomials p{terms, {}, {}};
    for (std::size_t patch = 0; patch < patches; ++patch) {
        p.residuals.push_back(dice.between(0, 0.2f) * o.level);
        const bool negative = dice.chance(o.negative);
        for (const int term : terms) {
            Rgb a;
            for (int c = 0; c < 3; ++c) {
                const float constant = dice.between(0.3f, 1), other = dice.between(-0.15f, 0.15f);
                a[c] = o.level * (term != kConstantTerm ? other : negative ? -constant : constant);
            }
            for (int c = 0; c < 3; ++c) p.coefficients.push_back(grey ? a.x : a[c]);
        }
    }
    return p;
}

// A lamp of the map with polynomials for all its patches.
inline MapLight random_light(const IlluminationMap& map, const std::string& name, const Box3& domain,
                             const Index3& divisions, Dice& dice, const SyntheticLight& o = {}) {
    MapLight light;
    light.name = name;
    light.domain = domain;
    light.boxes = split_domain(domain, divisions);
    const auto terms = terms_of(3, light.boxes[0].moves());
    for (std::size_t b = 0; b < light.boxes.size(); ++b) {
        light.fits.push_back({40, int(terms.size()), 1.5, 1.5, {}, 0});
        auto& polynomials = light.polynomials.emplace_back();
        for (const Component c : map.components)
            polynomials[std::size_t(c)] = random_polynomials(map.patches.size(), terms, map.grey, dice, o);
    }
    return light;
}

// Patches on both sides of all surfaces: some hundred places per cell, each in the cell before it. Where
// `layers`, a third of all cells and facings has a second one behind.
inline std::vector<Patch> scattered_patches(const Scene& scene, const CellGrid& grid, bool layers) {
    struct Sum {
        double area = 0;
        Vec3d moment{0};
    };
    std::map<std::tuple<int, int, int, int>, Sum> sums;  // cell, slot
    Dice dice(7);
    for (uint32_t t = 0; t < scene.geometry.triangles.size(); ++t) {
        const auto corners = scene.geometry.corners(t);
        const double whole = area(corners);
        const int count = std::clamp(int(100 * whole / (grid.cell_size * grid.cell_size)), 3, 20000);
        for (int i = 0; i < 2 * count; ++i) {
            float b1 = dice.between(0, 1), b2 = dice.between(0, 1);
            if (b1 + b2 > 1) b1 = 1 - b1, b2 = 1 - b2;
            const Vec3 normal = shading_normal(scene.geometry, t, Side(i % 2), b1, b2);
            const Vec3 p = corners[0] + (corners[1] - corners[0]) * b1 + (corners[2] - corners[0]) * b2;
            const Vec3d place =
                (Vec3d(p + normal * float(0.01 * grid.cell_size)) - grid.origin) / grid.cell_size;
            const Index3 cell(int(std::floor(place.x)), int(std::floor(place.y)), int(std::floor(place.z)));
            if (!grid.contains(cell)) continue;
            const FacingWeights facing = facing_weights(grid, normal);
            for (int k = 0; k < kFacingCount; ++k) {
                if (!(facing.weight[std::size_t(k)] > 0)) continue;
                const bool split = layers && grid.facings && (cell.x + 2 * cell.y + cell.z + k) % 3 == 0;
                const bool behind = split && dice.chance(0.5f);
                Sum& sum = sums[{cell.x, cell.y, cell.z, behind ? k + kFacingCount : k}];
                const double share = whole / count * double(facing.weight[std::size_t(k)]);
                Vec3d from_centre = Vec3d(p) - grid.centre(cell);
                if (behind) from_centre -= Vec3d(normal) * (0.3 * grid.cell_size);
                sum.area += share;
                sum.moment += from_centre * share;
            }
        }
    }
    std::vector<Patch> patches;
    for (const auto& [key, sum] : sums) {
        const auto& [x, y, z, slot] = key;
        patches.push_back({Index3(x, y, z), slot, float(sum.area), Vec3(sum.moment / sum.area)});
    }
    return patches;
}

// A third of all patches sees everything; the others' parts, whatever the dice say.
inline PatchSight random_sight(const std::vector<Patch>& patches, Dice& dice) {
    std::vector<PatchSight::Entry> entries;
    for (uint32_t p = 0; p < patches.size(); ++p)
        for (int part = 0; p % 3 && part < kPartCount; ++part)
            if (dice.chance(0.9f)) entries.push_back({p, part, Unseen(dice.below(1 << 16))});
    return {patches.size(), std::move(entries)};
}

struct SyntheticOptions {
    int cells = 10;  // along the longest side
    bool facings = true, layers = true, mend_signs = true, walls = false;
    Index3 boxes{2, 1, 1};
    std::vector<Component> components{Component::direct, Component::indirect};
    SyntheticLight light;
};

// The scene's grid and the divisions of its lamps' domains become those of the options.
inline IlluminationMap synthetic_map(Scene& scene, const SyntheticOptions& o) {
    scene.grid.resolution = CellCount{o.cells};
    scene.grid.facings = o.facings;
    IlluminationMap map;
    map.origin = scene.geometry.origin;
    map.grid = make_grid(scene);
    map.patches = scattered_patches(scene, map.grid, o.layers);
    map.index = PatchIndex(map.grid, map.patches);
    map.mend_signs = o.mend_signs;
    map.components = o.components;
    map.description = scene.description;
    if (!scene.geometry_file.empty())
        map.geometry_path = std::filesystem::absolute(scene.geometry_file).string();
    map.geometry_hash = scene.geometry_hash;
    Dice dice(1);
    if (o.walls) map.sight = random_sight(map.patches, dice);
    for (Light& light : scene.lights) {
        for (int axis = 0; axis < 3; ++axis)
            light.boxes[axis] = light.domain.max[axis] > light.domain.min[axis] ? o.boxes[axis] : 1;
        map.lights.push_back(random_light(map, light.name, light.domain, light.boxes, dice, o.light));
        map.lights.back().type = light.rectangle() ? "rectangle" : "point";
        map.lights.back().power = light.power;
    }
    return map;
}

inline Scene scene_of_data(const std::string& name) {
    set_log_level("error");
    return read_scene(std::filesystem::path(PIM_DATA) / name / (name + ".toml"));
}

// A scene, its map in memory and on disk. Those of data/ can be opened by the map's name alone.
struct MappedScene {
    TemporaryFolder folder;
    std::filesystem::path file = folder / "map.vdb";
    BakedScene baked;
    MapFile map;
    RayCaster caster;

    explicit MappedScene(Scene scene, const SyntheticOptions& o = {})
        : baked(with_map(std::move(scene), o)),
          map((write_map(file, baked.map), file)),
          caster(baked.scene.geometry, InstructionSet::best) {}
    // `bake` writes the map to the path that it is given.
    template <class Bake>
    static MappedScene baked_by(Bake bake) {
        return MappedScene(bake, 0);
    }
    const Scene& scene() const { return baked.scene; }

  private:
    template <class Bake>
    MappedScene(Bake bake, int)
        : baked((bake(file), read_baked_scene(file, {}))),
          map(file),
          caster(baked.scene.geometry, InstructionSet::best) {}
    static BakedScene with_map(Scene scene, const SyntheticOptions& o) {
        BakedScene made;
        made.map = synthetic_map(scene, o);
        made.scene = std::move(scene);
        return made;
    }
};

}  // namespace pim
