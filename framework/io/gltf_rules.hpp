// SPDX-License-Identifier: Apache-2.0
// What --strict asks of objects that belong together: attributes of one primitive, joints of one
// skin, samplers of one animation. Types and references (gltf_schema) have been checked before;
// the numbers in buffers are gltf_values'. Private to io/gltf.
#pragma once

#include "framework/io/gltf_findings.hpp"

#include <nlohmann/json_fwd.hpp>

namespace ockham {

/// Refuses, with the name of the object, what breaks a rule of glTF 2.0 or of a ratified extension.
/// `root` has passed check_gltf_schema and check_gltf_json. Only for --strict.
void check_gltf_rules(const nlohmann::json& root, const GltfFindings& findings);

} // namespace ockham
