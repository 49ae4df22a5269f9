// SPDX-License-Identifier: Apache-2.0
// URIs of buffers and images: data URIs and files beside the glTF file. Never the network.
// Private to io/gltf.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace ockham {

/// Largest file that is read, also through a URI: a GLB holds its length in 32 bits.
constexpr std::size_t kMaxGltfBytes = 0xFFFFFFFF;

/// The bytes behind a URI: a data URI, or a file in `folder`. Throws Error(input) for every other
/// scheme, and for paths that leave the folder unless `allow_external`.
std::vector<std::byte> read_gltf_uri(
    const std::string& uri, const std::filesystem::path& folder, bool allow_external);

/// True for "http://..." and the like, which are valid but never fetched.
bool is_remote_gltf_uri(const std::string& uri);

} // namespace ockham
