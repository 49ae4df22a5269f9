// SPDX-License-Identifier: Apache-2.0
// Scenes made by the program itself: deterministic, bit-equal on every machine, so that pictures,
// tests and tables need no files. Called by samples and tests.
#pragma once

#include "framework/scene/scene.hpp"

#include <string_view>
#include <vector>

namespace ockham {

/// Names that builtin_scene knows, with one line of help each.
struct BuiltinName {
    std::string_view name;
    std::string_view help;
};
const std::vector<BuiltinName>& builtin_scenes();

/// The scene of that name, with its own camera, lights and background. Throws Error(input) naming
/// the scenes there are.
Scene builtin_scene(std::string_view name);

} // namespace ockham
