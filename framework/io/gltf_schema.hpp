// SPDX-License-Identifier: Apache-2.0
// What --strict asks of glTF's JSON beyond what the loader reads: types, ranges, references and
// places of every property of glTF 2.0 and of the ratified extensions that have a table here.
// Not the rules that span objects (gltf_rules). Private to io/gltf.
#pragma once

#include "framework/io/gltf_findings.hpp"

#include <nlohmann/json_fwd.hpp>

namespace ockham {

/// Refuses, with the name of the object, whatever in `root` is not as the specification's tables
/// (glTF 2.0, chapter 5) want it. Properties that no table knows are valid. Only for --strict.
/// After it has returned, each reference is to an object that is there, but for the samplers of
/// animations.
void check_gltf_schema(const nlohmann::json& root, const GltfFindings& findings);

} // namespace ockham
