// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/geometry_file.h"

#include <ImathMatrix.h>
#include <assimp/GltfMaterial.h>
#include <assimp/ObjMaterial.h>
#include <assimp/commonMetaData.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <assimp/Importer.hpp>
#include <cctype>
#include <cmath>
#include <map>
#include <set>
#include <string_view>

#include "common/core/error.h"
#include "common/scene/emitters.h"
#include "common/scene/gltf_lights.h"

namespace pim {
namespace {

namespace fs = std::filesystem;
using Imath::M44d;

// Metals rougher than this scatter like paint; only smoother ones are taken as mirrors.
constexpr float kRoughestMirror = 0.3f;
constexpr std::size_t kMostSuggestions = 8;  // lamps in place of one shining material

M44d to_row_vectors(const aiMatrix4x4& m) {
    return M44d(m.a1, m.b1, m.c1, m.d1, m.a2, m.b2, m.c2, m.d2, m.a3, m.b3, m.c3, m.d3, m.a4, m.b4, m.c4,
                m.d4);
}

Vec3d to_vector(const aiVector3D& v) { return {v.x, v.y, v.z}; }
Rgb to_rgb(const aiColor3D& c) { return {c.r, c.g, c.b}; }

Rgb not_negative(Rgb c) {
    for (int i = 0; i < 3; ++i) c[i] = std::isfinite(c[i]) ? std::max(c[i], 0.0f) : 0.0f;
    return c;
}

class Reader {
  public:
    Reader(const fs::path& path, double metres_per_unit) : path_(path), scale_(metres_per_unit) {}

    GeometryFile read() {
        importer_.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
        source_ = importer_.ReadFile(path_.string(), aiProcess_Triangulate | aiProcess_SortByPType);
        // Joining takes a vertex that is no number for any other; left alone, mend() finds its triangles.
        if (source_ && all_finite()) source_ = importer_.ApplyPostProcessing(aiProcess_JoinIdenticalVertices);
        if (!source_ || !source_->mRootNode)
            throw Error(fmt::format("{}: the geometry cannot be read: {}", path_.string(),
                                    importer_.GetErrorString()));
        used_.resize(source_->mNumMaterials);
        for (unsigned i = 0; i < source_->mNumMeshes; ++i) used_[source_->mMeshes[i]->mMaterialIndex] = true;
        for (unsigned i = 0; i < source_->mNumMaterials; ++i) add_material(*source_->mMaterials[i], i);
        M44d root;
        root.setScale(scale_);
        add_node(*source_->mRootNode, root);
        if (file_.geometry.triangles.empty())
            throw Error(fmt::format("{}: holds no triangles; is it the right file?", path_.string()));
        choose_origin();
        add_lights();
        warn_of_emitters();  // after the lamps, whose names it must not take
        return std::move(file_);
    }

  private:
    bool all_finite() const {
        for (unsigned m = 0; m < source_->mNumMeshes; ++m)
            for (unsigned v = 0; v < source_->mMeshes[m]->mNumVertices; ++v) {
                const aiVector3D& p = source_->mMeshes[m]->mVertices[v];
                if (!std::isfinite(p.x + p.y + p.z)) return false;
            }
        return true;
    }

    // --- materials ---
    void add_material(const aiMaterial& source, unsigned index) {
        Material& material = file_.materials.emplace_back();
        emission_.emplace_back(0);
        if (!used_[index]) return;
        material.name = source.GetName().length ? source.GetName().C_Str() : fmt::format("material{}", index);
        aiColor3D color;
        if (source.Get(AI_MATKEY_BASE_COLOR, color) == AI_SUCCESS) {
            read_metallic_roughness(source, to_rgb(color), material);
        } else {
            read_phong(source, material);
        }
        read_texture(source, material);
        limit_reflectance(material);
        if (source.Get(AI_MATKEY_COLOR_EMISSIVE, color) == AI_SUCCESS)
            emission_.back() = not_negative(to_rgb(color));
    }

    void read_metallic_roughness(const aiMaterial& source, const Rgb& base, Material& material) {
        float metallic = 0, roughness = 1, transmission = 0;
        source.Get(AI_MATKEY_METALLIC_FACTOR, metallic);
        source.Get(AI_MATKEY_ROUGHNESS_FACTOR, roughness);
        source.Get(AI_MATKEY_TRANSMISSION_FACTOR, transmission);
        if (metallic > 0 && roughness > kRoughestMirror) {
            file_.warnings.push_back(
                fmt::format("material '{}': rough metal is taken as diffuse", material.name));
            metallic = 0;
        }
        material.diffuse = base * (1 - metallic);
        material.specular = base * metallic;
        material.glass = transmission > 0.5f;
        read_ior(source, material);
    }

    // OBJ: `illum` 3, 5 and 8 reflect like mirrors, 4, 6, 7 and 9 are glass; Ks of the others is a highlight.
    void read_phong(const aiMaterial& source, Material& material) {
        aiColor3D diffuse(0.5f, 0.5f, 0.5f), specular(0, 0, 0);
        int illum = 0;
        source.Get(AI_MATKEY_COLOR_DIFFUSE, diffuse);
        source.Get(AI_MATKEY_COLOR_SPECULAR, specular);
        source.Get(AI_MATKEY_OBJ_ILLUM, illum);
        material.diffuse = to_rgb(diffuse);
        if (illum == 3 || illum == 5 || illum == 8) material.specular = to_rgb(specular);
        material.glass = illum == 4 || illum == 6 || illum == 7 || illum == 9;
        read_ior(source, material);
    }

    void read_ior(const aiMaterial& source, Material& material) {
        float ior = 0;
        if (source.Get(AI_MATKEY_REFRACTI, ior) == AI_SUCCESS && ior > 1) material.ior = ior;
    }

    void limit_reflectance(Material& material) {
        material.diffuse = not_negative(material.diffuse);
        material.specular = not_negative(material.specular);
        const float most = max_channel(material.diffuse + material.specular);
        if (most <= 1) return;
        file_.warnings.push_back(fmt::format(
            "material '{}': reflects {:.3g} times what it receives; scaled to 1", material.name, most));
        material.diffuse /= most;
        material.specular /= most;
    }

    void read_texture(const aiMaterial& source, Material& material) {
        aiString name;
        if (source.GetTexture(aiTextureType_BASE_COLOR, 0, &name) != AI_SUCCESS &&
            source.GetTexture(aiTextureType_DIFFUSE, 0, &name) != AI_SUCCESS)
            return;
        const auto [known, is_new] = texture_index_.try_emplace(name.C_Str(), int(file_.textures.size()));
        if (is_new) file_.textures.push_back(load_texture(name.C_Str(), material.name));
        material.texture = known->second;
        // The base colour is a metal's reflectance; OBJ's map_Kd leaves Ks alone.
        aiColor3D base;
        material.texture_tints_specular =
            source.Get(AI_MATKEY_BASE_COLOR, base) == AI_SUCCESS && !is_black(material.specular);
    }

    Image load_texture(const std::string& name, const std::string& material) {
        if (const aiTexture* embedded = source_->GetEmbeddedTexture(name.c_str()))
            return decode(*embedded, name);
        std::string portable = name;
        std::ranges::replace(portable, '\\', '/');
        const fs::path file = path_.parent_path() / portable;
        if (!fs::exists(file))
            throw Error(
                fmt::format("{}: the texture {} of material '{}' does not exist; put it there or remove it "
                            "from the material",
                            path_.string(), file.string(), material));
        return read_image(file);
    }

    Image decode(const aiTexture& embedded, const std::string& name) {
        if (embedded.mHeight == 0)
            return read_image(embedded.pcData, embedded.mWidth,
                              fmt::format("{}: texture {}", path_.string(), name));
        Image image(int(embedded.mWidth), int(embedded.mHeight));
        for (std::size_t i = 0; i < image.pixels.size(); ++i) {
            const aiTexel& t = embedded.pcData[i];
            image.pixels[i] = {srgb_decode(t.r / 255.0f), srgb_decode(t.g / 255.0f),
                               srgb_decode(t.b / 255.0f)};
        }
        return image;
    }

    // --- geometry ---
    void add_node(const aiNode& node, const M44d& parent) {
        const M44d transform = to_row_vectors(node.mTransformation) * parent;
        transforms_[node.mName.C_Str()] = transform;
        for (unsigned i = 0; i < node.mNumMeshes; ++i)
            add_mesh(*source_->mMeshes[node.mMeshes[i]], node, transform);
        for (unsigned i = 0; i < node.mNumChildren; ++i) add_node(*node.mChildren[i], transform);
    }

    void add_mesh(const aiMesh& mesh, const aiNode& node, const M44d& transform) {
        Geometry& g = file_.geometry;
        const auto first = uint32_t(positions_.size());
        const M44d normal_transform = transform.inverse().transposed();
        for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
            positions_.push_back(to_vector(mesh.mVertices[i]) * transform);
            Vec3d normal(0);
            if (mesh.HasNormals()) normal_transform.multDirMatrix(to_vector(mesh.mNormals[i]), normal);
            g.normals.push_back(Vec3(normal.normalized()));
            const aiVector3D uv = mesh.HasTextureCoords(0) ? mesh.mTextureCoords[0][i] : aiVector3D();
            g.texture_coordinates.push_back({uv.x, uv.y});
        }
        const bool mirrored = transform.determinant() < 0;
        const auto object = uint32_t(g.objects.size());
        g.objects.push_back(node.mName.length ? node.mName.C_Str() : mesh.mName.C_Str());
        for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
            const unsigned* v = mesh.mFaces[i].mIndices;
            std::array<uint32_t, 3> vertices{first + v[0], first + v[1], first + v[2]};
            if (mirrored) std::swap(vertices[1], vertices[2]);
            g.triangles.push_back({vertices, mesh.mMaterialIndex, object});
        }
    }

    // Far from the world's origin, positions are kept relative to the middle of the scene, rounded to whole
    // powers of two so that shifting costs no bits.
    void choose_origin() {
        Box3d box;
        for (const Vec3d& p : positions_)
            if (std::isfinite(p.x + p.y + p.z)) box.extendBy(p);
        const double extent = (box.max - box.min).length();
        const Vec3d centre = box.center();
        if (extent > 0 && std::isfinite(extent) && centre.length() > 16 * extent) {
            const double unit = std::exp2(std::floor(std::log2(extent)));
            for (int axis = 0; axis < 3; ++axis)
                file_.geometry.origin[axis] = std::round(centre[axis] / unit) * unit;
        }
        for (const Vec3d& p : positions_) file_.geometry.positions.push_back(file_.geometry.to_local(p));
    }

    // --- lamps ---
    bool is_gltf() const {
        aiString format;
        return source_->mMetaData && source_->mMetaData->Get(AI_METADATA_SOURCE_FORMAT, format) &&
               std::string_view(format.C_Str()) == "glTF2 Importer";
    }

    void add_lights() {
        if (is_gltf()) {
            for (const GltfLight& light : read_gltf_lights(path_))
                add_light(light.name, light.type == "point", light.intensity, light.position * scale_);
            return;
        }
        for (unsigned i = 0; i < source_->mNumLights; ++i) {
            const aiLight& light = *source_->mLights[i];
            add_light(light.mName.C_Str(), light.mType == aiLightSource_POINT, to_rgb(light.mColorDiffuse),
                      to_vector(light.mPosition) * transforms_[light.mName.C_Str()]);
        }
    }

    void add_light(const std::string& name, bool is_point, const Rgb& intensity, const Vec3d& position) {
        if (!is_point) {
            file_.warnings.push_back(fmt::format(
                "lamp '{}' of the file is no point lamp and is left out: only point and rectangle lamps "
                "exist",
                name));
            return;
        }
        Light light;
        light.name = unused_name(name);
        light.power = intensity * float(4 * kPi / kLumensPerWatt);  // 4 pi I / 683
        light.position = file_.geometry.to_local(position);
        light.domain = Box3(light.position);
        light.samples = 1;
        file_.lights.push_back(light);
        file_.warnings.push_back(fmt::format("lamp '{}' of the file: candela taken as {:.4g} {:.4g} {:.4g} W",
                                             light.name, light.power.x, light.power.y, light.power.z));
    }

    // Names of lamps become names of grids and files: no slashes, and no name twice.
    std::string unused_name(std::string name) {
        std::ranges::replace_if(
            name, [](unsigned char c) { return c == '/' || std::iscntrl(c); }, '_');
        std::string unused = name;
        for (int k = 2; !lamp_names_.insert(unused).second; ++k) unused = fmt::format("{}_{}", name, k);
        return unused;
    }

    // --- shining surfaces ---
    void warn_of_emitters() {
        for (std::size_t m = 0; m < emission_.size(); ++m) {
            if (is_black(emission_[m])) continue;
            std::vector<std::array<Vec3d, 3>> triangles;
            for (const Triangle& t : file_.geometry.triangles)
                if (t.material == m)
                    triangles.push_back(
                        {positions_[t.vertices[0]], positions_[t.vertices[1]], positions_[t.vertices[2]]});
            warn_of_emitters(file_.materials[m].name, emission_[m], find_emitters(triangles));
        }
    }

    void warn_of_emitters(const std::string& material, const Rgb& radiance,
                          const std::vector<Emitter>& emitters) {
        if (emitters.empty()) return;
        const std::size_t shown = std::min(emitters.size(), kMostSuggestions);
        std::string places, what = "it";
        if (emitters.size() > 1) places = fmt::format(" in {} places", emitters.size());
        if (shown < emitters.size())
            what =
                fmt::format("the {} most powerful ({} more are not listed)", shown, emitters.size() - shown);
        std::string text = fmt::format(
            "material '{}' shines{}, but surfaces are not lamps here; to light the scene with {}, add",
            material, places, what);
        for (std::size_t i = 0; i < shown; ++i)
            text.append("\n").append(light_lines(emitters[i], radiance, unused_name(material)));
        file_.warnings.push_back(text);
    }

    fs::path path_;
    double scale_;
    Assimp::Importer importer_;
    const aiScene* source_ = nullptr;
    GeometryFile file_;
    std::vector<Vec3d> positions_;  // world, m
    std::vector<Rgb> emission_;     // per material, W/(m² sr)
    std::vector<bool> used_;        // per material: importers add some of their own
    std::map<std::string, int> texture_index_;
    std::map<std::string, M44d> transforms_;
    std::set<std::string> lamp_names_;  // taken, by lamps of the file or suggested ones
};

}  // namespace

GeometryFile read_geometry(const fs::path& path, double metres_per_unit) {
    if (!fs::is_regular_file(path))
        throw Error(
            fmt::format("{}: the geometry file does not exist; mend [scene] geometry", path.string()));
    return Reader(path, metres_per_unit).read();
}

}  // namespace pim
