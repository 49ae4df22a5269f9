// SPDX-License-Identifier: Apache-2.0
#include "framework/io/gltf_check.hpp"

#include "framework/io/gltf_uri.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

namespace ockham {
namespace {

using nlohmann::json;

/// Largest count of an accessor, and of one that has no data behind it (all zeros).
constexpr std::uint64_t kMaxElements = 1u << 28;
constexpr std::uint64_t kMaxZeroElements = 1u << 24;
constexpr std::uint64_t kMaxInteger = std::numeric_limits<std::int32_t>::max();

/// Checks everything the loader reads from the JSON, and turns integers that are written as floats
/// (1.0) into integers. What it does not know, it leaves alone.
class JsonChecker {
public:
    JsonChecker(json& root, const GltfFindings& findings) : root_(root), findings_(findings) {}

    void check_all() {
        check_asset();
        check_extensions();
        for (const char* key : {"buffers", "bufferViews", "accessors", "images", "samplers",
                 "textures", "materials", "meshes", "nodes", "scenes", "cameras"}) {
            if (root_.contains(key) && count(key) == 0) findings_.tolerate("{} is empty", key);
        }
        for_each("buffers", &JsonChecker::check_buffer);
        for_each("bufferViews", &JsonChecker::check_buffer_view);
        for_each("accessors", &JsonChecker::check_accessor);
        for_each("images", &JsonChecker::check_image);
        for_each("samplers", &JsonChecker::check_sampler);
        for_each("textures", &JsonChecker::check_texture);
        for_each("materials", &JsonChecker::check_material);
        for_each("meshes", &JsonChecker::check_mesh);
        for_each("cameras", &JsonChecker::check_camera);
        check_lights();
        for_each("nodes", &JsonChecker::check_node);
        for_each("scenes", &JsonChecker::check_scene);
        check_hierarchy();
        index(root_, "", "scene", count("scenes"), optional, "scenes");
    }

    /// After check_all: accessors of a type that glTF 2.0 does not know, replaced by a byte of
    /// zero.
    std::vector<bool> take_unknown_accessors() { return std::move(unknown_accessors_); }

private:
    enum Presence { optional, required };

    static std::string join(const std::string& path, const std::string& key) {
        return path.empty() ? key : path + "." + key;
    }

    [[noreturn]] void refuse(
        const std::string& path, const json& found, const std::string& expected) const {
        std::string text = found.dump(-1, ' ', true, json::error_handler_t::replace);
        findings_.fatal("{} is {}, expected {}", path, shortened(text), expected);
    }

    /// The member, or null if it is absent and optional.
    json* member(json& object, const std::string& path, const char* key, Presence presence) const {
        const auto found = object.find(key);
        if (found != object.end()) return &*found;
        if (presence == required) findings_.fatal("{} is missing", join(path, key));
        return nullptr;
    }

    json* object(json& parent, const std::string& path, const char* key,
        Presence presence = optional) const {
        json* value = member(parent, path, key, presence);
        if (value && !value->is_object()) refuse(join(path, key), *value, "an object");
        return value;
    }

    json* array(json& parent, const std::string& path, const char* key,
        Presence presence = optional) const {
        json* value = member(parent, path, key, presence);
        if (!value) return nullptr;
        if (!value->is_array()) refuse(join(path, key), *value, "an array");
        if (value->empty()) findings_.tolerate("{} is an empty array", join(path, key));
        return value;
    }

    std::string* string(json& parent, const std::string& path, const char* key,
        Presence presence = optional) const {
        json* value = member(parent, path, key, presence);
        if (value && !value->is_string()) refuse(join(path, key), *value, "a string");
        return value ? value->get_ptr<std::string*>() : nullptr;
    }

    void boolean(json& parent, const std::string& path, const char* key) const {
        json* value = member(parent, path, key, optional);
        if (value && !value->is_boolean()) refuse(join(path, key), *value, "true or false");
    }

    /// Checks `value` in place; `maximum` <= 2^53.
    std::uint64_t whole_number(
        json& value, const std::string& path, std::uint64_t minimum, std::uint64_t maximum) const {
        // Negative, fractional and huge values all fail the comparison with the range.
        const double number = value.is_number() ? value.get<double>() : -1.0;
        const bool fits = number >= static_cast<double>(minimum) &&
                          number <= static_cast<double>(maximum) && number == std::floor(number);
        if (!fits) refuse(path, value, fmt::format("an integer from {} to {}", minimum, maximum));
        const auto result = static_cast<std::uint64_t>(number);
        if (value.is_number_float()) value = result;
        return result;
    }

    std::optional<std::uint64_t> integer(json& parent, const std::string& path, const char* key,
        std::uint64_t minimum, std::uint64_t maximum, Presence presence = optional) const {
        json* value = member(parent, path, key, presence);
        if (!value) return std::nullopt;
        return whole_number(*value, join(path, key), minimum, maximum);
    }

    /// A reference into an array of `size` objects.
    std::size_t reference(
        json& value, const std::string& path, std::size_t size, const char* what) const {
        if (!value.is_number()) refuse(path, value, "an index");
        const double number = value.get<double>();
        if (!(number >= 0.0 && number < static_cast<double>(size)) ||
            number != std::floor(number)) {
            findings_.fatal("{} is {}, but the file has {} {}", path, value.dump(), size, what);
        }
        if (value.is_number_float()) value = static_cast<std::uint64_t>(number);
        return static_cast<std::size_t>(number);
    }

    std::optional<std::size_t> index(json& parent, const std::string& path, const char* key,
        std::size_t size, Presence presence, const char* what) const {
        json* value = member(parent, path, key, presence);
        if (!value) return std::nullopt;
        return reference(*value, join(path, key), size, what);
    }

    /// Finite as a float; kept as one, since tinygltf cuts integers in extensions to 32 bits.
    double finite(json& value, const std::string& path) const {
        if (!value.is_number() || !std::isfinite(static_cast<float>(value.get<double>()))) {
            refuse(path, value, "a finite number");
        }
        const double result = value.get<double>();
        value = result;
        return result;
    }

    std::optional<double> number(json& parent, const std::string& path, const char* key,
        Presence presence = optional) const {
        json* value = member(parent, path, key, presence);
        if (!value) return std::nullopt;
        return finite(*value, join(path, key));
    }

    /// As `number`; outside of [low, high] it is clamped, which is tolerated.
    void clamped(json& parent, const std::string& path, const char* key, double low,
        double high = std::numeric_limits<float>::max()) const {
        const std::optional<double> found = number(parent, path, key);
        if (found) clamp(parent.at(key), join(path, key), *found, low, high);
    }

    void clamp(json& value, const std::string& path, double found, double low, double high) const {
        if (found >= low && found <= high) return;
        if (high < std::numeric_limits<float>::max()) {
            findings_.tolerate("{} is {}, clamped to [{}, {}]", path, found, low, high);
        } else {
            findings_.tolerate("{} is {}, clamped to at least {}", path, found, low);
        }
        value = std::clamp(found, low, high);
    }

    bool numbers(json& parent, const std::string& path, const char* key, std::size_t size) const {
        json* value = member(parent, path, key, optional);
        if (!value) return false;
        const std::string place = join(path, key);
        if (!value->is_array() || value->size() != size) {
            refuse(place, *value, fmt::format("an array of {} numbers", size));
        }
        for (std::size_t i = 0; i < size; ++i) finite((*value)[i], fmt::format("{}[{}]", place, i));
        return true;
    }

    void clamped_numbers(json& parent, const std::string& path, const char* key, std::size_t size,
        double low, double high) const {
        if (!numbers(parent, path, key, size)) return;
        for (std::size_t i = 0; i < size; ++i) {
            json& value = parent.at(key)[i];
            clamp(value, fmt::format("{}.{}[{}]", path, key, i), value.get<double>(), low, high);
        }
    }

    json* extension(json& parent, const std::string& path, const char* name) const {
        json* extensions = object(parent, path, "extensions");
        return extensions ? object(*extensions, join(path, "extensions"), name) : nullptr;
    }

    /// Objects in a top-level array; 0 if it is absent.
    std::size_t count(const char* key) const {
        const auto found = root_.find(key);
        if (found == root_.end()) return 0;
        if (!found->is_array()) refuse(key, *found, "an array");
        return found->size();
    }

    template <class Check>
    void for_each(const char* key, Check check) {
        const auto found = root_.find(key);
        if (found == root_.end()) return;
        for (std::size_t i = 0; i < found->size(); ++i) {
            const std::string path = fmt::format("{}[{}]", key, i);
            if (!(*found)[i].is_object()) refuse(path, (*found)[i], "an object");
            string((*found)[i], path, "name");
            (this->*check)((*found)[i], path);
        }
    }

    // The objects of glTF 2.0, in the order of the specification's reference.

    void check_asset() const {
        json* asset = object(root_, "", "asset", required);
        const int minor = minor_version(*string(*asset, "asset", "version", required), "version");
        if (minor != 0) findings_.note("asset.version is 2.{}, read as 2.0", minor);
        if (const std::string* minimum = string(*asset, "asset", "minVersion")) {
            const int needed = minor_version(*minimum, "minVersion");
            if (needed > minor) {
                findings_.tolerate(
                    "asset.minVersion is 2.{}, above asset.version 2.{}", needed, minor);
            }
            if (needed > 0) findings_.note("asset.minVersion is 2.{}, read as 2.0", needed);
        }
    }

    /// N of "2.N".
    int minor_version(const std::string& version, const char* key) const {
        const bool is_2 = version.starts_with("2.") && version.size() > 2 && version.size() < 8 &&
                          version.find_first_not_of("0123456789", 2) == std::string::npos;
        if (!is_2) findings_.fatal("asset.{} is '{}', expected 2.0", key, shortened(version));
        return std::stoi(version.substr(2));
    }

    void check_extensions() const {
        constexpr std::array<std::string_view, 6> kSupported{"KHR_lights_punctual",
            "KHR_materials_emissive_strength", "KHR_materials_ior", "KHR_materials_unlit",
            "KHR_mesh_quantization", "KHR_texture_transform"};
        const auto supported = [&](const std::string& name) {
            return std::find(kSupported.begin(), kSupported.end(), name) != kSupported.end();
        };
        const auto names = [&](const char* key) {
            std::vector<std::string> result;
            json* list = array(root_, "", key);
            if (!list) return result;
            for (std::size_t i = 0; i < list->size(); ++i) {
                json& name = (*list)[i];
                if (!name.is_string()) refuse(fmt::format("{}[{}]", key, i), name, "a string");
                result.push_back(shortened(name.get<std::string>()));
            }
            return result;
        };
        const std::vector<std::string> used = names("extensionsUsed");
        std::string refused, ignored;
        for (const std::string& name : names("extensionsRequired")) {
            if (!supported(name)) refused += refused.empty() ? name : ", " + name;
            if (std::find(used.begin(), used.end(), name) == used.end()) {
                findings_.tolerate("extensionsRequired has {}, extensionsUsed has not", name);
            }
        }
        if (!refused.empty()) {
            findings_.fatal("it requires {}, which is not supported; export it without", refused);
        }
        for (const std::string& name : used) {
            if (!supported(name)) ignored += ignored.empty() ? name : ", " + name;
        }
        if (!ignored.empty()) findings_.note("extensions not supported and ignored: {}", ignored);
    }

    void check_buffer(json& buffer, const std::string& path) const {
        integer(buffer, path, "byteLength", 1, kMaxGltfBytes, required);
        string(buffer, path, "uri");
    }

    void check_buffer_view(json& view, const std::string& path) const {
        const std::size_t buffer =
            *index(view, path, "buffer", count("buffers"), required, "buffers");
        const std::uint64_t offset =
            integer(view, path, "byteOffset", 0, kMaxGltfBytes).value_or(0);
        const std::uint64_t length = *integer(view, path, "byteLength", 1, kMaxGltfBytes, required);
        const std::uint64_t end = root_["buffers"][buffer]["byteLength"].get<std::uint64_t>();
        if (offset + length > end) {
            findings_.fatal(
                "{} ends at byte {}, but buffers[{}] has {}", path, offset + length, buffer, end);
        }
        const auto stride = integer(view, path, "byteStride", 0, kMaxGltfBytes);
        if (stride && (*stride < 4 || *stride > 252 || *stride % 4 != 0)) {
            findings_.fatal(
                "{}.byteStride is {}, expected a multiple of 4 from 4 to 252", path, *stride);
        }
    }

    /// Bytes of a component, of an element, and from one tightly packed element to the next.
    struct Layout {
        std::uint64_t component_bytes = 0;
        std::uint64_t element_bytes = 0;
        std::uint64_t step_bytes = 0;
    };

    /// Bytes of the component type, or nothing if glTF 2.0 does not know it or not there.
    std::optional<std::uint64_t> component_bytes(
        json& parent, const std::string& path, std::initializer_list<std::uint64_t> allowed) const {
        const std::uint64_t type =
            *integer(parent, path, "componentType", 0, kMaxInteger, required);
        if (std::find(allowed.begin(), allowed.end(), type) == allowed.end()) return std::nullopt;
        return type <= 5121 ? 1 : type <= 5123 ? 2 : 4;
    }

    std::optional<Layout> layout(json& accessor, const std::string& path) const {
        const auto component =
            component_bytes(accessor, path, {5120, 5121, 5122, 5123, 5125, 5126});
        const std::string& type = *string(accessor, path, "type", required);
        if (!component) return std::nullopt;
        const std::uint64_t bytes = *component;
        const auto vector = [&](std::uint64_t n) { return Layout{bytes, n * bytes, n * bytes}; };
        // Columns of matrices begin at multiples of four bytes.
        const auto matrix = [&](std::uint64_t n) {
            const std::uint64_t column = (n * bytes + 3) / 4 * 4;
            return Layout{bytes, (n - 1) * column + n * bytes, n * column};
        };
        if (type == "SCALAR") return vector(1);
        if (type == "VEC2") return vector(2);
        if (type == "VEC3") return vector(3);
        if (type == "VEC4") return vector(4);
        if (type == "MAT2") return matrix(2);
        if (type == "MAT3") return matrix(3);
        if (type == "MAT4") return matrix(4);
        return std::nullopt;
    }

    /// `elements` of `layout` must lie within the view named by `parent`.
    void check_range(json& parent, const std::string& path, std::uint64_t elements, Layout layout,
        std::uint64_t stride) const {
        const std::size_t view_index = parent["bufferView"].get<std::size_t>();
        const json& view = root_["bufferViews"][view_index];
        const std::uint64_t view_bytes = view["byteLength"].get<std::uint64_t>();
        const std::uint64_t offset =
            integer(parent, path, "byteOffset", 0, kMaxGltfBytes).value_or(0);
        // No overflow: all factors are below 2^33, and one of each product is below 2^9.
        const std::uint64_t end = offset + stride * (elements - 1) + layout.element_bytes;
        if (end > view_bytes) {
            findings_.fatal("{}: its {} elements end at byte {}, but bufferViews[{}] has {}", path,
                elements, end, view_index, view_bytes);
        }
        if ((offset + view.value("byteOffset", std::uint64_t{0})) % layout.component_bytes != 0) {
            findings_.tolerate("{}: its data is not aligned to its components' {} bytes", path,
                layout.component_bytes);
        }
    }

    void check_accessor(json& accessor, const std::string& path) {
        const std::optional<Layout> known = layout(accessor, path);
        unknown_accessors_.push_back(!known);
        if (!known) {
            findings_.note("{} has type {} and component type {}, which glTF 2.0 does not know",
                path, shortened(accessor["type"].get<std::string>()),
                accessor["componentType"].dump());
            accessor = {{"type", "SCALAR"}, {"componentType", 5121}, {"count", 1}};
            return;
        }
        const Layout& element = *known;
        boolean(accessor, path, "normalized");
        const std::uint64_t elements = *integer(accessor, path, "count", 1, kMaxElements, required);
        const std::size_t views = count("bufferViews");
        const auto view = index(accessor, path, "bufferView", views, optional, "bufferViews");
        if (view) {
            const std::uint64_t stride =
                root_["bufferViews"][*view].value("byteStride", element.step_bytes);
            if (stride < element.step_bytes) {
                findings_.fatal("{} has elements of {} bytes, but bufferViews[{}].byteStride is {}",
                    path, element.step_bytes, *view, stride);
            }
            check_range(accessor, path, elements, element, stride);
        } else if (elements > kMaxZeroElements) {
            findings_.fatal("{} has {} elements and no data; at most {} are accepted", path,
                elements, kMaxZeroElements);
        }

        json* sparse = object(accessor, path, "sparse");
        if (!sparse) return;
        const std::string place = path + ".sparse";
        const std::uint64_t replaced = *integer(*sparse, place, "count", 1, kMaxElements, required);
        if (replaced > elements) {
            findings_.fatal(
                "{}.count is {}, but the accessor has {} elements", place, replaced, elements);
        }
        json& indices = *object(*sparse, place, "indices", required);
        json& values = *object(*sparse, place, "values", required);
        const auto bytes = component_bytes(indices, place + ".indices", {5121, 5123, 5125});
        if (!bytes) {
            refuse(
                place + ".indices.componentType", indices["componentType"], "5121, 5123 or 5125");
        }
        index(indices, place + ".indices", "bufferView", views, required, "bufferViews");
        index(values, place + ".values", "bufferView", views, required, "bufferViews");
        check_range(indices, place + ".indices", replaced, {*bytes, *bytes, *bytes}, *bytes);
        check_range(values, place + ".values", replaced, element, element.step_bytes);
    }

    void check_image(json& image, const std::string& path) const {
        const bool has_uri = string(image, path, "uri") != nullptr;
        const bool has_view =
            index(image, path, "bufferView", count("bufferViews"), optional, "bufferViews")
                .has_value();
        if (has_uri == has_view) {
            findings_.tolerate("{} has {} of uri and bufferView", path, has_uri ? "both" : "none");
        }
    }

    void check_sampler(json& sampler, const std::string& path) const {
        for (const char* key : {"wrapS", "wrapT"}) {
            const auto wrap = integer(sampler, path, key, 0, 65535);
            if (!wrap || *wrap == 33071 || *wrap == 33648 || *wrap == 10497) continue;
            findings_.note("{}.{} is {}, read as repeat", path, key, *wrap);
        }
    }

    void check_texture(json& texture, const std::string& path) const {
        index(texture, path, "sampler", count("samplers"), optional, "samplers");
        index(texture, path, "source", count("images"), optional, "images");
    }

    void check_texture_use(json& parent, const std::string& path, const char* key) const {
        json* use = object(parent, path, key);
        if (!use) return;
        const std::string place = join(path, key);
        index(*use, place, "index", count("textures"), required, "textures");
        integer(*use, place, "texCoord", 0, 65535);
        number(*use, place, "scale");
        clamped(*use, place, "strength", 0.0, 1.0);
        if (json* transform = extension(*use, place, "KHR_texture_transform")) {
            const std::string name = place + ".extensions.KHR_texture_transform";
            numbers(*transform, name, "offset", 2);
            numbers(*transform, name, "scale", 2);
            number(*transform, name, "rotation");
            integer(*transform, name, "texCoord", 0, 65535);
        }
    }

    void check_material(json& material, const std::string& path) const {
        if (json* pbr = object(material, path, "pbrMetallicRoughness")) {
            const std::string place = path + ".pbrMetallicRoughness";
            clamped_numbers(*pbr, place, "baseColorFactor", 4, 0.0, 1.0);
            clamped(*pbr, place, "metallicFactor", 0.0, 1.0);
            clamped(*pbr, place, "roughnessFactor", 0.0, 1.0);
            check_texture_use(*pbr, place, "baseColorTexture");
            check_texture_use(*pbr, place, "metallicRoughnessTexture");
        }
        check_texture_use(material, path, "normalTexture");
        check_texture_use(material, path, "occlusionTexture");
        check_texture_use(material, path, "emissiveTexture");
        clamped_numbers(material, path, "emissiveFactor", 3, 0.0, 1.0);
        string(material, path, "alphaMode");
        clamped(material, path, "alphaCutoff", 0.0);
        boolean(material, path, "doubleSided");
        if (json* strength = extension(material, path, "KHR_materials_emissive_strength")) {
            clamped(*strength, path + ".extensions.KHR_materials_emissive_strength",
                "emissiveStrength", 0.0);
        }
        if (json* ior = extension(material, path, "KHR_materials_ior")) {
            const std::string place = path + ".extensions.KHR_materials_ior";
            // 0 stands for a reflectance of 1.
            if (number(*ior, place, "ior") != 0.0) clamped(*ior, place, "ior", 1.0);
        }
        extension(material, path, "KHR_materials_unlit");
    }

    void check_mesh(json& mesh, const std::string& path) const {
        json& primitives = *array(mesh, path, "primitives", required);
        for (std::size_t i = 0; i < primitives.size(); ++i) {
            json& primitive = primitives[i];
            const std::string place = fmt::format("{}.primitives[{}]", path, i);
            if (!primitive.is_object()) refuse(place, primitive, "an object");
            json& attributes = *object(primitive, place, "attributes", required);
            for (auto& [name, value] : attributes.items()) {
                reference(value, place + ".attributes." + shortened(name), count("accessors"),
                    "accessors");
            }
            index(primitive, place, "indices", count("accessors"), optional, "accessors");
            index(primitive, place, "material", count("materials"), optional, "materials");
            integer(primitive, place, "mode", 0, kMaxInteger);
        }
    }

    void check_camera(json& camera, const std::string& path) const {
        const std::string type = *string(camera, path, "type", required);
        if (type == "perspective") {
            json& perspective = *object(camera, path, "perspective", required);
            number(perspective, path + ".perspective", "yfov", required);
            number(perspective, path + ".perspective", "znear", required);
        } else if (type == "orthographic") {
            json& orthographic = *object(camera, path, "orthographic", required);
            for (const char* key : {"xmag", "ymag", "zfar", "znear"}) {
                number(orthographic, path + ".orthographic", key, required);
            }
        } else {
            findings_.note("{}.type is {}, it is left out", path, shortened(type));
            camera = {{"type", "perspective"}, {"perspective", {{"yfov", 0}, {"znear", 1}}}};
        }
    }

    /// The file's lights, or null.
    json* lights() const {
        json* punctual = extension(root_, "", "KHR_lights_punctual");
        return punctual ? array(*punctual, "KHR_lights_punctual", "lights", required) : nullptr;
    }

    void check_lights() const {
        json* list = lights();
        for (std::size_t i = 0; list && i < list->size(); ++i) {
            json& light = (*list)[i];
            const std::string path = fmt::format("KHR_lights_punctual.lights[{}]", i);
            if (!light.is_object()) refuse(path, light, "an object");
            string(light, path, "name");
            const std::string type = *string(light, path, "type", required);
            clamped_numbers(light, path, "color", 3, 0.0, 1.0);
            clamped(light, path, "intensity", 0.0);
            number(light, path, "range");
            if (type != "spot") continue;
            json& spot = *object(light, path, "spot", required);
            number(spot, path + ".spot", "innerConeAngle");
            number(spot, path + ".spot", "outerConeAngle");
        }
    }

    void check_indices(json& parent, const std::string& path, const char* key) const {
        json* list = array(parent, path, key);
        for (std::size_t i = 0; list && i < list->size(); ++i) {
            reference((*list)[i], fmt::format("{}.{}[{}]", path, key, i), count("nodes"), "nodes");
        }
    }

    void check_node(json& node, const std::string& path) const {
        index(node, path, "mesh", count("meshes"), optional, "meshes");
        index(node, path, "camera", count("cameras"), optional, "cameras");
        check_indices(node, path, "children");
        const bool matrix = numbers(node, path, "matrix", 16);
        const bool translation = numbers(node, path, "translation", 3);
        const bool rotation = numbers(node, path, "rotation", 4);
        const bool scale = numbers(node, path, "scale", 3);
        if (matrix && (translation || rotation || scale)) {
            findings_.tolerate("{} has a matrix and also {}; the matrix is used", path,
                translation ? "a translation"
                : rotation  ? "a rotation"
                            : "a scale");
        }
        if (json* light = extension(node, path, "KHR_lights_punctual")) {
            const json* list = lights();
            index(*light, path + ".extensions.KHR_lights_punctual", "light",
                list ? list->size() : 0, required, "lights");
        }
    }

    void check_scene(json& scene, const std::string& path) const {
        check_indices(scene, path, "nodes");
    }

    /// Nodes must form trees: one parent each, no cycles. glTF 2.0, 3.5.2.
    void check_hierarchy() const {
        const std::size_t nodes = count("nodes");
        constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
        std::vector<std::size_t> parent(nodes, kNone);
        for (std::size_t i = 0; i < nodes; ++i) {
            const json& node = root_["nodes"][i];
            const auto children = node.find("children");
            if (children == node.end()) continue;
            for (const json& value : *children) {
                const auto child = value.get<std::size_t>();
                if (parent[child] != kNone) {
                    findings_.fatal("nodes[{}] is a child of nodes[{}] and of nodes[{}]", child,
                        parent[child], i);
                }
                parent[child] = i;
            }
        }
        // With one parent each, a walk upwards either ends at a root or goes round a cycle.
        std::vector<std::size_t> walk(nodes, kNone);
        for (std::size_t start = 0; start < nodes; ++start) {
            std::size_t node = start;
            while (node != kNone && walk[node] == kNone) {
                walk[node] = start;
                node = parent[node];
            }
            if (node != kNone && walk[node] == start) {
                findings_.fatal("nodes[{}] is its own ancestor", node);
            }
        }
        check_roots(parent, kNone);
    }

    void check_roots(const std::vector<std::size_t>& parent, std::size_t none) const {
        const std::size_t scenes = count("scenes");
        for (std::size_t i = 0; i < scenes; ++i) {
            const json& scene = root_["scenes"][i];
            const auto list = scene.find("nodes");
            if (list == scene.end()) continue;
            for (const json& value : *list) {
                const auto node = value.get<std::size_t>();
                if (parent[node] == none) continue;
                findings_.tolerate(
                    "scenes[{}] lists nodes[{}], a child of nodes[{}]", i, node, parent[node]);
            }
        }
    }

    json& root_;
    const GltfFindings& findings_;
    std::vector<bool> unknown_accessors_;
};

} // namespace

std::vector<bool> check_gltf_json(json& root, const GltfFindings& findings) {
    JsonChecker checker(root, findings);
    checker.check_all();
    return checker.take_unknown_accessors();
}

} // namespace ockham
