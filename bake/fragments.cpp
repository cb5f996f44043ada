// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/fragments.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <mutex>

#include "common/core/error.h"
#include "common/core/parallel.h"

namespace pim {
namespace {

constexpr uint64_t kPlaces = 1 << 16;  // per axis

using Polygon = std::vector<Vec3d>;

// Parts of a convex polygon below and above a plane across an axis (Sutherland and Hodgman 1974).
void split(const Polygon& polygon, int axis, double plane, Polygon& below, Polygon& above) {
    below.clear();
    above.clear();
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vec3d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
        const double da = a[axis] - plane, db = b[axis] - plane;
        if (da <= 0) below.push_back(a);
        if (da >= 0) above.push_back(a);
        if ((da < 0 && db > 0) || (da > 0 && db < 0)) {
            Vec3d cut = a + (b - a) * (da / (da - db));
            cut[axis] = plane;
            below.push_back(cut);
            above.push_back(cut);
        }
    }
}

double polygon_area(const Polygon& p) {
    Vec3d sum(0);
    for (std::size_t i = 1; i + 1 < p.size(); ++i) sum += (p[i] - p[0]).cross(p[i + 1] - p[0]);
    return 0.5 * sum.length();
}

Vec3d centroid(const Polygon& p) {
    Vec3d sum(0);
    double total = 0;
    for (std::size_t i = 1; i + 1 < p.size(); ++i) {
        const double area = (p[i] - p[0]).cross(p[i + 1] - p[0]).length();
        sum += (p[0] + p[i] + p[i + 1]) * (area / 3);
        total += area;
    }
    return total > 0 ? sum / total : p[0];
}

// Weights of the second and third corner.
Imath::V2d barycentric(const std::array<Vec3, 3>& corners, const Vec3d& place) {
    const Vec3d a(corners[0]), e1 = Vec3d(corners[1]) - a, e2 = Vec3d(corners[2]) - a, d = place - a;
    const double d11 = e1.dot(e1), d12 = e1.dot(e2), d22 = e2.dot(e2), q1 = d.dot(e1), q2 = d.dot(e2);
    const double determinant = d11 * d22 - d12 * d12;
    return {(d22 * q1 - d12 * q2) / determinant, (d11 * q2 - d12 * q1) / determinant};
}

// Shading normal at a place of a triangle.
Vec3 normal_at(const Geometry& geometry, uint32_t triangle, Side side, const Vec3d& place) {
    if (geometry.normals[geometry.triangles[triangle].vertices[0]] == Vec3(0))  // flat
        return shading_normal(geometry, triangle, side, 0, 0);
    const auto b = barycentric(geometry.corners(triangle), place);
    return shading_normal(geometry, triangle, side, float(b.x), float(b.y));
}

class Cutter {
  public:
    Cutter(const Scene& scene, const SurfaceCells& cells, uint32_t triangle, std::vector<Fragment>& out)
        : geometry_(scene.geometry), cells_(cells), grid_(cells.grid()), triangle_(triangle), out_(out) {}

    void cut() {
        const auto corners = geometry_.corners(triangle_);
        const Polygon whole{Vec3d(corners[0]), Vec3d(corners[1]), Vec3d(corners[2])};
        for (const Side side : {Side::front, Side::back}) {
            side_ = side;
            slice(whole, 0);
        }
    }

  private:
    void slice(const Polygon& polygon, int axis) {
        if (polygon.size() < 3) return;
        if (axis == 3) return finish(polygon);
        if (const auto tie = cells_.tied(triangle_, side_, axis)) {
            if (*tie < 0) return;
            fine_[axis] = *tie;
            return slice(polygon, axis + 1);
        }
        const double fine_size = grid_.cell_size / kFinePerCell, start = grid_.origin[axis];
        const int last = grid_.size[axis] * kFinePerCell - 1;
        double low = polygon[0][axis], high = low;
        for (const Vec3d& p : polygon) low = std::min(low, p[axis]), high = std::max(high, p[axis]);
        int first = int(std::floor((low - start) / fine_size));
        Polygon rest = polygon, below, above;
        if (first < 0) {
            split(polygon, axis, start, below, rest);
            first = 0;
        }
        for (int i = first; i <= last && rest.size() >= 3; ++i) {
            const double plane = start + (i + 1) * fine_size;
            fine_[axis] = i;
            if (plane >= high) return slice(rest, axis + 1);
            split(rest, axis, plane, below, above);
            slice(below, axis + 1);
            rest = above;
        }
    }

    void finish(const Polygon& polygon) {
        const double whole = polygon_area(polygon);
        if (!(whole > 0)) return;
        Fragment fragment{
            fragment_key(grid_, triangle_, side_, fine_), float(whole), Vec3(centroid(polygon)), {}, {}};
        for (const Vec3d& p : polygon) fragment.box.extendBy(Vec3(p));
        const auto& v = geometry_.triangles[triangle_].vertices;
        if (geometry_.normals[v[0]] == Vec3(0)) {
            add_facings(fragment, normal_at(geometry_, triangle_, side_, polygon[0]), whole);
        } else {
            for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
                integrate_facings(fragment, {polygon[0], polygon[i], polygon[i + 1]});
        }
        out_.push_back(fragment);
    }

    // Three-point rule at the middles of the edges, exact for quadratics.
    void integrate_facings(Fragment& fragment, const Polygon& part) {
        const double third = polygon_area(part) / 3;
        for (int i = 0; i < 3; ++i) {
            const Vec3d middle = 0.5 * (part[i] + part[(i + 1) % 3]);
            add_facings(fragment, normal_at(geometry_, triangle_, side_, middle), third);
        }
    }

    void add_facings(Fragment& fragment, const Vec3& normal, double part) {
        const FacingWeights facing = facing_weights(grid_, normal);
        for (int f = 0; f < kFacingCount; ++f) fragment.facing_area[f] += facing.weight[f] * float(part);
    }

    const Geometry& geometry_;
    const SurfaceCells& cells_;
    const CellGrid& grid_;
    uint32_t triangle_;
    std::vector<Fragment>& out_;
    Side side_ = Side::front;
    Index3 fine_{0};
};

// Share of a triangle's box that lies in the grid.
double share_in_grid(const std::array<Vec3, 3>& corners, const CellGrid& grid) {
    Box3 box;
    for (const Vec3& corner : corners) box.extendBy(corner);
    double share = 1;
    for (int axis = 0; axis < 3; ++axis) {
        const double low = grid.origin[axis], high = low + grid.size[axis] * grid.cell_size;
        const double inside = std::min(double(box.max[axis]), high) - std::max(double(box.min[axis]), low);
        if (box.size()[axis] > 0) share *= std::clamp(inside / double(box.size()[axis]), 0.0, 1.0);
    }
    return share;
}

void check_memory(const Scene& scene, const CellGrid& grid) {
    const double needed = fragment_bytes(scene, grid), there = memory_there();
    if (needed > there)
        throw Error(fmt::format(
            "{}: [grid] cells of {:.3g} m need about {:.0f} GB of memory, this machine has {:.0f}; make "
            "cells larger or set bounds",
            scene.description_file.string(), grid.cell_size, needed / 1e9, there / 1e9));
}

}  // namespace

double memory_there() { return double(sysconf(_SC_PHYS_PAGES)) * double(sysconf(_SC_PAGESIZE)); }

double fragment_bytes(const Scene& scene, const CellGrid& grid) {
    const double fine = grid.cell_size / kFinePerCell;
    double count = 0;  // both sides; a fine cell's cut of a plane is about its face
    for (uint32_t t = 0; t < scene.geometry.triangles.size(); ++t) {
        const auto corners = scene.geometry.corners(t);
        count += 2 * share_in_grid(corners, grid) * (1 + area(corners) / (fine * fine));
    }
    return 5 * count * sizeof(Fragment);  // and what finds the unlit ones and cuts them
}

Vec3 plane_normal(const Geometry& geometry, const Fragment& fragment) {
    const Vec3 front = geometric_normal(geometry.corners(fragment.key.triangle));
    return Side(fragment.key.place % 2) == Side::front ? front : -front;
}

Vec3 normal_at_centre(const Geometry& geometry, const Fragment& fragment) {
    return normal_at(geometry, fragment.key.triangle, Side(fragment.key.place % 2), Vec3d(fragment.centre));
}

FragmentKey fragment_key(const CellGrid& grid, uint32_t triangle, Side side, const Index3& fine) {
    const Index3 cell = cell_of_fine(fine), in = fine - cell * kFinePerCell;
    const uint64_t linear = (uint64_t(cell.x) * grid.size.y + cell.y) * grid.size.z + cell.z;
    return {linear, triangle, uint8_t(((in.x * kFinePerCell + in.y) * kFinePerCell + in.z) * 2 + int(side))};
}

Index3 cell_of(const CellGrid& grid, const FragmentKey& key) {
    const uint64_t yz = uint64_t(grid.size.y) * grid.size.z;
    return {int(key.cell / yz), int(key.cell % yz / grid.size.z), int(key.cell % grid.size.z)};
}

std::vector<std::size_t> begins_of_cells(const std::vector<Fragment>& fragments) {
    std::vector<std::size_t> begins;
    for (std::size_t i = 0; i < fragments.size(); ++i)
        if (i == 0 || fragments[i].key.cell != fragments[i - 1].key.cell) begins.push_back(i);
    begins.push_back(fragments.size());
    return begins;
}

PlaneAxes::PlaneAxes(const Vec3& normal) : axis(0) {
    for (int i = 1; i < 3; ++i)
        if (std::abs(normal[i]) > std::abs(normal[axis])) axis = i;
    u = (axis + 1) % 3;
    v = (axis + 2) % 3;
}

int quarter_of(uint64_t packed, const PlaneAxes& to) {
    const auto upper = [&](int axis) { return int(packed >> (16 * axis + 15) & 1); };
    return upper(to.u) + 2 * upper(to.v);
}

uint64_t pack_place(const Fragment& fragment, const Vec3& position) {
    uint64_t packed = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const float low = fragment.box.min[axis], size = fragment.box.max[axis] - low;
        const float share = size > 0 ? std::clamp((position[axis] - low) / size, 0.0f, 1.0f) : 0;
        packed |= std::min(uint64_t(share * float(kPlaces)), kPlaces - 1) << 16 * axis;
    }
    return packed;
}

Vec3 unpack_place(const Fragment& fragment, uint64_t packed) {
    Vec3 place = fragment.box.min;
    for (int axis = 0; axis < 3; ++axis)
        place[axis] += (float(packed >> 16 * axis & (kPlaces - 1)) + 0.5f) / float(kPlaces) *
                       (fragment.box.max[axis] - fragment.box.min[axis]);
    return place;
}

std::vector<Fragment> cut_into_fragments(const Scene& scene, const SurfaceCells& cells) {
    check_memory(scene, cells.grid());
    constexpr std::size_t kBlock = 1024;
    const std::size_t count = scene.geometry.triangles.size(), blocks = (count + kBlock - 1) / kBlock;
    std::vector<std::vector<Fragment>> parts(blocks);
    parallel_for(blocks, [&](std::size_t block) {
        for (std::size_t t = block * kBlock; t < std::min(count, (block + 1) * kBlock); ++t)
            if (scene.materials[scene.geometry.triangles[t].material].receives())
                Cutter(scene, cells, uint32_t(t), parts[block]).cut();
    });
    std::vector<Fragment> all;
    for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
    std::ranges::sort(all, {}, &Fragment::key);
    // A triangle that grazes the plane between two fine cells may be cut twice into one.
    std::size_t kept = 0;
    for (std::size_t i = 1; i < all.size(); ++i) {
        if (all[i].key == all[kept].key) {
            const float share = all[i].area / (all[kept].area + all[i].area);
            all[kept].centre += (all[i].centre - all[kept].centre) * share;
            all[kept].area += all[i].area;
            all[kept].box.extendBy(all[i].box);
            for (int f = 0; f < kFacingCount; ++f) all[kept].facing_area[f] += all[i].facing_area[f];
        } else {
            all[++kept] = all[i];
        }
    }
    if (!all.empty()) all.resize(kept + 1);
    return all;
}

}  // namespace pim
