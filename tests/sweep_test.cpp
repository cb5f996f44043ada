// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/sweep.h"

#include <fstream>

#include "common/core/error.h"
#include "common/core/file.h"
#include "tests/baked_scenes.h"

namespace pim {
namespace {

TEST(Sweep, AxesHoldListsOfValues) {
    const Axis boxes = parse_axis("boxes=[1,1,1],[2,1,2]");
    EXPECT_EQ(boxes.key, "boxes");
    EXPECT_EQ(boxes.values, (std::vector<std::string>{"[1,1,1]", "[2,1,2]"}));
    EXPECT_EQ(parse_axis("photons=1000").values, std::vector<std::string>{"1000"});
    for (const char* wrong : {"photons", "photons=", "=3", "photons=1,,2", "photons=1,", "colour=1,2"})
        EXPECT_THROW(parse_axis(wrong), UsageError) << wrong;
}

SweepOptions options_of(const std::string& folder, const std::vector<std::string>& axes) {
    SweepOptions options;
    for (const std::string& axis : axes) options.axes.push_back(parse_axis(axis));
    options.folder = test_folder() / folder;
    options.evaluate = {.lights = 4, .pixels = 200, .paths = 128, .geometry = {}};
    return options;
}

const fs::path kSphere = fs::path(PIM_DATA) / "sphere/sphere.toml";

TEST(Sweep, BakesAndEvaluatesEveryCombination) {
    set_log_level("error");
    const auto options = options_of("sweep", {"photons=200,3200", "degree=0,1", "reach_photons=65536"});
    const auto results = sweep(kSphere, options);
    ASSERT_EQ(results.size(), 4u);
    const int photons[] = {200, 200, 3200, 3200}, degree[] = {0, 1, 0, 1};
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_EQ(results[i]["settings"]["photons"], photons[i]);
        EXPECT_EQ(results[i]["settings"]["degree"], degree[i]);
        EXPECT_EQ(results[i]["photons_total"], 100 * photons[i]);
        EXPECT_GT(results[i]["bake_seconds"], 0);
        EXPECT_TRUE(fs::exists(results[i]["map"].get<std::string>()));
    }
    // The light of a closed sphere depends on the lamp's place through its direct part alone, so that 16
    // times the photons make a quarter of the error.
    const double ratio =
        results[0]["relrmse_indirect"].get<double>() / results[2]["relrmse_indirect"].get<double>();
    EXPECT_GT(ratio, 2.5);
    EXPECT_LT(ratio, 6.5);
    EXPECT_LT(results[0]["bytes"], results[1]["bytes"]);

    // The same as each by itself.
    const fs::path alone = test_folder() / "alone/alone.vdb";  // as deep: the path to the geometry is in it
    fs::create_directories(alone.parent_path());
    bake_run(kSphere, {.output = alone, .settings = {{"photons", "3200"}, {"degree", "1"}, {"reach_photons", "65536"}}});
    EXPECT_TRUE(read_text(alone) == read_text(results[3]["map"].get<std::string>()));
    EXPECT_EQ(Evaluator(options.evaluate).evaluate(alone)["relrmse"], results[3]["relrmse"]);

    // What is there is not done again; what has changed is.
    const auto time = fs::last_write_time(results[0]["map"].get<std::string>());
    EXPECT_EQ(sweep(kSphere, options), results);
    EXPECT_EQ(fs::last_write_time(results[0]["map"].get<std::string>()), time);
    auto other = options;
    other.evaluate.paths = 32;
    EXPECT_NE(sweep(kSphere, other)[0]["relrmse"], results[0]["relrmse"]);
}

TEST(Sweep, MistakesAreFoundBeforeTheWork) {
    set_log_level("error");
    const auto options = options_of("mistakes", {"photons=100", "degree=1,7"});
    EXPECT_THROW(sweep(kSphere, options), Error);
    EXPECT_FALSE(fs::exists(options.folder));
}

TEST(Sweep, SettingsReachTheirTables) {
    const Scene scene = read_scene(
        kSphere, {.settings = {{"cells", "9"}, {"boxes", "[2, 1, 1]"}, {"samples", "77"}}, .geometry = {}});
    EXPECT_EQ(std::get<CellCount>(scene.grid.resolution).longest, 9);
    EXPECT_EQ(scene.lights[0].boxes, Index3(2, 1, 1));
    EXPECT_EQ(std::get<int>(scene.lights[0].samples), 77);
    EXPECT_THROW(table_of_setting("colour"), UsageError);
}

}  // namespace
}  // namespace pim
