// SPDX-License-Identifier: Apache-2.0
// What --strict asks of URIs and pictures: well-formed data URIs, pictures that are there and of
// the type declared for them. Decodes none: what is drawn is decoded by io/gltf. Private to
// io/gltf.
#pragma once

#include "framework/io/gltf.hpp"
#include "framework/io/gltf_findings.hpp"

#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <filesystem>
#include <vector>

namespace ockham {

/// Refuses pictures that cannot be had, have a broken header or another type than declared, and
/// textures with pictures of a type that they may not have. `buffers`: one per buffer of the file,
/// empty where it gives no data; `folder`: what URIs are relative to. `root` has passed
/// check_gltf_rules. Only for --strict.
void check_gltf_pictures(const nlohmann::json& root,
    const std::vector<std::vector<std::byte>>& buffers, const std::filesystem::path& folder,
    const GltfOptions& options, const GltfFindings& findings);

} // namespace ockham
