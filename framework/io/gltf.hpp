// SPDX-License-Identifier: Apache-2.0
// glTF 2.0 (.gltf, .glb) to a Scene. Parsing is tinygltf's; every accessor, view, index, reference
// and cycle is validated here, since a read beyond a buffer must be impossible. Called by samples.
#pragma once

#include "framework/scene/scene.hpp"

#include <filesystem>

namespace ockham {

struct GltfOptions {
    /// Also refuse what is tolerated with a warning by default.
    bool strict = false;
    /// Allow resource URIs that leave the file's folder.
    bool allow_external = false;
};

/// Loads the default scene (or the first, or all root nodes). Throws Error(input) naming the file,
/// the glTF object and what was found. docs/formats.md lists what is read and what is refused.
Scene load_gltf(const std::filesystem::path& path, const GltfOptions& options = {});

} // namespace ockham
