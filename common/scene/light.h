// SPDX-License-Identifier: GPL-3.0-or-later
// Lamps. Positions are local (see geometry.h), metres; power is radiant flux, W per colour channel.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "common/core/random.h"
#include "common/core/vector.h"

namespace pim {

inline constexpr float kLumensPerWatt = 683;  // photometric units, at 555 nm

struct PointShape {};

// One-sided: shines where `normal` points, with the same radiance in all directions. Corners at
// position ± size.x/2 · axes[0] ± size.y/2 · axes[1].
struct RectangleShape {
    Vec2 size;     // m, > 0
    Vec3 normal;   // unit
    Vec3 axes[2];  // unit, orthogonal to normal

    RectangleShape(Vec2 size, Vec3 normal);
    float area() const { return size.x * size.y; }
};

using LightShape = std::variant<PointShape, RectangleShape>;

// So many positions, well spread over each of the domain's `boxes` in turn.
struct SampleGroup {
    Index3 boxes{1, 1, 1};
    int count = 0;
};

// Where positions of a lamp are sampled: so many, spread over its boxes; a regular grid; or groups, one after
// the other, each spread over boxes of its own (positions that were added later).
using SampleCount = std::variant<int, Index3, std::vector<SampleGroup>>;

struct Light {
    std::string name;
    LightShape shape;
    Rgb power{100};
    Box3 domain;            // where it may stand; zero extent on an axis: it does not move there
    Index3 boxes{1, 1, 1};  // the domain's division per axis
    SampleCount samples = 182;
    bool choose_boxes = false, choose_samples = false;  // the bake chooses them (see Choices)
    Vec3 position;                                      // where it stands unless told otherwise

    const RectangleShape* rectangle() const { return std::get_if<RectangleShape>(&shape); }
};

struct Emission {
    Vec3 origin, direction;
};

// A photon's start from a lamp at `position`; all photons carry the same power.
Emission sample_emission(const Light& light, const Vec3& position, RandomStream& random);
// Its direction from two numbers, uniform in [0, 1).
Emission sample_emission(const Light& light, const Vec3& position, const Vec2& direction,
                         RandomStream& random);

// Radiance of a rectangular lamp of `power` per channel: power / (pi · area), W/(m² sr).
Rgb emitted_radiance(const RectangleShape& shape, const Rgb& power);

// Distance along a ray at which it meets the lamp's shining side.
std::optional<float> intersect(const RectangleShape& shape, const Vec3& centre, const Vec3& origin,
                               const Vec3& direction);

}  // namespace pim
