// SPDX-License-Identifier: Apache-2.0
#include "framework/io/gltf_pictures.hpp"

#include "framework/io/gltf_uri.hpp"

#include <nlohmann/json.hpp>
#include <stb_image.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace ockham {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// The media type by the first bytes, or nothing.
std::string media_type(std::span<const std::byte> bytes) {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (text.starts_with("\x89PNG\r\n\x1A\n")) return "image/png";
    if (text.starts_with("\xFF\xD8\xFF")) return "image/jpeg";
    if (text.starts_with("RIFF") && text.substr(0, 12).ends_with("WEBP")) return "image/webp";
    return "";
}

/// RFC 2397: "data:", a media type, parameters with '=', perhaps ";base64", a comma.
bool is_data_uri(std::string_view uri) {
    const std::size_t comma = uri.find(',');
    if (comma == std::string_view::npos) return false;
    std::string_view header = uri.substr(5, comma - 5);
    if (header.ends_with(";base64")) header.remove_suffix(7);
    std::size_t at = header.find(';');
    while (at != std::string_view::npos) {
        const std::size_t end = header.find(';', at + 1);
        if (header.substr(at, end - at).find('=') == std::string_view::npos) return false;
        at = end;
    }
    return true;
}

std::string declared_type(const std::string& uri) {
    return uri.substr(5, std::min(uri.find(','), uri.find(';')) - 5);
}

class PictureChecker {
public:
    PictureChecker(const json& root, const std::vector<std::vector<std::byte>>& buffers,
        const fs::path& folder, const GltfOptions& options, const GltfFindings& findings)
        : root_(root), buffers_(buffers), folder_(folder), options_(options), findings_(findings) {}

    void check_all() {
        for (const char* key : {"buffers", "images"}) {
            for (std::size_t i = 0; i < count(key); ++i) check_uri(root_[key][i], key, i);
        }
        for (std::size_t i = 0; i < count("images"); ++i) {
            types_.push_back(check_image(root_["images"][i], fmt::format("images[{}]", i)));
        }
        for (std::size_t i = 0; i < count("textures"); ++i) {
            check_texture(root_["textures"][i], fmt::format("textures[{}]", i));
        }
    }

private:
    std::size_t count(const char* key) const { return root_.contains(key) ? root_[key].size() : 0; }

    void check_uri(const json& user, const char* key, std::size_t i) const {
        const std::string uri = user.value("uri", std::string());
        const bool is_data = uri.starts_with("data:");
        if ((is_data && !is_data_uri(uri)) || uri.starts_with(':')) {
            findings_.refuse("{}[{}].uri '{}' is no URI", key, i, shortened(uri));
        }
    }

    /// The encoded bytes, or nothing where the file names no data that is at hand.
    std::optional<std::vector<std::byte>> bytes(const json& image, const std::string& where) const {
        if (image.contains("bufferView")) {
            const json& view = root_["bufferViews"][image["bufferView"].get<std::size_t>()];
            const std::vector<std::byte>& buffer = buffers_[view["buffer"].get<std::size_t>()];
            if (buffer.empty()) return std::nullopt;
            const auto data = std::span(buffer).subspan(
                view.value("byteOffset", std::size_t{0}), view["byteLength"].get<std::size_t>());
            return std::vector<std::byte>(data.begin(), data.end());
        }
        const std::string uri = image.value("uri", std::string());
        if (is_remote_gltf_uri(uri)) return std::nullopt;
        try {
            return read_gltf_uri(uri, folder_, options_.allow_external);
        } catch (const Error& error) {
            findings_.refuse("{}: {}", where, error.what());
        }
    }

    /// The media type of what is there, or nothing.
    std::string check_image(const json& image, const std::string& where) const {
        const auto data = bytes(image, where);
        if (!data) return "";
        const std::string found = media_type(*data);
        if (found.empty()) return "";
        const std::string uri = image.value("uri", std::string());
        for (const std::string& declared : {image.value("mimeType", std::string()),
                 uri.starts_with("data:") ? declared_type(uri) : std::string()}) {
            if (declared.empty() || declared == found) continue;
            findings_.refuse("{} is declared as {} and is {}", where, shortened(declared), found);
        }
        if (found == "image/webp") {
            if (!uses_webp())
                findings_.refuse("{} is WebP, but the file names no extension", where);
        } else if (!has_sound_header(*data)) {
            findings_.refuse("{}: the header of its picture is damaged", where);
        }
        return found;
    }

    static bool has_sound_header(std::span<const std::byte> bytes) {
        if (bytes.size() > std::numeric_limits<int>::max()) return false;
        int width = 0, height = 0, channels = 0;
        return stbi_info_from_memory(reinterpret_cast<const stbi_uc*>(bytes.data()),
                   static_cast<int>(bytes.size()), &width, &height, &channels) != 0;
    }

    bool uses_webp() const {
        if (!root_.contains("extensionsUsed")) return false;
        const json& used = root_["extensionsUsed"];
        return std::find(used.begin(), used.end(), "EXT_texture_webp") != used.end();
    }

    void check_texture(const json& texture, const std::string& where) const {
        if (texture.contains("source")) check_source(texture, where, false);
        if (!texture.contains("extensions")) return;
        const json& extensions = texture["extensions"];
        if (extensions.contains("EXT_texture_webp") &&
            extensions["EXT_texture_webp"].contains("source")) {
            check_source(extensions["EXT_texture_webp"], where, true);
        }
    }

    void check_source(const json& user, const std::string& where, bool is_webp) const {
        const std::string& found = types_[user["source"].get<std::size_t>()];
        if (found.empty() || (found == "image/webp") == is_webp) return;
        findings_.refuse("{} has a picture of type {}, which may not stand there", where, found);
    }

    const json& root_;
    const std::vector<std::vector<std::byte>>& buffers_;
    const fs::path& folder_;
    const GltfOptions& options_;
    const GltfFindings& findings_;
    std::vector<std::string> types_; ///< of images
};

} // namespace

void check_gltf_pictures(const json& root, const std::vector<std::vector<std::byte>>& buffers,
    const fs::path& folder, const GltfOptions& options, const GltfFindings& findings) {
    PictureChecker(root, buffers, folder, options, findings).check_all();
}

} // namespace ockham
