// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/places.h"

namespace pim {
namespace {

constexpr int kTries = 8;  // to find one place of a fragment in its box

}  // namespace

FragmentPlane::FragmentPlane(const Geometry& geometry, const Fragment& fragment)
    : fragment_(fragment),
      corners_(geometry.corners(fragment.key.triangle)),
      normal_(geometric_normal(corners_)) {}

Vec3 FragmentPlane::flat(Vec3 p) const {
    const PlaneAxes to(normal_);
    p[to.axis] = corners_[0][to.axis] - ((p[to.u] - corners_[0][to.u]) * normal_[to.u] +
                                         (p[to.v] - corners_[0][to.v]) * normal_[to.v]) /
                                            normal_[to.axis];
    return p;
}

std::vector<Vec3> FragmentPlane::places(int number, int most) const {
    std::vector<Vec3> found;
    for (int i = 0; i < kTries * most && int(found.size()) < most; ++i)
        if (const auto place = place_at(golden_place(number * kTries * most + i))) found.push_back(*place);
    return found;
}

std::optional<Vec3> FragmentPlane::place_at(const Imath::V2d& share) const {
    const PlaneAxes to(normal_);
    const Box3& box = fragment_.box;
    Vec3 p = box.min;
    p[to.u] += float(share.x) * (box.max[to.u] - box.min[to.u]);
    p[to.v] += float(share.y) * (box.max[to.v] - box.min[to.v]);
    p = flat(p);
    const float slack = 1e-3f * std::max(box.max[to.u] - box.min[to.u], box.max[to.v] - box.min[to.v]);
    if (p[to.axis] < box.min[to.axis] - slack || p[to.axis] > box.max[to.axis] + slack) return {};
    for (int i = 0; i < 3; ++i)
        if ((corners_[(i + 1) % 3] - corners_[i]).cross(p - corners_[i]).dot(normal_) < 0) return {};
    return p;
}

Vec3 lifted_centre(const Scene& scene, const RayCaster& caster, const CellGrid& grid,
                   const Fragment& fragment) {
    const Vec3 up = plane_normal(scene.geometry, fragment);
    const Vec3 start = fragment.centre + up * caster.surface_offset();
    const float lift = kSightLift * float(grid.cell_size);
    const auto above = caster.intersect({start, up, lift});
    return start + up * (above ? 0.5f * above->distance : lift);
}

RayPacket lines_between(const Places& from, const Places& to, int packet_number) {
    RayPacket packet;
    for (int lane = 0; lane < RayPacket::kSize; ++lane) {
        const Imath::V2d share = golden_place(packet_number * RayPacket::kSize + lane);
        const Vec3 a = from.at(share.x), b = to.at(share.y);
        packet.set(lane, a, b - a, 1);
    }
    return packet;
}

}  // namespace pim
