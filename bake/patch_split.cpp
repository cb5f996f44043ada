// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/patch_split.h"

#include <cmath>

#include "bake/places.h"

namespace pim {
namespace {

constexpr double kLayerGap = 0.1;  // in cells: surfaces parted by more are two layers
constexpr int kPackets = 4;
constexpr double kAgreement = 0.9;
constexpr int kFewestAcross = 6;
constexpr float kSheet = 0.02f;  // cells: thinner, surface lies on the middle plane itself

struct Line {
    Vec3 from, to;  // from the cell's centre
    bool is_blocked;
};

// Of the lines that are blocked or cross the plane, the share that is and does.
double agreement(const std::vector<Line>& lines, const PatchSplit& split) {
    int both = 0, either = 0;
    for (const Line& line : lines) {
        const bool crosses = split.is_behind(line.from) != split.is_behind(line.to);
        both += crosses && line.is_blocked;
        either += crosses || line.is_blocked;
    }
    return both < kFewestAcross ? 0 : double(both) / double(either);
}

Vec3 start_of(const RayPacket& lines, int lane) {
    return {lines.origin[0][lane], lines.origin[1][lane], lines.origin[2][lane]};
}

Vec3 end_of(const RayPacket& lines, int lane) {
    return start_of(lines, lane) +
           Vec3(lines.direction[0][lane], lines.direction[1][lane], lines.direction[2][lane]);
}

// Whether either side of a surface belongs to a facing.
bool is_of(const CellGrid& grid, int facing, const Vec3& normal) {
    return facing_weights(grid, normal).weight[facing] > 0 ||
           facing_weights(grid, -normal).weight[facing] > 0;
}

}  // namespace

bool PatchSplit::passes(const Box3& box, const Vec3d& centre) const {
    int behind = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3 place(corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y,
                         corner & 4 ? box.max.z : box.min.z);
        behind += is_behind(Vec3(Vec3d(place) - centre));
    }
    return behind > 0 && behind < 8;
}

PatchSplit PatchSplitter::find(std::span<const std::size_t> of_cell, int facing, const Vec3d& centre) const {
    if (!grid_.facings) return {};
    const PatchSplit layers = by_layers(of_cell, facing, centre);
    return std::isfinite(layers.offset) ? layers : by_sight(of_cell, facing, centre);
}

// At the middle of the widest gap between surfaces, if it is wide enough.
PatchSplit PatchSplitter::by_layers(std::span<const std::size_t> of_cell, int facing,
                                    const Vec3d& centre) const {
    const int axis = facing / 2, sign = facing % 2 ? -1 : 1;
    std::vector<std::pair<double, double>> extents;  // from, to
    for (const std::size_t i : of_cell) {
        const Fragment& f = fragments_[i];
        if (!(f.facing_area[std::size_t(facing)] > 0.5f * f.area)) continue;
        extents.push_back(std::minmax(sign * (double(f.box.min[axis]) - centre[axis]),
                                      sign * (double(f.box.max[axis]) - centre[axis])));
    }
    std::ranges::sort(extents);
    PatchSplit split;
    double widest = kLayerGap * grid_.cell_size, reached = extents.empty() ? 0 : extents[0].second;
    for (const auto& [from, to] : extents) {
        if (from - reached > widest) {
            widest = from - reached;
            split.normal[axis] = float(sign);
            split.offset = float(0.5 * (from + reached));
        }
        reached = std::max(reached, to);
    }
    return split;
}

// By the middle plane of something that hides places from each other, if it parts nearly all that do not see
// each other and nearly none that do.
PatchSplit PatchSplitter::by_sight(std::span<const std::size_t> of_cell, int facing,
                                   const Vec3d& centre) const {
    Places places, lifted;
    for (const std::size_t i : of_cell)
        if (const float area = fragments_[i].facing_area[std::size_t(facing)]; area > 0) {
            places.add(Vec3(Vec3d(fragments_[i].centre) - centre), area);
            lifted.add(lifted_centre(scene_, caster_, grid_, fragments_[i]), area);
        }
    if (places.empty()) return {};
    std::vector<Line> lines;
    std::vector<PatchSplit> planes;
    for (int number = 0; number < kPackets; ++number) {
        RayPacket sight = lines_between(lifted, lifted, number);
        const RayPacket above = sight, ends = lines_between(places, places, number);
        caster_.occluded(sight);
        for (int lane = 0; lane < RayPacket::kSize; ++lane) {
            const bool is_blocked = sight.length[lane] < 0;
            lines.push_back({start_of(ends, lane), end_of(ends, lane), is_blocked});
            if (!is_blocked) continue;
            if (const auto plane = between(start_of(above, lane), end_of(above, lane), facing, centre))
                planes.push_back(*plane);
        }
        if (planes.empty()) return {};
    }
    double best = kAgreement;
    PatchSplit split;
    for (const PatchSplit& plane : planes) {
        const double own = agreement(lines, plane);
        if (own > best) best = own, split = plane;
    }
    return split;
}

// In the middle of what lies between two places; none where that is a sheet of the facing's own surface.
std::optional<PatchSplit> PatchSplitter::between(const Vec3& from, const Vec3& to, int facing,
                                                 const Vec3d& centre) const {
    const float length = (to - from).length();
    const Vec3 towards = (to - from) / length;
    const auto near = caster_.intersect({from, towards, length});
    const auto far = caster_.intersect({to, -towards, length});
    if (!near || !far) return {};
    PatchSplit plane;
    plane.normal = geometric_normal(scene_.geometry.corners(near->triangle));
    const Vec3 in = from + towards * near->distance, out = to - towards * far->distance;
    plane.offset = plane.normal.dot(Vec3(Vec3d(in) - centre) + Vec3(Vec3d(out) - centre)) / 2;
    const float thickness = std::abs(plane.normal.dot(out - in));
    if (thickness < kSheet * float(grid_.cell_size) && is_of(grid_, facing, plane.normal)) return {};
    return plane;
}

}  // namespace pim
