// SPDX-License-Identifier: Apache-2.0
#include "framework/io/gltf.hpp"

#include "framework/io/gltf_accessor.hpp"
#include "framework/io/gltf_file.hpp"
#include "framework/io/gltf_uri.hpp"
#include "framework/io/texture_image.hpp"

#include <glm/gtc/quaternion.hpp>
#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <new>
#include <optional>
#include <span>
#include <string_view>

namespace ockham {
namespace {

namespace fs = std::filesystem;

/// Vertices and indices of one file, summed over its primitives, which may share accessors or have
/// no data: a small file could otherwise fill the memory.
constexpr std::size_t kMaxElements = std::size_t{1} << 28;
constexpr std::size_t kElementsOfAnyFile = std::size_t{1} << 22;
constexpr std::size_t kElementsPerByte = 64;

tinygltf::Model parse(const GltfFile& file, const GltfFindings& findings) {
    tinygltf::TinyGLTF parser;
    // What it could read from disk has been taken out of the JSON.
    parser.SetFsCallbacks({[](const std::string&, void*) { return false; },
        [](const std::string& path, void*) { return path; },
        [](std::vector<unsigned char>*, std::string*, const std::string&, void*) { return false; },
        nullptr, nullptr});
    parser.SetImageLoader([](tinygltf::Image*, const int, std::string*, std::string*, int, int,
                              const unsigned char*, int, void*) { return false; },
        nullptr);
    tinygltf::Model model;
    std::string error, warning;
    const bool loaded = parser.LoadASCIIFromString(&model, &error, &warning, file.json.data(),
        static_cast<unsigned int>(file.json.size()), "");
    if (!loaded || !error.empty()) {
        findings.fatal("{}", error.substr(0, std::min<std::size_t>(error.find('\n'), 160)));
    }
    return model;
}

const tinygltf::Value* extension(const tinygltf::ExtensionMap& extensions, const char* name) {
    const auto found = extensions.find(name);
    return found == extensions.end() ? nullptr : &found->second;
}

float number(const tinygltf::Value& object, const char* key, float fallback) {
    return object.Has(key) ? static_cast<float>(object.Get(key).GetNumberAsDouble()) : fallback;
}

glm::vec2 vector2(const tinygltf::Value& object, const char* key, glm::vec2 fallback) {
    if (!object.Has(key)) return fallback;
    const tinygltf::Value& value = object.Get(key);
    return {static_cast<float>(value.Get(0).GetNumberAsDouble()),
        static_cast<float>(value.Get(1).GetNumberAsDouble())};
}

glm::vec3 vector3(const std::vector<double>& values, glm::vec3 fallback) {
    return values.size() == 3 ? glm::vec3(values[0], values[1], values[2]) : fallback;
}

bool finite(glm::vec3 v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

/// Where a matrix takes the corners of a box, they are finite.
bool finite(const glm::mat4& matrix, const Bounds& box) {
    for (int corner = 0; corner < 8; ++corner) {
        const glm::vec3 point(corner & 1 ? box.high.x : box.low.x,
            corner & 2 ? box.high.y : box.low.y, corner & 4 ? box.high.z : box.low.z);
        if (!finite(glm::vec3(matrix * glm::vec4(point, 1.0f)))) return false;
    }
    return true;
}

/// To the accuracy that glTF files have: normals are often stored in 8 bits.
bool is_unit(glm::vec3 v) { return std::abs(glm::length(v) - 1.0f) < 0.00674f; }

/// Turns one checked model into a Scene.
class GltfConverter {
public:
    GltfConverter(const tinygltf::Model& model, const GltfFile& file, const fs::path& path,
        const GltfOptions& options, const GltfFindings& findings)
        : model_(model), file_(file), folder_(path.parent_path()), options_(options),
          findings_(findings), reader_(model, file, findings) {
        scene_.name = path.stem().string();
    }

    Scene convert() {
        refuse_too_many_elements();
        for (std::size_t i = 0; i < model_.materials.size(); ++i) add_material(i);
        for (std::size_t i = 0; i < model_.meshes.size(); ++i) add_mesh(i);
        place_nodes();
        return std::move(scene_);
    }

private:
    // Textures

    /// The decoded image, or -1 if it cannot be had. Each is decoded once.
    int image(int index) {
        const GltfImageSource& source = file_.images[index];
        const bool is_file = !source.uri.empty() && !source.uri.starts_with("data:");
        const std::string key = is_file ? source.uri : fmt::format("#{}", index);
        const auto known = images_.find(key);
        if (known != images_.end()) return known->second;
        int& result = images_[key] = -1;
        const std::string what = fmt::format("images[{}]", index);
        try {
            std::vector<std::byte> bytes;
            std::span<const std::byte> encoded;
            if (!source.uri.empty()) {
                bytes = read_gltf_uri(source.uri, folder_, options_.allow_external);
                encoded = bytes;
            } else if (source.buffer_view >= 0) {
                encoded = reader_.view(source.buffer_view);
            }
            TextureImage decoded = decode_texture(encoded);
            decoded.name = is_file ? source.uri : source.name.empty() ? what : source.name;
            result = static_cast<int>(scene_.images.size());
            scene_.images.push_back(std::move(decoded));
        } catch (const Error& error) {
            if (is_remote_gltf_uri(source.uri)) {
                findings_.note("{} is left out: {}", what, error.what());
            } else {
                findings_.tolerate("{} is left out: {}", what, error.what());
            }
        }
        return result;
    }

    static Wrap wrap(int mode) {
        if (mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return Wrap::clamp;
        if (mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT) return Wrap::mirror;
        return Wrap::repeat;
    }

    /// KHR_texture_transform: scale first, then rotation, then offset.
    static void set_transform(TextureUse& use, const tinygltf::Value& transform) {
        const glm::vec2 offset = vector2(transform, "offset", glm::vec2(0.0f));
        const glm::vec2 scale = vector2(transform, "scale", glm::vec2(1.0f));
        const float rotation = number(transform, "rotation", 0.0f);
        const float cosine = std::cos(rotation), sine = std::sin(rotation);
        use.transform_u = {cosine * scale.x, sine * scale.y, offset.x};
        use.transform_v = {-sine * scale.x, cosine * scale.y, offset.y};
    }

    template <class Info>
    TextureUse texture(const Info& info, const std::string& where) {
        TextureUse use;
        if (info.index < 0) return use;
        use.uv_set = info.texCoord;
        if (const auto* transform = extension(info.extensions, "KHR_texture_transform")) {
            set_transform(use, *transform);
            use.uv_set = static_cast<int>(number(*transform, "texCoord", float(use.uv_set)));
        }
        const tinygltf::Texture& source = model_.textures[info.index];
        if (source.sampler >= 0) {
            use.wrap_u = wrap(model_.samplers[source.sampler].wrapS);
            use.wrap_v = wrap(model_.samplers[source.sampler].wrapT);
        }
        if (use.uv_set > 1) {
            findings_.note(
                "{}: texture coordinate set {} is not supported, the texture is left out", where,
                use.uv_set);
        } else if (source.source < 0) {
            findings_.note("{}: textures[{}] has no image, it is left out", where, info.index);
        } else {
            use.image = image(source.source);
        }
        return use;
    }

    // Materials

    void add_material(std::size_t index) {
        const tinygltf::Material& source = model_.materials[index];
        const std::string where = fmt::format("materials[{}] '{}'", index, shortened(source.name));
        const auto& pbr = source.pbrMetallicRoughness;
        Material material;
        material.name = source.name;
        const std::vector<double>& base = pbr.baseColorFactor;
        material.base_color = glm::vec4(base[0], base[1], base[2], base[3]);
        material.base_color_texture = texture(pbr.baseColorTexture, where);
        material.metallic = static_cast<float>(pbr.metallicFactor);
        material.roughness = static_cast<float>(pbr.roughnessFactor);
        material.metallic_roughness_texture = texture(pbr.metallicRoughnessTexture, where);
        material.normal_texture = texture(source.normalTexture, where);
        material.normal_scale = static_cast<float>(source.normalTexture.scale);
        material.occlusion_texture = texture(source.occlusionTexture, where);
        material.occlusion_strength = static_cast<float>(source.occlusionTexture.strength);
        material.emissive = vector3(source.emissiveFactor, glm::vec3(0.0f));
        material.emissive_texture = texture(source.emissiveTexture, where);
        if (const auto* strength =
                extension(source.extensions, "KHR_materials_emissive_strength")) {
            material.emissive *= number(*strength, "emissiveStrength", 1.0f);
        }
        if (const auto* ior = extension(source.extensions, "KHR_materials_ior")) {
            material.ior = number(*ior, "ior", 1.5f);
        }
        material.unlit = source.extensions.contains("KHR_materials_unlit");
        material.double_sided = source.doubleSided;
        set_alpha(material, source, where);
        scene_.materials.push_back(std::move(material));
    }

    void set_alpha(Material& material, const tinygltf::Material& source, const std::string& where) {
        if (source.alphaMode == "MASK") {
            material.masked = true;
            material.alpha_cutoff = static_cast<float>(source.alphaCutoff);
        } else if (source.alphaMode == "BLEND") {
            findings_.note("{}: alpha mode BLEND is treated as MASK with cutoff 0.5", where);
            material.masked = true;
        } else if (source.alphaMode != "OPAQUE") {
            findings_.note("{}: unknown alpha mode is treated as OPAQUE", where);
        }
    }

    /// The material of primitives that have none: white, as glTF 2.0, 3.7.2.1 has it.
    int default_material() {
        if (default_material_ < 0) {
            default_material_ = static_cast<int>(scene_.materials.size());
            scene_.materials.emplace_back().name = "default";
        }
        return default_material_;
    }

    // Meshes

    void refuse_too_many_elements() const {
        std::size_t elements = 0;
        for (const tinygltf::Mesh& mesh : model_.meshes) {
            for (const tinygltf::Primitive& primitive : mesh.primitives) {
                const auto position = primitive.attributes.find("POSITION");
                if (position != primitive.attributes.end()) {
                    elements += model_.accessors[position->second].count;
                }
                if (primitive.indices >= 0) elements += model_.accessors[primitive.indices].count;
            }
        }
        std::size_t bytes = 0;
        for (const std::vector<std::byte>& buffer : file_.buffers) bytes += buffer.size();
        const std::size_t limit =
            std::min(kMaxElements, kElementsOfAnyFile + kElementsPerByte * bytes);
        if (elements > limit) {
            findings_.fatal("its primitives have {} vertices and indices, at most {} are accepted "
                            "of a file with {} bytes of data",
                elements, limit, bytes);
        }
    }

    enum ComponentTypes : unsigned {
        kFloat = 1,
        kUnsignedNormalized = 2,
        kSignedNormalized = 4,
        kAnyInteger = 8
    };

    /// What an attribute may be stored as; `quantized` adds KHR_mesh_quantization's.
    struct Format {
        std::array<int, 2> types;
        unsigned plain;
        unsigned quantized;
    };

    static unsigned component_types(const tinygltf::Accessor& accessor) {
        switch (accessor.componentType) {
        case TINYGLTF_COMPONENT_TYPE_FLOAT:
            return kFloat;
        case TINYGLTF_COMPONENT_TYPE_BYTE:
        case TINYGLTF_COMPONENT_TYPE_SHORT:
            return accessor.normalized ? kSignedNormalized | kAnyInteger : kAnyInteger;
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return accessor.normalized ? kUnsignedNormalized | kAnyInteger : kAnyInteger;
        default:
            return 0;
        }
    }

    /// The accessor of an attribute after checks of its format and length, or nothing.
    std::optional<int> attribute(const tinygltf::Primitive& source, const std::string& where,
        const char* name, const Format& format) const {
        const auto found = source.attributes.find(name);
        if (found == source.attributes.end()) return std::nullopt;
        const tinygltf::Accessor& accessor = reader_.accessor(found->second);
        const unsigned types = component_types(accessor);
        const bool known = std::find(format.types.begin(), format.types.end(), accessor.type) !=
                           format.types.end();
        if (!known || (types & (format.plain | format.quantized)) == 0) {
            findings_.fatal(
                "{}.attributes.{}: accessors[{}] has a format not allowed there (component "
                "type {}, {} components, {}normalized)",
                where, name, found->second, accessor.componentType,
                tinygltf::GetNumComponentsInType(accessor.type), accessor.normalized ? "" : "not ");
        }
        const auto& required = model_.extensionsRequired;
        if ((types & format.plain) == 0 && std::find(required.begin(), required.end(),
                                               "KHR_mesh_quantization") == required.end()) {
            findings_.tolerate("{}.attributes.{} is quantized, but the file does not require "
                               "KHR_mesh_quantization",
                where, name);
        }
        const auto position = source.attributes.find("POSITION");
        const std::size_t vertices = reader_.accessor(position->second).count;
        if (accessor.count != vertices) {
            findings_.fatal("{}.attributes.{}: accessors[{}] has {} elements, POSITION has {}",
                where, name, found->second, accessor.count, vertices);
        }
        return found->second;
    }

    void add_mesh(std::size_t index) {
        const tinygltf::Mesh& source = model_.meshes[index];
        Mesh mesh;
        mesh.name = source.name;
        for (std::size_t i = 0; i < source.primitives.size(); ++i) {
            const std::string where = fmt::format("meshes[{}].primitives[{}]", index, i);
            std::optional<Primitive> primitive = read_primitive(source.primitives[i], where);
            if (primitive) mesh.primitives.push_back(std::move(*primitive));
        }
        Bounds& bounds = mesh_bounds_.emplace_back();
        for (const Primitive& primitive : mesh.primitives) {
            for (const glm::vec3& position : primitive.positions) bounds.add(position);
        }
        scene_.meshes.push_back(std::move(mesh));
    }

    /// Why a valid primitive is not read, or null.
    const char* reason_to_skip(const tinygltf::Primitive& source) const {
        if (source.mode < TINYGLTF_MODE_TRIANGLES) return "it has points or lines";
        if (source.mode > TINYGLTF_MODE_TRIANGLE_FAN) return "its mode is unknown";
        if (!source.attributes.contains("POSITION")) return "it has no POSITION";
        constexpr const char* kNoData = "it lies in a buffer without data";
        if (source.indices >= 0 && !reader_.has_data(source.indices)) return kNoData;
        for (const char* name :
            {"POSITION", "NORMAL", "TANGENT", "TEXCOORD_0", "TEXCOORD_1", "COLOR_0"}) {
            const auto found = source.attributes.find(name);
            if (found != source.attributes.end() && !reader_.has_data(found->second))
                return kNoData;
        }
        return nullptr;
    }

    std::optional<Primitive> read_primitive(
        const tinygltf::Primitive& source, const std::string& where) {
        if (const char* reason = reason_to_skip(source)) {
            findings_.note("{} is left out: {}", where, reason);
            return std::nullopt;
        }
        if (!source.targets.empty() && !warned_morph_) {
            findings_.note("morph targets are ignored");
            warned_morph_ = true;
        }
        Primitive primitive;
        read_attributes(primitive, source, where);
        read_indices(primitive, source, where);
        complete(primitive, where);
        if (primitive.indices.empty()) return std::nullopt;
        return primitive;
    }

    void read_attributes(
        Primitive& primitive, const tinygltf::Primitive& source, const std::string& where) {
        const Format position{{TINYGLTF_TYPE_VEC3, TINYGLTF_TYPE_VEC3}, kFloat, kAnyInteger};
        const Format normal{{TINYGLTF_TYPE_VEC3, TINYGLTF_TYPE_VEC3}, kFloat, kSignedNormalized};
        const Format tangent{{TINYGLTF_TYPE_VEC4, TINYGLTF_TYPE_VEC4}, kFloat, kSignedNormalized};
        const Format uv{
            {TINYGLTF_TYPE_VEC2, TINYGLTF_TYPE_VEC2}, kFloat | kUnsignedNormalized, kAnyInteger};
        const Format color{
            {TINYGLTF_TYPE_VEC3, TINYGLTF_TYPE_VEC4}, kFloat | kUnsignedNormalized, 0};

        primitive.positions =
            reader_.floats<glm::vec3>(*attribute(source, where, "POSITION", position));
        refuse_not_finite(primitive.positions, where);
        // Directions that are all zero are as good as none.
        if (const auto found = attribute(source, where, "NORMAL", normal);
            found && !reader_.all_zero(*found)) {
            primitive.normals = reader_.floats<glm::vec3>(*found);
        }
        if (const auto found = attribute(source, where, "TANGENT", tangent);
            found && !reader_.all_zero(*found)) {
            primitive.tangents = reader_.floats<glm::vec4>(*found);
        }
        for (int set = 0; set < 2; ++set) {
            const char* name = set == 0 ? "TEXCOORD_0" : "TEXCOORD_1";
            if (const auto found = attribute(source, where, name, uv)) {
                primitive.uvs[set] = reader_.floats<glm::vec2>(*found);
                zero_not_finite(primitive.uvs[set], where, name);
            }
        }
        if (const auto found = attribute(source, where, "COLOR_0", color)) {
            if (reader_.accessor(*found).type == TINYGLTF_TYPE_VEC4) {
                primitive.colors = reader_.floats<glm::vec4>(*found);
            } else {
                for (const glm::vec3& rgb : reader_.floats<glm::vec3>(*found)) {
                    primitive.colors.emplace_back(rgb, 1.0f);
                }
            }
            clamp_colors(primitive.colors, where);
        }
        primitive.material = source.material >= 0 ? source.material : default_material();
    }

    void refuse_not_finite(
        const std::vector<glm::vec3>& positions, const std::string& where) const {
        for (std::size_t i = 0; i < positions.size(); ++i) {
            const glm::vec3& p = positions[i];
            if (finite(p)) continue;
            findings_.fatal(
                "{}.attributes.POSITION: vertex {} is ({}, {}, {}), expected finite numbers", where,
                i, p.x, p.y, p.z);
        }
    }

    void zero_not_finite(
        std::vector<glm::vec2>& uvs, const std::string& where, const char* name) const {
        std::size_t bad = 0;
        for (glm::vec2& uv : uvs) {
            if (std::isfinite(uv.x) && std::isfinite(uv.y)) continue;
            uv = glm::vec2(0.0f);
            ++bad;
        }
        if (bad != 0) {
            findings_.tolerate(
                "{}.attributes.{}: {} vertices are not finite, read as 0", where, name, bad);
        }
    }

    void clamp_colors(std::vector<glm::vec4>& colors, const std::string& where) const {
        std::size_t bad = 0;
        for (glm::vec4& color : colors) {
            for (int i = 0; i < 4; ++i) {
                if (color[i] >= 0.0f && color[i] <= 1.0f) continue;
                color[i] = color[i] > 1.0f ? 1.0f : 0.0f;
                ++bad;
            }
        }
        if (bad != 0) {
            findings_.tolerate(
                "{}.attributes.COLOR_0: {} components clamped to [0, 1]", where, bad);
        }
    }

    void read_indices(
        Primitive& primitive, const tinygltf::Primitive& source, const std::string& where) {
        const std::size_t vertices = primitive.positions.size();
        std::vector<std::uint32_t> list;
        if (source.indices >= 0) {
            const tinygltf::Accessor& accessor = reader_.accessor(source.indices);
            const bool is_unsigned =
                accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
                accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
                accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
            if (accessor.type != TINYGLTF_TYPE_SCALAR || !is_unsigned) {
                findings_.fatal(
                    "{}.indices: accessors[{}] has component type {} and {} components, "
                    "expected unsigned scalars",
                    where, source.indices, accessor.componentType,
                    tinygltf::GetNumComponentsInType(accessor.type));
            }
            list = reader_.integers(source.indices);
        } else {
            list.resize(vertices);
            for (std::size_t i = 0; i < vertices; ++i) list[i] = static_cast<std::uint32_t>(i);
        }
        for (std::size_t i = 0; i < list.size(); ++i) {
            if (list[i] >= vertices) {
                findings_.fatal("{}.indices: index {} is {}, but there are {} vertices", where, i,
                    list[i], vertices);
            }
        }
        to_triangles(primitive, std::move(list), source.mode, where);
        const std::size_t triangles = drop_degenerate_triangles(primitive);
        const std::size_t unused = drop_unused_vertices(primitive);
        if (triangles + unused != 0) {
            log::debug("{}: {} degenerate triangles and {} unused vertices dropped", where,
                triangles, unused);
        }
    }

    /// Lists, strips and fans to triangles: glTF 2.0, 3.7.2.1, which keeps the orientation.
    void to_triangles(Primitive& primitive, std::vector<std::uint32_t> list, int mode,
        const std::string& where) const {
        if (mode == TINYGLTF_MODE_TRIANGLES) {
            if (list.size() % 3 != 0) {
                findings_.note("{}: {} indices left over after the last triangle are ignored",
                    where, list.size() % 3);
                list.resize(list.size() - list.size() % 3);
            }
            primitive.indices = std::move(list);
            return;
        }
        if (list.size() < 3)
            findings_.note("{} has {} indices, too few for a triangle", where, list.size());
        for (std::size_t i = 0; i + 2 < list.size(); ++i) {
            if (mode == TINYGLTF_MODE_TRIANGLE_FAN) {
                primitive.indices.insert(
                    primitive.indices.end(), {list[i + 1], list[i + 2], list[0]});
            } else {
                const std::size_t odd = i % 2;
                primitive.indices.insert(
                    primitive.indices.end(), {list[i], list[i + 1 + odd], list[i + 2 - odd]});
            }
        }
    }

    /// Normals, tangents and texture coordinates that the material needs and the file lacks.
    void complete(Primitive& primitive, const std::string& where) {
        const Material& material = scene_.materials[primitive.material];
        for (const TextureUse* use : {&material.base_color_texture,
                 &material.metallic_roughness_texture, &material.normal_texture,
                 &material.occlusion_texture, &material.emissive_texture}) {
            if (!use->used() || !primitive.uvs[use->uv_set].empty()) continue;
            findings_.tolerate(
                "{} has no TEXCOORD_{}, which its material uses; read as 0", where, use->uv_set);
            primitive.uvs[use->uv_set].assign(primitive.positions.size(), glm::vec2(0.0f));
        }
        if (primitive.normals.empty()) {
            if (!primitive.tangents.empty()) {
                findings_.note("{} has TANGENT without NORMAL, it is ignored", where);
            }
            generate_flat_normals(primitive);
        } else {
            normalize_normals(primitive, where);
        }
        if (!material.normal_texture.used()) {
            primitive.tangents.clear();
        } else if (primitive.tangents.empty()) {
            generate_tangents(primitive, material.normal_texture.uv_set);
        } else {
            normalize_tangents(primitive, where);
        }
    }

    void normalize_normals(Primitive& primitive, const std::string& where) const {
        const auto count = std::count_if(primitive.normals.begin(), primitive.normals.end(),
            [](glm::vec3 normal) { return !is_unit(normal); });
        if (count != 0) {
            findings_.tolerate(
                "{}.attributes.NORMAL: {} vertices are not of unit length", where, count);
        }
        const std::size_t bad = repair_normals(primitive);
        if (bad != 0) {
            findings_.tolerate("{}.attributes.NORMAL: {} vertices have no direction, taken from "
                               "their triangles",
                where, bad);
        }
    }

    void normalize_tangents(Primitive& primitive, const std::string& where) {
        const auto usable = [](const glm::vec4& tangent) {
            const float length = glm::length(glm::vec3(tangent));
            return length > 0.0f && std::isfinite(length) && std::abs(tangent.w) == 1.0f;
        };
        const auto bad = std::count_if(primitive.tangents.begin(), primitive.tangents.end(),
            [&](const glm::vec4& tangent) { return !usable(tangent); });
        if (bad != 0) {
            findings_.tolerate(
                "{}.attributes.TANGENT: {} vertices have no direction or a sign other "
                "than 1 and -1, all are generated anew",
                where, bad);
            generate_tangents(
                primitive, scene_.materials[primitive.material].normal_texture.uv_set);
            return;
        }
        for (glm::vec4& tangent : primitive.tangents) {
            tangent = glm::vec4(glm::normalize(glm::vec3(tangent)), tangent.w);
        }
    }

    // Nodes

    glm::mat4 local_transform(const tinygltf::Node& node, int index) const {
        glm::mat4 matrix(1.0f);
        if (node.matrix.size() == 16) {
            for (int i = 0; i < 16; ++i) matrix[i / 4][i % 4] = static_cast<float>(node.matrix[i]);
            return matrix;
        }
        glm::dquat rotation(1.0, 0.0, 0.0, 0.0);
        if (node.rotation.size() == 4) {
            const std::vector<double>& r = node.rotation;
            rotation = glm::dquat(r[3], r[0], r[1], r[2]);
            const double length = glm::length(rotation);
            if (!(std::abs(length - 1.0) < 0.00769)) {
                findings_.tolerate("nodes[{}].rotation has length {}, expected 1", index, length);
            }
            rotation = length > 0.0 ? rotation / length : glm::dquat(1.0, 0.0, 0.0, 0.0);
        }
        matrix = glm::mat4(glm::mat4_cast(rotation));
        const glm::vec3 scale = vector3(node.scale, glm::vec3(1.0f));
        for (int i = 0; i < 3; ++i) matrix[i] *= scale[i];
        matrix[3] = glm::vec4(vector3(node.translation, glm::vec3(0.0f)), 1.0f);
        return matrix;
    }

    std::vector<int> root_nodes() const {
        if (!model_.scenes.empty()) return model_.scenes[std::max(model_.defaultScene, 0)].nodes;
        std::vector<bool> is_child(model_.nodes.size(), false);
        for (const tinygltf::Node& node : model_.nodes) {
            for (const int child : node.children) is_child[child] = true;
        }
        std::vector<int> roots;
        for (std::size_t i = 0; i < is_child.size(); ++i) {
            if (!is_child[i]) roots.push_back(static_cast<int>(i));
        }
        return roots;
    }

    void place_nodes() {
        struct Pending {
            int node;
            glm::mat4 parent;
        };
        std::vector<Pending> pending;
        const std::vector<int> roots = root_nodes();
        for (auto root = roots.rbegin(); root != roots.rend(); ++root) {
            pending.push_back({*root, glm::mat4(1.0f)});
        }
        while (!pending.empty()) {
            const Pending next = pending.back();
            pending.pop_back();
            const tinygltf::Node& node = model_.nodes[next.node];
            const glm::mat4 world = next.parent * local_transform(node, next.node);
            place(node, next.node, world);
            for (auto child = node.children.rbegin(); child != node.children.rend(); ++child) {
                pending.push_back({*child, world});
            }
        }
    }

    void place(const tinygltf::Node& node, int index, const glm::mat4& world) {
        const Bounds box =
            node.mesh >= 0 ? mesh_bounds_[node.mesh] : Bounds{glm::vec3(0.0f), glm::vec3(0.0f)};
        if (!box.empty() && !finite(world, box)) {
            findings_.fatal("nodes[{}] '{}' is moved or scaled beyond the range of floats", index,
                shortened(node.name));
        }
        // A scale of zero hides a node: glTF 2.0, 3.5.3.
        const bool hidden = glm::determinant(glm::dmat3(world)) == 0.0;
        if (node.mesh >= 0 && !box.empty() && !hidden)
            scene_.instances.push_back({node.mesh, world});
        if (node.camera >= 0) add_camera(node, index, world);
        if (const auto* light = extension(node.extensions, "KHR_lights_punctual")) {
            add_light(light->Get("light").GetNumberAsInt(), node, index, world);
        }
    }

    void add_camera(const tinygltf::Node& node, int index, const glm::mat4& world) {
        const tinygltf::Camera& source = model_.cameras[node.camera];
        Camera camera;
        camera.name = source.name.empty() ? node.name : source.name;
        camera.position = glm::vec3(world[3]);
        const glm::vec3 backward(world[2]), up(world[1]);
        const glm::vec3 right = glm::cross(up, backward);
        if (!(glm::length(right) > 0.0f)) {
            findings_.note("nodes[{}] '{}': its camera has no direction, it is left out", index,
                shortened(node.name));
            return;
        }
        camera.forward = -glm::normalize(backward);
        camera.up = glm::normalize(glm::cross(backward, right));
        if (source.type == "perspective") {
            const auto fov = static_cast<float>(glm::degrees(source.perspective.yfov));
            if (!(fov > 0.0f && fov < 180.0f)) {
                findings_.note(
                    "cameras[{}].perspective.yfov is {} degrees, it is left out", node.camera, fov);
                return;
            }
            camera.fov_y_degrees = fov;
        } else {
            const auto height = static_cast<float>(2.0 * std::abs(source.orthographic.ymag));
            if (!(height > 0.0f)) {
                findings_.tolerate(
                    "cameras[{}].orthographic.ymag is 0, it is left out", node.camera);
                return;
            }
            camera.orthographic_height = height;
        }
        scene_.cameras.push_back(std::move(camera));
    }

    void add_light(int light_index, const tinygltf::Node& node, int index, const glm::mat4& world) {
        const tinygltf::Light& source = model_.lights[light_index];
        if (source.type != "directional" && source.type != "point" && source.type != "spot") {
            findings_.note("lights[{}] has an unknown type, it is left out", light_index);
            return;
        }
        Light light;
        light.name = source.name.empty() ? node.name : source.name;
        light.type = source.type == "directional" ? LightType::directional
                     : source.type == "spot"      ? LightType::spot
                                                  : LightType::point;
        light.position = glm::vec3(world[3]);
        if (light.type != LightType::point) {
            const glm::vec3 axis(world[2]);
            if (!(glm::length(axis) > 0.0f)) {
                findings_.note("nodes[{}] '{}': its light has no direction, it is left out", index,
                    shortened(node.name));
                return;
            }
            light.direction = -glm::normalize(axis);
        }
        light.intensity =
            static_cast<float>(source.intensity) * vector3(source.color, glm::vec3(1.0f));
        if (source.range > 0.0) light.range = static_cast<float>(source.range);
        if (source.range < 0.0) {
            findings_.tolerate(
                "lights[{}].range is {}, read as infinite", light_index, source.range);
        }
        if (light.type == LightType::spot) set_cones(light, source.spot, light_index);
        light.casts_shadow = light.type == LightType::directional;
        scene_.lights.push_back(std::move(light));
    }

    void set_cones(Light& light, const tinygltf::SpotLight& source, int light_index) const {
        const double outer = source.outerConeAngle, inner = source.innerConeAngle;
        if (!(inner >= 0.0 && inner < outer && outer <= glm::half_pi<double>() + 1e-6)) {
            findings_.tolerate(
                "lights[{}].spot has cones {} and {}, expected 0 <= inner < outer <= "
                "pi/2; clamped",
                light_index, inner, outer);
        }
        light.outer_cone = static_cast<float>(std::clamp(outer, 1e-3, glm::half_pi<double>()));
        light.inner_cone = std::clamp(static_cast<float>(inner), 0.0f, 0.999f * light.outer_cone);
    }

    const tinygltf::Model& model_;
    const GltfFile& file_;
    fs::path folder_;
    const GltfOptions& options_;
    const GltfFindings& findings_;
    GltfAccessorReader reader_;
    Scene scene_;
    std::vector<Bounds> mesh_bounds_;
    std::map<std::string, int> images_; ///< by URI, or by index for images inside the file
    int default_material_ = -1;
    bool warned_morph_ = false;
};

} // namespace

Scene load_gltf(const fs::path& path, const GltfOptions& options) {
    const GltfFindings findings(path.string(), options.strict);
    try {
        const GltfFile file = read_gltf_file(path, options, findings);
        const tinygltf::Model model = parse(file, findings);
        return GltfConverter(model, file, path, options, findings).convert();
    } catch (const Error&) {
        throw;
    } catch (const std::bad_alloc&) {
        findings.fatal("it needs more memory than there is");
    } catch (const std::exception& error) {
        findings.fatal("{}", error.what());
    }
}

} // namespace ockham
