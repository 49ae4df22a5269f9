// SPDX-License-Identifier: Apache-2.0
// What --strict asks of the numbers in buffers: bounds as declared, unit vectors, weights that sum
// to 1, times that increase. Private to io/gltf.
#pragma once

#include "framework/io/gltf_findings.hpp"

#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <vector>

namespace ockham {

/// One per buffer of the file; empty where the file gives no data for it.
using GltfBuffers = std::vector<std::vector<std::byte>>;

/// Refuses accessors with values that break a rule of glTF 2.0, by name. Accessors without data
/// are valid. `root` has passed check_gltf_rules. Only for --strict.
void check_gltf_values(
    const nlohmann::json& root, const GltfBuffers& buffers, const GltfFindings& findings);

} // namespace ockham
