// SPDX-License-Identifier: Apache-2.0
// The outer layer of a glTF file: plain JSON, or a GLB with a JSON and a BIN chunk. Private to
// io/gltf.
#pragma once

#include "framework/io/gltf_findings.hpp"

#include <cstddef>
#include <span>
#include <string_view>

namespace ockham {

/// Views into the bytes of the file.
struct GltfContainer {
    std::string_view json;
    std::span<const std::byte> binary;
    bool is_binary = false;
    bool has_binary_chunk = false;
};

/// Splits `bytes`. Throws Error(input) unless the chunks of a GLB are whole and in order.
GltfContainer open_gltf_container(std::span<const std::byte> bytes, const GltfFindings& findings);

} // namespace ockham
