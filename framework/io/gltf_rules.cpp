// SPDX-License-Identifier: Apache-2.0
#include "framework/io/gltf_rules.hpp"

#include <glm/glm.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>

namespace ockham {
namespace {

using nlohmann::json;

const json kNothing;

/// The member, or a null that has no members.
const json& get(const json& object, const char* key) {
    if (!object.is_object()) return kNothing;
    const auto found = object.find(key);
    return found == object.end() ? kNothing : *found;
}

const json& get(const json& object, const char* key, const char* inner) {
    return get(get(object, key), inner);
}

std::string text(const json& object, const char* key) {
    const json& value = get(object, key);
    return value.is_string() ? value.get<std::string>() : std::string();
}

/// Walks the arrays of a file.
class RuleChecker {
public:
    RuleChecker(const json& root, const GltfFindings& findings)
        : root_(root), findings_(findings), views_(get(root, "bufferViews")),
          accessors_(get(root, "accessors")), nodes_(get(root, "nodes")), parents_(find_parents()) {
    }

    void check_all() {
        if (!get(root_, "extensionsRequired").is_null() && get(root_, "extensionsUsed").is_null()) {
            findings_.refuse("extensionsRequired stands without extensionsUsed");
        }
        for (std::size_t i = 0; i < views_.size(); ++i) check_view(i);
        each(accessors_, "accessors", [&](const json& accessor, const std::string& where) {
            check_accessor(accessor, where);
        });
        each(get(root_, "buffers"), "buffers",
            [&](const json& buffer, const std::string& where) { check_buffer(buffer, where); });
        each(get(root_, "cameras"), "cameras",
            [&](const json& camera, const std::string& where) { check_camera(camera, where); });
        each(get(root_, "meshes"), "meshes",
            [&](const json& mesh, const std::string& where) { check_mesh(mesh, where); });
        each(get(root_, "skins"), "skins",
            [&](const json& skin, const std::string& where) { check_skin(skin, where); });
        each(nodes_, "nodes",
            [&](const json& node, const std::string& where) { check_node(node, where); });
        check_scenes();
        each(get(root_, "animations"), "animations",
            [&](const json& animation, const std::string& where) {
                check_animation(animation, where);
            });
        each(get(get(root_, "extensions", "KHR_lights_punctual"), "lights"), "lights",
            [&](const json& light, const std::string& where) { check_light(light, where); });
        each(get(root_, "images"), "images",
            [&](const json& image, const std::string& where) { check_image(image, where); });
    }

private:
    template <class Check>
    static void each(const json& list, const std::string& name, Check check) {
        for (std::size_t i = 0; i < list.size(); ++i)
            check(list[i], fmt::format("{}[{}]", name, i));
    }

    // Views and accessors

    enum class Usage { none, vertices, indices, bind_matrices, animation, picture };

    /// A view serves one purpose only: glTF 2.0, 3.6.2.
    void use_view(const json& index, Usage usage, const std::string& where) {
        if (!index.is_number()) return;
        Usage& known = usages_[index.get<std::size_t>()];
        if (known != Usage::none && known != usage) {
            findings_.refuse("{} uses bufferViews[{}], which serves something else", where,
                index.get<std::size_t>());
        }
        known = usage;
    }

    const json& accessor(const json& index) const { return accessors_[index.get<std::size_t>()]; }

    bool has_stride(const json& view_index) const {
        return view_index.is_number() &&
               views_[view_index.get<std::size_t>()].contains("byteStride");
    }

    void check_view(std::size_t index) {
        const json& view = views_[index];
        const json& target = get(view, "target");
        if (target == 34962) usages_[index] = Usage::vertices;
        if (target == 34963) usages_[index] = Usage::indices;
        if (!view.contains("byteStride")) return;
        if (target == 34963) {
            findings_.refuse("bufferViews[{}] has indices and a byteStride", index);
        }
        if (view["byteStride"] > view["byteLength"]) {
            findings_.refuse("bufferViews[{}].byteStride is above its byteLength", index);
        }
    }

    static std::size_t components(const json& accessor) {
        static const std::map<std::string, std::size_t> kComponents{{"SCALAR", 1}, {"VEC2", 2},
            {"VEC3", 3}, {"VEC4", 4}, {"MAT2", 4}, {"MAT3", 9}, {"MAT4", 16}};
        const auto found = kComponents.find(text(accessor, "type"));
        return found == kComponents.end() ? 1 : found->second;
    }

    void check_accessor(const json& accessor, const std::string& where) const {
        if (accessor.contains("byteOffset") && !accessor.contains("bufferView")) {
            findings_.refuse("{} has a byteOffset and no bufferView", where);
        }
        const int type = get(accessor, "componentType").get<int>();
        if (get(accessor, "normalized") == true && (type == 5125 || type == 5126)) {
            findings_.refuse("{} is normalized, but of 32 bits", where);
        }
        for (const char* key : {"min", "max"}) {
            const json& bound = get(accessor, key);
            if (!bound.is_null() && bound.size() != components(accessor)) {
                findings_.refuse("{}.{} has {} numbers, expected {}", where, key, bound.size(),
                    components(accessor));
            }
        }
    }

    void check_buffer(const json& buffer, const std::string& where) const {
        const std::string uri = text(buffer, "uri");
        if (!uri.starts_with("data:")) return;
        std::string type = uri.substr(5, std::min(uri.find(','), uri.find(';')) - 5);
        std::transform(type.begin(), type.end(), type.begin(),
            [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
        if (type != "application/octet-stream" && type != "application/gltf-buffer") {
            findings_.refuse("{}.uri has the media type '{}', expected "
                             "application/octet-stream or application/gltf-buffer",
                where, shortened(type));
        }
    }

    void check_image(const json& image, const std::string& where) {
        const json& view = get(image, "bufferView");
        if (view.is_null()) return;
        if (!image.contains("mimeType")) findings_.refuse("{} has no mimeType", where);
        if (has_stride(view)) findings_.refuse("{}: its view has a byteStride", where);
        use_view(view, Usage::picture, where);
    }

    void check_camera(const json& camera, const std::string& where) const {
        const json& perspective = get(camera, "perspective");
        const json& orthographic = get(camera, "orthographic");
        if (perspective.is_null() == orthographic.is_null()) {
            findings_.refuse("{} is not either perspective or orthographic", where);
        }
        const json& lens = perspective.is_null() ? orthographic : perspective;
        if (lens.contains("zfar") && lens["zfar"] <= lens["znear"]) {
            findings_.refuse("{}: zfar is not above znear", where);
        }
        if (orthographic.is_object() && (orthographic["xmag"] == 0 || orthographic["ymag"] == 0)) {
            findings_.refuse("{}: xmag or ymag is 0", where);
        }
    }

    void check_light(const json& light, const std::string& where) const {
        const json& spot = get(light, "spot");
        if (!spot.is_object()) return;
        if (spot.value("innerConeAngle", 0.0) >= spot.value("outerConeAngle", 0.7853981633974483)) {
            findings_.refuse("{}.spot: innerConeAngle is not below outerConeAngle", where);
        }
    }

    // Meshes

    /// A type and how it may be stored, as in "VEC3 float" or "VEC4 unsigned byte normalized".
    struct Format {
        std::string type;
        int component_type;
        bool normalized;
    };

    static Format format(const json& accessor) {
        return {text(accessor, "type"), get(accessor, "componentType").get<int>(),
            accessor.value("normalized", false)};
    }

    bool quantized() const {
        const json& used = get(root_, "extensionsUsed");
        return std::find(used.begin(), used.end(), "KHR_mesh_quantization") != used.end();
    }

    /// glTF 2.0, 3.7.2.1 and 3.7.2.2; `is_target`: of a morph target.
    bool allows(const std::string& semantic, const Format& f, bool is_target) const {
        const bool is_float = f.component_type == 5126;
        const bool is_small = f.component_type <= 5123;
        const bool is_unsigned = f.component_type == 5121 || f.component_type == 5123;
        const bool unorm = is_unsigned && f.normalized;
        const bool snorm = is_small && !is_unsigned && f.normalized;
        const bool more = quantized();
        if (semantic == "POSITION") return f.type == "VEC3" && (is_float || (more && is_small));
        if (semantic == "NORMAL") return f.type == "VEC3" && (is_float || (more && snorm));
        if (semantic == "TANGENT") {
            return f.type == (is_target ? "VEC3" : "VEC4") && (is_float || (more && snorm));
        }
        if (semantic.starts_with("TEXCOORD_")) {
            const bool any = more || (is_target && snorm);
            return f.type == "VEC2" && (is_float || unorm || (any && is_small));
        }
        if (semantic.starts_with("COLOR_")) {
            const bool any = is_target && snorm;
            return (f.type == "VEC3" || f.type == "VEC4") && (is_float || unorm || any);
        }
        if (semantic.starts_with("JOINTS_"))
            return f.type == "VEC4" && is_unsigned && !f.normalized;
        if (semantic.starts_with("WEIGHTS_")) return f.type == "VEC4" && (is_float || unorm);
        return f.component_type != 5125; // of the application
    }

    /// True for the names of glTF 2.0, 3.7.2.1, and those of applications, which begin with '_'.
    static bool is_semantic(const std::string& name) {
        if (name.starts_with('_')) return true;
        if (name == "POSITION" || name == "NORMAL" || name == "TANGENT") return true;
        for (const std::string_view base : {"TEXCOORD_", "COLOR_", "JOINTS_", "WEIGHTS_"}) {
            if (!name.starts_with(base)) continue;
            const std::string set = name.substr(base.size());
            return !set.empty() && set.find_first_not_of("0123456789") == std::string::npos &&
                   (set.size() == 1 || set[0] != '0');
        }
        return false;
    }

    /// Sets of TEXCOORD, COLOR, ...: numbered from 0 without gaps.
    static std::size_t sets(const json& attributes, const std::string& base) {
        std::size_t count = 0;
        while (attributes.contains(fmt::format("{}_{}", base, count))) ++count;
        return count;
    }

    void check_mesh(const json& mesh, const std::string& where) {
        const json& primitives = mesh["primitives"];
        const std::size_t targets = get(primitives[0], "targets").size();
        each(primitives, where + ".primitives",
            [&](const json& primitive, const std::string& place) {
                check_attributes(primitive, place);
                check_material(primitive, place);
                check_variants(primitive, place);
                if (get(primitive, "targets").size() != targets) {
                    findings_.refuse("{}: not all primitives have {} targets", where, targets);
                }
            });
        const json& weights = get(mesh, "weights");
        if (!weights.is_null() && weights.size() != targets) {
            findings_.refuse("{} has {} weights and {} targets", where, weights.size(), targets);
        }
    }

    void check_attributes(const json& primitive, const std::string& where) {
        const json& attributes = primitive["attributes"];
        std::map<std::string, std::size_t> found;
        std::map<std::size_t, std::size_t> user_of_view;
        std::optional<std::size_t> count;
        for (const auto& [name, index] : attributes.items()) {
            const std::string place = where + ".attributes." + shortened(name);
            check_attribute(name, index, place, false);
            if (const std::size_t end = name.rfind('_'); end != std::string::npos && end > 0) {
                ++found[name.substr(0, end)];
            }
            if (count && accessor(index)["count"] != *count) {
                findings_.refuse("{} has another count than the other attributes", place);
            }
            count = accessor(index)["count"].get<std::size_t>();
            const json& view = get(accessor(index), "bufferView");
            if (!view.is_number() || has_stride(view)) continue;
            const auto [user, is_new] = user_of_view.emplace(view, index);
            if (!is_new && user->second != index) {
                findings_.refuse("{}: bufferViews[{}] has several accessors and no byteStride",
                    place, view.get<std::size_t>());
            }
        }
        for (const char* base : {"TEXCOORD", "COLOR", "JOINTS", "WEIGHTS"}) {
            if (found[base] != sets(attributes, base)) {
                findings_.refuse("{}.attributes: {}_n are not numbered from 0", where, base);
            }
        }
        if (found["JOINTS"] != found["WEIGHTS"]) {
            findings_.refuse("{}.attributes: as many WEIGHTS as JOINTS are needed", where);
        }
        if (const json& list = get(primitive, "indices"); list.is_number()) {
            check_indices(list, where + ".indices");
        }
        each(get(primitive, "targets"), where + ".targets",
            [&](const json& target, const std::string& place) {
                check_target(target, attributes, place);
            });
    }

    void check_attribute(
        const std::string& name, const json& index, const std::string& where, bool is_target) {
        if (!is_semantic(name)) findings_.refuse("{} is no known attribute", where);
        const json& source = accessor(index);
        if (!allows(name, format(source), is_target)) {
            findings_.refuse("{}: accessors[{}] has a format not allowed there", where,
                index.get<std::size_t>());
        }
        if (name == "POSITION" && !(source.contains("min") && source.contains("max"))) {
            findings_.refuse("{}: its accessor needs min and max", where);
        }
        const json& view = get(source, "bufferView");
        use_view(view, Usage::vertices, where);
        if (view.is_number() && !is_aligned(source, views_[view.get<std::size_t>()])) {
            findings_.refuse("{} is not aligned to 4 bytes", where);
        }
    }

    static bool is_aligned(const json& accessor, const json& view) {
        const int type = accessor["componentType"].get<int>();
        const std::size_t bytes = type <= 5121 ? 1 : type <= 5123 ? 2 : 4;
        const std::size_t stride = view.value("byteStride", bytes * components(accessor));
        return accessor.value("byteOffset", std::size_t{0}) % 4 == 0 && stride % 4 == 0;
    }

    void check_indices(const json& index, const std::string& where) {
        const json& source = accessor(index);
        const Format f = format(source);
        const bool is_unsigned =
            f.component_type == 5121 || f.component_type == 5123 || f.component_type == 5125;
        if (f.type != "SCALAR" || !is_unsigned || f.normalized) {
            findings_.refuse("{}: its accessor has no unsigned scalars", where);
        }
        const json& view = get(source, "bufferView");
        use_view(view, Usage::indices, where);
        if (has_stride(view)) findings_.refuse("{}: its view has a byteStride", where);
    }

    void check_target(const json& target, const json& attributes, const std::string& where) {
        for (const auto& [name, index] : target.items()) {
            const std::string place = where + "." + shortened(name);
            check_attribute(name, index, place, true);
            const auto base = attributes.find(name);
            if (base == attributes.end()) {
                findings_.refuse("{}: the primitive has no such attribute", place);
            } else if (accessor(*base)["count"] != accessor(index)["count"]) {
                findings_.refuse("{} has another count than what it moves", place);
            }
        }
    }

    /// The highest set of texture coordinates that textures in `object` need, plus 1.
    static std::size_t needed_sets(const json& object) {
        std::size_t needed = 0;
        if (!object.is_object()) return needed;
        for (const auto& [key, value] : object.items()) {
            if (!value.is_object()) continue;
            if (value.contains("index") && key.ends_with("Texture")) {
                const json& moved = get(get(value, "extensions"), "KHR_texture_transform");
                const std::size_t own = value.value("texCoord", std::size_t{0});
                needed =
                    std::max(needed, 1 + (moved.is_object() ? moved.value("texCoord", own) : own));
            } else if (key != "extras") {
                needed = std::max(needed, needed_sets(value));
            }
        }
        return needed;
    }

    void check_material(const json& primitive, const std::string& where) const {
        const json& index = get(primitive, "material");
        if (!index.is_number()) return;
        const json& material = root_["materials"][index.get<std::size_t>()];
        const json& attributes = primitive["attributes"];
        if (needed_sets(material) > sets(attributes, "TEXCOORD")) {
            findings_.refuse("{} has fewer TEXCOORD_n than its material uses", where);
        }
        const json& extensions = get(material, "extensions");
        const bool needs_tangents =
            get(extensions, "KHR_materials_anisotropy").contains("anisotropyTexture") ||
            get(extensions, "KHR_materials_clearcoat").contains("clearcoatNormalTexture");
        const bool has_tangents = attributes.contains("NORMAL") && attributes.contains("TANGENT");
        if (needs_tangents && !has_tangents && !material.contains("normalTexture")) {
            findings_.refuse("{} has no TANGENT, which its material needs", where);
        }
    }

    void check_variants(const json& primitive, const std::string& where) const {
        const json& mappings =
            get(get(primitive, "extensions"), "KHR_materials_variants", "mappings");
        std::set<json> seen;
        for (const json& mapping : mappings) {
            for (const json& variant : mapping["variants"]) {
                if (seen.insert(variant).second) continue;
                findings_.refuse("{}: variant {} has several materials", where, variant.dump());
            }
        }
    }

    // Nodes, skins, scenes

    static constexpr std::size_t kNone = ~std::size_t{0};

    std::vector<std::size_t> find_parents() const {
        std::vector<std::size_t> parents(nodes_.size(), kNone);
        for (std::size_t i = 0; i < nodes_.size(); ++i) {
            for (const json& child : get(nodes_[i], "children")) {
                parents[child.get<std::size_t>()] = i;
            }
        }
        return parents;
    }

    std::size_t root_of(std::size_t node) const {
        while (parents_[node] != kNone) node = parents_[node];
        return node;
    }

    bool is_below(std::size_t node, std::size_t ancestor) const {
        while (node != ancestor && node != kNone) node = parents_[node];
        return node == ancestor;
    }

    void check_skin(const json& skin, const std::string& where) {
        const json& joints = skin["joints"];
        const auto first = joints[0].get<std::size_t>();
        for (const json& joint : joints) {
            if (root_of(joint.get<std::size_t>()) != root_of(first)) {
                findings_.refuse("{}.joints have no common root", where);
            }
            if (const json& skeleton = get(skin, "skeleton");
                skeleton.is_number() && !is_below(joint, skeleton.get<std::size_t>())) {
                findings_.refuse("{}.skeleton is no root of joint {}", where, joint.dump());
            }
        }
        const json& index = get(skin, "inverseBindMatrices");
        if (!index.is_number()) return;
        const json& source = accessor(index);
        const Format f = format(source);
        const std::string place = where + ".inverseBindMatrices";
        if (f.type != "MAT4" || f.component_type != 5126) {
            findings_.refuse("{}: its accessor has no MAT4 of floats", place);
        }
        if (source["count"] < joints.size()) {
            findings_.refuse(
                "{}: {} matrices for {} joints", place, source["count"].dump(), joints.size());
        }
        const json& view = get(source, "bufferView");
        use_view(view, Usage::bind_matrices, place);
        if (has_stride(view)) findings_.refuse("{}: its view has a byteStride", place);
    }

    const json& mesh_of(const json& node) const {
        const json& index = get(node, "mesh");
        return index.is_number() ? root_["meshes"][index.get<std::size_t>()] : kNothing;
    }

    static std::size_t target_count(const json& mesh) {
        return mesh.is_null() ? 0 : get(mesh["primitives"][0], "targets").size();
    }

    void check_node(const json& node, const std::string& where) const {
        const json& mesh = mesh_of(node);
        for (const char* key : {"skin", "weights"}) {
            if (node.contains(key) && mesh.is_null()) {
                findings_.refuse("{} has {} and no mesh", where, key);
            }
        }
        if (node.contains("weights") && node["weights"].size() != target_count(mesh)) {
            findings_.refuse("{}.weights are not as many as the targets of its mesh", where);
        }
        if (node.contains("skin")) {
            for (const json& primitive : mesh["primitives"]) {
                if (primitive["attributes"].contains("JOINTS_0")) continue;
                findings_.refuse("{} has a skin, but its mesh has no JOINTS_0", where);
            }
        }
        if (node.contains("matrix") && !has_orthogonal_axes(node["matrix"])) {
            findings_.refuse("{}.matrix is no translation, rotation and scale", where);
        }
    }

    /// Columns at right angles and a last row of 0, 0, 0, 1: what TRS makes. glTF 2.0, 3.5.3.
    static bool has_orthogonal_axes(const json& matrix) {
        const auto axis = [&](std::size_t i) {
            return glm::dvec3(matrix[4 * i].get<double>(), matrix[4 * i + 1].get<double>(),
                matrix[4 * i + 2].get<double>());
        };
        for (std::size_t i = 0; i < 3; ++i) {
            if (matrix[4 * i + 3].get<double>() != 0.0) return false;
            const glm::dvec3 a = axis(i), b = axis((i + 1) % 3);
            if (glm::length(a) == 0.0 || glm::length(b) == 0.0) return false;
            if (std::abs(glm::dot(glm::normalize(a), glm::normalize(b))) > 5e-5) return false;
        }
        return matrix[15].get<double>() == 1.0;
    }

    void check_scenes() const {
        each(get(root_, "scenes"), "scenes", [&](const json& scene, const std::string& where) {
            std::set<std::size_t> roots;
            for (const json& node : get(scene, "nodes")) roots.insert(node.get<std::size_t>());
            for (std::size_t i = 0; i < nodes_.size(); ++i) {
                if (!nodes_[i].contains("skin") || !roots.contains(root_of(i))) continue;
                const json& skin = root_["skins"][nodes_[i]["skin"].get<std::size_t>()];
                if (roots.contains(root_of(skin["joints"][0].get<std::size_t>()))) continue;
                findings_.refuse("{} has nodes[{}], but not the joints of its skin", where, i);
            }
        });
    }

    // Animations: glTF 2.0, 3.11.

    void check_animation(const json& source, const std::string& where) {
        const json& samplers = source["samplers"];
        each(samplers, where + ".samplers", [&](const json& sampler, const std::string& place) {
            check_input(sampler, place + ".input");
            for (const char* key : {"input", "output"}) {
                const json& view = get(accessor(sampler[key]), "bufferView");
                use_view(view, Usage::animation, place);
                if (has_stride(view)) {
                    findings_.refuse("{}.{}: its view has a byteStride", place, key);
                }
            }
        });
        std::set<std::pair<json, std::string>> targets;
        each(source["channels"], where + ".channels",
            [&](const json& channel, const std::string& place) {
                const auto index = channel["sampler"].get<std::size_t>();
                if (index >= samplers.size()) {
                    findings_.refuse("{}.sampler is {}, but the animation has {}", place, index,
                        samplers.size());
                    return;
                }
                const json& target = channel["target"];
                const bool is_new =
                    targets.emplace(get(target, "node"), text(target, "path")).second;
                if (target.contains("node") && !is_new) {
                    findings_.refuse("{}.target is moved by two channels", place);
                }
                check_target_path(target, place + ".target");
                if (target.contains("node")) check_output(samplers[index], target, place);
            });
    }

    void check_input(const json& sampler, const std::string& where) const {
        const json& input = accessor(sampler["input"]);
        const Format f = format(input);
        if (f.type != "SCALAR" || f.component_type != 5126) {
            findings_.refuse("{}: its accessor has no scalar floats", where);
        }
        if (!input.contains("min") || !input.contains("max")) {
            findings_.refuse("{}: its accessor needs min and max", where);
        }
        if (text(sampler, "interpolation") == "CUBICSPLINE" && input["count"] < 2) {
            findings_.refuse("{}: a spline needs two elements", where);
        }
    }

    void check_target_path(const json& target, const std::string& where) const {
        const std::string path = text(target, "path");
        const json& pointer = get(get(target, "extensions"), "KHR_animation_pointer");
        if (pointer.is_object()) {
            if (target.contains("node")) findings_.refuse("{} has a pointer and a node", where);
            if (path != "pointer") findings_.refuse("{}.path is not 'pointer'", where);
            if (!is_pointer(text(pointer, "pointer"))) {
                findings_.refuse(
                    "{}: '{}' is no JSON pointer", where, shortened(text(pointer, "pointer")));
            }
        }
        if (!target.contains("node")) return;
        const json& node = nodes_[target["node"].get<std::size_t>()];
        if (path == "weights") {
            if (target_count(mesh_of(node)) == 0) {
                findings_.refuse("{}: its node has no morph targets", where);
            }
        } else if (node.contains("matrix")) {
            findings_.refuse("{}: its node has a matrix", where);
        }
    }

    /// RFC 6901.
    static bool is_pointer(const std::string& text) {
        if (!text.empty() && text[0] != '/') return false;
        for (std::size_t i = 0; i < text.size(); ++i) {
            if (text[i] != '~') continue;
            if (i + 1 == text.size() || (text[i + 1] != '0' && text[i + 1] != '1')) return false;
        }
        return true;
    }

    void check_output(const json& sampler, const json& target, const std::string& where) const {
        const json& output = accessor(sampler["output"]);
        const std::string path = text(target, "path");
        const Format f = format(output);
        const bool is_float = f.component_type == 5126;
        const bool may_be_small = is_float || (f.component_type <= 5123 && f.normalized);
        const bool fits = path == "rotation"  ? f.type == "VEC4" && may_be_small
                          : path == "weights" ? f.type == "SCALAR" && may_be_small
                          : path == "translation" || path == "scale" ? f.type == "VEC3" && is_float
                                                                     : true;
        if (!fits) findings_.refuse("{}: its output has a format not allowed there", where);
        std::size_t expected = accessor(sampler["input"])["count"].get<std::size_t>();
        if (text(sampler, "interpolation") == "CUBICSPLINE") expected *= 3;
        if (path == "weights") {
            expected *= target_count(mesh_of(nodes_[target["node"].get<std::size_t>()]));
        }
        if (output["count"] != expected) {
            findings_.refuse("{}: its output has {} elements, expected {}", where,
                output["count"].dump(), expected);
        }
    }

    const json& root_;
    const GltfFindings& findings_;
    const json& views_;
    const json& accessors_;
    const json& nodes_;
    std::vector<std::size_t> parents_;
    std::map<std::size_t, Usage> usages_;
};

} // namespace

void check_gltf_rules(const json& root, const GltfFindings& findings) {
    RuleChecker(root, findings).check_all();
}

} // namespace ockham
