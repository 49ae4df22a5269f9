// SPDX-License-Identifier: Apache-2.0
// Rig files: camera, background, ambient, sun and point lights as JSON, apart from the geometry.
#pragma once

#include "framework/scene/scene.hpp"

#include <filesystem>
#include <optional>

namespace ockham {

struct Rig {
    std::optional<Camera> camera;
    std::optional<glm::vec3> background;
    std::optional<glm::vec3> ambient;
    std::vector<Light> lights; ///< the sun first, then the points in file order
};

/// Reads a rig. `sun.toward` points to the sun, so light travels the other way; point lights fall
/// off as max(0, 1 - d^2/range^2) / (d^2 + 0.1). Throws Error(input) naming file, key and value.
Rig load_rig(const std::filesystem::path& path);

/// Replaces what the rig has in the scene: its camera comes first, its lights replace all others.
void apply(const Rig& rig, Scene& scene);

} // namespace ockham
