// SPDX-License-Identifier: GPL-3.0-or-later
// The scenes of data/ baked with their own settings, against closed forms and path tracing on their surfaces.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

#include "bake/fit.h"
#include "common/core/parallel.h"
#include "common/map/irradiance.h"
#include "common/scene/scene_file.h"
#include "tests/baked_scenes.h"

namespace pim {
namespace {

SurfacePoint point_on(const Scene& scene, uint32_t triangle, Side side, RandomStream& random) {
    float b1 = random.next(), b2 = random.next();
    if (b1 + b2 > 1) b1 = 1 - b1, b2 = 1 - b2;
    return surface_at(scene, {triangle, 0, b1, b2, side});
}

struct Comparison {
    double map = 0, path = 0, path_error = 0;  // means over a surface; standard error of the second
    double ratio() const { return map / path; }
};

// Means of the indirect irradiance over points of the fronts of a surface: by the map and by paths.
Comparison compare_on(Baked& b, const std::function<bool(const SurfacePoint&, const std::string&)>& wanted,
                      int points) {
    const Scene& scene = b.baked.scene;
    const auto lamps = lamps_at_start(scene);
    const auto values = patch_irradiance(b.baked.map, {Component::indirect}, lamps);
    const PathScene paths{scene, b.caster, lamps};
    std::vector<double> cumulative;
    std::vector<uint32_t> chosen;
    double total = 0;
    RandomStream random(1, RandomPurpose::evaluation, 0, 0);
    for (uint32_t t = 0; t < scene.geometry.triangles.size(); ++t)
        if (wanted(point_on(scene, t, Side::front, random),
                   scene.geometry.objects[scene.geometry.triangles[t].object])) {
            cumulative.push_back(total += area(scene.geometry.corners(t)));
            chosen.push_back(t);
        }
    EXPECT_FALSE(chosen.empty());
    std::vector<double> map_values(points), path_values(points);
    parallel_for(std::size_t(points), [&](std::size_t i) {
        RandomStream own(2, RandomPurpose::evaluation, 1, i);
        SurfacePoint s;
        do {
            const double place = (double(i) + own.next()) / points * total;
            const auto at = std::size_t(std::ranges::lower_bound(cumulative, place) - cumulative.begin());
            s = point_on(scene, chosen[std::min(at, chosen.size() - 1)], Side::front, own);
        } while (!wanted(s, scene.geometry.objects[scene.geometry.triangles[s.triangle].object]));
        map_values[i] = mean_channel(irradiance_at(b.baked.map, values, s.position, s.shading_normal));
        path_values[i] = path_irradiance(b, paths, s, 64, own).mean;
    });
    Comparison c;
    double squares = 0;
    for (int i = 0; i < points; ++i) c.map += map_values[i] / points, c.path += path_values[i] / points;
    for (int i = 0; i < points; ++i) squares += std::pow(path_values[i] - map_values[i] - c.path + c.map, 2);
    c.path_error = std::sqrt(squares) / points;
    return c;
}

// The mark of the board and its surroundings: within 3 % of the mean of each surface, beyond 3 standard
// errors.
void expect_within(const char* surface, const Comparison& c, double share) {
    std::printf("%s: map %.5g, paths %.5g ± %.2g, ratio %.4f\n", surface, c.map, c.path, c.path_error,
                c.ratio());
    EXPECT_LE(std::abs(c.map - c.path), share * c.path + 3 * c.path_error) << surface;
}

TEST(Panel, IndirectIrradianceOfItsSurfacesAgreesWithPaths) {
    Baked& b = baked_scene("panel");
    const auto up = [](const SurfacePoint& s) { return s.geometric_normal.y > 0.9f; };
    Box3 board;
    const Geometry& g = b.baked.scene.geometry;
    for (const Triangle& t : g.triangles)
        if (g.objects[t.object] == "board")
            for (const uint32_t v : t.vertices) board.extendBy(g.positions[v]);
    int thin = 0;
    for (int axis = 1; axis < 3; ++axis)
        if (board.size()[axis] < board.size()[thin]) thin = axis;
    // The board's front faces away from the nearest wall, into the room; the wall's covered part is left out.
    const Vec3 middle = bounds(g).center();
    const float inward = middle[thin] > board.center()[thin] ? 1.0f : -1.0f;
    const auto covered = [&](const Vec3& p) {
        for (int axis = 0; axis < 3; ++axis)
            if (axis != thin && (p[axis] < board.min[axis] || p[axis] > board.max[axis])) return false;
        return true;
    };
    expect_within("board's front",
                  compare_on(
                      b,
                      [&](const SurfacePoint& s, const std::string& object) {
                          return object == "board" && s.geometric_normal[thin] * inward > 0.9f;
                      },
                      3000),
                  0.03);
    expect_within("wall around the board",
                  compare_on(
                      b,
                      [&](const SurfacePoint& s, const std::string& object) {
                          return object.starts_with("wall") && s.geometric_normal[thin] * inward > 0.9f &&
                                 std::abs(s.position[thin] - board.center()[thin]) < 0.2f &&
                                 !covered(s.position);
                      },
                      3000),
                  0.03);
    const auto floor_lit = [&](const SurfacePoint& s, const std::string& object) {
        if (object != "floor" || !up(s) || std::abs(s.position.y) > 1e-3f) return false;
        const Vec3 above = s.position + Vec3(0, 1e-3f, 0);
        return !b.caster.occluded({above, Vec3(0, 1, 0), 0.02f});  // nothing stands on it there
    };
    expect_within("floor", compare_on(b, floor_lit, 3000), 0.03);
    expect_within(
        "table's top",
        compare_on(
            b,
            [&](const SurfacePoint& s, const std::string& object) { return object == "table_top" && up(s); },
            3000),
        0.03);
}

TEST(ThinWall, DarkRoomStaysDark) {
    Baked& b = baked_scene("thin_wall");
    const auto values = patch_irradiance(b.baked.map, {Component::indirect}, lamps_at_start(b.baked.scene));
    const Scene& scene = b.baked.scene;
    const float cell = float(b.baked.map.grid.cell_size);
    double bright = 0, far = 0, near = 0;
    int bright_count = 0, far_count = 0, near_count = 0;
    RandomStream random(3, RandomPurpose::evaluation, 0, 0);
    // The wall stands between x = 3 and x = 3.02; look at all surfaces from inside the rooms.
    for (int i = 0; i < 200000; ++i) {
        const bool dark_room = i & 1;
        const Vec3 from = dark_room ? Vec3(4.5f, 1.2f, 1.5f) : Vec3(1.5f, 1.2f, 1.5f);
        const float u1 = random.next(), u2 = random.next();
        const auto hit = b.caster.intersect({from, sample_sphere(u1, u2)});
        ASSERT_TRUE(hit);
        const SurfacePoint s = surface_at(scene, *hit);
        const double e = mean_channel(irradiance_at(b.baked.map, values, s.position, s.shading_normal));
        if (!dark_room)
            bright += e, ++bright_count;
        else if (s.position.x > 3.02f + cell)
            far += e, ++far_count;
        else
            near += e, ++near_count;
    }
    bright /= bright_count, far /= far_count, near /= near_count;
    std::printf("bright room %.4g, dark room farther than a cell %.4g (%.3f %%), nearer %.4g (%.2f %%)\n",
                bright, far, 100 * far / bright, near, 100 * near / bright);
    EXPECT_LE(far, 0.005 * bright);
}

// Least squares without shrinkage over the volumes of the work folder.
BoxFit refit(Baked& b, std::vector<Vec3>& positions) {
    const Scene& scene = b.baked.scene;
    const RayCaster pinned(scene.geometry, InstructionSet::pinned);
    const WorkFolder work({WorkFolder::beside(b.map_file)}, trace_settings(scene, pinned, solids_of(scene)),
                          scene);
    const Cells cells = *work.read_cells();
    const Solids solids = solids_of(scene);
    std::vector<std::string> warnings;
    const auto samples = all_light_samples(scene, solids, warnings);
    for (const LightSample& s : samples) positions.push_back(s.position);
    return fit_box(split_domain(scene.lights[0].domain, Index3(1))[0], positions, {3}, cells.patches.size(),
                   [&](std::size_t i) { return work.read(scene, cells, samples[i], Component::indirect); },
                   {});
}

TEST(Sphere, IndirectLightDoesNotFollowTheLamp) {
    Baked& b = baked_scene("sphere");
    const IlluminationMap& map = b.baked.map;
    std::vector<Vec3> positions;
    const BoxFit fit = refit(b, positions);
    // Standard errors from the design by plain normal equations and each patch's own residual.
    const MapBox box = map.lights[0].boxes[0];
    Eigen::MatrixXd design(Eigen::Index(positions.size()), kTermCount);
    for (std::size_t m = 0; m < positions.size(); ++m) {
        const auto row = monomials(box.normalised(Vec3d(positions[m])));
        for (int t = 0; t < kTermCount; ++t) design(Eigen::Index(m), t) = row[t];
    }
    const Eigen::VectorXd variance = (design.transpose() * design).inverse().diagonal();
    const double freedom = double(positions.size()) - kTermCount;
    double squares = 0, most = 0;
    std::size_t count = 0;
    for (std::size_t p = 0; p < fit.polynomials.residuals.size(); ++p) {
        const double sigma = fit.polynomials.residuals[p] * std::sqrt(double(positions.size()) / freedom);
        if (!(sigma > 0)) continue;  // outside of the shell: no photon
        for (int t = 0; t < kConstantTerm; ++t, ++count) {
            const double ratio =
                fit.polynomials.coefficients[(p * kTermCount + t) * 3] / (sigma * std::sqrt(variance(t)));
            squares += ratio * ratio;
            most = std::max(most, std::abs(ratio));
        }
    }
    const double rms = std::sqrt(squares / double(count));
    // Of so many Student-distributed ratios, the largest passes this once in a thousand.
    const double bound =
        boost::math::quantile(boost::math::students_t(freedom), 1 - 0.001 / (2.0 * double(count)));
    std::printf("%zu ratios, root mean square %.4f, largest %.2f (bound %.2f)\n", count, rms, most, bound);
    EXPECT_NEAR(rms, 1, 0.05);
    EXPECT_LE(most, bound);
}

TEST(Sphere, IndirectIrradianceIsTheClosedForm) {
    Baked& b = baked_scene("sphere");
    const IlluminationMap& map = b.baked.map;
    double flux = 0, total = 0;
    for (std::size_t p = 0; p < map.patches.size(); ++p) {
        flux += map.patches[p].area * map.lights[0]
                                          .polynomials[0][int(Component::indirect)]
                                          ->coefficients[(p * kTermCount + kConstantTerm) * 3];
        total += map.patches[p].area;
    }
    const double rho = b.baked.scene.materials[b.baked.scene.geometry.triangles[0].material].diffuse.x;
    const double expected = rho / ((1 - rho) * 4 * double(kPi));  // per watt, R = 1 m
    std::printf("area mean %.6f, closed form %.6f\n", flux / total, expected);
    EXPECT_NEAR(flux / total, expected, 0.01 * expected);
}

// Energy: photons exactly, flux within 4 standard errors, for every scene.
class EveryScene : public testing::TestWithParam<std::string> {};

TEST_P(EveryScene, EnergyAccountCloses) {
    const Scene scene = read_scene(fs::path(PIM_DATA) / GetParam() / (GetParam() + ".toml"));
    const RayCaster caster(scene.geometry, InstructionSet::pinned);
    EnergyAccount account;
    for (uint64_t i = 0; i < 100000; ++i) {
        RandomStream random(7, RandomPurpose::photons, 0, i);
        const Light& light = scene.lights[i % scene.lights.size()];
        trace_photon(
            scene, caster, light, light.position, random, [](const Landing&) {}, account);
    }
    EXPECT_EQ(account.emitted, account.absorbed + account.escaped + account.cut_off);
    const Vec3d mean = account.total_flux() / double(account.emitted), error = account.standard_error();
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(mean[c], 1, 4 * error[c] + 1e-6) << GetParam();
}

INSTANTIATE_TEST_SUITE_P(All, EveryScene,
                         testing::Values("cornell", "temple", "cloister", "caustic", "thin_wall", "sphere",
                                         "gallery", "panel"));

}  // namespace
}  // namespace pim
