// SPDX-License-Identifier: Apache-2.0
// A glTF file taken apart: checked JSON for tinygltf, buffers, and where images are.
// Private to io/gltf, which turns it into a Scene.
#pragma once

#include "framework/io/gltf.hpp"
#include "framework/io/gltf_findings.hpp"

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace ockham {

/// Where the encoded bytes of an image are: `uri` or a buffer view.
struct GltfImageSource {
    std::string name;
    std::string uri;
    int buffer_view = -1;
};

struct GltfFile {
    /// Checked JSON for tinygltf, without buffers, images, animations and skins. An accessor
    /// without a buffer view refers to the one past the file's own: see `zeros_view`.
    std::string json;
    int zeros_view = 0;
    /// One per accessor; true: it has a type that glTF 2.0 does not know and must not be read.
    std::vector<bool> unknown_accessors;
    /// Cut to their declared length; empty if the file gives no data for it.
    std::vector<std::vector<std::byte>> buffers;
    std::vector<GltfImageSource> images;
};

/// Reads and checks `path`. Throws Error(input) naming file, object, and what was found.
GltfFile read_gltf_file(
    const std::filesystem::path& path, const GltfOptions& options, const GltfFindings& findings);

} // namespace ockham
