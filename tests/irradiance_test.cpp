// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/map/irradiance.h"

#include "common/core/error.h"
#include "statistics.h"
#include "test_scenes.h"

namespace pim {
namespace {

constexpr float kRounding = 1e-5f;  // some dozen float roundings of numbers near 10

// A floor of cells of size 1 at height 0.5, whole or in part; values are a linear function of the place.
struct FloorMap {
    IlluminationMap map;
    std::vector<Rgb> values;

    static Rgb value_at(double x, double z) { return Rgb(float(2 + 0.5 * x + 0.25 * z), 1, 0); }

    template <class Holds>
    explicit FloorMap(Holds holds) {
        map.grid.size = Index3(8, 3, 8);
        for (int x = 0; x < 8; ++x)
            for (int z = 0; z < 8; ++z) {
                if (!holds(x, z)) continue;
                map.patches.push_back({{x, 1, z}, 2, 1, Vec3(0)});
                values.push_back(value_at(x + 0.5, z + 0.5));
            }
        map.index = PatchIndex(map.grid, map.patches);
    }
    Rgb at(const Vec3& position, const Vec3& normal = Vec3(0, 1, 0)) const {
        return irradiance_at(map, values, position, normal);
    }
};

bool everywhere(int, int) { return true; }

TEST(IrradianceAt, LinearFieldsComeBack) {  // trilinear weights of equal areas
    const FloorMap floor(everywhere);
    for (const Vec3& p : {Vec3(2.5f, 1.5f, 3.5f), Vec3(3.1f, 1.5f, 4.9f), Vec3(6, 1.5f, 1)})
        EXPECT_NEAR((floor.at(p) - FloorMap::value_at(p.x, p.z)).length(), 0, kRounding);
}

TEST(IrradianceAt, IsContinuous) {
    const FloorMap floor([](int x, int z) { return (x + z) % 3 != 0; });
    Rgb before = floor.at({0.5f, 1.5f, 0.7f});
    for (int i = 1; i < 7000;
         ++i) {  // slopes stay below the largest difference of neighbours over half a cell
        const float x = 0.5f + 1e-3f * float(i);
        const Rgb now = floor.at({x, 1.5f, 0.7f + 0.5f * float(i) * 1e-3f});
        ASSERT_NEAR(now.x, before.x, 2e-2f) << x;
        before = now;
    }
}

TEST(IrradianceAt, CellsWithoutSurfaceNeverCount) {
    const FloorMap floor([](int x, int) { return x < 4; });
    EXPECT_NEAR(floor.at({4.2f, 1.5f, 2.5f}).x, FloorMap::value_at(3.5, 2.5).x, kRounding);
    EXPECT_EQ(floor.at({6.5f, 1.5f, 2.5f}), Rgb(0));  // no surface near
}

TEST(IrradianceAt, OtherFacingsDoNotMix) {
    FloorMap floor(everywhere);
    for (int x = 0; x < 8; ++x) floor.map.patches.push_back({{x, 1, 0}, 0, 1, Vec3(0)});
    std::ranges::stable_sort(floor.map.patches, patch_before);
    floor.map.index = PatchIndex(floor.map.grid, floor.map.patches);
    std::vector<Rgb> values;
    for (const Patch& p : floor.map.patches) values.push_back(p.slot == 0 ? Rgb(9) : Rgb(1));
    EXPECT_NEAR(irradiance_at(floor.map, values, {3.5f, 1.5f, 0.5f}, {0, 1, 0}).x, 1, kRounding);
    EXPECT_NEAR(irradiance_at(floor.map, values, {3.5f, 1.5f, 0.5f}, {1, 0, 0}).x, 9, kRounding);
    // Halfway between the two, both halfway.
    EXPECT_NEAR(irradiance_at(floor.map, values, {3.5f, 1.5f, 0.5f}, Vec3(1, 1, 0).normalized()).x, 5, 1e-4f);
}

TEST(IrradianceAt, LargerPatchesWeighMore) {
    FloorMap floor(everywhere);
    for (Patch& p : floor.map.patches)
        if (p.cell.x == 3) p.area = 3;
    const float left = FloorMap::value_at(2.5, 2.5).x, right = FloorMap::value_at(3.5, 2.5).x;
    EXPECT_NEAR(floor.at({3, 1.5f, 2.5f}).x, (left + 3 * right) / 4, kRounding);
}

// --- patches under lamps ---

TEST(CheckInDomain, NamesLampAndDomain) {
    const Box3 domain(Vec3(0), Vec3(1, 2, 3));
    check_in_domain("lamp", domain, {1, 2, 3}, Vec3d(0));
    check_in_domain("lamp", domain, {1.000001f, 0, 0}, Vec3d(0));  // rounding
    try {
        check_in_domain("reading lamp", domain, {1.5f, 0, 0}, Vec3d(100, 0, 0));
        FAIL();
    } catch (const UsageError& e) {
        for (const char* part : {"reading lamp", "101.5", "100,0,0", "101,2,3"})
            EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
    }
    EXPECT_THROW(check_in_domain("lamp", domain, Vec3(std::nanf("")), Vec3d(0)), UsageError);
}

IlluminationMap constant_map(const std::vector<float>& constants) {
    IlluminationMap map;
    map.grid.size = Index3(8);
    MapLight light;
    light.name = "lamp";
    light.domain = Box3(Vec3(0));
    light.boxes = split_domain(light.domain, Index3(1));
    Polynomials p{{kConstantTerm}, {}, {}};
    for (std::size_t i = 0; i < constants.size(); ++i) {
        map.patches.push_back({{int(i), 0, 0}, 0, 1, Vec3(0)});
        p.coefficients.insert(p.coefficients.end(), 3, constants[i]);
        p.residuals.push_back(float(i));
    }
    light.polynomials.emplace_back()[int(Component::indirect)] = p;
    map.lights.push_back(light);
    map.components = {Component::indirect};
    map.index = PatchIndex(map.grid, map.patches);
    return map;
}

TEST(PatchIrradiance, NegativeValuesAreCutToZero) {
    std::size_t cut = 0;
    const auto values =
        patch_irradiance(constant_map({2, -1}), {Component::indirect}, {{Vec3(0), Rgb(1, 2, 3)}}, &cut);
    EXPECT_EQ(values[0], Rgb(2, 4, 6));
    EXPECT_EQ(values[1], Rgb(0));
    EXPECT_EQ(cut, 3u);  // channels
}

TEST(PatchIrradiance, TheThesisKeepsNegativeValues) {
    IlluminationMap map = constant_map({2, -1});
    map.mend_signs = false;
    EXPECT_EQ(patch_irradiance(map, {Component::indirect}, {{Vec3(0), Rgb(1, 2, 3)}})[1], Rgb(-1, -2, -3));
}

}  // namespace
}  // namespace pim
