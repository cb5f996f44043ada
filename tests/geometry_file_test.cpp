// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/geometry_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "common/core/error.h"
#include "temporary_folder.h"

namespace pim {
namespace {

const char* const kTriangleObj = "v 0 0 0\nv 1 0 0\nv 0 2 0\nvt 0 0\nvt 1 0\nvt 0 1\n";

// One triangle per material, named in this order.
GeometryFile read_obj(const TemporaryFolder& folder, const std::string& materials,
                      const std::vector<std::string>& used) {
    std::string obj = std::string("mtllib a.mtl\n") + kTriangleObj;
    for (const std::string& name : used) obj += "usemtl " + name + "\nf 1/1 2/2 3/3\n";
    folder.write("a.mtl", materials);
    return read_geometry(folder.write("a.obj", obj), 1);
}

const Material& material_named(const GeometryFile& file, const std::string& name) {
    for (const Material& m : file.materials)
        if (m.name == name) return m;
    throw std::runtime_error("no material " + name);
}

bool any_warning(const GeometryFile& file, const std::string& part) {
    for (const std::string& w : file.warnings)
        if (w.find(part) != std::string::npos) return true;
    return false;
}

TEST(ReadGeometry, ObjTriangle) {
    const TemporaryFolder folder;
    const GeometryFile file = read_obj(folder, "newmtl m\nKd 0.1 0.2 0.3\n", {"m"});
    ASSERT_EQ(file.geometry.triangles.size(), 1u);
    const auto corners = file.geometry.corners(0);
    EXPECT_EQ(corners[1], Vec3(1, 0, 0));
    EXPECT_EQ(corners[2], Vec3(0, 2, 0));
    EXPECT_EQ(file.geometry.texture_coordinates[file.geometry.triangles[0].vertices[2]], Vec2(0, 1));
    EXPECT_EQ(file.materials[file.geometry.triangles[0].material].name, "m");
    EXPECT_EQ(material_named(file, "m").diffuse, Rgb(0.1f, 0.2f, 0.3f));
    for (const Vec3& n : file.geometry.normals) EXPECT_EQ(n, Vec3(0));  // the file has none: flat
}

TEST(ReadGeometry, ObjIllumSaysWhatKsMeans) {
    const TemporaryFolder folder;
    const GeometryFile file = read_obj(folder,
                                       "newmtl shiny\nKd 0.3 0.3 0.3\nKs 0.5 0.5 0.5\nillum 2\n"
                                       "newmtl mirror\nKd 0.2 0.2 0.2\nKs 0.5 0.6 0.7\nillum 3\n"
                                       "newmtl glass\nKd 0 0 0\nKs 1 1 1\nNi 1.7\nillum 7\n"
                                       "newmtl over\nKd 1 0.5 0\nKs 1 0 0\nillum 5\n",
                                       {"shiny", "mirror", "glass", "over"});
    EXPECT_EQ(material_named(file, "shiny").specular, Rgb(0));  // a highlight, no mirror
    EXPECT_EQ(material_named(file, "mirror").specular, Rgb(0.5f, 0.6f, 0.7f));
    EXPECT_EQ(material_named(file, "mirror").diffuse, Rgb(0.2f));
    EXPECT_TRUE(material_named(file, "glass").glass);
    EXPECT_FLOAT_EQ(material_named(file, "glass").ior, 1.7f);
    EXPECT_FALSE(material_named(file, "mirror").glass);
    const Material& over = material_named(file, "over");  // reflects twice what it receives: scaled, and said
    EXPECT_LE(max_channel(over.diffuse + over.specular), 1.000001f);
    EXPECT_FLOAT_EQ(over.diffuse.y, 0.25f);
    EXPECT_TRUE(any_warning(file, "over"));
}

TEST(ReadGeometry, MetresPerUnit) {
    const TemporaryFolder folder;
    folder.write("a.obj", std::string(kTriangleObj) + "f 1 2 3\n");
    EXPECT_EQ(read_geometry(folder / "a.obj", 0.01).geometry.corners(0)[2], Vec3(0, 0.02f, 0));
}

TEST(ReadGeometry, ErrorsNameFileAndTexture) {
    const TemporaryFolder folder;
    const std::string message =
        message_of<Error>([&] { read_obj(folder, "newmtl painted\nmap_Kd missing.png\n", {"painted"}); });
    for (const char* part : {"a.obj", "missing.png", "painted"})
        EXPECT_NE(message.find(part), std::string::npos) << message;
    EXPECT_NE(message_of<Error>([&] { read_geometry(folder / "none.obj", 1); }).find("none.obj"),
              std::string::npos);
    folder.write("broken.glb", "glTF but nothing else");
    EXPECT_NE(message_of<Error>([&] { read_geometry(folder / "broken.glb", 1); }).find("broken.glb"),
              std::string::npos);
    folder.write("points.obj", "v 0 0 0\nv 1 0 0\n");
    EXPECT_THROW(read_geometry(folder / "points.obj", 1), Error);
}

TEST(ReadGeometry, TextureOfAnObj) {
    const TemporaryFolder folder;
    Image picture(2, 2);
    picture.pixels = {Rgb(1, 0, 0), Rgb(0, 1, 0), Rgb(0, 0, 1), Rgb(1)};
    write_image(folder / "t.png", picture, 1);
    const GeometryFile file = read_obj(folder, "newmtl painted\nKd 1 1 1\nmap_Kd t.png\n", {"painted"});
    ASSERT_TRUE(material_named(file, "painted").texture);
    EXPECT_EQ(file.textures.at(std::size_t(*material_named(file, "painted").texture)).pixels, picture.pixels);
}

// --- glTF ---

std::string base64(const std::vector<float>& numbers) {
    static const char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string bytes(numbers.size() * 4, '\0'), text;
    std::memcpy(bytes.data(), numbers.data(), bytes.size());
    for (std::size_t i = 0; i < bytes.size(); i += 3) {  // 36 bytes per triangle: no padding
        const unsigned word =
            unsigned(uint8_t(bytes[i])) << 16 | unsigned(uint8_t(bytes[i + 1])) << 8 | uint8_t(bytes[i + 2]);
        for (int shift = 18; shift >= 0; shift -= 6) text += kDigits[word >> shift & 63];
    }
    return text;
}

// The triangle (0,0,0) (1,0,0) (0,2,0); `nodes`, `materials` and the rest as JSON.
std::string gltf(const std::string& nodes, int node_count, const std::string& material = "{}",
                 const std::string& more = "") {
    const std::string roots = node_count == 1 ? "0" : "0,1";
    return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[)" + roots + R"(]}],"nodes":[)" +
           nodes +
           R"(],"meshes":[{"name":"mesh","primitives":[{"attributes":{"POSITION":0},"material":0}]}],"materials":[)" +
           material +
           R"(],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,2,0]}],)"
           R"("bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,)" +
           base64({0, 0, 0, 1, 0, 0, 0, 2, 0}) + "\"}]" + more + "}";
}

GeometryFile read_gltf(const std::string& text, double metres_per_unit = 1) {
    const TemporaryFolder folder;
    return read_geometry(folder.write("a.gltf", text), metres_per_unit);
}

void expect_corners(const Geometry& g, uint32_t t, const std::array<Vec3d, 3>& expected,
                    double rounding = 1e-6) {
    const auto c = g.corners(t);
    for (std::size_t i = 0; i < 3; ++i)
        EXPECT_NEAR((g.to_world(c[i]) - expected[i]).length(), 0, rounding) << i;
}

TEST(ReadGeometry, GltfInstancesWithTransforms) {
    // Turned by 90° about z: (x, y) -> (-y, x); scaled and moved.
    const GeometryFile file = read_gltf(
        gltf(
            R"({"mesh":0,"name":"plain"},{"mesh":0,"name":"turned","rotation":[0,0,0.7071067811865476,0.7071067811865476],"translation":[5,0,0],"scale":[2,2,2]})",
            2),
        0.5);
    ASSERT_EQ(file.geometry.triangles.size(), 2u);
    expect_corners(file.geometry, 0, {Vec3d(0), Vec3d(0.5, 0, 0), Vec3d(0, 1, 0)});
    expect_corners(file.geometry, 1, {Vec3d(2.5, 0, 0), Vec3d(2.5, 1, 0), Vec3d(0.5, 0, 0)});
    EXPECT_EQ(file.geometry.objects[file.geometry.triangles[1].object], "turned");
}

TEST(ReadGeometry, GltfNestedNodes) {  // the parent moves what the child has scaled
    std::string text = gltf(
        R"({"name":"parent","translation":[10,0,0],"children":[1]},{"mesh":0,"name":"child","scale":[3,1,1]})",
        1);
    const GeometryFile file = read_gltf(text);
    ASSERT_EQ(file.geometry.triangles.size(), 1u);
    expect_corners(file.geometry, 0, {Vec3d(10, 0, 0), Vec3d(13, 0, 0), Vec3d(10, 2, 0)});
}

TEST(ReadGeometry, MirroredNodesKeepTheirFront) {
    const GeometryFile file = read_gltf(gltf(R"({"mesh":0},{"mesh":0,"scale":[-1,1,1]})", 2));
    ASSERT_EQ(file.geometry.triangles.size(), 2u);
    EXPECT_EQ(geometric_normal(file.geometry.corners(0)), Vec3(0, 0, 1));
    EXPECT_EQ(geometric_normal(file.geometry.corners(1)),
              Vec3(0, 0, 1));  // the mirrored front looks the same way
}

TEST(ReadGeometry, FarFromTheOriginPositionsKeepTheirPrecision) {
    // 2^20 m away, floats step by 1/8 m; the triangle's own corners must not.
    const GeometryFile file =
        read_gltf(gltf(R"({"mesh":0,"translation":[1048576,0,-1048576],"scale":[0.3,0.3,0.3]})", 1));
    const Geometry& g = file.geometry;
    EXPECT_GT(g.origin.length(), 1e6);
    expect_corners(
        g, 0, {Vec3d(1048576, 0, -1048576), Vec3d(1048576.3, 0, -1048576), Vec3d(1048576, 0.6, -1048576)});
    for (const Vec3& p : g.positions) EXPECT_LT(p.length(), 10);
    EXPECT_NEAR(area(g.corners(0)), 0.5 * 0.3 * 0.6, 1e-6);
}

TEST(ReadGeometry, GltfMaterials) {
    const auto read_material = [](const std::string& json) {
        return read_gltf(
            gltf(R"({"mesh":0})", 1, json, R"(,"extensionsUsed":["KHR_materials_transmission"])"));
    };
    const GeometryFile matte = read_material(
        R"({"name":"m","pbrMetallicRoughness":{"baseColorFactor":[0.1,0.2,0.3,1],"metallicFactor":0}})");
    EXPECT_EQ(material_named(matte, "m").diffuse, Rgb(0.1f, 0.2f, 0.3f));
    EXPECT_EQ(material_named(matte, "m").specular, Rgb(0));
    const GeometryFile metal = read_material(
        R"({"name":"m","pbrMetallicRoughness":{"baseColorFactor":[0.8,0.4,0.2,1],"metallicFactor":0.25,"roughnessFactor":0}})");
    EXPECT_NEAR((material_named(metal, "m").diffuse - Rgb(0.6f, 0.3f, 0.15f)).length(), 0, 1e-6);
    EXPECT_NEAR((material_named(metal, "m").specular - Rgb(0.2f, 0.1f, 0.05f)).length(), 0, 1e-6);
    const GeometryFile glass = read_material(
        R"({"name":"m","pbrMetallicRoughness":{"metallicFactor":0},"extensions":{"KHR_materials_transmission":{"transmissionFactor":1}}})");
    EXPECT_TRUE(material_named(glass, "m").glass);
}

TEST(ReadGeometry, EmissiveSurfacesAreNamedWithTheLampInTheirPlace) {
    const GeometryFile file =
        read_gltf(gltf(R"({"mesh":0})", 1, R"({"name":"panel","emissiveFactor":[1,1,0.5]})"));
    EXPECT_TRUE(any_warning(file, "panel"));
    EXPECT_TRUE(any_warning(file, "[[light]]"));
    EXPECT_TRUE(any_warning(file, "normal = [0, 0, 1]"));
    // pi × radiance × area 1
    EXPECT_TRUE(any_warning(file, "power = [3.14159, 3.14159, 1.5708]"));
}

TEST(ReadGeometry, PunctualLampsInCandela) {  // 4 pi I / 683 W
    const std::string lamp =
        R"({"mesh":0},{"name":"bulb","translation":[1,2,3],"extensions":{"KHR_lights_punctual":{"light":0}}})";
    const std::string more =
        R"(,"extensionsUsed":["KHR_lights_punctual"],"extensions":{"KHR_lights_punctual":{"lights":[)"
        R"({"type":"point","name":"bulb","intensity":683,"color":[1,0.5,0.25]}]}})";
    const GeometryFile file = read_gltf(gltf(lamp, 2, "{}", more), 0.5);
    ASSERT_EQ(file.lights.size(), 1u);
    const Light& light = file.lights[0];
    EXPECT_EQ(light.name, "bulb");
    EXPECT_NEAR(light.power.x, 4 * M_PI, 1e-5);
    EXPECT_NEAR(light.power.y, 2 * M_PI, 1e-5);
    EXPECT_NEAR(light.power.z, M_PI, 1e-5);
    EXPECT_EQ(light.position, Vec3(0.5f, 1, 1.5f));
    EXPECT_EQ(light.domain.min, light.domain.max);
    EXPECT_TRUE(any_warning(file, "bulb"));
}

TEST(ReadGeometry, OtherPunctualLampsAreNamed) {
    const std::string lamp = R"({"mesh":0},{"name":"sun","extensions":{"KHR_lights_punctual":{"light":0}}})";
    const std::string more =
        R"(,"extensionsUsed":["KHR_lights_punctual"],"extensions":{"KHR_lights_punctual":{"lights":[)"
        R"({"type":"directional","name":"sun","intensity":3}]}})";
    const GeometryFile file = read_gltf(gltf(lamp, 2, "{}", more));
    EXPECT_TRUE(file.lights.empty());
    EXPECT_TRUE(any_warning(file, "sun"));
}

}  // namespace
}  // namespace pim
