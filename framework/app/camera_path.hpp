// SPDX-License-Identifier: Apache-2.0
// Several pictures in one run: cameras along a path of key cameras, from a JSON file, or around the
// scene. What --camera-path and --turntable show. Called by samples.
#pragma once

#include "framework/app/cli.hpp"
#include "framework/scene/camera.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace ockham {

/// {"keys": [{"camera": "px,py,pz tx,ty,tz fov"}, ...]}, at least one. `count` cameras evenly from
/// the first key to the last, between them linear in position, direction and angle; 0: the keys
/// themselves. Throws Error(input) naming the file and the key.
std::vector<Camera> load_camera_path(const std::filesystem::path& path, int count, UpAxis up);

struct CameraMoves {
    std::string path;
    int turntable = 0;
};

/// Declares --turntable and --camera-path; `moves` must outlive `params`.
void add_camera_moves(Params& params, CameraMoves& moves, const char* centre);

/// One camera per picture: --camera-path with `count` pictures (0: one for each key), --turntable
/// around `centre` from `first` on, or `first` alone; --orthographic goes for all. Throws
/// Error(input) where flags contradict each other.
std::vector<Camera> choose_cameras(const CameraMoves& moves, const CommonOptions& options,
    const Camera& first, glm::vec3 centre, UpAxis up, int count);

/// Throws Error(input) where several pictures share one name.
void check_numbered(const CommonOptions& options, std::size_t pictures);

} // namespace ockham
