// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/geometry_file.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "common/core/error.h"
#include "common/core/log.h"
#include "common/scene/scene_file.h"
#include "common/transport/surface.h"
#include "base64.h"
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
    EXPECT_TRUE(any_warning(file, "power = [3.14159265, 3.14159265, 1.57079633]"));
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

const std::string kTwoBulbs =
    R"(,"extensionsUsed":["KHR_lights_punctual"],"extensions":{"KHR_lights_punctual":{"lights":[)"
    R"({"type":"point","name":"bulb","intensity":683},{"type":"point","name":"other"}]}})";

std::string lamp_node(const std::string& name, int light, const std::string& translation) {
    return R"({"name":")" + name + R"(","translation":)" + translation +
           R"(,"extensions":{"KHR_lights_punctual":{"light":)" + std::to_string(light) + "}}}";
}

TEST(ReadGeometry, ALampSharedByNodesShinesAtEachOfThem) {
    const std::string nodes = R"({"mesh":0,"children":[1,2]},)" + lamp_node("left", 0, "[-1,0,3]") + "," +
                              lamp_node("right", 0, "[1,0,3]");
    const GeometryFile file = read_gltf(gltf(nodes, 1, "{}", kTwoBulbs), 0.5);
    ASSERT_EQ(file.lights.size(), 2u);
    EXPECT_EQ(file.lights[0].name, "left");
    EXPECT_EQ(file.lights[0].position, Vec3(-0.5f, 0, 1.5f));
    EXPECT_EQ(file.lights[1].name, "right");
    EXPECT_EQ(file.lights[1].position, Vec3(0.5f, 0, 1.5f));
    EXPECT_NEAR(file.lights[1].power.x, 4 * M_PI, 1e-5);
}

TEST(ReadGeometry, LampsOnNodesOfOneNameStandWhereTheirNodesDo) {
    const std::string nodes = R"({"mesh":0,"children":[1,2,3]},)" + lamp_node("same", 0, "[1,0,0]") + "," +
                              lamp_node("same", 0, "[2,0,0]") + "," + lamp_node("same", 1, "[3,0,0]");
    const GeometryFile file = read_gltf(gltf(nodes, 1, "{}", kTwoBulbs));
    ASSERT_EQ(file.lights.size(), 3u);
    const char* const names[] = {"bulb", "bulb_2", "other"};
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(file.lights[i].name, names[i]);
        EXPECT_EQ(file.lights[i].position, Vec3(float(i + 1), 0, 0));
    }
}

TEST(ReadGeometry, LampsOfABinaryFile) {
    std::string text = gltf(R"({"mesh":0},)" + lamp_node("bulb", 0, "[1,2,3]"), 2, "{}", kTwoBulbs);
    const auto uri = text.find(R"(,"uri")");
    text.erase(uri, text.find('}', uri) - uri);  // the numbers are in the second chunk
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const auto word = [](std::size_t n) {
        const auto value = uint32_t(n);
        return std::string(reinterpret_cast<const char*>(&value), 4);
    };
    const float corners[] = {0, 0, 0, 1, 0, 0, 0, 2, 0};
    const std::string numbers(reinterpret_cast<const char*>(corners), sizeof corners);
    const TemporaryFolder folder;
    const auto path =
        folder.write("a.glb", "glTF" + word(2) + word(28 + text.size() + numbers.size()) + word(text.size()) +
                                  "JSON" + text + word(numbers.size()) + std::string("BIN\0", 4) + numbers);
    const GeometryFile file = read_geometry(path, 1);
    ASSERT_EQ(file.lights.size(), 1u);
    EXPECT_EQ(file.lights[0].position, Vec3(1, 2, 3));
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

// --- shining surfaces ---

std::string quad(const Vec3& corner, const Vec3& u, const Vec3& v) {
    std::string text;
    for (const Vec3& p : {corner, corner + u, corner + u + v, corner + v})
        text += fmt::format("v {} {} {}\n", p.x, p.y, p.z);
    return text + "f -4 -3 -2 -1\n";
}

// The scene with everything that the warning about `material` tells to add, as a user would paste it.
Scene with_suggested_lamps(const std::string& obj, const std::string& material) {
    set_log_level("error");
    const TemporaryFolder folder;
    folder.write("a.mtl", "newmtl " + material + "\nKd 0 0 0\nKe 2 1 0\n");
    folder.write("a.obj", "mtllib a.mtl\nusemtl " + material + "\n" + obj);
    std::string text = "[scene]\ngeometry = \"a.obj\"\n";
    for (const std::string& warning : read_geometry(folder / "a.obj", 1).warnings)
        if (const auto lines = warning.find('\n'); lines != std::string::npos) text += warning.substr(lines);
    return read_scene_text(text, "test.toml", folder.path());
}

void expect_near(const Vec3& found, const Vec3& expected, double rounding = 1e-5) {
    EXPECT_NEAR((found - expected).length(), 0, rounding) << found << " " << expected;
}

TEST(ReadGeometry, SeparatePanelsOfOneMaterialAreSeparateLamps) {
    const Scene scene = with_suggested_lamps(
        quad({0, 3, 0}, {2, 0, 0}, {0, 0, 0.5f}) + quad({10, 0, 0}, {0, 1, 0}, {0, 0, 1}), "glow");
    ASSERT_EQ(scene.lights.size(), 2u);
    const Light &ceiling = scene.lights[0], &wall = scene.lights[1];  // by power
    ASSERT_TRUE(ceiling.rectangle());
    ASSERT_TRUE(wall.rectangle());
    EXPECT_EQ(ceiling.name, "glow");
    EXPECT_EQ(wall.name, "glow_2");
    EXPECT_EQ(ceiling.rectangle()->normal, Vec3(0, -1, 0));
    EXPECT_EQ(wall.rectangle()->normal, Vec3(1, 0, 0));
    expect_near(ceiling.position, {1, 3 - 1e-3f, 0.25f});
    expect_near(wall.position, {10 + 1e-3f, 0.5f, 0.5f});
    const Vec3 extent = ceiling.rectangle()->axes[0] * ceiling.rectangle()->size.x +
                        ceiling.rectangle()->axes[1] * ceiling.rectangle()->size.y;
    expect_near({std::abs(extent.x), extent.y, std::abs(extent.z)}, {2, 0, 0.5f});
    expect_near({wall.rectangle()->size.x, wall.rectangle()->size.y, 0}, {1, 1, 0});
    for (const Light& light : scene.lights) expect_near(light.power, Rgb(2, 1, 0) * float(M_PI));
}

std::string cube() {
    return quad({0, 0, 0}, {0, 1, 0}, {1, 0, 0}) + quad({0, 0, 1}, {1, 0, 0}, {0, 1, 0}) +
           quad({0, 0, 0}, {0, 0, 1}, {0, 1, 0}) + quad({1, 0, 0}, {0, 1, 0}, {0, 0, 1}) +
           quad({0, 0, 0}, {1, 0, 0}, {0, 0, 1}) + quad({0, 1, 0}, {0, 0, 1}, {1, 0, 0});
}

TEST(ReadGeometry, AClosedShiningBodyIsAPointLamp) {
    const Scene scene = with_suggested_lamps(cube(), "glow");
    ASSERT_EQ(scene.lights.size(), 1u);
    EXPECT_FALSE(scene.lights[0].rectangle());
    expect_near(scene.lights[0].position, Vec3(0.5f));
    expect_near(scene.lights[0].power, Rgb(12, 6, 0) * float(M_PI));
}

TEST(ReadGeometry, SuggestedNamesAreTomlAndNoPaths) {
    const Scene scene = with_suggested_lamps(quad({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), R"(a/"b"\c)");
    ASSERT_EQ(scene.lights.size(), 1u);
    EXPECT_EQ(scene.lights[0].name, R"(a_"b"\c)");
}

TEST(ReadGeometry, OfManyShiningPlacesTheStrongestAreListed) {
    std::string panels;
    for (int i = 1; i <= 11; ++i) panels += quad({20.0f * float(i), 0, 0}, {float(i), 0, 0}, {0, 1, 0});
    const Scene scene = with_suggested_lamps(panels, "glow");
    ASSERT_EQ(scene.lights.size(), 8u);
    for (std::size_t i = 0; i < 8; ++i) EXPECT_NEAR(scene.lights[i].power.x, 2 * M_PI * double(11 - i), 1e-4);
}

TEST(ReadGeometry, SuggestedLampsDoNotTakeTheNamesOfLamps) {
    const std::string lamp = R"({"mesh":0},{"name":"glow","extensions":{"KHR_lights_punctual":{"light":0}}})";
    const std::string more =
        R"(,"extensionsUsed":["KHR_lights_punctual"],"extensions":{"KHR_lights_punctual":{"lights":[)"
        R"({"type":"point"}]}})";
    const GeometryFile file = read_gltf(gltf(lamp, 2, R"({"name":"glow","emissiveFactor":[1,1,1]})", more));
    ASSERT_EQ(file.lights.size(), 1u);
    EXPECT_EQ(file.lights[0].name, "glow");
    EXPECT_TRUE(any_warning(file, "name = \"glow_2\""));
}

// --- textures of metals ---

// In 8 bits of sRGB without loss.
const Rgb kTexel(srgb_decode(200 / 255.0f), srgb_decode(100 / 255.0f), srgb_decode(50 / 255.0f));

// The triangle with a picture of one colour.
Scene textured(const TemporaryFolder& folder, const std::string& pbr, const std::string& more = "") {
    set_log_level("error");
    Image picture(2, 2);
    picture.pixels.assign(4, kTexel);
    write_image(folder / "t.png", picture, 1);
    std::string text =
        gltf(R"({"mesh":0})", 1,
             R"({"name":"m","pbrMetallicRoughness":{"baseColorTexture":{"index":0},)" + pbr + "}}",
             R"(,"textures":[{"source":0}],"images":[{"uri":"t.png"}])");
    const std::string plain = R"("POSITION":0)";
    text.replace(text.find(plain), plain.size(), R"("POSITION":0,"TEXCOORD_0":1)");
    const std::string accessor = R"(],"bufferViews")";
    text.replace(text.find(accessor), accessor.size(),
                 R"(,{"bufferView":0,"componentType":5126,"count":3,"type":"VEC2"}],"bufferViews")");
    folder.write("a.gltf", text);
    return read_scene_text(
        "[scene]\ngeometry = \"a.gltf\"\n[[light]]\nname = \"l\"\nposition = [0,0,1]\n" + more, "test.toml",
        folder.path());
}

TEST(ReadGeometry, BaseColourTexturesTintMetals) {
    const TemporaryFolder folder;
    const auto at = [&](const std::string& pbr, const std::string& more = "") {
        const Scene scene = textured(folder, pbr, more);
        const SurfacePoint surface = surface_at(scene, {0, 1, 0.25f, 0.5f, Side::front});
        return std::pair(surface.diffuse, surface.specular);
    };
    const std::string smooth = R"("roughnessFactor":0,"metallicFactor":)";
    const std::string mirror = "[[material]]\nname = \"m\"\nkind = \"mirror\"\n";
    const Rgb texel = kTexel;
    const auto metal = at(smooth + "1"), half = at(smooth + "0.5"), paint = at(smooth + "0");
    expect_near(metal.first, Rgb(0));
    expect_near(metal.second, texel);
    expect_near(half.first, texel / 2);
    expect_near(half.second, texel / 2);
    expect_near(paint.first, texel);
    expect_near(paint.second, Rgb(0));
    expect_near(at(smooth + "0", mirror).second, texel);  // paint turned mirror keeps its picture
    expect_near(at(smooth + "1", mirror).second, texel);
    const auto plain = at(smooth + "1", "[[material]]\nname = \"m\"\nspecular = [0.5, 0.6, 0.7]\n");
    expect_near(plain.second, {0.5f, 0.6f, 0.7f});
}

TEST(ReadGeometry, TintedMetalsAreNotGreyAndHashedAsSuch) {
    const TemporaryFolder folder;
    Scene scene = textured(folder, R"("roughnessFactor":0,"metallicFactor":1)");
    EXPECT_FALSE(is_grey(scene));
    const std::string tinted = content_hash(scene);
    scene.materials[scene.geometry.triangles[0].material].texture_tints_specular = false;
    EXPECT_TRUE(is_grey(scene));  // the diffuse part is black
    EXPECT_NE(content_hash(scene), tinted);
}

TEST(ReadGeometry, DiffuseTexturesOfAnObjLeaveItsMirrorAlone) {
    const TemporaryFolder folder;
    write_image(folder / "t.png", Image(1, 1), 1);
    const GeometryFile file =
        read_obj(folder, "newmtl m\nKd 0.5 0.5 0.5\nKs 0.5 0.4 0.3\nillum 3\nmap_Kd t.png\n", {"m"});
    EXPECT_TRUE(material_named(file, "m").texture);
    EXPECT_FALSE(material_named(file, "m").texture_tints_specular);
}

}  // namespace
}  // namespace pim
