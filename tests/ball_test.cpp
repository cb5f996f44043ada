// SPDX-License-Identifier: GPL-3.0-or-later
// A lit ball in a room: between the facings of its surface there must be no seam.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "common/core/parallel.h"
#include "common/map/irradiance.h"
#include "tests/baked_scenes.h"

namespace pim {
namespace {

// A ball with smooth normals, of rings × 2 rings quads, in a box of 4 m.
void write_ball(const fs::path& path, int rings) {
    std::ofstream out(path);
    out << "mtllib ball.mtl\no ball\nusemtl white\n";
    const int columns = 2 * rings;
    for (int i = 0; i <= rings; ++i)
        for (int j = 0; j < columns; ++j) {
            const double a = M_PI * i / rings, b = 2 * M_PI * j / columns;
            const double n[3] = {std::sin(a) * std::cos(b), std::cos(a), std::sin(a) * std::sin(b)};
            out << "v " << n[0] << ' ' << n[1] << ' ' << n[2] << "\nvn " << n[0] << ' ' << n[1] << ' ' << n[2]
                << '\n';
        }
    const auto vertex = [&](int i, int j) {
        const std::string k = std::to_string(i * columns + j % columns + 1);
        return k + "//" + k;
    };
    for (int i = 0; i < rings; ++i)
        for (int j = 0; j < columns; ++j) {
            if (i > 0)
                out << "f " << vertex(i, j) << ' ' << vertex(i, j + 1) << ' ' << vertex(i + 1, j) << '\n';
            if (i < rings - 1)
                out << "f " << vertex(i, j + 1) << ' ' << vertex(i + 1, j + 1) << ' ' << vertex(i + 1, j)
                    << '\n';
        }
    const int first = (rings + 1) * columns;
    out << "o room\n";
    for (int k = 0; k < 8; ++k)
        out << "v " << (k & 1 ? 2 : -2) << ' ' << (k & 2 ? 2 : -2) << ' ' << (k & 4 ? 2 : -2) << '\n';
    const char* walls[] = {"1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"};
    for (const char* wall : walls) {
        std::istringstream corners(wall);
        out << (wall == walls[5] ? "usemtl red\nf" : "f");
        for (int k = 0; k < 4; ++k) {
            int corner = 0;
            corners >> corner;
            out << ' ' << first + corner;
        }
        out << '\n';
    }
    std::ofstream(path.parent_path() / "ball.mtl")
        << "newmtl white\nKd 0.7 0.7 0.7\nnewmtl red\nKd 0.7 0.1 0.1\n";
}

fs::path write_scene(const std::string& name, int rings) {
    write_ball(test_folder() / (name + ".obj"), rings);
    std::ofstream(test_folder() / (name + ".toml"))
        << "[scene]\ngeometry = \"" << name << ".obj\"\n[grid]\ncell_size = 0.2\n[bake]\nphotons = 2000000\n"
        << "[[light]]\nname = \"lamp\"\npower = [100, 100, 100]\nposition = [1.5, 1.6, 1.2]\n"
        << "[[camera]]\nname = \"c\"\neye = [-1.5, 0, -1.5]\ntarget = [0, 0, 0]\n";
    return test_folder() / (name + ".toml");
}

struct Profile {
    std::vector<double> map, path, error;
};

// Indirect irradiance along a great circle of the ball (x, z), seen from outside.
Profile profile_of(Baked& b, int count, int paths_per_point) {
    const auto lamps = lamps_at_start(b.baked.scene);
    const auto values = patch_irradiance(b.baked.map, {Component::indirect}, lamps);
    const PathScene paths{b.baked.scene, b.caster, lamps};
    Profile profile{std::vector<double>(count), std::vector<double>(count), std::vector<double>(count)};
    parallel_for(std::size_t(count), [&](std::size_t i) {
        const double angle = 2 * M_PI * (double(i) + 0.5) / count;
        const Vec3 outward(float(std::cos(angle)), 0.013f, float(std::sin(angle)));
        const auto hit = b.caster.intersect({outward * 1.5f, -outward.normalized()});
        ASSERT_TRUE(hit);
        const SurfacePoint s = surface_at(b.baked.scene, *hit);
        profile.map[i] = mean_channel(irradiance_at(b.baked.map, values, s.position, s.shading_normal));
        RandomStream random(5, RandomPurpose::evaluation, 0, i);
        const PathIrradiance e = path_irradiance(b, paths, s, paths_per_point, random);
        profile.path[i] = e.mean, profile.error[i] = e.error;
    });
    return profile;
}

// Mean of map - path over the points from `begin`, relative to the mean path value, and its standard error.
std::pair<double, double> misfit(const Profile& p, int begin, int count) {
    double difference = 0, variance = 0, level = 0;
    const int n = int(p.map.size());
    for (int k = 0; k < count; ++k) {
        const int i = ((begin + k) % n + n) % n;
        difference += p.map[i] - p.path[i], variance += p.error[i] * p.error[i], level += p.path[i];
    }
    return {difference / level, std::sqrt(variance) / level};
}

void expect_no_seam(const std::string& name, int rings) {
    Baked b(write_scene(name, rings), test_folder() / (name + ".vdb"));
    constexpr int kCount = 720;  // half a degree each
    const Profile p = profile_of(b, kCount, 4096);
    // Left and right of each 45 degree line, 6 degrees each. The map's own noise: 2,000,000 photons leave
    // some thousands in a patch: under 2 %.
    for (int line = 0; line < 4; ++line) {
        const int at = kCount / 8 + line * kCount / 4;
        const auto [left, left_error] = misfit(p, at - 12, 12);
        const auto [right, right_error] = misfit(p, at, 12);
        std::printf("%s, %d degrees: map - path %.2f %% before, %.2f %% after (± %.2f %%)\n", name.c_str(),
                    at / 2, 100 * left, 100 * right, 100 * std::hypot(left_error, right_error));
        EXPECT_NEAR(left, right, 0.02 + 4 * std::hypot(left_error, right_error));
    }
    // The profile itself has no jump: half a degree changes a smooth field by little.
    double level = 0, largest = 0;
    for (int i = 0; i < kCount; ++i) level += p.map[i] / kCount;
    for (int i = 0; i < kCount; ++i)
        largest = std::max(largest, std::abs(p.map[(i + 1) % kCount] - p.map[i]));
    std::printf("%s: largest step in half a degree %.2f %% of the mean\n", name.c_str(),
                100 * largest / level);
    // Facings and cells are blended over a cell (0.2 rad = 23 points) from values that differ by less than 60
    // %.
    EXPECT_LT(largest, 0.06 * level);
    const auto [all, all_error] = misfit(p, 0, kCount);
    EXPECT_NEAR(all, 0, 0.03 + 4 * all_error) << "mean over the circle";
}

TEST(Ball, FineBallShowsNoSeam) { expect_no_seam("fine_ball", 64); }
TEST(Ball, CoarseBallWithSmoothNormalsShowsNoSeam) { expect_no_seam("coarse_ball", 8); }

}  // namespace
}  // namespace pim
