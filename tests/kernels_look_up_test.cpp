// SPDX-License-Identifier: GPL-3.0-or-later
// Each vector unit's surfaces against surface_at(), and its weights of patches against look_up() and double
// precision.
#include <array>
#include <cmath>

#include "common/map/irradiance.h"
#include "kernels_of.h"
#include "test_scenes.h"

namespace pim {
namespace {

// --- weigh ---

// Cells of a quarter of a metre, so that all places here are exact floats; patches of all sizes at random,
// a fifth of the cells empty, layers in some.
IlluminationMap random_map(bool facings, Dice& dice) {
    IlluminationMap map;
    map.grid = {Vec3d(-0.5, 0.25, 1), 0.25, Index3(5, 6, 4), facings};
    for (int x = 0; x < 5; ++x)
        for (int y = 0; y < 6; ++y)
            for (int z = 0; z < 4; ++z)
                for (int slot = 0; slot < (facings ? kSlotCount : 1); ++slot) {
                    if (!dice.chance(facings ? 0.5f : 0.8f)) continue;
                    const float area = 0.06f * std::pow(10.0f, dice.between(-3, 0));
                    map.patches.push_back(
                        {{x, y, z}, slot, area, dice.inside({Vec3(-0.125f), Vec3(0.125f)})});
                }
    map.index = PatchIndex(map.grid, map.patches);
    return map;
}

// The patches that take part at a point, as common/map/irradiance.h derives them, in double.
struct Neighbour {
    int patch, facing;
    double trilinear, area, distance;  // signed, from the tangent plane, cells
    int other = -1;                    // the other layer's place in the list
};
struct Neighbourhood {
    std::vector<Neighbour> all;
    std::array<double, kFacingCount> facing{};

    Neighbourhood(const IlluminationMap& map, const Index3& low, const Vec3d& place, const Vec3& normal) {
        for (int k = 0; k < kFacingCount; ++k) {
            const double n = normal[k / 2];
            const bool own_side = (k % 2 == 0) == (n >= 0);
            facing[std::size_t(k)] = !map.grid.facings ? k == 0
                                     : own_side        ? std::max(0.0, n * n - double(kFacingThreshold))
                                                       : 0;
        }
        for (std::size_t p = 0; p < map.patches.size(); ++p) add(map, int(p), low, place, normal);
        for (std::size_t i = 0; i < all.size(); ++i)
            for (std::size_t j = 0; j < all.size(); ++j) {
                const Patch &a = map.patches[std::size_t(all[i].patch)],
                            &b = map.patches[std::size_t(all[j].patch)];
                if (a.cell == b.cell && std::abs(a.slot - b.slot) == kFacingCount) all[i].other = int(j);
            }
    }
    void add(const IlluminationMap& map, int number, const Index3& low, const Vec3d& place,
             const Vec3& normal) {
        const Patch& p = map.patches[std::size_t(number)];
        const Index3 step = p.cell - low;
        const int k = p.slot % kFacingCount;
        if (!(facing[std::size_t(k)] > 0)) return;
        double trilinear = 1, distance = 0;
        for (int axis = 0; axis < 3; ++axis) {
            if (step[axis] < 0 || step[axis] > 1) return;
            trilinear *= step[axis] == 1 ? place[axis] : 1 - place[axis];
            const double centre = double(p.centre[axis]) / map.grid.cell_size + step[axis];
            distance += double(normal[axis]) * (centre - place[axis]);
        }
        all.push_back({number, k, trilinear, double(p.area), distance});
    }

    static double plane_factor(double distance) {
        const double t = std::clamp((0.75 - std::abs(distance)) * 2, 0.0, 1.0);
        return std::max(1e-4, t * t * (3 - 2 * t));
    }
    std::vector<double> weights() const {
        std::vector<double> w;
        std::array<double, kFacingCount> area{};
        for (const Neighbour& n : all) {
            double share = 1;
            if (n.other >= 0) {
                const double a = n.distance * n.distance + 1e-6,
                             b = std::pow(all[std::size_t(n.other)].distance, 2) + 1e-6;
                share = b / (a + b);
            }
            w.push_back(n.trilinear * n.area * plane_factor(n.distance) * share);
            area[std::size_t(n.facing)] += w.back();
        }
        double total = 0;
        for (std::size_t k = 0; k < kFacingCount; ++k)
            if (area[k] > 0) total += facing[k];
        for (std::size_t i = 0; i < all.size(); ++i) {
            const auto k = std::size_t(all[i].facing);
            w[i] = area[k] > 0 ? w[i] / area[k] * facing[k] / total : 0;
        }
        return w;
    }
    // What float arithmetic may do to the weights. Positive factors and sums bring at most 64 roundings of
    // themselves. Distances are sums that cancel: some 24 roundings of numbers up to 1.5 · √3; weights of
    // facings, of numbers up to 1. How far these move the weights is found by moving them.
    std::vector<double> tolerances() const {
        const std::vector<double> straight = weights();
        std::vector<double> sum;
        for (const double w : straight) sum.push_back(64 * kRound * w + 1e-30);
        Neighbourhood moved = *this;
        const auto add_change = [&](double& value, double step) {
            const double old = value;
            std::vector<double> most(sum.size());
            for (const double sign : {-1.0, 1.0}) {
                value = std::max(old + sign * step,
                                 &value >= moved.facing.data() && &value < moved.facing.data() + kFacingCount
                                     ? 1e-300
                                     : -1e300);
                const std::vector<double> other = moved.weights();
                for (std::size_t i = 0; i < sum.size(); ++i)
                    most[i] = std::max(most[i], std::abs(other[i] - straight[i]));
            }
            value = old;
            for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += most[i];
        };
        for (Neighbour& n : moved.all) add_change(n.distance, 24 * kRound * 2.6);
        for (double& f : moved.facing)
            if (f > 0 && all.size() > 1) add_change(f, 3 * kRound);
        return sum;
    }
};

// Sixteen points with the same lowest cell and the same facings, and the entries that they share.
struct WeighedBlock {
    Index3 low;
    std::array<Vec3d, kLanes> place;
    std::array<Vec3, kLanes> normal;
    std::vector<StencilEntry> entries;
    std::vector<int> patches;
    Floats rows = Floats(kPlaceRows * kLanes);

    WeighedBlock(const IlluminationMap& map, Dice& dice) {
        const Index3& size = map.grid.size;
        low = Index3(dice.below(size.x + 1) - 1, dice.below(size.y + 1) - 1, dice.below(size.z + 1) - 1);
        const Vec3 first = dice.chance(0.2f) ? Vec3(0, 0, dice.chance(0.5f) ? 1 : -1) : dice.direction();
        for (int lane = 0; lane < kLanes; ++lane) {
            const auto l = std::size_t(lane);
            for (int axis = 0; axis < 3; ++axis) place[l][axis] = random_place(dice);
            do {
                normal[l] = (first + dice.direction() * dice.between(0, 1)).normalized();
            } while (mask(map, normal[l]) != mask(map, first));
            for (int axis = 0; axis < 3; ++axis) {
                rows[std::size_t(axis * kLanes + lane)] = float(place[l][axis]);
                rows[std::size_t((3 + axis) * kLanes + lane)] = normal[l][axis];
            }
        }
        for (int k = 0; k < kFacingCount; ++k)
            if (mask(map, first) >> k & 1) add_facing(map, k);
    }
    // Exact in 16 bits; on the border to the next cell now and then.
    static double random_place(Dice& dice) {
        if (dice.chance(0.1f)) return 0;
        if (dice.chance(0.1f)) return 65535.0 / 65536;
        return std::floor(double(dice.between(0, 1)) * 65536) / 65536;
    }
    static int mask(const IlluminationMap& map, const Vec3& n) {
        if (!map.grid.facings) return 1;
        int bits = 0;
        for (int axis = 0; axis < 3; ++axis)
            if (n[axis] * n[axis] > kFacingThreshold) bits |= 1 << (2 * axis + (n[axis] < 0));
        return bits;
    }
    void add_facing(const IlluminationMap& map, int facing) {
        const std::size_t before = entries.size();
        for (int corner = 0; corner < 8; ++corner) {
            const Index3 step(corner & 1, corner >> 1 & 1, corner >> 2);
            const int front = map.index.find(low + step, facing),
                      behind = map.grid.facings ? map.index.find(low + step, facing + kFacingCount) : -1;
            for (const int patch : {front, behind}) {
                if (patch < 0) continue;
                const Vec3 centre = map.patches[std::size_t(patch)].centre * 4.0f + Vec3(step);
                entries.push_back({{float(step.x), float(step.y), float(step.z)},
                                   {centre.x, centre.y, centre.z},
                                   map.patches[std::size_t(patch)].area,
                                   map.grid.facings ? facing / 2 : -1,
                                   false,
                                   patch == front && behind >= 0});
                patches.push_back(patch);
            }
        }
        if (entries.size() > before) entries.back().ends_facing = true;
    }
    Floats weights(const Kernels& k) const {
        Floats w(entries.size() * kLanes);
        k.weigh(entries.data(), int(entries.size()), kFacingThreshold, rows.data(), w.data());
        return w;
    }
    Vec3 position(const IlluminationMap& map, std::size_t lane) const {
        return Vec3(map.grid.origin + (Vec3d(low) + place[lane] + Vec3d(0.5)) * map.grid.cell_size);
    }
};

class WeighOf : public KernelsOf {
  protected:
    void check(bool facings) {
        Largest error("error"), error_alone("error_without_layers"), apart("from_plain");
        int none = 0, paired = 0, checked = 0;
        for (int m = 0; m < 4; ++m) {
            const IlluminationMap map = random_map(facings, dice_);
            for (int i = 0; i < 60; ++i) {
                const WeighedBlock block(map, dice_);
                const Floats weights = block.weights(own()), reference = block.weights(plain());
                for (std::size_t lane = 0; lane < kLanes; ++lane) {
                    const Neighbourhood around(map, block.low, block.place[lane], block.normal[lane]);
                    const auto expected = around.weights(), tolerance = around.tolerances();
                    std::map<int, double> looked_up;
                    std::vector<PatchShare> shares;
                    look_up(map, block.position(map, lane), block.normal[lane], shares);
                    for (const PatchShare& s : shares) looked_up[int(s.patch)] += double(s.weight);
                    ASSERT_EQ(around.all.size(), block.patches.size());
                    bool layers = false;
                    double sum = 0;
                    for (const Neighbour& n : around.all) layers = layers || n.other >= 0;
                    for (std::size_t e = 0; e < block.patches.size(); ++e) {
                        const auto found = std::ranges::find(around.all, block.patches[e], &Neighbour::patch);
                        ASSERT_NE(found, around.all.end());
                        const auto n = std::size_t(found - around.all.begin());
                        const double w = double(weights[e * kLanes + lane]);
                        ASSERT_NEAR(w, expected[n], tolerance[n]);
                        ASSERT_NEAR(w, looked_up[block.patches[e]], 2 * tolerance[n]);
                        const double plain_weight = double(reference[e * kLanes + lane]);
                        ASSERT_NEAR(w, plain_weight, layers ? 2 * tolerance[n] : 1e-5);
                        (layers ? error : error_alone).add(w - expected[n]);
                        apart.add(w - plain_weight);
                        sum += w;
                    }
                    double whole = 0;
                    for (const double w : expected) whole += w;
                    if (whole == 0) {
                        ASSERT_EQ(sum, 0);
                    } else {
                        ASSERT_NEAR(sum, 1, 64 * kRound);
                    }
                    none += whole == 0, paired += layers, ++checked;
                }
            }
        }
        EXPECT_GT(none, 0);
        EXPECT_EQ(paired > checked / 10, facings);
    }
};

PIM_FOR_EACH_UNIT(WeighOf);

TEST_P(WeighOf, WeightsAreThoseOfLookUp) { check(true); }
TEST_P(WeighOf, WeightsAreThoseOfLookUpWithoutFacings) { check(false); }

TEST_P(WeighOf, NoPatchesNoWeights) {
    Floats rows(kPlaceRows * kLanes), weights(kLanes, 7.0f);
    own().weigh(nullptr, 0, kFacingThreshold, rows.data(), weights.data());
    for (const float w : weights) EXPECT_EQ(w, 7);  // untouched
}

// --- locate ---

std::vector<TriangleRow> rows_of(const Geometry& g) {
    std::vector<TriangleRow> rows;
    for (uint32_t t = 0; t < g.triangles.size(); ++t) {
        const auto corners = g.corners(t);
        const auto& v = g.triangles[t].vertices;
        const Vec3 flat = geometric_normal(corners);
        const bool smooth = g.normals[v[0]] != Vec3(0);
        TriangleRow& row = rows.emplace_back();
        row.material = g.triangles[t].material;
        for (int axis = 0; axis < 3; ++axis) {
            row.corner[axis] = corners[0][axis];
            row.edge1[axis] = corners[1][axis] - corners[0][axis];
            row.edge2[axis] = corners[2][axis] - corners[0][axis];
            row.geometric_normal[axis] = flat[axis];
            row.normal[axis] = smooth ? g.normals[v[0]][axis] : flat[axis];
            row.bend1[axis] = smooth ? g.normals[v[1]][axis] - g.normals[v[0]][axis] : 0;
            row.bend2[axis] = smooth ? g.normals[v[2]][axis] - g.normals[v[0]][axis] : 0;
        }
    }
    return rows;
}

// A flat and a smooth ball and a heap of triangles whose corners' normals point anywhere, about (0.3, -0.2,
// 0.5).
Scene many_triangles(Dice& dice) {
    Scene scene = empty_scene();
    const Vec3 centre(0.3f, -0.2f, 0.5f);
    add_sphere(scene, centre, 1, 1, false, false);
    add_sphere(scene, centre, 1.3f, 1, true, true);
    for (int i = 0; i < 100; ++i) {
        add_triangle(scene, dice.inside({Vec3(-1), Vec3(2)}), dice.inside({Vec3(-1), Vec3(2)}),
                     dice.inside({Vec3(-1), Vec3(2)}));
        for (std::size_t v = scene.geometry.normals.size() - 3; v < scene.geometry.normals.size(); ++v)
            scene.geometry.normals[v] = dice.direction();
    }
    return scene;
}

struct Hits {
    alignas(64) uint32_t triangle[kLanes];
    alignas(64) float u[kLanes], v[kLanes], normal[3][kLanes], direction[3][kLanes];

    HitLanes lanes() const {
        return {
            triangle, u, v, {normal[0], normal[1], normal[2]}, {direction[0], direction[1], direction[2]}};
    }
    // As the ray caster gives them: the normal of any length towards the front.
    void set(int lane, const Geometry& g, uint32_t t, float b1, float b2, const Vec3& towards, float length) {
        triangle[lane] = t, u[lane] = b1, v[lane] = b2;
        const Vec3 front = geometric_normal(g.corners(t)) * length;
        for (int axis = 0; axis < 3; ++axis)
            normal[axis][lane] = front[axis], direction[axis][lane] = towards[axis];
    }
    double towards(int lane) const {
        double sum = 0;
        for (int axis = 0; axis < 3; ++axis)
            sum += double(normal[axis][lane]) * double(direction[axis][lane]);
        return sum;
    }
    Hit hit(int lane) const {
        return {triangle[lane], 1, u[lane], v[lane], towards(lane) <= 0 ? Side::front : Side::back};
    }
};

struct Located {
    Floats rows = Floats(kLocatedRows * kLanes);
    alignas(64) int32_t cells[kCellRows * kLanes];

    Located(const Kernels& k, const std::vector<TriangleRow>& triangles, const Hits& hits,
            const CellGrid& grid) {
        const GridPlacement placement{{float(grid.origin.x), float(grid.origin.y), float(grid.origin.z)},
                                      float(1 / grid.cell_size),
                                      kFacingThreshold,
                                      grid.facings};
        k.locate(triangles.data(), hits.lanes(), placement, rows.data(), cells);
    }
    Vec3 row(int first, int lane) const {
        return {rows[std::size_t(first * kLanes + lane)], rows[std::size_t((first + 1) * kLanes + lane)],
                rows[std::size_t((first + 2) * kLanes + lane)]};
    }
};

class LocateOf : public KernelsOf {
  protected:
    // Positions up to 2.3 m and normals are sums of three or four products on either side: within 16
    // roundings of the largest, and interpolated normals of that over their length.
    static constexpr double kPosition = 16 * 2.3 * kRound * 1.8, kNormal = 16 * kRound * 1.8;

    void check_lane(const Scene& scene, const Hits& hits, const Located& located, const CellGrid& grid,
                    int lane) {
        const Geometry& g = scene.geometry;
        const auto& v = g.triangles[hits.triangle[lane]].vertices;
        const double b1 = double(hits.u[lane]), b2 = double(hits.v[lane]);
        Vec3d smooth = Vec3d(g.normals[v[0]]) * (1 - b1 - b2) + Vec3d(g.normals[v[1]]) * b1 +
                       Vec3d(g.normals[v[2]]) * b2;
        const SurfacePoint s = surface_at(scene, hits.hit(lane));
        if (smooth.length2() == 0) smooth = Vec3d(s.geometric_normal);
        const double normal_off = kNormal / std::min(1.0, smooth.length());
        ASSERT_NEAR((located.row(0, lane) - s.position).length(), 0, kPosition);
        ASSERT_EQ(located.row(6, lane), s.geometric_normal);
        if (std::abs(smooth.dot(Vec3d(s.geometric_normal))) > kNormal) {  // else it may turn either way
            ASSERT_NEAR((located.row(3, lane) - s.shading_normal).length(), 0, normal_off);
            ASSERT_GE(located.row(3, lane).dot(s.geometric_normal), -normal_off);
            position_.add((located.row(0, lane) - s.position).length());
            normal_.add((located.row(3, lane) - s.shading_normal).length() * smooth.length());
            check_mask(s.shading_normal, located.cells[3 * kLanes + lane], grid, 2 * normal_off);
        }
        for (int axis = 0; axis < 3; ++axis) check_cell(s, located, grid, axis, lane);
    }
    static void check_mask(const Vec3& normal, int mask, const CellGrid& grid, double off) {
        if (!grid.facings) {
            ASSERT_EQ(mask, 1);
        }
        const FacingWeights facing = facing_weights(grid, normal);
        for (int k = 0; k < kFacingCount && grid.facings; ++k) {
            const float n = normal[k / 2];
            if (std::abs(n * n - kFacingThreshold) < float(off)) continue;
            ASSERT_EQ(mask >> k & 1, facing.weight[std::size_t(k)] > 0) << normal << " facing " << k;
        }
        ASSERT_EQ(mask >> kFacingCount, 0);
    }
    // The place among the cells' centres and the cell: floor of it, but for places on its border.
    void check_cell(const SurfacePoint& s, const Located& located, const CellGrid& grid, int axis, int lane) {
        const double place = (double(s.position[axis]) - grid.origin[axis]) / grid.cell_size - 0.5;
        const double off = kPosition / grid.cell_size + 4 * kRound * (std::abs(place) + 1);
        const int low = located.cells[axis * kLanes + lane];
        const double rest = double(located.rows[std::size_t((9 + axis) * kLanes + lane)]);
        ASSERT_NEAR(low + rest, place, off);
        ASSERT_GE(rest, 0);
        ASSERT_LE(rest, 1);
        if (place - std::floor(place) > off && std::ceil(place) - place > off) {
            ASSERT_EQ(low, std::floor(place));
        }
        place_.add(low + rest - place);
    }
    Largest position_{"position_m"}, normal_{"normal_by_length"}, place_{"place_cells"};
};

PIM_FOR_EACH_UNIT(LocateOf);

TEST_P(LocateOf, SurfacesAndCells) {
    const Scene scene = many_triangles(dice_);
    const auto rows = rows_of(scene.geometry);
    int back = 0;
    for (const bool facings : {true, false}) {
        const CellGrid grid{Vec3d(-1.5, -2, -0.7), 0.13, Index3(30), facings};  // part of it lies outside
        for (int i = 0; i < 500; ++i) {
            Hits hits;
            for (int lane = 0; lane < kLanes; ++lane) {
                float b1 = dice_.between(0, 1), b2 = dice_.between(0, 1);
                if (b1 + b2 > 1) b1 = 1 - b1, b2 = 1 - b2;
                const auto t = uint32_t(dice_.below(int(rows.size())));
                do
                    hits.set(lane, scene.geometry, t, b1, b2, dice_.direction() * dice_.between(0.1f, 3),
                             dice_.between(0.1f, 3));
                while (std::abs(hits.towards(lane)) < 1e-6);  // along the surface: either side is right
                back += hits.hit(lane).side == Side::back;
            }
            const Located located(own(), rows, hits, grid), other(plain(), rows, hits, grid);
            for (int lane = 0; lane < kLanes; ++lane) {
                check_lane(scene, hits, located, grid, lane);
                ASSERT_NEAR((located.row(0, lane) - other.row(0, lane)).length(), 0, 1e-5);
                ASSERT_EQ(located.row(6, lane), other.row(6, lane));
                if (HasFatalFailure()) return;
            }
        }
    }
    EXPECT_GT(back, 5000);
}

TEST_P(LocateOf, NormalsThatCancelGiveTheFlatOne) {
    Scene scene = empty_scene();
    add_triangle(scene, {0, 0, 0}, {1, 0, 0}, {0, 0, -1});  // front up
    const float u[kLanes] = {0.5f, 0.5f, 0.25f}, v[kLanes] = {0, 0.25f, 0.25f};
    // Opposite each other; then all along the surface, neither in front of it nor behind.
    for (const auto& normals : {std::array{Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 0, 0)},
                                std::array{Vec3(1, 0, 0), Vec3(1, 0, 0), Vec3(1, 0, 0)}}) {
        for (std::size_t i = 0; i < 3; ++i) scene.geometry.normals[i] = normals[i];
        Hits hits;
        for (int lane = 0; lane < kLanes; ++lane)
            hits.set(lane, scene.geometry, 0, u[lane], v[lane], Vec3(0.1f, lane % 2 ? 1.0f : -1.0f, 0), 2);
        const CellGrid grid{Vec3d(-1), 0.5, Index3(8), true};
        const Located located(own(), rows_of(scene.geometry), hits, grid);
        for (const int lane : {0, 1}) {
            const SurfacePoint s = surface_at(scene, hits.hit(lane));
            EXPECT_EQ(located.row(6, lane), Vec3(0, lane % 2 ? -1.0f : 1.0f, 0))
                << "the side that the ray meets";
            EXPECT_EQ(located.row(3, lane), s.shading_normal) << normals[1];
        }
    }
}

}  // namespace
}  // namespace pim
