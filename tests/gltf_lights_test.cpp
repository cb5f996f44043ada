// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/gltf_lights.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/core/error.h"
#include "temporary_folder.h"

namespace pim {
namespace {

std::vector<GltfLight> read(const std::string& scene_and_nodes, const std::string& lights) {
    const TemporaryFolder folder;
    return read_gltf_lights(folder.write(
        "a.gltf",
        "{" + scene_and_nodes + R"(,"extensions":{"KHR_lights_punctual":{"lights":[)" + lights + "]}}}"));
}

// The node's part that refers to a light.
std::string light(int index) {
    return R"("extensions":{"KHR_lights_punctual":{"light":)" + std::to_string(index) + "}}";
}

void expect_at(const GltfLight& light, const Vec3d& expected) {
    EXPECT_NEAR((light.position - expected).length(), 0, 1e-12) << light.position;
}

TEST(GltfLights, Defaults) {
    const auto lights =
        read(R"("scenes":[{"nodes":[0]}],"nodes":[{)" + light(0) + "}]", R"({"type":"point"})");
    ASSERT_EQ(lights.size(), 1u);
    EXPECT_EQ(lights[0].name, "lamp");
    EXPECT_EQ(lights[0].type, "point");
    EXPECT_EQ(lights[0].intensity, Rgb(1));
    expect_at(lights[0], Vec3d(0));
}

TEST(GltfLights, NestedTurnedAndScaledNodes) {
    // The child at (1,2,3), doubled: (2,4,6); turned by 90° about z: (-4,2,6); moved.
    const std::string parent =
        R"("translation":[10,0,0],"rotation":[0,0,0.7071067811865476,0.7071067811865476],"scale":[2,2,2])";
    // The same as columns.
    const std::string matrix = R"("matrix":[0,2,0,0, -2,0,0,0, 0,0,2,0, 10,0,0,1])";
    for (const std::string& transform : {parent, matrix}) {
        const auto lights = read(R"("scene":0,"scenes":[{"nodes":[1]}],"nodes":[{"translation":[1,2,3],)" +
                                     light(0) + R"(},{"children":[0],)" + transform + "}]",
                                 R"({"type":"point","intensity":3,"color":[1,0.5,0]})");
        ASSERT_EQ(lights.size(), 1u);
        expect_at(lights[0], {6, 2, 6});
        EXPECT_EQ(lights[0].intensity, Rgb(3, 1.5f, 0));
    }
}

TEST(GltfLights, OnlyOfTheDefaultScene) {
    const std::string nodes = R"("nodes":[{"name":"a",)" + light(0) + R"(},{"name":"b",)" + light(0) + "}]";
    const std::string definition = R"({"type":"point"})";
    const auto second = read(R"("scene":1,"scenes":[{"nodes":[0]},{"nodes":[1]}],)" + nodes, definition);
    ASSERT_EQ(second.size(), 1u);
    EXPECT_EQ(second[0].name, "b");
    EXPECT_EQ(read(nodes, definition).size(), 2u);  // no scene: all roots
}

TEST(GltfLights, NodesNameLampsWhereTheyTellThemApart) {
    const auto lights = read(R"("nodes":[{"name":"x",)" + light(0) + R"(},{"name":"x",)" + light(1) +
                                 R"(},{"name":"y",)" + light(0) + R"(},{"name":"x"}])",
                             R"({"type":"point","name":"bulb"},{"type":"spot"})");
    ASSERT_EQ(lights.size(), 3u);
    EXPECT_EQ(lights[0].name, "bulb");
    EXPECT_EQ(lights[1].name, "lamp");
    EXPECT_EQ(lights[1].type, "spot");
    EXPECT_EQ(lights[2].name, "y");
}

TEST(GltfLights, BrokenFilesAreNamed) {
    const auto error = [](const std::string& nodes) { return message_of<Error>([&] { read(nodes, "{}"); }); };
    for (const std::string& nodes :
         {R"("nodes":[{)" + light(7) + "}]", std::string(R"("nodes":[{"children":[3]}])"),
          std::string(R"("scenes":[{"nodes":[0]}],"nodes":[{"children":[0]}])"),
          R"("nodes":[{"matrix":[1,2],)" + light(0) + "}]", std::string(R"("nodes":[{]})")})
        EXPECT_NE(error(nodes).find("a.gltf"), std::string::npos) << nodes;
    const TemporaryFolder folder;
    const auto cut = folder.write("a.glb", std::string("glTF\2\0\0\0\x20\0\0\0\x20\0\0\0JSON{", 21));
    EXPECT_NE(message_of<Error>([&] { read_gltf_lights(cut); }).find("a.glb"), std::string::npos);
}

}  // namespace
}  // namespace pim
