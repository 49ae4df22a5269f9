// SPDX-License-Identifier: Apache-2.0
// Checks the JSON of a glTF file: every type, range, reference and cycle of what the loader reads.
// tinygltf ignores what it does not understand, so it gets to see checked JSON only.
// Private to io/gltf.
#pragma once

#include "framework/io/gltf_findings.hpp"

#include <nlohmann/json_fwd.hpp>

#include <vector>

namespace ockham {

/// Checks `root`, an object, and turns integers that are written as floats (1.0) into integers,
/// and factors out of range into such within. Throws Error(input) naming the object.
/// Returns one flag per accessor: true where it has a type that glTF 2.0 does not know; such an
/// accessor is replaced by a byte of zero and must not be read.
std::vector<bool> check_gltf_json(nlohmann::json& root, const GltfFindings& findings);

} // namespace ockham
