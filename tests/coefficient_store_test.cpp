// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/relight/coefficient_store.h"

#include <gtest/gtest.h>

#include <chrono>
#include <fstream>

#include "common/core/error.h"
#include "kernels_of.h"

namespace pim {
namespace {

constexpr std::size_t kPatches = 37;  // not a whole number of blocks

// Lamps: one free in eight boxes, one that moves along x alone in eight, one that stands still. Signs are not
// mended, so that all is a sum.
IlluminationMap map_of(bool grey, uint64_t seed, bool facings = true) {
    IlluminationMap map;
    map.origin = Vec3d(100, 0, 0);
    map.grid = {Vec3d(-1, 0.5, 0), 0.1, Index3(20, 10, 5), facings};
    map.grey = grey;
    map.mend_signs = false;
    map.components = {Component::direct, Component::indirect};
    map.description = "[scene]\n";
    Dice dice(seed);
    for (std::size_t p = 0; p < kPatches; ++p)
        map.patches.push_back({Index3(int(p) / 2, int(p) % 3, 4),
                               facings ? (p % 2 == 0 ? 2 : 2 + kFacingCount) : 0, dice.between(0.01f, 1),
                               Vec3(0.01f, -0.02f, 0)});
    std::ranges::sort(map.patches, patch_before);
    map.index = PatchIndex(map.grid, map.patches);
    map.lights = {random_light(map, "free", {Vec3(0), Vec3(2, 1, 3)}, {2, 2, 2}, dice),
                  random_light(map, "rail", {Vec3(0), Vec3(8, 0, 0)}, {8, 1, 1}, dice),
                  random_light(map, "still", Box3(Vec3(0.5f)), Index3(1), dice)};
    return map;
}
constexpr std::size_t kFree = 0, kRail = 1;

// All lamps but one are dark.
std::vector<LightState> only(const IlluminationMap& map, std::size_t lamp, const Vec3& position) {
    std::vector<LightState> lights;
    for (const MapLight& light : map.lights) lights.push_back({light.domain.min, Rgb(0)});
    lights[lamp] = {position, Rgb(3, 2, 1)};
    return lights;
}

struct Sum {
    double value = 0, magnitude = 0;
};

// What the boxes hold, summed as the header lays it out.
Sum sum_of(const std::vector<ActiveBox>& boxes, std::size_t patch, int channel) {
    Sum sum;
    for (const ActiveBox& active : boxes) {
        const PackedBox& b = *active.box;
        for (std::size_t t = 0; t < b.terms.size(); ++t) {
            const std::size_t own = b.channels == 1 ? 0 : std::size_t(channel);
            const std::size_t block = patch / kLanes, lane = patch % kLanes;
            const std::size_t place =
                ((block * b.terms.size() + t) * std::size_t(b.channels) + own) * kLanes + lane;
            const double term =
                double(active.power[channel]) * double(active.monomials[t]) * double(b.coefficients[place]);
            sum.value += term;
            sum.magnitude += std::abs(term);
        }
    }
    return sum;
}

// Either side rounds each term some ten times, and patch_irradiance its sums of up to 20 terms, 8 boxes and 2
// components; components that cancel in the stored sum have at most twice its magnitude here (direct and
// indirect are drawn alike).
void expect_irradiance(const std::vector<ActiveBox>& boxes, const IlluminationMap& map,
                       const std::vector<Component>& components, const std::vector<LightState>& lights) {
    const auto expected = patch_irradiance(map, components, lights);
    for (std::size_t p = 0; p < map.patches.size(); ++p)
        for (int c = 0; c < 3; ++c) {
            const Sum sum = sum_of(boxes, p, c);
            ASSERT_NEAR(sum.value, expected[p][c], 2 * 40 * kRound * sum.magnitude) << p << ' ' << c;
        }
}

// The background has read what it wants; half a minute is ample.
bool settles(const CoefficientStore& store) {
    for (int i = 0; i < 6000 && !store.is_settled(); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    return store.is_settled();
}

class CoefficientStoreTest : public testing::Test {
  protected:
    std::filesystem::path write(const IlluminationMap& map) {
        write_map(file_name(), map);
        return file_name();
    }
    std::filesystem::path file_name() const { return folder_ / "map.vdb"; }
    TemporaryFolder folder_;
    Dice dice_{3};
};

TEST_F(CoefficientStoreTest, BoxesAddUpToThePatchesIrradiance) {
    for (const bool facings : {true, false}) {
        const IlluminationMap map = map_of(false, 1, facings);
        const MapFile file(write(map));
        for (const std::vector<Component>& components : {std::vector{Component::indirect},
                                                         {Component::direct},
                                                         {Component::indirect, Component::direct}}) {
            CoefficientStore store(file, components);
            for (int i = 0; i < 25; ++i) {
                std::vector<LightState> lights;
                for (const MapLight& light : map.lights)
                    lights.push_back({dice_.inside(light.domain), dice_.inside({Vec3(0), Vec3(9)})});
                expect_irradiance(store.active(lights), map, components, lights);
            }
        }
    }
}

TEST_F(CoefficientStoreTest, BordersAndCornersOfTheDomainBelongToIt) {
    const IlluminationMap map = map_of(false, 1);
    const MapFile file(write(map));
    CoefficientStore store(file, map.components);
    for (int corner = 0; corner < 27; ++corner) {
        const Vec3 share(float(corner % 3) / 2, float(corner / 3 % 3) / 2, float(corner / 9) / 2);
        const auto lights = only(map, kFree, map.lights[kFree].domain.max * share);
        const auto boxes = store.active(lights);
        // In the middle of an axis both boxes count.
        const auto middles = int(share.x == 0.5f) + int(share.y == 0.5f) + int(share.z == 0.5f);
        EXPECT_EQ(boxes.size(), std::size_t{1} << middles) << share;
        expect_irradiance(boxes, map, map.components, lights);
    }
}

TEST_F(CoefficientStoreTest, GreyScenesHaveOneChannel) {
    const IlluminationMap map = map_of(true, 2);
    const MapFile file(write(map));
    CoefficientStore store(file, map.components);
    for (int i = 0; i < 20; ++i) {
        const auto lights = only(map, kFree, dice_.inside(map.lights[kFree].domain));
        const auto boxes = store.active(lights);
        for (const ActiveBox& box : boxes) {
            EXPECT_EQ(box.box->channels, 1);
            EXPECT_EQ(box.box->coefficients.size(), 3u * 16 * 20);  // 37 patches in whole blocks, 20 terms
        }
        expect_irradiance(boxes, map, map.components, lights);
    }
}

TEST_F(CoefficientStoreTest, HoldsTermsAndResidualsOfTheMap) {
    const IlluminationMap map = map_of(false, 1);
    const MapFile file(write(map)), again(file_name());  // a file has one reader at a time
    CoefficientStore both(file, map.components), indirect(again, {Component::indirect});
    auto lights = only(map, kRail, Vec3(0));
    lights[2].power = Rgb(1);
    for (CoefficientStore* store : {&both, &indirect}) {
        const auto boxes = store->active(lights);
        ASSERT_EQ(boxes.size(), 2u);
        EXPECT_EQ(boxes[0].box->terms, (std::vector<int>{7, 10, 16, 19}));  // x³, x², x, 1
        EXPECT_EQ(boxes[1].box->terms, std::vector<int>{19});
        EXPECT_EQ(boxes[0].monomials, (std::vector<float>{-1, 1, -1, 1}));  // at the low end
        EXPECT_EQ(boxes[0].power, Rgb(3, 2, 1));
        const auto& polynomials = map.lights[kRail].polynomials[0];
        for (std::size_t p = 0; p < kPatches; ++p) {
            const double a = double(polynomials[std::size_t(Component::indirect)]->residuals[p]);
            const double b =
                store == &indirect ? 0 : double(polynomials[std::size_t(Component::direct)]->residuals[p]);
            EXPECT_NEAR(boxes[0].box->residuals[p], std::sqrt(a * a + b * b), 4 * kRound * (a + b));
        }
    }
}

TEST_F(CoefficientStoreTest, DarkLampsAndNoComponentsMakeNoBoxes) {
    const IlluminationMap map = map_of(false, 1);
    const MapFile file(write(map));
    CoefficientStore store(file, map.components);
    EXPECT_EQ(store.active(only(map, kRail, Vec3(0.5f, 0, 0))).size(), 1u);
    auto lights = only(map, kRail, Vec3(1, 0, 0));
    lights[kRail].power = Rgb(0);
    EXPECT_TRUE(store.active(lights).empty());
    const MapFile again(file_name());
    CoefficientStore none(again, {});
    EXPECT_TRUE(none.active(only(map, kRail, Vec3(1, 0, 0))).empty());
}

// --- what is held ---

// A lamp on the rail has boxes of a metre, which overlap by a quarter.
TEST_F(CoefficientStoreTest, HoldsNeighboursAndDropsWhatIsFar) {
    const IlluminationMap map = map_of(false, 1);
    const MapFile file(write(map));
    CoefficientStore store(file, map.components);
    const auto& boxes = map.lights[kRail].boxes;
    std::size_t most = 0;
    for (const float x : {0.0f, 0.5f, 1.0f, 2.0f, 3.5f, 4.0f, 6.5f, 8.0f, 0.2f}) {
        store.active(only(map, kRail, Vec3(x, 0, 0)));
        ASSERT_TRUE(settles(store));
        std::size_t touching = 0, within_four = 0, of_others = map.lights[kFree].boxes.size() + 1;
        for (const MapBox& box : boxes) {
            double to_own = 1e9;  // between this box and those where the lamp is
            for (const MapBox& own : boxes)
                if (own.contains(Vec3d(double(x), 0, 0)))
                    to_own =
                        std::min(to_own, std::abs(box.centre.x - own.centre.x) - box.half.x - own.half.x);
            touching += to_own <= 0;
            within_four += std::abs(double(x) - box.centre.x) <= 5 * box.half.x;
        }
        // The free lamp's eight boxes are near each other; the lamp that stands still has one.
        EXPECT_GE(store.boxes(), touching + of_others) << x;
        EXPECT_LE(store.boxes(), within_four + of_others) << x;
        EXPECT_LT(within_four, boxes.size());
        most = std::max(most, store.boxes());
        const std::size_t floats = 3 * (3 * 16 * 20 * 8 + 3 * 16 * 1), per_rail_box = 3 * 3 * 16 * 4;
        const std::size_t residuals = kPatches * store.boxes();
        EXPECT_EQ(store.bytes(), 4 * (floats + per_rail_box * (store.boxes() - of_others) + residuals));
    }
    EXPECT_EQ(store.take_problem(), "");
    EXPECT_LT(most, boxes.size() + 9);
}

// Where the file can no longer be read, what is needed must be there.
TEST_F(CoefficientStoreTest, NeighboursAreThereBeforeTheLampIs) {
    const IlluminationMap map = map_of(false, 1);
    const MapFile file(write(map));
    CoefficientStore store(file, map.components);
    store.active(only(map, kRail, Vec3(4.5f, 0, 0)));
    ASSERT_TRUE(settles(store));
    std::ofstream(file_name(), std::ios::binary) << "no map";
    for (const float x : {5.0f, 5.8f, 4.0f, 3.2f}) {
        const auto lights = only(map, kRail, Vec3(x, 0, 0));
        expect_irradiance(store.active(lights), map, map.components, lights);
    }
    EXPECT_THROW(store.active(only(map, kRail, Vec3(8, 0, 0))), Error);
}

TEST_F(CoefficientStoreTest, ABoxInUseOutlivesItsPlaceInTheStore) {
    const IlluminationMap map = map_of(false, 1);
    const MapFile file(write(map));
    CoefficientStore store(file, map.components);
    const auto lights = only(map, kRail, Vec3(0));
    const auto boxes = store.active(lights);
    store.active(only(map, kRail, Vec3(8, 0, 0)));
    expect_irradiance(boxes, map, map.components, lights);
}

// --- errors, and files that change ---

TEST_F(CoefficientStoreTest, LampsOutsideTheirDomainAreRefused) {
    const IlluminationMap map = map_of(false, 1);
    const MapFile file(write(map));
    CoefficientStore store(file, map.components);
    const std::string message =
        message_of<UsageError>([&] { store.active(only(map, kFree, Vec3(1, 1.5f, 1))); });
    for (const char* part : {"free", "101,1.5,1", "100,0,0", "102,1,3"})  // world coordinates
        EXPECT_NE(message.find(part), std::string::npos) << message;
    EXPECT_THROW(store.active(only(map, kFree, Vec3(NAN, 0, 0))), UsageError);
    const auto lights = only(map, kFree, Vec3(1, 1.000001f, 1));  // rounding is forgiven
    const auto boxes = store.active(lights);
    expect_irradiance(boxes, map, map.components, lights);
}

TEST_F(CoefficientStoreTest, AMapThatIsReplacedStaysReadable) {
    const IlluminationMap map = map_of(false, 1), other = map_of(false, 99);
    const MapFile file(write(map));
    CoefficientStore store(file, map.components);
    store.active(only(map, kRail, Vec3(0)));
    ASSERT_TRUE(settles(store));
    write(other);  // to a file beside it, then renamed
    EXPECT_EQ(file.change(), MapFile::Change::replaced);
    for (const float x : {8.0f, 4.0f, 0.5f}) {
        const auto lights = only(map, kRail, Vec3(x, 0, 0));
        expect_irradiance(store.active(lights), map, map.components, lights);
    }
    std::filesystem::remove(file_name());
    const auto lights = only(map, kRail, Vec3(6, 0, 0));
    expect_irradiance(store.active(lights), map, map.components, lights);
    ASSERT_TRUE(settles(store));
    EXPECT_EQ(store.take_problem(), "");
}

TEST_F(CoefficientStoreTest, AMapThatIsOverwrittenIsSaidNotRead) {
    const IlluminationMap map = map_of(false, 1);
    const std::filesystem::path path = file_name();
    for (const bool shorter : {true, false}) {
        const MapFile file(write(map));
        CoefficientStore store(file, map.components);
        const auto start = only(map, kRail, Vec3(0));
        store.active(start);
        ASSERT_TRUE(settles(store));
        std::this_thread::sleep_for(std::chrono::milliseconds(20));  // file times may be so coarse
        const auto length = shorter ? 100 : std::filesystem::file_size(path);
        std::ofstream(path, std::ios::binary) << std::string(length, 'x');
        EXPECT_EQ(file.change(), MapFile::Change::overwritten);
        const std::string message = message_of<Error>([&] { store.active(only(map, kRail, Vec3(8, 0, 0))); });
        EXPECT_NE(message.find("map.vdb: was overwritten"), std::string::npos) << message;
        EXPECT_TRUE(settles(store));
        // The background wanted the neighbours; it says so once.
        EXPECT_NE(store.take_problem().find("map.vdb: was overwritten"), std::string::npos);
        EXPECT_EQ(store.take_problem(), "");
        // What is in memory still shines: the free lamp's boxes.
        const auto held = only(map, kFree, Vec3(0.1f));
        expect_irradiance(store.active(held), map, map.components, held);
    }
}

// What is mapped is the old file, cut short: reading it would end the program (SIGBUS).
TEST_F(CoefficientStoreTest, AMapThatIsOverwrittenAndThenReplacedIsNotReadEither) {
    const IlluminationMap map = map_of(false, 1);
    const MapFile file(write(map));
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    std::ofstream(file_name(), std::ios::binary) << "no map";
    write(map);  // renamed to its place
    EXPECT_EQ(file.change(), MapFile::Change::overwritten);
    std::filesystem::remove(file_name());
    EXPECT_EQ(file.change(), MapFile::Change::overwritten);
}

}  // namespace
}  // namespace pim
