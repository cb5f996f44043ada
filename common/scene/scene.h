// SPDX-License-Identifier: GPL-3.0-or-later
// A scene description with everything it names loaded: what `bake` and `viewer` agree on.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "common/core/image.h"
#include "common/scene/camera.h"
#include "common/scene/geometry.h"
#include "common/scene/light.h"
#include "common/scene/material.h"

namespace pim {

enum class Estimator { area, sphere };
enum class Store { incident, absorbed };
enum class Robust { off, automatic, always };

// The part of the light that has come straight from a lamp, and all the rest.
enum class Component : uint8_t { direct, indirect };
inline constexpr int kComponentCount = 2;
const char* name(Component component);

struct CellCount {
    int longest = 64;  // cells along the longest side of the bounds
};
struct CellSize {
    double metres;
};

struct GridSettings {
    std::variant<CellCount, CellSize> resolution = CellCount{};
    std::optional<Box3> bounds;  // local; absent: the geometry's box
    bool facings = true;
    Estimator estimator = Estimator::area;
    std::optional<double> radius;                // m, for `sphere`; absent: kDefaultRadius cells
    bool reachable_area_only = true;             // false: all of the cell's surface counts (the thesis)
    uint64_t reach_photons = uint64_t{1} << 23;  // that look for it, at most
};

struct BakeSettings {
    uint64_t photons = 40000;  // per lamp position
    std::vector<Component> components{Component::indirect};
    int degree = 3;
    Robust robust = Robust::automatic;
    Store store = Store::incident;
    bool shrinkage = true;  // and filter, by known noise (see fit.h); false: plain least squares (the thesis)
    bool mend_signs = true;  // negative values of a polynomial are seen as 0; false: as they are (the thesis)
    uint64_t seed = 1;
};

// What a bake that chooses for itself aims at where nothing names an error or a time.
inline constexpr double kDefaultTargetError = 0.03;

// What the bake is to choose by itself, and how far it is to go.
struct Choices {
    bool cells = false, reach_photons = false, photons = false, degree = false;
    std::optional<double> target_error;  // relrmse, as `bake evaluate` measures it
    std::optional<double> time_budget;   // s
};

struct Scene {
    std::filesystem::path description_file;
    std::string description;  // the text of the description, overrides applied
    std::filesystem::path geometry_file;
    std::string geometry_hash;  // of everything that decides how light travels
    Geometry geometry;
    std::vector<Material> materials;
    std::vector<Image> textures;
    std::vector<Light> lights;
    std::vector<Camera> cameras;
    GridSettings grid;
    BakeSettings bake;
    Choices choices;
};

struct Reflectance {
    Rgb diffuse, specular;
};

// Of a triangle's material at barycentric weights b1, b2, texture included; black for glass.
Reflectance reflectance(const Scene& scene, uint32_t triangle, float b1, float b2);

bool is_automatic(const Scene& scene);  // is anything left to choose?
bool is_grey(const Scene& scene);       // every reflectance has three equal channels
const Camera& find_camera(const Scene& scene, const std::string& name);  // throws UsageError
std::size_t find_light(const Scene& scene, const std::string& name);     // throws UsageError
std::string content_hash(const Scene& scene);

}  // namespace pim
