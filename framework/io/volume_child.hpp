// SPDX-License-Identifier: Apache-2.0
// Reads a volume in a process of its own: libraries that end the program on a bad file, or never
// come to an end with one, then end only that process. Private to io/volume.
#pragma once

#include "framework/scene/volume.hpp"

#include <filesystem>
#include <functional>

namespace ockham {

/// Whether a reader may take memory as it likes, because what is stated has been checked before, or
/// in proportion to what there is to read.
enum class Memory { any, by_file_size };

/// What `load` returns in a child of this process, or the Error that it throws there. Throws
/// Error(input) naming `path`, a file or folder, where the child is stopped by a signal, runs
/// longer than what is there can take, or fails otherwise. What the libraries print is dropped. The
/// child must not need threads that this process has started.
Volume load_in_child(
    const std::filesystem::path& path, Memory memory, const std::function<Volume()>& load);

} // namespace ockham
