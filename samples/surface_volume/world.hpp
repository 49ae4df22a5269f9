// SPDX-License-Identifier: Apache-2.0
// Scenes with a volume among them, from the command line: which input is which, where the volume
// is, one light for both. No rendering. Called by surface_volume and the viewer.
#pragma once

#include "framework/app/scene_source.hpp"
#include "framework/app/volume_source.hpp"
#include "passes/pipelines/surface_volume.hpp"

#include <optional>
#include <string>
#include <vector>

namespace ockham {

/// As on the command line; docs/cli.md says what each may be.
struct WorldOptions {
    std::vector<std::string> inputs; ///< none: builtin:atrium builtin:cloud
    std::string environment;
    std::string place;
};

/// Declares them with the flags of scenes and of volumes; all must outlive `params`.
void add_world_options(
    Params& params, WorldOptions& world, SceneOptions& scene, VolumeOptions& volume);

/// What is rendered: a scene, a volume, or both.
struct World {
    std::optional<Scene> scene;
    std::optional<VolumeSource> volume; ///< its view without seed and bounces
    VolumePlacement placement;
};

/// Loads what `options` names, with the flags of `scene` and `volume`. Throws Error(input) naming
/// the file or the flag.
World load_world(const WorldOptions& options, SceneOptions scene, VolumeOptions volume,
    const CommonOptions& common);

/// "tx,ty,tz rx,ry,rz scale"; none: at the origin, upright, 1. Throws Error(input).
VolumePlacement parse_place(const std::string& text);

/// As update_view() of volume_source.hpp, in the light of `scene`, which --light does not change.
void update_view(const WorldOptions& options, const VolumeOptions& volume, const Scene& scene,
    VolumeSource& source);

} // namespace ockham
