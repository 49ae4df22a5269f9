// SPDX-License-Identifier: Apache-2.0
// Whole files in and out. Writing is atomic: a temporary beside the target, flushed to the disk,
// re-read in full, then renamed, so that no partial file ever stands under the final name.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace ockham {

/// The bytes of a file. Throws Error(input) naming the path and the system's reason; refuses
/// folders, and files larger than `max_bytes`.
std::vector<std::byte> read_file(
    const std::filesystem::path& path, std::size_t max_bytes = std::size_t{1} << 32);
/// The same as text.
std::string read_text(
    const std::filesystem::path& path, std::size_t max_bytes = std::size_t{1} << 30);

/// Writes `bytes` under `path` atomically (temporary, fsync, verify, rename). Throws Error(input)
/// and leaves nothing behind if that fails; an older file under `path` then survives.
void write_file(const std::filesystem::path& path, std::span<const std::byte> bytes);
void write_text(const std::filesystem::path& path, std::string_view text);

/// For writers that insist on a path of their own: calls `write(temporary)`, then syncs and
/// renames it to `path`. `write` throws to give up; the temporary is removed then.
void write_atomically(const std::filesystem::path& path,
    const std::function<void(const std::filesystem::path& temporary)>& write);

/// Throws Error(input) unless a file could be created under `path` now: used before long work, so
/// that a typing mistake costs a second and not an hour.
void check_writable(const std::filesystem::path& path);

} // namespace ockham
