// SPDX-License-Identifier: Apache-2.0
// Other programs, run by their arguments: no shell reads them, so that no name of a file can be
// anything else. Not for programs to talk with. Called by what asks other programs for an opinion.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace ockham {

/// Where `name` would be started from: itself if it has a '/', else looked up in PATH. Absolute.
/// Nothing where no file there may be executed.
std::optional<std::filesystem::path> find_program(const std::string& name);

struct ProcessResult {
    int exit_code = 0; ///< 128 + the signal that ended it
    std::string text;  ///< stdout and stderr, as they came
};

/// Runs `words[0]` with the others as its arguments, in `folder` (empty: where this process is),
/// with nothing to read, and waits for its end. Throws Error(input) where it cannot be started.
ProcessResult run_process(
    const std::vector<std::string>& words, const std::filesystem::path& folder = {});

/// An empty folder of its own among the system's temporary files, gone with this object.
class TemporaryFolder {
public:
    TemporaryFolder();
    ~TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    const std::filesystem::path& path() const { return path_; }

private:
    std::filesystem::path path_;
};

} // namespace ockham
