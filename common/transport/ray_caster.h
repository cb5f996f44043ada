// SPDX-License-Identifier: GPL-3.0-or-later
// Every ray of the program. Embree inside.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "common/scene/geometry.h"

namespace pim {

struct Ray {
    Vec3 origin, direction;  // local; direction unit
    float length = std::numeric_limits<float>::infinity();
};

struct Hit {
    uint32_t triangle;
    float distance;
    float b1, b2;  // barycentric weights of the second and third corner
    Side side;     // the one that the ray meets
};

// Which instruction set Embree may use: its answers differ in their last bits between them, so a bake pins
// the one that every supported machine has; the viewer takes the best.
enum class InstructionSet { pinned, best };

class RayCaster {
  public:
    RayCaster(const Geometry& geometry, InstructionSet instructions);
    ~RayCaster();
    std::optional<Hit> intersect(const Ray& ray) const;
    bool occluded(const Ray& ray) const;  // anything at all before ray.length

    // Distance by which rays are started off a surface, m: beyond the rounding of positions in this scene.
    float surface_offset() const { return surface_offset_; }
    std::string instruction_set() const;

  private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
    float surface_offset_;
};

}  // namespace pim
