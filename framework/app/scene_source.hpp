// SPDX-License-Identifier: Apache-2.0
// Scenes from the command line: files and builtin: names loaded into one world, a rig laid over
// it, and overrides. Shared by the samples that render surfaces.
#pragma once

#include "framework/app/cli.hpp"
#include "framework/core/params.hpp"
#include "framework/scene/scene.hpp"

#include <string>
#include <vector>

namespace ockham {

struct SceneOptions {
    std::vector<std::string> scenes; ///< files or builtin:NAME; none: builtin:atrium
    std::string rig;
    float roughness = -1;    ///< >= 0: of every material
    int lights = -1;         ///< >= 0: only the first so many
    std::string environment; ///< "r,g,b": background radiance
};

void add_scene_options(Params& params, SceneOptions& options);
/// The same for programs that name scenes and environment themselves.
void add_scene_flags(Params& params, SceneOptions& options);
/// Whether an argument means a scene: .gltf, .glb, or the builtin: name of one.
bool names_scene(const std::string& argument);

/// Loads and merges. Throws Error(input) naming file, flag and what was found.
Scene load_scenes(const SceneOptions& options, const CommonOptions& common);

} // namespace ockham
