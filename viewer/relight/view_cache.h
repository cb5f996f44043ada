// SPDX-License-Identifier: GPL-3.0-or-later
// What a resting camera sees, kept: for each pixel the surface points that make its colour, and for each
// point which patches of the map make its irradiance (section 3.3.2 of the thesis keeps the hits; we keep the
// weights too). Points of a tile that look up the same patches stand together, in blocks of kLanes.
#pragma once

#include "common/map/illumination_map.h"
#include "common/render/camera_rays.h"
#include "common/scene/scene.h"
#include "viewer/relight/aligned.h"
#include "viewer/relight/kernels.h"

namespace pim {

inline constexpr int kTileSize = 32;
inline constexpr uint16_t kNoPixel = 0xffff;

// Points that share a stencil: blocks [first_block, first_block + blocks).
struct PointGroup {
    uint32_t first_patch, patches;  // in ViewTile::patches
    uint32_t first_block, blocks;
    uint32_t first_weight;               // in ViewTile::weights: [block][patch][lane]
    Rgb factor;                          // radiance per irradiance, or 1: of all points, if
    uint32_t first_factor = kOneFactor;  // does not say where in ViewTile::factors theirs begin

    static constexpr uint32_t kOneFactor = ~0u;
};

// A stretch of a ray that meets nothing before `until`: for lamps that are seen.
struct Segment {
    Ray ray;
    float until;
    Rgb throughput;
    uint16_t pixel;
    bool primary;
};

struct ViewTile {
    int x = 0, y = 0, width = 0, height = 0;  // pixels
    bool one_point_per_pixel = true;
    std::vector<PointGroup> groups;
    std::vector<uint32_t> patches;
    AlignedVector<Weight> weights;
    AlignedVector<float> factors;   // [block][channel][lane], of groups whose points differ
    AlignedVector<float> surfaces;  // [block][row of kSurfaceRows][lane], if asked for
    std::vector<uint16_t> pixels;   // [block][lane]: y · kTileSize + x in the tile; kNoPixel: padding
    std::vector<Segment> segments;  // if asked for

    std::size_t block_count() const { return pixels.size() / kLanes; }
    std::size_t bytes() const;
};

struct ViewOptions {
    bool radiance = true;  // false: the irradiance of the first surface, whatever it is made of
    bool surfaces = false;
    bool segments = false;
    bool operator==(const ViewOptions&) const = default;
};

class ViewBuilder {
  public:
    // All arguments outlive it.
    ViewBuilder(const Scene& scene, const RayCaster& caster, const IlluminationMap& map,
                const Kernels& kernels);
    // Fills a tile whose place is set; rays go through (x, y) + offset, offset in [0,1)². Thread-safe.
    void build(const CameraRays& rays, const Vec2& offset, const ViewOptions& options, ViewTile& tile) const;

  private:
    friend class TileBuilder;
    const Scene& scene_;
    const RayCaster& caster_;
    const IlluminationMap& map_;
    const Kernels& kernels_;
    std::vector<TriangleRow> triangles_;
    // Per material: radiance per irradiance, where it has neither texture, mirror nor glass.
    std::vector<std::optional<Rgb>> plain_;
    GridPlacement grid_;
    uint64_t generation_;
};

// The tiles of a picture, rows first.
std::vector<ViewTile> make_tiles(const Imath::V2i& size);

}  // namespace pim
