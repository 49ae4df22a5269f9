// SPDX-License-Identifier: Apache-2.0
// Reads the elements of accessors as vertices and indices. Ranges of accessors and views have been
// checked by gltf_check; sparse indices are checked here. Private to io/gltf.
#pragma once

#include "framework/io/gltf_file.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tinygltf {
class Model;
struct Accessor;
} // namespace tinygltf

namespace ockham {

/// Borrows all it is given. Indices are those of accessors and views, and within them.
class GltfAccessorReader {
public:
    GltfAccessorReader(
        const tinygltf::Model& model, const GltfFile& file, const GltfFindings& findings)
        : model_(model), file_(file), findings_(findings) {}

    /// Throws Error(input) if its type is unknown.
    const tinygltf::Accessor& accessor(int index) const;
    /// True if it has neither a view nor sparse elements: such an accessor is valid, and all zeros.
    bool all_zero(int index) const;
    /// False if it lies in a buffer that the file gives no data for; then it must not be read.
    bool has_data(int index) const;

    /// The first components of each element, for glm::vec2, vec3 and vec4.
    template <class Vector>
    std::vector<Vector> floats(int index) const;
    /// Unsigned scalars.
    std::vector<std::uint32_t> integers(int index) const;
    /// The bytes of a view; none if its buffer has no data.
    std::span<const std::byte> view(int index) const;

private:
    bool view_has_data(int index) const;
    /// Calls take(element, first byte) for every element that has data, sparse ones last.
    template <class Take>
    void visit(int index, Take take) const;

    const tinygltf::Model& model_;
    const GltfFile& file_;
    const GltfFindings& findings_;
};

} // namespace ockham
