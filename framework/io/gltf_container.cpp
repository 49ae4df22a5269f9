// SPDX-License-Identifier: Apache-2.0
#include "framework/io/gltf_container.hpp"

#include <cstdint>

namespace ockham {
namespace {

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
GltfContainer open_glb(std::span<const std::byte> bytes, const GltfFindings& findings) {
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
    GltfContainer container;
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

} // namespace

GltfContainer open_gltf_container(std::span<const std::byte> bytes, const GltfFindings& findings) {
    if (bytes.empty()) findings.fatal("the file is empty");
    if (as_text(bytes).starts_with("glTF")) return open_glb(bytes, findings);
    GltfContainer container;
    container.json = as_text(bytes);
    return container;
}

} // namespace ockham
