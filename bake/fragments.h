// SPDX-License-Identifier: GPL-3.0-or-later
// The scene's surface cut into fragments: fine cell × triangle × side.
#pragma once

#include <vector>

#include "common/map/cell_grid.h"

namespace pim {

struct FragmentKey {
    uint64_t cell;  // linear number in the grid, x slowest
    uint32_t triangle;
    uint8_t place;  // fine cell within the cell · 2 + side

    auto operator<=>(const FragmentKey&) const = default;
};

struct Fragment {
    FragmentKey key;
    float area;                                     // m², exact but for rounding
    Vec3 centre;                                    // centroid, local, m
    std::array<float, kFacingCount> facing_area{};  // its share per facing, by the shading normals
    Box3 box;                                       // local, m
};

Vec3 plane_normal(const Geometry& geometry, const Fragment& fragment);      // unit, of its side
Vec3 normal_at_centre(const Geometry& geometry, const Fragment& fragment);  // shading normal, of its side

FragmentKey fragment_key(const CellGrid& grid, uint32_t triangle, Side side, const Index3& fine);
Index3 cell_of(const CellGrid& grid, const FragmentKey& key);

// Where those of each cell begin, and where the last ends: sorted, they stand together.
std::vector<std::size_t> begins_of_cells(const std::vector<Fragment>& fragments);

// A plane's coordinates: without the axis along which projection loses most of it.
struct PlaneAxes {
    int axis, u, v;
    explicit PlaneAxes(const Vec3& normal);
};

// A place in a fragment's box, 16 bits per axis: so fine that walls beside it stay on their side.
uint64_t pack_place(const Fragment& fragment, const Vec3& position);
Vec3 unpack_place(const Fragment& fragment, uint64_t packed);
inline constexpr int kQuarters = 4;
int quarter_of(uint64_t packed, const PlaneAxes& to);  // of the box

// Memory that cutting needs, about, and what this machine has; bytes.
double fragment_bytes(const Scene& scene, const CellGrid& grid);
double memory_there();

// All fragments of surfaces that hold irradiance, sorted by key. Surfaces beyond the grid are left out.
// Throws Error if they would not fit into this machine's memory.
std::vector<Fragment> cut_into_fragments(const Scene& scene, const SurfaceCells& cells);

}  // namespace pim
