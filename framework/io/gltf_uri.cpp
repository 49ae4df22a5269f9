// SPDX-License-Identifier: Apache-2.0
#include "framework/io/gltf_uri.hpp"

#include "framework/core/file.hpp"
#include "framework/io/gltf_findings.hpp"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace ockham {
namespace {

namespace fs = std::filesystem;

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

/// RFC 3986: letters, digits and some signs up to the first colon.
bool has_scheme(std::string_view uri) {
    const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
    const std::size_t end = uri.find(':');
    if (end == std::string_view::npos || end == 0 || !is_letter(uri[0])) return false;
    return std::all_of(uri.begin(), uri.begin() + static_cast<std::ptrdiff_t>(end), [&](char c) {
        return is_letter(c) || (c >= '0' && c <= '9') || c == '+' || c == '-' || c == '.';
    });
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

} // namespace

bool is_remote_gltf_uri(const std::string& uri) {
    return !uri.starts_with("data:") && has_scheme(uri);
}

std::vector<std::byte> read_gltf_uri(
    const std::string& uri, const fs::path& folder, bool allow_external) {
    if (uri.starts_with("data:")) return decode_data_uri(uri);
    if (is_remote_gltf_uri(uri)) fail_input("uri '{}' is not a relative path", shortened(uri));
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
    return read_file(folder / relative, kMaxGltfBytes);
}

} // namespace ockham
