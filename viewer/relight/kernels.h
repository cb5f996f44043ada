// SPDX-License-Identifier: GPL-3.0-or-later
// The inner loops of a frame, sixteen lanes at a time, compiled for several vector units; the widest that the
// processor has is chosen at run time. Arrays come in blocks of kLanes floats, 64-byte aligned.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace pim {

inline constexpr int kLanes = 16;

enum class VectorUnit { plain, avx2, avx512 };
const char* name(VectorUnit unit);
bool is_supported(VectorUnit unit);
VectorUnit best_vector_unit();
std::optional<VectorUnit> find_vector_unit(const std::string& name);

// One patch that takes part in the look-up of a group of points, see look_up() in common/map/irradiance.h.
// Lengths in cells, places relative to the lowest of the eight cells' centres.
struct StencilEntry {
    float step[3];    // 0 or 1: which of the eight cells
    float centre[3];  // of the patch's area
    float area;
    int axis;          // of the facing; -1: the map has no facings
    bool ends_facing;  // the last entry of its facing
    bool is_paired;    // this entry and the next are the layers of one cell and facing
    int bit = 0;       // its own in the points' rows of what they do not see
};

inline constexpr int kMostEntries = 48;  // of a stencil: 8 cells, 3 facings, 2 layers

using Weight = uint16_t;
inline constexpr float kWeightSteps = 65535;

// A block of kLanes points: [0..2] place in the stencil, cells; [3..5] unit shading normal; [6..8] bits of
// the entries that they do not see, by the axis of the facing, as whole numbers.
inline constexpr int kPlaceRows = 9;
inline constexpr float kUnseenWeight = 4e-3f;  // of those, as kUnseenFactor
// A block of kLanes surfaces for shadow rays: position, shading normal, geometric normal.
inline constexpr int kSurfaceRows = 9;

// What a shadow ray packet takes: see RayCaster::Rays.
struct ShadowRays {
    float* origin[3];
    float* direction[3];  // to the lamp, not unit: length 1 ends at the lamp
    float* term;          // cos θ / d² at the surface; 0: no ray needed
};

// A triangle as hits need it: kTriangleRow floats, edges and normals as differences from the first corner.
// Flat triangles have the geometric normal for a shading normal, and no bend.
struct TriangleRow {
    float corner[3], edge1[3], edge2[3], geometric_normal[3], normal[3], bend1[3], bend2[3];
    uint32_t material;
    float unused[2];
};
inline constexpr int kTriangleRow = sizeof(TriangleRow) / sizeof(float);

// Where a packet of rays has met triangles.
struct HitLanes {
    const uint32_t* triangle;  // valid in all lanes
    const float *u, *v;
    const float* normal[3];     // of the triangle, any length
    const float* direction[3];  // of the rays, any length
};
struct GridPlacement {
    float origin[3];  // local, m
    float cells_per_metre, facing_threshold;
    int facings;
};
// Surfaces of a packet: rows of kLanes: position, shading normal, geometric normal (unit, on the side that
// the ray met), place in the stencil; and, as integers, the stencil's lowest cell, the facings' mask
// and Home's corner + 8 · (its part's lowest bit on each axis).
inline constexpr int kLocatedRows = kSurfaceRows + 3, kCellRows = 5;

struct Kernels {
    // sum[channel][lane] += power[channel] · Σ_t monomials[t] · coefficients[t][channel][lane]; with one
    // channel in the coefficients it stands for all three.
    void (*evaluate)(const float* coefficients, int terms, int channels, const float* monomials,
                     const float* power, float* sum);
    // See kLocatedRows. A bit of the mask for each facing that facing_weights() gives a weight to.
    void (*locate)(const TriangleRow* triangles, const HitLanes& hits, const GridPlacement& grid, float* rows,
                   int32_t* cells);
    // weights[entry][lane] of one block of points; they add to 1, or are all 0.
    void (*weigh)(const StencilEntry* entries, int count, float facing_threshold, const float* places,
                  float* weights);
    // Weights from 0 to 1 as kept for each point seen: in steps of 1 / kWeightSteps, what rounding leaves
    // goes on to the next entry, so that sums of 1 stay 1. Weights
    // of 0 stay 0.
    void (*pack)(const float* weights, int entries, Weight* packed);
    // sum[channel][lane] = Σ_e weights[e][lane] · values[e][channel].
    void (*gather)(const Weight* weights, const float* values, int entries, float* sum);
    // Rays from a block of surfaces to targets[axis][lane], started `offset` off the surface. `lamp_normal`:
    // of a one-sided rectangle, whose cosine enters the term; null for a point lamp.
    void (*aim)(const float* surfaces, const float* targets, const float* lamp_normal, float offset,
                const ShadowRays& rays);
    // rgba[lane] of one block of linear colours [channel][lane]: times exposure, tone curve (as ToneCurve),
    // sRGB, 8 bits.
    void (*encode)(const float* linear, float exposure, int curve, uint32_t* rgba);
};
const Kernels& kernels(VectorUnit unit);

}  // namespace pim
