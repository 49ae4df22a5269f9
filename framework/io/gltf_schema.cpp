// SPDX-License-Identifier: Apache-2.0
#include "framework/io/gltf_schema.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace ockham {
namespace {

using nlohmann::json;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

enum Kind {
    text,
    texts,      ///< an array of different strings
    flag,       ///< true or false
    whole,      ///< an integer
    number,     ///< finite, as all numbers of JSON
    numbers,    ///< an array; of any length if `length` is 0
    object,     ///< `of` the type
    objects,    ///< an array of objects `of` the type
    index,      ///< into the array `of` the file
    indices,    ///< an array of different indices into the array `of` the file
    index_map,  ///< an object whose members are indices into the array `of` the file
    index_maps, ///< an array of these
};

struct Range {
    double low = -kInfinity;
    double high = kInfinity;
    bool open = false; ///< `low` itself is out
};

constexpr Range kAny{}, kNotNegative{0.0}, kPositive{0.0, kInfinity, true}, kAtLeast1{1.0},
    kUnit{0.0, 1.0}, kRightAngle{0.0, 1.5707963705062866};

constexpr bool optional = false, required = true;

/// One row of the specification's tables; types and arrays are named as there.
struct Property {
    std::string_view type, key;
    Kind kind;
    std::string_view of = {};
    bool is_required = optional;
    Range range = kAny;
    std::size_t length = 0;
};

constexpr Property kProperties[] = {
    {"glTF", "extensionsUsed", texts},
    {"glTF", "extensionsRequired", texts},
    {"glTF", "accessors", objects, "accessor"},
    {"glTF", "animations", objects, "animation"},
    {"glTF", "asset", object, "asset", required},
    {"glTF", "buffers", objects, "buffer"},
    {"glTF", "bufferViews", objects, "bufferView"},
    {"glTF", "cameras", objects, "camera"},
    {"glTF", "images", objects, "image"},
    {"glTF", "materials", objects, "material"},
    {"glTF", "meshes", objects, "mesh"},
    {"glTF", "nodes", objects, "node"},
    {"glTF", "samplers", objects, "sampler"},
    {"glTF", "scene", index, "scenes"},
    {"glTF", "scenes", objects, "scene"},
    {"glTF", "skins", objects, "skin"},
    {"glTF", "textures", objects, "texture"},
    {"asset", "copyright", text},
    {"asset", "generator", text},
    {"asset", "version", text, {}, required},
    {"asset", "minVersion", text},
    {"accessor", "bufferView", index, "bufferViews"},
    {"accessor", "byteOffset", whole, {}, optional, kNotNegative},
    {"accessor", "componentType", whole, {}, required, kNotNegative},
    {"accessor", "normalized", flag},
    {"accessor", "count", whole, {}, required, kAtLeast1},
    {"accessor", "type", text, {}, required},
    {"accessor", "max", numbers},
    {"accessor", "min", numbers},
    {"accessor", "sparse", object, "sparse"},
    {"sparse", "count", whole, {}, required, kAtLeast1},
    {"sparse", "indices", object, "sparse indices", required},
    {"sparse", "values", object, "sparse values", required},
    {"sparse indices", "bufferView", index, "bufferViews", required},
    {"sparse indices", "byteOffset", whole, {}, optional, kNotNegative},
    {"sparse indices", "componentType", whole, {}, required, kNotNegative},
    {"sparse values", "bufferView", index, "bufferViews", required},
    {"sparse values", "byteOffset", whole, {}, optional, kNotNegative},
    {"animation", "channels", objects, "channel", required},
    {"animation", "samplers", objects, "animation sampler", required},
    {"channel", "sampler", whole, {}, required, kNotNegative},
    {"channel", "target", object, "target", required},
    {"target", "node", index, "nodes"},
    {"target", "path", text, {}, required},
    {"animation sampler", "input", index, "accessors", required},
    {"animation sampler", "interpolation", text},
    {"animation sampler", "output", index, "accessors", required},
    {"buffer", "uri", text},
    {"buffer", "byteLength", whole, {}, required, kAtLeast1},
    {"bufferView", "buffer", index, "buffers", required},
    {"bufferView", "byteOffset", whole, {}, optional, kNotNegative},
    {"bufferView", "byteLength", whole, {}, required, kAtLeast1},
    {"bufferView", "byteStride", whole, {}, optional, {4.0, 252.0}},
    {"bufferView", "target", whole, {}, optional, kNotNegative},
    {"camera", "orthographic", object, "orthographic"},
    {"camera", "perspective", object, "perspective"},
    {"camera", "type", text, {}, required},
    {"orthographic", "xmag", number, {}, required},
    {"orthographic", "ymag", number, {}, required},
    {"orthographic", "zfar", number, {}, required, kPositive},
    {"orthographic", "znear", number, {}, required, kNotNegative},
    {"perspective", "aspectRatio", number, {}, optional, kPositive},
    {"perspective", "yfov", number, {}, required, kPositive},
    {"perspective", "zfar", number, {}, optional, kPositive},
    {"perspective", "znear", number, {}, required, kPositive},
    {"image", "uri", text},
    {"image", "mimeType", text},
    {"image", "bufferView", index, "bufferViews"},
    {"material", "pbrMetallicRoughness", object, "pbrMetallicRoughness"},
    {"material", "normalTexture", object, "textureInfo"},
    {"material", "occlusionTexture", object, "textureInfo"},
    {"material", "emissiveTexture", object, "textureInfo"},
    {"material", "emissiveFactor", numbers, {}, optional, kUnit, 3},
    {"material", "alphaMode", text},
    {"material", "alphaCutoff", number, {}, optional, kNotNegative},
    {"material", "doubleSided", flag},
    {"pbrMetallicRoughness", "baseColorFactor", numbers, {}, optional, kUnit, 4},
    {"pbrMetallicRoughness", "baseColorTexture", object, "textureInfo"},
    {"pbrMetallicRoughness", "metallicFactor", number, {}, optional, kUnit},
    {"pbrMetallicRoughness", "roughnessFactor", number, {}, optional, kUnit},
    {"pbrMetallicRoughness", "metallicRoughnessTexture", object, "textureInfo"},
    {"textureInfo", "index", index, "textures", required},
    {"textureInfo", "texCoord", whole, {}, optional, kNotNegative},
    {"textureInfo", "scale", number},
    {"textureInfo", "strength", number, {}, optional, kUnit},
    {"mesh", "primitives", objects, "primitive", required},
    {"mesh", "weights", numbers},
    {"primitive", "attributes", index_map, "accessors", required},
    {"primitive", "indices", index, "accessors"},
    {"primitive", "material", index, "materials"},
    {"primitive", "mode", whole, {}, optional, kNotNegative},
    {"primitive", "targets", index_maps, "accessors"},
    {"node", "camera", index, "cameras"},
    {"node", "children", indices, "nodes"},
    {"node", "skin", index, "skins"},
    {"node", "matrix", numbers, {}, optional, kAny, 16},
    {"node", "mesh", index, "meshes"},
    {"node", "rotation", numbers, {}, optional, {-1.0, 1.0}, 4},
    {"node", "scale", numbers, {}, optional, kAny, 3},
    {"node", "translation", numbers, {}, optional, kAny, 3},
    {"node", "weights", numbers},
    {"sampler", "magFilter", whole, {}, optional, kNotNegative},
    {"sampler", "minFilter", whole, {}, optional, kNotNegative},
    {"sampler", "wrapS", whole, {}, optional, kNotNegative},
    {"sampler", "wrapT", whole, {}, optional, kNotNegative},
    {"scene", "nodes", indices, "nodes"},
    {"skin", "inverseBindMatrices", index, "accessors"},
    {"skin", "skeleton", index, "nodes"},
    {"skin", "joints", indices, "nodes", required},
    {"texture", "sampler", index, "samplers"},
    {"texture", "source", index, "images"},

    {"EXT_texture_webp", "source", index, "images"},
    {"KHR_animation_pointer", "pointer", text, {}, required},
    {"KHR_lights_punctual", "lights", objects, "light", required},
    {"KHR_lights_punctual of a node", "light", index, "lights", required},
    {"light", "color", numbers, {}, optional, kUnit, 3},
    {"light", "intensity", number, {}, optional, kNotNegative},
    {"light", "spot", object, "spot"},
    {"light", "type", text, {}, required},
    {"light", "range", number, {}, optional, kPositive},
    {"spot", "innerConeAngle", number, {}, optional, kRightAngle},
    {"spot", "outerConeAngle", number, {}, optional, kRightAngle},
    {"KHR_materials_anisotropy", "anisotropyStrength", number, {}, optional, kUnit},
    {"KHR_materials_anisotropy", "anisotropyRotation", number},
    {"KHR_materials_anisotropy", "anisotropyTexture", object, "textureInfo"},
    {"KHR_materials_clearcoat", "clearcoatFactor", number, {}, optional, kUnit},
    {"KHR_materials_clearcoat", "clearcoatTexture", object, "textureInfo"},
    {"KHR_materials_clearcoat", "clearcoatRoughnessFactor", number, {}, optional, kUnit},
    {"KHR_materials_clearcoat", "clearcoatRoughnessTexture", object, "textureInfo"},
    {"KHR_materials_clearcoat", "clearcoatNormalTexture", object, "textureInfo"},
    {"KHR_materials_dispersion", "dispersion", number, {}, optional, kNotNegative},
    {"KHR_materials_emissive_strength", "emissiveStrength", number, {}, optional, kNotNegative},
    {"KHR_materials_ior", "ior", number, {}, optional, kNotNegative},
    {"KHR_materials_iridescence", "iridescenceFactor", number, {}, optional, kUnit},
    {"KHR_materials_iridescence", "iridescenceTexture", object, "textureInfo"},
    {"KHR_materials_iridescence", "iridescenceIor", number, {}, optional, kAtLeast1},
    {"KHR_materials_iridescence", "iridescenceThicknessMinimum", number, {}, optional,
        kNotNegative},
    {"KHR_materials_iridescence", "iridescenceThicknessMaximum", number, {}, optional,
        kNotNegative},
    {"KHR_materials_iridescence", "iridescenceThicknessTexture", object, "textureInfo"},
    {"KHR_materials_pbrSpecularGlossiness", "diffuseFactor", numbers, {}, optional, kUnit, 4},
    {"KHR_materials_pbrSpecularGlossiness", "diffuseTexture", object, "textureInfo"},
    {"KHR_materials_pbrSpecularGlossiness", "specularFactor", numbers, {}, optional, kUnit, 3},
    {"KHR_materials_pbrSpecularGlossiness", "glossinessFactor", number, {}, optional, kUnit},
    {"KHR_materials_pbrSpecularGlossiness", "specularGlossinessTexture", object, "textureInfo"},
    {"KHR_materials_sheen", "sheenColorFactor", numbers, {}, optional, kUnit, 3},
    {"KHR_materials_sheen", "sheenColorTexture", object, "textureInfo"},
    {"KHR_materials_sheen", "sheenRoughnessFactor", number, {}, optional, kUnit},
    {"KHR_materials_sheen", "sheenRoughnessTexture", object, "textureInfo"},
    {"KHR_materials_specular", "specularFactor", number, {}, optional, kUnit},
    {"KHR_materials_specular", "specularTexture", object, "textureInfo"},
    {"KHR_materials_specular", "specularColorFactor", numbers, {}, optional, kNotNegative, 3},
    {"KHR_materials_specular", "specularColorTexture", object, "textureInfo"},
    {"KHR_materials_transmission", "transmissionFactor", number, {}, optional, kUnit},
    {"KHR_materials_transmission", "transmissionTexture", object, "textureInfo"},
    {"KHR_materials_variants", "variants", objects, "variant", required},
    {"KHR_materials_variants of a primitive", "mappings", objects, "mapping", required},
    {"mapping", "variants", indices, "variants", required},
    {"mapping", "material", index, "materials", required},
    {"variant", "name", text, {}, required},
    {"KHR_materials_volume", "thicknessFactor", number, {}, optional, kNotNegative},
    {"KHR_materials_volume", "thicknessTexture", object, "textureInfo"},
    {"KHR_materials_volume", "attenuationDistance", number, {}, optional, kPositive},
    {"KHR_materials_volume", "attenuationColor", numbers, {}, optional, kUnit, 3},
    {"KHR_node_visibility", "visible", flag},
    {"KHR_texture_transform", "offset", numbers, {}, optional, kAny, 2},
    {"KHR_texture_transform", "rotation", number},
    {"KHR_texture_transform", "scale", numbers, {}, optional, kAny, 2},
    {"KHR_texture_transform", "texCoord", whole, {}, optional, kNotNegative},
};

/// Where extensions may stand; `type` is the table of what they hold there, if there is one.
struct Place {
    std::string_view extension, parent, type;
};

constexpr Place kPlaces[] = {
    {"EXT_texture_webp", "texture", "EXT_texture_webp"},
    {"KHR_animation_pointer", "target", "KHR_animation_pointer"},
    {"KHR_lights_punctual", "glTF", "KHR_lights_punctual"},
    {"KHR_lights_punctual", "node", "KHR_lights_punctual of a node"},
    {"KHR_materials_anisotropy", "material", "KHR_materials_anisotropy"},
    {"KHR_materials_clearcoat", "material", "KHR_materials_clearcoat"},
    {"KHR_materials_dispersion", "material", "KHR_materials_dispersion"},
    {"KHR_materials_emissive_strength", "material", "KHR_materials_emissive_strength"},
    {"KHR_materials_ior", "material", "KHR_materials_ior"},
    {"KHR_materials_iridescence", "material", "KHR_materials_iridescence"},
    {"KHR_materials_pbrSpecularGlossiness", "material", "KHR_materials_pbrSpecularGlossiness"},
    {"KHR_materials_sheen", "material", "KHR_materials_sheen"},
    {"KHR_materials_specular", "material", "KHR_materials_specular"},
    {"KHR_materials_transmission", "material", "KHR_materials_transmission"},
    {"KHR_materials_unlit", "material", ""},
    {"KHR_materials_variants", "glTF", "KHR_materials_variants"},
    {"KHR_materials_variants", "primitive", "KHR_materials_variants of a primitive"},
    {"KHR_materials_volume", "material", "KHR_materials_volume"},
    {"KHR_mesh_quantization", "", ""},
    {"KHR_node_visibility", "node", "KHR_node_visibility"},
    {"KHR_texture_transform", "textureInfo", "KHR_texture_transform"},
};

/// Walks the objects of a file along the tables.
class SchemaWalk {
public:
    SchemaWalk(const json& root, const GltfFindings& findings)
        : root_(root), findings_(findings), used_(extensions_used()) {}

    void visit(const json& value, const std::string& path, std::string_view type) const {
        if (!value.is_object()) return mismatch(value, path, "an object");
        if (const auto name = value.find("name"); name != value.end() && !name->is_string()) {
            mismatch(*name, join(path, "name"), "a string");
        }
        for (const Property& property : kProperties) {
            if (property.type != type) continue;
            const std::string place = join(path, property.key);
            const auto found = value.find(property.key);
            if (found != value.end()) {
                visit(*found, place, property);
            } else if (property.is_required) {
                findings_.refuse("{} is missing", place);
            }
        }
        visit_extensions(value, path, type);
    }

private:
    static std::string join(const std::string& path, std::string_view key) {
        return path.empty() ? std::string(key) : fmt::format("{}.{}", path, key);
    }

    void mismatch(const json& found, const std::string& path, std::string_view expected) const {
        const std::string text = found.dump(-1, ' ', true, json::error_handler_t::replace);
        findings_.refuse("{} is {}, expected {}", path, shortened(text), expected);
    }

    void visit(const json& value, const std::string& place, const Property& property) const {
        switch (property.kind) {
        case text:
            if (!value.is_string()) mismatch(value, place, "a string");
            break;
        case flag:
            if (!value.is_boolean()) mismatch(value, place, "true or false");
            break;
        case whole:
        case number:
            visit_number(value, place, property);
            break;
        case object:
            visit(value, place, property.of);
            break;
        case index:
            visit_index(value, place, property.of);
            break;
        case index_map:
            visit_map(value, place, property.of);
            break;
        default:
            visit_array(value, place, property);
        }
    }

    void visit_array(const json& value, const std::string& place, const Property& property) const {
        if (!value.is_array()) return mismatch(value, place, "an array");
        if (value.empty()) findings_.refuse("{} is an empty array", place);
        if (property.length != 0 && value.size() != property.length) {
            mismatch(value, place, fmt::format("an array of {} numbers", property.length));
        }
        const bool is_set = property.kind == texts || property.kind == indices;
        if (is_set && std::set<json>(value.begin(), value.end()).size() != value.size()) {
            findings_.refuse("{} has an element twice", place);
        }
        for (std::size_t i = 0; i < value.size(); ++i) {
            const std::string element = fmt::format("{}[{}]", place, i);
            if (property.kind == texts && !value[i].is_string())
                mismatch(value[i], element, "a string");
            if (property.kind == numbers) visit_number(value[i], element, property);
            if (property.kind == objects) visit(value[i], element, property.of);
            if (property.kind == indices) visit_index(value[i], element, property.of);
            if (property.kind == index_maps) visit_map(value[i], element, property.of);
        }
    }

    void visit_number(const json& value, const std::string& place, const Property& property) const {
        if (!value.is_number()) return mismatch(value, place, "a number");
        const double found = value.get<double>();
        if (property.kind == whole && found != std::floor(found)) {
            mismatch(value, place, "an integer");
        }
        const auto [low, high, open] = property.range;
        if (found < low || found > high || (open && found == low)) {
            findings_.refuse("{} is {}, out of range", place, found);
        }
    }

    void visit_map(const json& value, const std::string& place, std::string_view array) const {
        if (!value.is_object()) return mismatch(value, place, "an object");
        if (value.empty()) findings_.refuse("{} is empty", place);
        for (const auto& [name, element] : value.items()) {
            visit_index(element, join(place, shortened(name)), array);
        }
    }

    void visit_index(const json& value, const std::string& place, std::string_view array) const {
        if (!value.is_number()) return mismatch(value, place, "an index");
        const double found = value.get<double>();
        const std::size_t size = count(array);
        if (!(found >= 0.0 && found < static_cast<double>(size)) || found != std::floor(found)) {
            findings_.refuse("{} is {}, but the file has {} {}", place, value.dump(), size, array);
        }
    }

    std::size_t count(std::string_view array) const {
        const json* found = nullptr;
        if (array == "lights") {
            found = in_extension("KHR_lights_punctual", "lights");
        } else if (array == "variants") {
            found = in_extension("KHR_materials_variants", "variants");
        } else if (const auto at = root_.find(array); at != root_.end()) {
            found = &*at;
        }
        return found && found->is_array() ? found->size() : 0;
    }

    const json* in_extension(const char* name, const char* key) const {
        const auto extensions = root_.find("extensions");
        if (extensions == root_.end() || !extensions->is_object()) return nullptr;
        const auto extension = extensions->find(name);
        if (extension == extensions->end() || !extension->is_object()) return nullptr;
        const auto found = extension->find(key);
        return found == extension->end() ? nullptr : &*found;
    }

    std::set<std::string> extensions_used() const {
        std::set<std::string> names;
        const auto list = root_.find("extensionsUsed");
        if (list == root_.end() || !list->is_array()) return names;
        for (const json& name : *list) {
            if (name.is_string()) names.insert(name.get<std::string>());
        }
        return names;
    }

    void visit_extensions(
        const json& parent, const std::string& path, std::string_view type) const {
        const auto extensions = parent.find("extensions");
        if (extensions == parent.end()) return;
        const std::string place = join(path, "extensions");
        if (!extensions->is_object()) return mismatch(*extensions, place, "an object");
        for (const auto& [name, value] : extensions->items()) {
            const std::string where = join(place, shortened(name));
            if (!value.is_object()) mismatch(value, where, "an object");
            if (!used_.contains(name)) findings_.refuse("{} is not in extensionsUsed", where);
            visit_extension(name, value, where, type);
        }
    }

    void visit_extension(const std::string& name, const json& value, const std::string& where,
        std::string_view parent) const {
        bool known = false;
        for (const Place& place : kPlaces) {
            if (place.extension != name) continue;
            known = true;
            if (place.parent == parent) return visit(value, where, place.type);
        }
        if (known) findings_.refuse("{} is not where {} may stand", where, name);
    }

    const json& root_;
    const GltfFindings& findings_;
    std::set<std::string> used_;
};

} // namespace

void check_gltf_schema(const json& root, const GltfFindings& findings) {
    SchemaWalk(root, findings).visit(root, "", "glTF");
}

} // namespace ockham
