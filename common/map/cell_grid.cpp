// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/map/cell_grid.h"

#include <fmt/format.h>

#include <cmath>
#include <tuple>

#include "common/core/error.h"

namespace pim {
namespace {

constexpr int kNotTied = INT32_MIN;
constexpr double kFlat = 1e-3;    // a triangle thinner than this along an axis lies flat there, in cells
constexpr double kShift = 1e-2;   // ... and is tied to the cell so far in front of it
constexpr double kBorder = 1e-4;  // places so far outside the grid still count as on its border, in cells
constexpr int kMostCells = 4096;  // per axis

bool overlaps(const Box3& a, const Box3& b) {
    for (int axis = 0; axis < 3; ++axis)
        if (a.max[axis] < b.min[axis] || b.max[axis] < a.min[axis]) return false;
    return true;
}

bool any_surface_in(const Scene& scene, const Box3& box) {
    for (uint32_t t = 0; t < scene.geometry.triangles.size(); ++t) {
        Box3 own;
        for (const Vec3& corner : scene.geometry.corners(t)) own.extendBy(corner);
        if (overlaps(own, box)) return true;
    }
    return false;
}

}  // namespace

CellGrid make_grid(const Scene& scene) {
    const Box3 box = scene.grid.bounds.value_or(bounds(scene.geometry));
    const std::string where = scene.description_file.string();
    if (!any_surface_in(scene, box))
        throw Error(fmt::format("{}: [grid] bounds hold no surface of the scene; widen them", where));
    const Vec3d extent = Vec3d(box.max) - Vec3d(box.min);
    const double longest = std::max({extent.x, extent.y, extent.z});
    if (!(longest > 0))
        throw Error(fmt::format("{}: [grid] bounds have no extent; let max lie above min", where));
    CellGrid grid;
    grid.origin = Vec3d(box.min);
    grid.facings = scene.grid.facings;
    const auto* count = std::get_if<CellCount>(&scene.grid.resolution);
    grid.cell_size = count ? longest / count->longest : std::get<CellSize>(scene.grid.resolution).metres;
    for (int axis = 0; axis < 3; ++axis) {
        const double cells = std::max(1.0, std::ceil(extent[axis] / grid.cell_size - 1e-4));
        if (cells > kMostCells)
            throw Error(
                fmt::format("{}: [grid] gives {:.0f} cells along {}, more than {}; make cells larger or set "
                            "bounds",
                            where, cells, "xyz"[axis], kMostCells));
        grid.size[axis] = int(cells);
    }
    return grid;
}

std::string slot_name(const CellGrid& grid, int slot) {
    static constexpr const char* kNames[kFacingCount] = {"px", "nx", "py", "ny", "pz", "nz"};
    if (!grid.facings) return "all";
    return std::string(kNames[slot % kFacingCount]) + (slot < kFacingCount ? "" : "_behind");
}

FacingWeights facing_weights(const CellGrid& grid, const Vec3& n) {
    FacingWeights facing;
    if (!grid.facings) {
        facing.weight[0] = 1;
        return facing;
    }
    float sum = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const float w = std::max(0.0f, n[axis] * n[axis] - kFacingThreshold);
        facing.weight[2 * axis + (n[axis] < 0)] = w;
        sum += w;
    }
    for (float& w : facing.weight) w /= sum;
    return facing;
}

SurfaceCells::SurfaceCells(const CellGrid& grid, const Geometry& geometry) : grid_(grid) {
    ties_.resize(geometry.triangles.size());
    for (uint32_t t = 0; t < ties_.size(); ++t) {
        const auto corners = geometry.corners(t);
        const Vec3 front = geometric_normal(corners);
        Box3 box;
        for (const Vec3& corner : corners) box.extendBy(corner);
        for (int axis = 0; axis < 3; ++axis)
            for (int side = 0; side < 2; ++side) {
                int32_t& tie = ties_[t][3 * side + axis];
                tie = kNotTied;
                if (box.size()[axis] > kFlat * grid.cell_size) continue;
                const double towards = (front[axis] > 0) == (side == 0) ? 1 : -1;
                const double middle = 0.5 * (double(box.min[axis]) + double(box.max[axis]));
                const auto on_border = fine_index(middle, axis);
                const auto shifted = fine_index(middle + towards * kShift * grid.cell_size, axis);
                if (on_border)
                    tie = shifted.value_or(*on_border);
                else
                    tie = -1;
            }
    }
}

std::optional<int> SurfaceCells::fine_index(double coordinate, int axis) const {
    const double in_cells = (coordinate - grid_.origin[axis]) / grid_.cell_size;
    if (in_cells < -kBorder || in_cells > grid_.size[axis] + kBorder) return std::nullopt;
    return std::clamp(int(std::floor(in_cells * kFinePerCell)), 0, grid_.size[axis] * kFinePerCell - 1);
}

std::optional<int> SurfaceCells::tied(uint32_t triangle, Side side, int axis) const {
    const int32_t tie = ties_[triangle][3 * int(side) + axis];
    return tie == kNotTied ? std::nullopt : std::optional<int>(tie);
}

std::optional<Index3> SurfaceCells::fine_cell(uint32_t triangle, Side side, const Vec3& position) const {
    Index3 fine;
    for (int axis = 0; axis < 3; ++axis) {
        const int32_t tie = ties_[triangle][3 * int(side) + axis];
        const auto index = tie == kNotTied ? fine_index(position[axis], axis) : std::optional<int>(tie);
        if (!index || *index < 0) return std::nullopt;
        fine[axis] = *index;
    }
    return fine;
}

bool cell_before(const Index3& a, const Index3& b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
}

bool patch_before(const Patch& a, const Patch& b) {
    return std::tie(a.cell.x, a.cell.y, a.cell.z, a.slot) < std::tie(b.cell.x, b.cell.y, b.cell.z, b.slot);
}

PatchIndex::PatchIndex(const CellGrid& grid, const std::vector<Patch>& patches) : size_(grid.size) {
    for (int axis = 0; axis < 3; ++axis) bricks_[axis] = (size_[axis] + kBrick - 1) / kBrick;
    brick_start_.assign(std::size_t(bricks_.x) * bricks_.y * bricks_.z, -1);
    for (std::size_t p = 0; p < patches.size(); ++p) {
        const Index3& c = patches[p].cell;
        int32_t& start =
            brick_start_[(std::size_t(c.x / kBrick) * bricks_.y + c.y / kBrick) * bricks_.z + c.z / kBrick];
        if (start < 0) {
            start = int32_t(cell_number_.size());
            cell_number_.resize(cell_number_.size() + kBrick * kBrick * kBrick, -1);
        }
        int32_t& number =
            cell_number_[start + (c.x % kBrick * kBrick + c.y % kBrick) * kBrick + c.z % kBrick];
        if (number < 0) {
            number = int32_t(cells_.size());
            cells_.emplace_back().fill(-1);
        }
        cells_[number][patches[p].slot] = int32_t(p);
    }
}

const std::array<int32_t, kSlotCount>* PatchIndex::find_cell(const Index3& c) const {
    if (c.x < 0 || c.y < 0 || c.z < 0 || c.x >= size_.x || c.y >= size_.y || c.z >= size_.z) return nullptr;
    const int32_t start =
        brick_start_[(std::size_t(c.x / kBrick) * bricks_.y + c.y / kBrick) * bricks_.z + c.z / kBrick];
    if (start < 0) return nullptr;
    const int32_t number =
        cell_number_[start + (c.x % kBrick * kBrick + c.y % kBrick) * kBrick + c.z % kBrick];
    return number < 0 ? nullptr : &cells_[number];
}

}  // namespace pim
