// SPDX-License-Identifier: Apache-2.0
// Cameras along a path of key cameras, from a JSON file: what --camera-path shows.
#pragma once

#include "framework/scene/camera.hpp"

#include <filesystem>
#include <vector>

namespace ockham {

/// {"keys": [{"camera": "px,py,pz tx,ty,tz fov"}, ...]}, at least one. `count` cameras evenly from
/// the first key to the last, between them linear in position, direction and angle; 0: the keys
/// themselves. Throws Error(input) naming the file and the key.
std::vector<Camera> load_camera_path(const std::filesystem::path& path, int count, UpAxis up);

} // namespace ockham
