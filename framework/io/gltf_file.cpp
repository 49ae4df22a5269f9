// SPDX-License-Identifier: Apache-2.0
#include "framework/io/gltf_file.hpp"

#include "framework/core/file.hpp"
#include "framework/core/json_object.hpp"
#include "framework/io/gltf_check.hpp"
#include "framework/io/gltf_container.hpp"
#include "framework/io/gltf_pictures.hpp"
#include "framework/io/gltf_rules.hpp"
#include "framework/io/gltf_schema.hpp"
#include "framework/io/gltf_uri.hpp"
#include "framework/io/gltf_values.hpp"

#include <nlohmann/json.hpp>

#include <string_view>

namespace ockham {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

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

std::vector<std::byte> load_buffer(const json& buffer, std::size_t number,
    const GltfContainer& container, const fs::path& folder, const GltfOptions& options,
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

GltfFile read_gltf_file(
    const fs::path& path, const GltfOptions& options, const GltfFindings& findings) {
    const std::vector<std::byte> bytes = read_file(path, kMaxGltfBytes);
    const GltfContainer container = open_gltf_container(bytes, findings);
    json root = parse_json(container.json, findings);
    GltfFile file;
    if (options.strict) check_gltf_schema(root, findings);
    file.unknown_accessors = check_gltf_json(root, findings);
    if (options.strict) check_gltf_rules(root, findings);
    if (root.contains("buffers")) {
        for (const json& buffer : root["buffers"]) {
            file.buffers.push_back(load_buffer(
                buffer, file.buffers.size(), container, path.parent_path(), options, findings));
        }
    }
    if (options.strict) {
        check_gltf_values(root, file.buffers, findings);
        check_gltf_pictures(root, file.buffers, path.parent_path(), options, findings);
    }
    const auto take = [&](const char* key) {
        json list = root.contains(key) ? std::move(root[key]) : json::array();
        root.erase(key);
        return list;
    };
    if (!take("animations").empty()) findings.note("animations are ignored");
    if (!take("skins").empty()) findings.note("skins are ignored: meshes stay in their rest pose");
    take("buffers");
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
