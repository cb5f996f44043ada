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

// Sixteen rays, traced together: fastest where they go nearly the same way. Directions need not be unit;
// lengths count in them.
struct alignas(64) RayPacket {
    static constexpr int kSize = 16;
    float origin[3][kSize], nearest[kSize], direction[3][kSize], time[kSize], length[kSize];
    uint32_t mask[kSize], id[kSize], flags[kSize];

    RayPacket();  // no ray is active: length < 0
    void set(int lane, const Vec3& from, const Vec3& towards, float until) {
        for (int axis = 0; axis < 3; ++axis)
            origin[axis][lane] = from[axis], direction[axis][lane] = towards[axis];
        length[lane] = until;
    }
};

struct alignas(64) HitPacket {
    RayPacket rays;  // length: distance to the hit
    float normal[3][RayPacket::kSize], u[RayPacket::kSize], v[RayPacket::kSize];
    uint32_t triangle[RayPacket::kSize], geometry[RayPacket::kSize], instance[RayPacket::kSize];

    bool is_hit(int lane) const { return geometry[lane] != ~0u; }
    std::optional<Hit> hit(int lane) const;
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
    void intersect(HitPacket& packet) const;
    void occluded(RayPacket& packet) const;  // length becomes negative where anything stands in the way

    // Distance by which rays are started off a surface, m: beyond the rounding of positions in this scene.
    float surface_offset() const { return surface_offset_; }
    std::string instruction_set() const;

  private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
    float surface_offset_;
};

}  // namespace pim
