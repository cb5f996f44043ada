// SPDX-License-Identifier: GPL-3.0-or-later
// The baked result: for each patch of the scene and each box of each lamp's domain, a cubic of the lamp's
// position that gives the patch's irradiance per watt.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/map/cell_grid.h"
#include "common/map/map_box.h"
#include "common/map/patch_sight.h"
#include "common/map/polynomial.h"
#include "common/scene/light.h"

namespace pim {

// What became of a patch's fit; bits.
enum FitStatus : uint8_t {
    kRobust = 1,        // some samples are outliers and count less
    kRobustFailed = 2,  // they are, but no better fit was found: it is the linear one
    kMended = 4,        // went below zero and was moved towards its mean
    kBlack = 8,         // had a negative mean and is 0 now
};

struct Polynomials {
    std::vector<int> terms;            // those that are stored, in equation (7)'s order
    std::vector<float> coefficients;   // [patch][term][channel], W/m² per watt and channel
    std::vector<float> residuals;      // [patch] root mean square misfit over the samples, W/m² per watt
    std::vector<uint8_t> status = {};  // [patch] of FitStatus; empty: all 0
};

// What the fit of one box was given and how well it was posed.
struct FitStatistics {
    int samples = 0;
    int rank = 0;                     // terms that the samples determine
    double condition_number = 1;      // of the design as it was used
    double raw_condition_number = 1;  // of the monomials of world coordinates
    std::vector<int> dropped = {};    // terms that the samples do not determine
    int iterations = 0;               // of robust fits
};

struct MapLight {
    std::string name;
    Box3 domain;  // local, m
    std::vector<MapBox> boxes;
    std::vector<FitStatistics> fits;  // per box
    std::vector<std::array<std::optional<Polynomials>, kComponentCount>>
        polynomials;             // per box, by component
    std::string type = "point";  // or "rectangle"
    Rgb power{0};                // W per channel, as described
};

struct IlluminationMap {
    Vec3d origin{0};  // of local positions, world space, m
    CellGrid grid;
    std::vector<Patch> patches;  // sorted by patch_before
    PatchIndex index;
    PatchSight sight;
    bool grey = false;       // one channel stands for three
    bool mend_signs = true;  // negative values of a polynomial count as 0
    std::vector<Component> components;
    std::vector<MapLight> lights;
    std::string description;    // the scene description that was baked
    std::string geometry_path;  // relative to the map
    std::string geometry_hash;
    std::vector<std::string> left_out;  // what the scene did not need, in words

    bool has(Component component) const;
};

// A lamp as it stands in a picture.
struct LightState {
    Vec3 position;  // local
    Rgb power;      // W per channel, gain applied
};

// Irradiance of every patch by the given components together under all lamps, W/m², negative values cut to 0
// where the map asks for it (mend_signs); how many these were goes to `cut`.
// Throws UsageError if a lamp stands outside its domain, naming it.
std::vector<Rgb> patch_irradiance(const IlluminationMap& map, const std::vector<Component>& components,
                                  const std::vector<LightState>& lights, std::size_t* cut = nullptr);

// The nearest place in the domain: check_in_domain forgives rounding, boxes do not.
Vec3d clamped(const Box3& domain, const Vec3& position);

// Throws UsageError naming the domain in world coordinates.
void check_in_domain(const std::string& light, const Box3& domain, const Vec3& position, const Vec3d& origin);

}  // namespace pim
