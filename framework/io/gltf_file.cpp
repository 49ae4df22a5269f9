// SPDX-License-Identifier: Apache-2.0
#include "framework/io/gltf_file.hpp"

#include "framework/core/file.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <optional>
#include <span>
#include <string_view>

namespace ockham {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Deeper JSON is refused: tinygltf converts `extras` and `extensions` recursively.
constexpr int kMaxJsonDepth = 128;
/// Largest count of an accessor, and of one that has no data behind it (all zeros).
constexpr std::uint64_t kMaxElements = 1u << 28;
constexpr std::uint64_t kMaxZeroElements = 1u << 24;
constexpr std::size_t kMaxFileBytes = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint64_t kMaxInteger = std::numeric_limits<std::int32_t>::max();

/// One line of at most `length` bytes, for messages.
std::string shortened(std::string text, std::size_t length = 64) {
    for (char& c : text) {
        if (static_cast<unsigned char>(c) < 32) c = ' ';
    }
    return text.size() <= length ? text : text.substr(0, length - 3) + "...";
}

// --- Container -----------------------------------------------------------------------------------

struct Container {
    std::string_view json;
    std::span<const std::byte> binary;
    bool is_binary = false;
    bool has_binary_chunk = false;
};

std::uint32_t read_u32(std::span<const std::byte> bytes, std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i)
        value |= std::to_integer<std::uint32_t>(bytes[at + i]) << 8 * i;
    return value;
}

std::string_view as_text(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Splits a GLB: glTF 2.0, 4.4.
Container open_glb(std::span<const std::byte> bytes, const GltfFindings& findings) {
    constexpr std::uint32_t kJson = 0x4E4F534A, kBinary = 0x004E4942;
    if (bytes.size() < 12) {
        findings.fatal("the GLB header is cut off after {} of 12 bytes", bytes.size());
    }
    if (const std::uint32_t version = read_u32(bytes, 4); version != 2) {
        findings.fatal("GLB container version is {}, expected 2", version);
    }
    const std::size_t length = read_u32(bytes, 8);
    if (length > bytes.size()) {
        findings.fatal("the GLB header declares {} bytes, the file has {}", length, bytes.size());
    }
    if (length < bytes.size()) {
        findings.note("{} bytes after the end of the GLB are ignored", bytes.size() - length);
    }
    Container container;
    container.is_binary = true;
    std::size_t at = 12;
    for (int chunk = 0; at < length; ++chunk) {
        if (length - at < 8) {
            findings.fatal("the header of GLB chunk {} is cut off at byte {}", chunk, length);
        }
        const std::size_t size = read_u32(bytes, at);
        const std::uint32_t type = read_u32(bytes, at + 4);
        at += 8;
        if (size > length - at) {
            findings.fatal("GLB chunk {} declares {} bytes, {} are left in the file", chunk, size,
                length - at);
        }
        if (size % 4 != 0) {
            findings.fatal("GLB chunk {} has {} bytes, expected a multiple of 4", chunk, size);
        }
        const std::span<const std::byte> data = bytes.subspan(at, size);
        at += size;
        if ((chunk == 0) != (type == kJson)) {
            findings.fatal(
                "GLB chunk {} has type {:#010x}; the JSON chunk must come first, and once", chunk,
                type);
        }
        if (type == kJson) {
            if (size == 0) findings.fatal("the JSON chunk of the GLB is empty");
            container.json = as_text(data);
        } else if (type == kBinary) {
            if (chunk != 1)
                findings.fatal("GLB chunk {} is a BIN chunk; it must be the second", chunk);
            container.has_binary_chunk = true;
            container.binary = data;
        } else {
            findings.note("GLB chunk {} of unknown type {:#010x} is ignored", chunk, type);
        }
    }
    if (!container.json.data()) findings.fatal("the GLB has no chunks");
    return container;
}

Container open_container(std::span<const std::byte> bytes, const GltfFindings& findings) {
    if (bytes.empty()) findings.fatal("the file is empty");
    if (as_text(bytes).starts_with("glTF")) return open_glb(bytes, findings);
    Container container;
    container.json = as_text(bytes);
    return container;
}

/// True if the text nests deeper than kMaxJsonDepth. (The parser could tell in a callback, but
/// takes quadratic time then.)
bool is_too_deep(std::string_view text) {
    int depth = 0;
    bool in_string = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (in_string && c == '\\') {
            ++i;
        } else if (c == '"') {
            in_string = !in_string;
        } else if (!in_string && (c == '{' || c == '[')) {
            if (++depth > kMaxJsonDepth) return true;
        } else if (!in_string && (c == '}' || c == ']')) {
            --depth;
        }
    }
    return false;
}

json parse_json(std::string_view text, const GltfFindings& findings) {
    if (text.starts_with("\xEF\xBB\xBF")) {
        findings.tolerate("the JSON begins with a byte order mark");
        text.remove_prefix(3);
    }
    const std::size_t first = text.find_first_not_of(" \t\r\n");
    if (first == std::string_view::npos || text[first] != '{') {
        findings.fatal(
            "it is no glTF: it begins neither with 'glTF' (binary) nor with '{{' (JSON)");
    }
    if (is_too_deep(text)) {
        findings.fatal("the JSON is nested deeper than {} levels", kMaxJsonDepth);
    }
    try {
        return json::parse(text);
    } catch (const json::exception& error) {
        // The library's text begins with a code in brackets and ends with the bad input.
        std::string reason = error.what();
        if (const std::size_t code = reason.find("] "); code < 64) reason.erase(0, code + 2);
        findings.fatal("not valid JSON: {}", shortened(reason, 160));
    }
}

// --- URIs ----------------------------------------------------------------------------------------

std::optional<int> hex_digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return std::nullopt;
}

/// RFC 3986; nothing if a '%' is not followed by two hexadecimal digits.
std::optional<std::string> percent_decode(std::string_view text) {
    std::string result;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] != '%') {
            result += text[i];
            continue;
        }
        if (text.size() - i < 3) return std::nullopt;
        const auto high = hex_digit(text[i + 1]), low = hex_digit(text[i + 2]);
        if (!high || !low) return std::nullopt;
        result += static_cast<char>(16 * *high + *low);
        i += 2;
    }
    return result;
}

/// RFC 4648, padding optional; nothing if a character is not of the alphabet.
std::optional<std::vector<std::byte>> base64_decode(std::string_view text) {
    while (text.ends_with('=')) text.remove_suffix(1);
    if (text.size() % 4 == 1) return std::nullopt;
    std::vector<std::byte> bytes;
    bytes.reserve(text.size() / 4 * 3 + 2);
    std::uint32_t bits = 0;
    int count = 0;
    for (const char c : text) {
        std::uint32_t digit = 0;
        if (c >= 'A' && c <= 'Z')
            digit = static_cast<std::uint32_t>(c - 'A');
        else if (c >= 'a' && c <= 'z')
            digit = static_cast<std::uint32_t>(c - 'a' + 26);
        else if (c >= '0' && c <= '9')
            digit = static_cast<std::uint32_t>(c - '0' + 52);
        else if (c == '+')
            digit = 62;
        else if (c == '/')
            digit = 63;
        else
            return std::nullopt;
        bits = bits << 6 | digit;
        count += 6;
        if (count >= 8) {
            count -= 8;
            bytes.push_back(static_cast<std::byte>(bits >> count & 0xFF));
        }
    }
    return bytes;
}

bool has_scheme(std::string_view uri) {
    const std::size_t end = uri.find_first_of(":/?#");
    return end != std::string_view::npos && uri[end] == ':';
}

/// RFC 2397. Throws Error(input).
std::vector<std::byte> decode_data_uri(const std::string& uri) {
    const std::string_view text(uri);
    const std::size_t comma = text.find(',');
    if (comma == std::string_view::npos) fail_input("the data URI has no comma");
    const std::string_view data = text.substr(comma + 1);
    if (text.substr(0, comma).ends_with(";base64")) {
        auto bytes = base64_decode(data);
        if (!bytes) fail_input("the data URI has characters that are not base64");
        return std::move(*bytes);
    }
    const auto plain = percent_decode(data);
    if (!plain) fail_input("the data URI has a '%' without two hexadecimal digits");
    const auto bytes = std::as_bytes(std::span(*plain));
    return {bytes.begin(), bytes.end()};
}

// --- JSON ----------------------------------------------------------------------------------------

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
        index(root_, "", "scene", count("scenes"));
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
    std::optional<std::size_t> reference(
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
        std::size_t size, Presence presence = optional, const char* what = "such objects") const {
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
        integer(buffer, path, "byteLength", 1, kMaxFileBytes, required);
        string(buffer, path, "uri");
    }

    void check_buffer_view(json& view, const std::string& path) const {
        const std::size_t buffer =
            *index(view, path, "buffer", count("buffers"), required, "buffers");
        const std::uint64_t offset =
            integer(view, path, "byteOffset", 0, kMaxFileBytes).value_or(0);
        const std::uint64_t length = *integer(view, path, "byteLength", 1, kMaxFileBytes, required);
        const std::uint64_t end = root_["buffers"][buffer]["byteLength"].get<std::uint64_t>();
        if (offset + length > end) {
            findings_.fatal(
                "{} ends at byte {}, but buffers[{}] has {}", path, offset + length, buffer, end);
        }
        const auto stride = integer(view, path, "byteStride", 0, kMaxFileBytes);
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
            integer(parent, path, "byteOffset", 0, kMaxFileBytes).value_or(0);
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
        integer(*use, place, "texCoord", 0, kMaxInteger);
        number(*use, place, "scale");
        clamped(*use, place, "strength", 0.0, 1.0);
        if (json* transform = extension(*use, place, "KHR_texture_transform")) {
            const std::string name = place + ".extensions.KHR_texture_transform";
            numbers(*transform, name, "offset", 2);
            numbers(*transform, name, "scale", 2);
            number(*transform, name, "rotation");
            integer(*transform, name, "texCoord", 0, kMaxInteger);
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

// --- Buffers and images --------------------------------------------------------------------------

std::vector<std::byte> load_buffer(const json& buffer, std::size_t number,
    const Container& container, const fs::path& folder, const GltfOptions& options,
    const GltfFindings& findings) {
    const auto declared = buffer["byteLength"].get<std::size_t>();
    const std::string what = fmt::format("buffers[{}]", number);
    std::vector<std::byte> bytes;
    if (const auto found = buffer.find("uri"); found != buffer.end()) {
        const auto& uri = found->get_ref<const std::string&>();
        if (is_remote_gltf_uri(uri)) {
            findings.note("{} is left out: uri '{}' is not a relative path", what, shortened(uri));
            return {};
        }
        try {
            bytes = read_gltf_uri(uri, folder, options.allow_external);
        } catch (const Error& error) {
            findings.fatal("{}: {}", what, error.what());
        }

    } else if (number == 0 && container.has_binary_chunk) {
        bytes.assign(container.binary.begin(), container.binary.end());
    } else {
        if (container.is_binary && number == 0) {
            findings.fatal("{} refers to the BIN chunk, which the GLB has not", what);
        }
        return {};
    }
    if (bytes.size() < declared) {
        findings.fatal("{} declares {} bytes, its data has {}", what, declared, bytes.size());
    }
    bytes.resize(declared);
    return bytes;
}

} // namespace

bool is_remote_gltf_uri(const std::string& uri) {
    return !uri.starts_with("data:") && has_scheme(uri) && !uri.starts_with(":");
}

std::vector<std::byte> read_gltf_uri(
    const std::string& uri, const fs::path& folder, bool allow_external) {
    if (uri.starts_with("data:")) return decode_data_uri(uri);
    if (has_scheme(uri)) fail_input("uri '{}' is not a relative path", shortened(uri));
    const std::optional<std::string> name = percent_decode(uri);
    if (!name || name->empty() || name->find('\0') != std::string::npos) {
        fail_input("uri '{}' is not a path", shortened(uri));
    }
    const fs::path relative(*name);
    const bool leaves = relative.is_absolute() || name->find('\\') != std::string::npos ||
                        std::find(relative.begin(), relative.end(), "..") != relative.end();
    if (leaves && !allow_external) {
        fail_input("uri '{}' leaves the folder of the file; --allow-external permits that",
            shortened(uri));
    }
    return read_file(folder / relative, kMaxFileBytes);
}

GltfFile read_gltf_file(
    const fs::path& path, const GltfOptions& options, const GltfFindings& findings) {
    const std::vector<std::byte> bytes = read_file(path, kMaxFileBytes);
    const Container container = open_container(bytes, findings);
    json root = parse_json(container.json, findings);
    JsonChecker checker(root, findings);
    checker.check_all();

    GltfFile file;
    file.unknown_accessors = checker.take_unknown_accessors();
    const auto take = [&](const char* key) {
        json list = root.contains(key) ? std::move(root[key]) : json::array();
        root.erase(key);
        return list;
    };
    if (!take("animations").empty()) findings.note("animations are ignored");
    if (!take("skins").empty()) findings.note("skins are ignored: meshes stay in their rest pose");
    for (const json& buffer : take("buffers")) {
        file.buffers.push_back(load_buffer(
            buffer, file.buffers.size(), container, path.parent_path(), options, findings));
    }
    for (const json& image : take("images")) {
        file.images.push_back({image.value("name", std::string()),
            image.value("uri", std::string()), image.value("bufferView", -1)});
    }

    // tinygltf refuses indices whose accessor has no buffer view, though glTF allows it.
    if (root.contains("accessors")) {
        json& views = root["bufferViews"];
        file.zeros_view = static_cast<int>(views.size());
        views.push_back({{"buffer", 0}, {"byteLength", 1}});
        for (json& accessor : root["accessors"]) {
            if (!accessor.contains("bufferView")) accessor["bufferView"] = file.zeros_view;
        }
    }
    file.json = root.dump(-1, ' ', true);
    return file;
}

} // namespace ockham
