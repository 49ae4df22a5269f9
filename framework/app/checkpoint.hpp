// SPDX-License-Identifier: Apache-2.0
// The file from which an interrupted run goes on: what was run, how far it came, and all that its
// graph keeps. One file, written whole or not at all. Called by samples that accumulate.
#pragma once

#include "framework/runtime/executor.hpp"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <vector>

namespace ockham {

struct Checkpoint {
    /// Everything that decides the result, by name. Values are compared as they are printed.
    nlohmann::ordered_json identity;
    nlohmann::ordered_json progress; ///< the program's own: how far it came
    std::vector<SavedResource> resources;
};

/// Throws Error(input) naming the file where it cannot be written; an older one then survives.
void save_checkpoint(const std::filesystem::path& path, const Checkpoint& checkpoint);

/// Throws Error(input) naming the file where it is no checkpoint, is damaged, or was written by a
/// run that differs from `identity`: then with what differs, and both values.
Checkpoint load_checkpoint(
    const std::filesystem::path& path, const nlohmann::ordered_json& identity);

} // namespace ockham
