// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/relight/view_cache.h"

#include <atomic>
#include <cmath>
#include <unordered_map>

#include "common/core/float_traps.h"
#include "common/map/irradiance.h"
#include "common/render/specular_walk.h"
#include "viewer/relight/stencil.h"

namespace pim {
namespace {

struct Point {
    uint32_t slot;  // in Scratch::rows: block · kLanes + lane
    uint32_t group;
    Rgb factor;
    uint16_t pixel;
    UnseenByAxis unseen;
};

// What a thread keeps from tile to tile.
struct Scratch {
    uint64_t generation = 0;
    std::unordered_map<uint64_t, Stencil> stencils;
    uint32_t tile = 0;
    std::vector<Point> points;
    AlignedVector<float> rows;             // [block][row of kLocatedRows][lane]
    uint32_t blocks = 0, spare_lanes = 0;  // of rows; lanes left in a block of single points
    uint32_t spare_block = 0;
    std::vector<const Stencil*> groups;
    std::vector<uint32_t> counts, next;
    std::vector<Rgb> factors;    // of a group's first point
    std::vector<uint8_t> mixed;  // do its points differ in that?
    AlignedVector<float> places;
};

constexpr std::size_t kMostStencils = 1 << 17;

}  // namespace

std::size_t ViewTile::bytes() const {
    return weights.size() * sizeof(Weight) + (factors.size() + surfaces.size() + patches.size()) * 4 +
           pixels.size() * 2 + groups.size() * sizeof(PointGroup) + segments.size() * sizeof(Segment);
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
        scratch.factors.clear();
        scratch.mixed.clear();
        scratch.blocks = scratch.spare_lanes = 0;
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
    void diffuse(const SurfacePoint& s, const Rgb& throughput) { add_point(s, throughput * s.diffuse / kPi); }

  private:
    void trace(int x0, int y0, const Vec2& offset) {
        HitPacket packet;
        float x_of[kLanes], y_of[kLanes];
        for (int lane = 0; lane < kLanes; ++lane) {
            const int x = x0 + lane % 4, y = y0 + lane / 4;
            x_of[lane] = float(tile_.x + x) + offset.x, y_of[lane] = float(tile_.y + y) + offset.y;
            const bool inside = x < tile_.width && y < tile_.height;
            packet.rays.length[lane] = inside ? std::numeric_limits<float>::infinity() : -1.0f;
        }
        for (int axis = 0; axis < 3; ++axis) std::fill_n(packet.rays.origin[axis], kLanes, rays_.eye()[axis]);
        rays_.directions(x_of, y_of, kLanes, packet.rays.direction);
        view_.caster_.intersect(packet);
        const uint32_t block = add_block();
        alignas(64) int32_t cells[kCellRows * kLanes];
        locate(packet, block, cells);
        for (int lane = 0; lane < kLanes; ++lane) {
            const int x = x0 + lane % 4, y = y0 + lane / 4;
            if (x >= tile_.width || y >= tile_.height) continue;
            pixel_ = uint16_t(y * kTileSize + x);
            if (options_.segments) add_primary_segment(packet, lane);
            if (!packet.is_hit(lane)) continue;
            const Rgb factor = primary_factor(packet, lane);
            if (is_black(factor)) continue;
            const Index3 low(cells[lane], cells[kLanes + lane], cells[2 * kLanes + lane]);
            add_point(block * kLanes + uint32_t(lane), low, cells[3 * kLanes + lane],
                      cells[4 * kLanes + lane], factor);
        }
    }

    uint32_t add_block() {
        scratch_.rows.resize(std::size_t(++scratch_.blocks) * kLocatedRows * kLanes);
        return scratch_.blocks - 1;
    }

    void locate(const HitPacket& packet, uint32_t block, int32_t* cells) {
        alignas(64) uint32_t triangle[kLanes];
        for (int lane = 0; lane < kLanes; ++lane)
            triangle[lane] = packet.is_hit(lane) ? packet.triangle[lane] : 0;
        const HitLanes hits{triangle,
                            packet.u,
                            packet.v,
                            {packet.normal[0], packet.normal[1], packet.normal[2]},
                            {packet.rays.direction[0], packet.rays.direction[1], packet.rays.direction[2]}};
        const FloatTraps lanes_without_a_hit(FloatTraps::off);
        view_.kernels_.locate(view_.triangles_.data(), hits, view_.grid_,
                              &scratch_.rows[std::size_t(block) * kLocatedRows * kLanes], cells);
    }

    // Radiance per irradiance of the surface that the eye sees; beyond mirrors and glass goes the walk.
    Rgb primary_factor(const HitPacket& packet, int lane) {
        if (!options_.radiance) return Rgb(1);
        const uint32_t number = view_.triangles_[packet.triangle[lane]].material;
        if (view_.plain_[number]) return *view_.plain_[number];
        const Material& material = view_.scene_.materials[number];
        const Hit hit = *packet.hit(lane);
        if (!material.glass && is_black(material.specular))
            return reflectance(view_.scene_, hit.triangle, hit.b1, hit.b2).diffuse / kPi;
        const SurfacePoint surface = surface_at(view_.scene_, hit);
        SpecularWalk<TileBuilder>(view_.scene_, view_.caster_, *this)
            .leave(surface, direction_of(packet, lane).normalized(), Rgb(1));
        return surface.diffuse / kPi;
    }

    static Vec3 direction_of(const HitPacket& packet, int lane) {
        return {packet.rays.direction[0][lane], packet.rays.direction[1][lane],
                packet.rays.direction[2][lane]};
    }

    void add_primary_segment(const HitPacket& packet, int lane) {
        const Vec3 direction = direction_of(packet, lane);
        const float length = direction.length();
        tile_.segments.push_back(
            {{rays_.eye(), direction / length},
             packet.is_hit(lane) ? packet.rays.length[lane] * length : std::numeric_limits<float>::infinity(),
             Rgb(1),
             pixel_,
             true});
    }

    // A single point beyond a mirror.
    void add_point(const SurfacePoint& s, const Rgb& factor) {
        if (scratch_.spare_lanes == 0) {
            scratch_.spare_block = add_block();
            scratch_.spare_lanes = kLanes;
        }
        const uint32_t lane = kLanes - scratch_.spare_lanes--;
        float* row = &scratch_.rows[std::size_t(scratch_.spare_block) * kLocatedRows * kLanes + lane];
        Index3 low;
        for (int axis = 0; axis < 3; ++axis) {
            const float place =
                (s.position[axis] - view_.grid_.origin[axis]) * view_.grid_.cells_per_metre - 0.5f;
            low[axis] = int(std::floor(place));
            row[axis * kLanes] = s.position[axis];
            row[(3 + axis) * kLanes] = s.shading_normal[axis];
            row[(6 + axis) * kLanes] = s.geometric_normal[axis];
            row[(9 + axis) * kLanes] = place - float(low[axis]);
        }
        const FacingWeights facing = facing_weights(view_.map_.grid, s.shading_normal);
        int mask = 0;
        for (int k = 0; k < kFacingCount; ++k) mask |= int(facing.weight[k] > 0) << k;
        const Vec3 place(row[9 * kLanes], row[10 * kLanes], row[11 * kLanes]);
        const Home home = home_of(place, s.shading_normal);
        const int odd = (home.part & 1) | (home.part >> 1 & 2) | (home.part >> 2 & 4);
        add_point(scratch_.spare_block * kLanes + lane, low, mask, home.corner | odd << 3, factor);
    }

    void add_point(uint32_t slot, const Index3& low, int mask, int home, const Rgb& factor) {
        const Index3& size = view_.map_.grid.size;
        const bool outside =
            low.x < -1 || low.y < -1 || low.z < -1 || low.x >= size.x || low.y >= size.y || low.z >= size.z;
        const float* row = &scratch_.rows[std::size_t(slot / kLanes) * kLocatedRows * kLanes + slot % kLanes];
        Stencil& stencil = outside ? stencil_of(Index3(-1), 0) : stencil_of(low, mask);
        const UnseenByAxis* known = stencil.known_unseen(home);
        const UnseenByAxis unseen = known ? *known : unseen_at(stencil, home, row);
        const uint32_t group = group_of(stencil);
        if (scratch_.counts[group]++ == 0)
            scratch_.factors[group] = factor;
        else if (factor != scratch_.factors[group])
            scratch_.mixed[group] = true;
        scratch_.points.push_back({slot, group, factor, pixel_, unseen});
    }

    UnseenByAxis unseen_at(Stencil& stencil, int home, const float* row) {
        const Vec3 normal(row[3 * kLanes], row[4 * kLanes], row[5 * kLanes]),
            place(row[9 * kLanes], row[10 * kLanes], row[11 * kLanes]);
        return stencil.unseen_at(view_.map_, home, place, normal);
    }

    Stencil& stencil_of(const Index3& low, int mask) {
        const uint64_t key = uint64_t(low.x + 2) | uint64_t(low.y + 2) << 16 | uint64_t(low.z + 2) << 32 |
                             uint64_t(mask) << 48;
        if (key == last_key_) return *last_stencil_;
        last_key_ = key;
        Recent& recent = recent_[(key * 0x9e3779b97f4a7c15ull) >> 56];
        if (recent.key == key) return *(last_stencil_ = recent.stencil);
        const auto [found, is_new] = scratch_.stencils.try_emplace(key);
        if (is_new) found->second = Stencil(view_.map_, low, mask);
        recent = {key, &found->second};
        return *(last_stencil_ = recent.stencil);
    }

    uint32_t group_of(Stencil& stencil) {
        if (stencil.tile != scratch_.tile) {
            stencil.tile = scratch_.tile;
            stencil.group = uint32_t(scratch_.groups.size());
            scratch_.groups.push_back(&stencil);
            scratch_.counts.push_back(0);
            scratch_.factors.emplace_back(0.0f);
            scratch_.mixed.push_back(false);
        }
        return stencil.group;
    }

    // From points in order of pixels to blocks in order of groups.
    void lay_out() {
        std::size_t blocks = 0, weights = 0, patches = 0, factors = 0;
        scratch_.next.clear();
        tile_.groups.clear();
        tile_.patches.clear();
        for (std::size_t g = 0; g < scratch_.groups.size(); ++g) {
            const auto entries = uint32_t(scratch_.groups[g]->entries().size());
            const uint32_t own = (scratch_.counts[g] + kLanes - 1) / kLanes;
            tile_.groups.push_back({uint32_t(patches), entries, uint32_t(blocks), own, uint32_t(weights),
                                    scratch_.factors[g],
                                    scratch_.mixed[g] ? uint32_t(factors) : PointGroup::kOneFactor});
            if (scratch_.mixed[g]) factors += std::size_t(own) * 3 * kLanes;
            tile_.patches.insert(tile_.patches.end(), scratch_.groups[g]->patches().begin(),
                                 scratch_.groups[g]->patches().end());
            scratch_.next.push_back(uint32_t(blocks * kLanes));
            patches += entries;
            blocks += own;
            weights += std::size_t(own) * entries * kLanes;
        }
        reshape(scratch_.places, blocks * kPlaceRows * kLanes);
        tile_.pixels.assign(blocks * kLanes, kNoPixel);
        reshape(tile_.factors, factors);
        reshape(tile_.surfaces, options_.surfaces ? blocks * kSurfaceRows * kLanes : 0);
        reshape(tile_.weights, weights);
        for (const PointGroup& g : tile_.groups) clear_last_block(g);
        fill_blocks();
        weigh();
    }

    // Where those of a block's points stand; null: they are the group's.
    float* factors_of(const PointGroup& group, std::size_t block) {
        if (group.first_factor == PointGroup::kOneFactor) return nullptr;
        return &tile_.factors[group.first_factor + (block - group.first_block) * 3 * kLanes];
    }

    // Lanes behind the last point are black.
    void clear_last_block(const PointGroup& group) {
        const std::size_t block = group.first_block + group.blocks - 1;
        std::fill_n(&scratch_.places[block * kPlaceRows * kLanes], kPlaceRows * kLanes, 0.0f);
        if (float* factors = factors_of(group, block)) std::fill_n(factors, 3 * kLanes, 0.0f);
        if (options_.surfaces)
            std::fill_n(&tile_.surfaces[block * kSurfaceRows * kLanes], kSurfaceRows * kLanes, 0.0f);
    }

    void fill_blocks() {
        uint16_t last = kNoPixel;
        tile_.one_point_per_pixel = !options_.segments;
        for (const Point& p : scratch_.points) {
            tile_.one_point_per_pixel = tile_.one_point_per_pixel && p.pixel != last;
            last = p.pixel;
            const uint32_t slot = scratch_.next[p.group]++, block = slot / kLanes, lane = slot % kLanes;
            tile_.pixels[slot] = p.pixel;
            const float* from =
                &scratch_.rows[std::size_t(p.slot / kLanes) * kLocatedRows * kLanes + p.slot % kLanes];
            float* place = &scratch_.places[std::size_t(block) * kPlaceRows * kLanes + lane];
            if (float* factors = factors_of(tile_.groups[p.group], block))
                for (int c = 0; c < 3; ++c) factors[c * kLanes + lane] = p.factor[c];
            for (int c = 0; c < 3; ++c) {
                place[c * kLanes] = from[(9 + c) * kLanes];
                place[(3 + c) * kLanes] = from[(3 + c) * kLanes];
                place[(6 + c) * kLanes] = p.unseen[std::size_t(c)];
            }
            if (!options_.surfaces) continue;
            float* surface = &tile_.surfaces[std::size_t(block) * kSurfaceRows * kLanes + lane];
            for (int row = 0; row < kSurfaceRows; ++row) surface[row * kLanes] = from[row * kLanes];
        }
    }

    void weigh() {
        const FloatTraps lanes_without_a_point(FloatTraps::off);
        for (std::size_t g = 0; g < tile_.groups.size(); ++g) {
            const PointGroup& group = tile_.groups[g];
            for (uint32_t b = 0; b < group.blocks && group.patches > 0; ++b) {
                alignas(64) float weights[kMostEntries * kLanes];
                view_.kernels_.weigh(
                    scratch_.groups[g]->entries().data(), int(group.patches), kFacingThreshold,
                    &scratch_.places[std::size_t(group.first_block + b) * kPlaceRows * kLanes], weights);
                view_.kernels_.pack(
                    weights, int(group.patches),
                    &tile_.weights[group.first_weight + std::size_t(b) * group.patches * kLanes]);
            }
        }
    }

    const ViewBuilder& view_;
    const CameraRays& rays_;
    const ViewOptions& options_;
    ViewTile& tile_;
    Scratch& scratch_;
    uint16_t pixel_ = 0;
    // Stencils that this tile has met, found without the thread's large table.
    struct Recent {
        uint64_t key = ~uint64_t{0};
        Stencil* stencil = nullptr;
    };
    std::array<Recent, 256> recent_;
    uint64_t last_key_ = ~uint64_t{0};
    Stencil* last_stencil_ = nullptr;
};

ViewBuilder::ViewBuilder(const Scene& scene, const RayCaster& caster, const IlluminationMap& map,
                         const Kernels& kernels)
    : scene_(scene), caster_(caster), map_(map), kernels_(kernels) {
    static std::atomic<uint64_t> generations = 0;
    generation_ = ++generations;
    const CellGrid& grid = map.grid;
    grid_ = {{float(grid.origin.x), float(grid.origin.y), float(grid.origin.z)},
             float(1 / grid.cell_size),
             kFacingThreshold,
             grid.facings};
    for (const Material& m : scene.materials)
        plain_.push_back(!m.glass && is_black(m.specular) && !m.texture ? std::optional<Rgb>(m.diffuse / kPi)
                                                                        : std::nullopt);
    const Geometry& g = scene.geometry;
    triangles_.reserve(g.triangles.size());
    for (uint32_t t = 0; t < g.triangles.size(); ++t) {
        const auto corners = g.corners(t);
        const auto& v = g.triangles[t].vertices;
        const Vec3 flat = geometric_normal(corners), edge1 = corners[1] - corners[0],
                   edge2 = corners[2] - corners[0];
        const bool smooth = g.normals[v[0]] != Vec3(0);
        const Vec3 normal = smooth ? g.normals[v[0]] : flat;
        const Vec3 bend1 = smooth ? g.normals[v[1]] - normal : Vec3(0),
                   bend2 = smooth ? g.normals[v[2]] - normal : Vec3(0);
        TriangleRow row{};
        row.material = g.triangles[t].material;
        for (int c = 0; c < 3; ++c) {
            row.corner[c] = corners[0][c], row.edge1[c] = edge1[c], row.edge2[c] = edge2[c];
            row.geometric_normal[c] = flat[c], row.normal[c] = normal[c];
            row.bend1[c] = bend1[c], row.bend2[c] = bend2[c];
        }
        triangles_.push_back(row);
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
