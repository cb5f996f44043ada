// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/relight/view_cache.h"

#include <atomic>
#include <cmath>
#include <unordered_map>

#include "common/render/specular_walk.h"

namespace pim {
namespace {

// The patches around eight cell centres that surfaces of some facings look up.
struct Stencil {
    std::vector<StencilEntry> entries;
    std::vector<uint32_t> patches;
    uint32_t tile = 0, group = 0;  // the group that stands for it in a tile
};

int facing_mask(const FacingWeights& facing) {
    int mask = 0;
    for (int k = 0; k < kFacingCount; ++k) mask |= int(facing.weight[k] > 0) << k;
    return mask;
}

class StencilMaker {
  public:
    StencilMaker(const IlluminationMap& map, const Index3& low) : map_(map), low_(low) {}

    Stencil make(int mask) {
        for (int k = 0; k < kFacingCount; ++k) {
            if (!(mask >> k & 1)) continue;
            const std::size_t before = stencil_.entries.size();
            for (int corner = 0; corner < 8; ++corner) add_cell(corner, k);
            if (stencil_.entries.size() > before) stencil_.entries.back().ends_facing = true;
        }
        return std::move(stencil_);
    }

  private:
    void add_cell(int corner, int facing) {
        const Index3 step(corner & 1, corner >> 1 & 1, corner >> 2);
        const auto* patches = map_.index.find_cell(low_ + step);
        if (!patches) return;
        const int front = (*patches)[facing], behind = (*patches)[facing + kFacingCount];
        if (front >= 0) add(front, step, facing, behind >= 0);
        if (behind >= 0) add(behind, step, facing, false);
    }
    void add(int patch, const Index3& step, int facing, bool is_paired) {
        const Patch& p = map_.patches[std::size_t(patch)];
        const Vec3 centre = p.centre / float(map_.grid.cell_size) + Vec3(step);
        stencil_.entries.push_back({{float(step.x), float(step.y), float(step.z)},
                                    {centre.x, centre.y, centre.z},
                                    p.area,
                                    map_.grid.facings ? facing / 2 : -1,
                                    false,
                                    is_paired});
        stencil_.patches.push_back(uint32_t(patch));
    }

    const IlluminationMap& map_;
    Index3 low_;
    Stencil stencil_;
};

struct Point {
    Vec3 position, shading_normal, geometric_normal;
    Vec3 place;  // in the stencil, cells
    Rgb factor;
    uint32_t group;
    uint16_t pixel;
};

// What a thread keeps from tile to tile.
struct Scratch {
    uint64_t generation = 0;
    std::unordered_map<uint64_t, Stencil> stencils;
    uint32_t tile = 0;
    std::vector<Point> points;
    std::vector<const Stencil*> groups;
    std::vector<uint32_t> counts, next;
    AlignedVector<float> places;
};

constexpr std::size_t kMostStencils = 1 << 17;

}  // namespace

std::size_t ViewTile::bytes() const {
    return (weights.size() + factors.size() + surfaces.size() + patches.size()) * 4 + pixels.size() * 2 +
           groups.size() * sizeof(PointGroup) + segments.size() * sizeof(Segment);
}

class TileBuilder {
  public:
    TileBuilder(const ViewBuilder& view, const CameraRays& rays, const ViewOptions& options, ViewTile& tile,
                Scratch& scratch)
        : view_(view), rays_(rays), options_(options), tile_(tile), scratch_(scratch) {
        if (scratch.generation != view.generation_ || scratch.stencils.size() > kMostStencils) {
            scratch.stencils.clear();
            scratch.generation = view.generation_;
            scratch.tile = 0;
        }
        ++scratch.tile;
        scratch.points.clear();
        scratch.groups.clear();
        scratch.counts.clear();
        tile.segments.clear();
    }

    void build(const Vec2& offset) {
        for (int y = 0; y < tile_.height; y += 4)
            for (int x = 0; x < tile_.width; x += 4) trace(x, y, offset);
        lay_out();
    }

    // Visitor of SpecularWalk, beyond the first surface.
    bool segment(const Ray& ray, float until, const Rgb& throughput) {
        if (options_.segments) tile_.segments.push_back({ray, until, throughput, pixel_, false});
        return false;
    }
    void diffuse(const SurfacePoint& s, const Rgb& throughput) {
        add_point(s.position, s.shading_normal, s.geometric_normal, throughput * s.diffuse / kPi);
    }

  private:
    void trace(int x0, int y0, const Vec2& offset) {
        HitPacket packet;
        for (int lane = 0; lane < RayPacket::kSize; ++lane) {
            const int x = x0 + lane % 4, y = y0 + lane / 4;
            if (x >= tile_.width || y >= tile_.height) continue;
            const Vec3 direction =
                rays_.direction(float(tile_.x + x) + offset.x, float(tile_.y + y) + offset.y);
            packet.rays.set(lane, rays_.eye(), direction, std::numeric_limits<float>::infinity());
        }
        view_.caster_.intersect(packet);
        for (int lane = 0; lane < RayPacket::kSize; ++lane) {
            const int x = x0 + lane % 4, y = y0 + lane / 4;
            if (x >= tile_.width || y >= tile_.height) continue;
            pixel_ = uint16_t(y * kTileSize + x);
            const Vec3 direction(packet.rays.direction[0][lane], packet.rays.direction[1][lane],
                                 packet.rays.direction[2][lane]);
            add_pixel(packet.hit(lane), direction);
        }
    }

    void add_pixel(const std::optional<Hit>& hit, const Vec3& direction) {
        if (options_.segments) add_primary_segment(hit, direction);
        if (!hit) return;
        const auto& t = view_.triangles_[hit->triangle];
        const Material& material = view_.scene_.materials[t.material];
        const Vec3 position = t.corner + t.edge1 * hit->b1 + t.edge2 * hit->b2;
        const Vec3 geometric = hit->side == Side::front ? t.normal : -t.normal;
        const Vec3 normal =
            t.smooth ? shading_normal(view_.scene_.geometry, hit->triangle, hit->side, hit->b1, hit->b2)
                     : geometric;
        if (!options_.radiance) {
            add_point(position, normal, geometric, Rgb(1));
            return;
        }
        if (material.glass || !is_black(material.specular)) {
            const SurfacePoint surface = surface_at(view_.scene_, *hit);
            if (!is_black(surface.diffuse)) diffuse(surface, Rgb(1));
            SpecularWalk<TileBuilder>(view_.scene_, view_.caster_, *this)
                .leave(surface, direction.normalized(), Rgb(1));
            return;
        }
        const Rgb albedo = material.texture
                               ? reflectance(view_.scene_, hit->triangle, hit->b1, hit->b2).diffuse
                               : material.diffuse;
        if (!is_black(albedo)) add_point(position, normal, geometric, albedo / kPi);
    }

    void add_primary_segment(const std::optional<Hit>& hit, const Vec3& direction) {
        const float length = direction.length();
        tile_.segments.push_back({{rays_.eye(), direction / length},
                                  hit ? hit->distance * length : std::numeric_limits<float>::infinity(),
                                  Rgb(1),
                                  pixel_,
                                  true});
    }

    void add_point(const Vec3& position, const Vec3& normal, const Vec3& geometric, const Rgb& factor) {
        const CellGrid& grid = view_.map_.grid;
        const Vec3d place = (Vec3d(position) - grid.origin) / grid.cell_size - Vec3d(0.5);
        const Index3 low(int(std::floor(place.x)), int(std::floor(place.y)), int(std::floor(place.z)));
        const bool outside = low.x < -1 || low.y < -1 || low.z < -1 || low.x >= grid.size.x ||
                             low.y >= grid.size.y || low.z >= grid.size.z;
        const uint32_t group =
            outside ? group_of(Index3(-1), 0) : group_of(low, facing_mask(facing_weights(grid, normal)));
        ++scratch_.counts[group];
        scratch_.points.push_back(
            {position, normal, geometric, Vec3(place - Vec3d(low)), factor, group, pixel_});
    }

    uint32_t group_of(const Index3& low, int mask) {
        const uint64_t key = uint64_t(low.x + 2) | uint64_t(low.y + 2) << 16 | uint64_t(low.z + 2) << 32 |
                             uint64_t(mask) << 48;
        if (key == last_key_) return last_group_;
        last_key_ = key;
        const auto [found, is_new] = scratch_.stencils.try_emplace(key);
        Stencil& stencil = found->second;
        if (is_new) stencil = StencilMaker(view_.map_, low).make(mask);
        if (stencil.tile != scratch_.tile) {
            stencil.tile = scratch_.tile;
            stencil.group = uint32_t(scratch_.groups.size());
            scratch_.groups.push_back(&stencil);
            scratch_.counts.push_back(0);
        }
        return last_group_ = stencil.group;
    }

    // From points in order of pixels to blocks in order of groups.
    void lay_out() {
        std::size_t blocks = 0, weights = 0, patches = 0;
        scratch_.next.clear();
        tile_.groups.clear();
        tile_.patches.clear();
        for (std::size_t g = 0; g < scratch_.groups.size(); ++g) {
            const auto entries = uint32_t(scratch_.groups[g]->entries.size());
            const uint32_t own = (scratch_.counts[g] + kLanes - 1) / kLanes;
            tile_.groups.push_back({uint32_t(patches), entries, uint32_t(blocks), own, uint32_t(weights)});
            tile_.patches.insert(tile_.patches.end(), scratch_.groups[g]->patches.begin(),
                                 scratch_.groups[g]->patches.end());
            scratch_.next.push_back(uint32_t(blocks * kLanes));
            patches += entries;
            blocks += own;
            weights += std::size_t(own) * entries * kLanes;
        }
        scratch_.places.assign(blocks * kPlaceRows * kLanes, 0);
        tile_.pixels.assign(blocks * kLanes, kNoPixel);
        tile_.factors.assign(blocks * 3 * kLanes, 0);
        tile_.surfaces.assign(options_.surfaces ? blocks * kSurfaceRows * kLanes : 0, 0);
        tile_.weights.resize(weights);
        fill_blocks();
        weigh();
    }

    void fill_blocks() {
        uint16_t last = kNoPixel;
        tile_.one_point_per_pixel = !options_.segments;
        for (const Point& p : scratch_.points) {
            tile_.one_point_per_pixel = tile_.one_point_per_pixel && p.pixel != last;
            last = p.pixel;
            const uint32_t slot = scratch_.next[p.group]++, block = slot / kLanes, lane = slot % kLanes;
            tile_.pixels[slot] = p.pixel;
            for (int c = 0; c < 3; ++c) {
                tile_.factors[(block * 3 + c) * kLanes + lane] = p.factor[c];
                scratch_.places[(block * kPlaceRows + c) * kLanes + lane] = p.place[c];
                scratch_.places[(block * kPlaceRows + 3 + c) * kLanes + lane] = p.shading_normal[c];
            }
            if (!options_.surfaces) continue;
            float* row = &tile_.surfaces[block * kSurfaceRows * kLanes + lane];
            for (int c = 0; c < 3; ++c) {
                row[c * kLanes] = p.position[c];
                row[(3 + c) * kLanes] = p.shading_normal[c];
                row[(6 + c) * kLanes] = p.geometric_normal[c];
            }
        }
    }

    void weigh() {
        for (std::size_t g = 0; g < tile_.groups.size(); ++g) {
            const PointGroup& group = tile_.groups[g];
            for (uint32_t b = 0; b < group.blocks && group.patches > 0; ++b)
                view_.kernels_.weigh(
                    scratch_.groups[g]->entries.data(), int(group.patches), kFacingThreshold,
                    &scratch_.places[std::size_t(group.first_block + b) * kPlaceRows * kLanes],
                    &tile_.weights[group.first_weight + std::size_t(b) * group.patches * kLanes]);
        }
    }

    const ViewBuilder& view_;
    const CameraRays& rays_;
    const ViewOptions& options_;
    ViewTile& tile_;
    Scratch& scratch_;
    uint16_t pixel_ = 0;
    uint64_t last_key_ = ~uint64_t{0};
    uint32_t last_group_ = 0;
};

ViewBuilder::ViewBuilder(const Scene& scene, const RayCaster& caster, const IlluminationMap& map,
                         const Kernels& kernels)
    : scene_(scene), caster_(caster), map_(map), kernels_(kernels) {
    static std::atomic<uint64_t> generations = 0;
    generation_ = ++generations;
    const Geometry& g = scene.geometry;
    for (uint32_t t = 0; t < g.triangles.size(); ++t) {
        const auto corners = g.corners(t);
        triangles_.push_back({corners[0], corners[1] - corners[0], corners[2] - corners[0],
                              geometric_normal(corners), g.triangles[t].material,
                              g.normals[g.triangles[t].vertices[0]] != Vec3(0)});
    }
}

void ViewBuilder::build(const CameraRays& rays, const Vec2& offset, const ViewOptions& options,
                        ViewTile& tile) const {
    thread_local Scratch scratch;
    TileBuilder(*this, rays, options, tile, scratch).build(offset);
}

std::vector<ViewTile> make_tiles(const Imath::V2i& size) {
    std::vector<ViewTile> tiles;
    for (int y = 0; y < size.y; y += kTileSize)
        for (int x = 0; x < size.x; x += kTileSize) {
            ViewTile& tile = tiles.emplace_back();
            tile.x = x, tile.y = y;
            tile.width = std::min(kTileSize, size.x - x), tile.height = std::min(kTileSize, size.y - y);
        }
    return tiles;
}

}  // namespace pim
