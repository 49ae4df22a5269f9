// SPDX-License-Identifier: Apache-2.0
// A glTF file taken apart and checked: container, JSON, buffers, image sources. Every reference,
// range and cycle has been validated here, because tinygltf ignores what it does not understand.
// Private to io/gltf, which turns the result into a Scene.
#pragma once

#include "framework/core/error.hpp"
#include "framework/core/log.hpp"
#include "framework/io/gltf.hpp"

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace ockham {

/// What is wrong with one file, in three degrees.
class GltfFindings {
public:
    GltfFindings(std::string file, bool strict) : file_(std::move(file)), strict_(strict) {}

    /// Makes a read undefined, or cannot be given a meaning: throws Error(input).
    template <class... Args>
    [[noreturn]] void fatal(fmt::format_string<Args...> text, Args&&... args) const {
        fail_input("cannot load '{}': {}", file_, fmt::format(text, std::forward<Args>(args)...));
    }
    /// Invalid, but harmless: a warning; throws as `fatal` does if strict.
    template <class... Args>
    void tolerate(fmt::format_string<Args...> text, Args&&... args) const {
        const std::string found = fmt::format(text, std::forward<Args>(args)...);
        if (strict_) fail_input("cannot load '{}': {}; --strict refuses this", file_, found);
        log::warning("{}: {}", file_, found);
    }
    /// Valid, but not supported or not usual: a warning.
    template <class... Args>
    void note(fmt::format_string<Args...> text, Args&&... args) const {
        log::warning("{}: {}", file_, fmt::format(text, std::forward<Args>(args)...));
    }

private:
    std::string file_;
    bool strict_;
};

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

/// The bytes behind a URI: a data URI, or a file in `folder`. Throws Error(input) for every other
/// scheme, and for paths that leave the folder unless `allow_external`.
std::vector<std::byte> read_gltf_uri(
    const std::string& uri, const std::filesystem::path& folder, bool allow_external);

/// True for "http://..." and the like, which are valid but never fetched.
bool is_remote_gltf_uri(const std::string& uri);

} // namespace ockham
