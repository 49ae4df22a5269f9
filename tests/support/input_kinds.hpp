// SPDX-License-Identifier: Apache-2.0
// Every kind of file that programs take from others: good ones to begin with, and what reads them.
// The test of bad input and the fuzzer go through this one list.
#pragma once

#include <filesystem>
#include <functional>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

namespace ockham::test {

struct InputKind {
    std::string name;
    std::string file; ///< that is changed, by the name that its reader knows it by
    std::vector<std::string> good;
    /// Files beside it, which stay as they are: name and bytes.
    std::vector<std::pair<std::string, std::string>> beside;
    /// Throws ockham::Error and nothing else.
    std::function<void(const std::filesystem::path&)> load;
    /// Makes checksums right again, so that what lies behind them is reached; may be empty.
    std::function<std::string(const std::string&)> repair = {};

    /// Writes what is beside the file into `folder`.
    void write_beside(const std::filesystem::path& folder) const;
};

inline void PrintTo(const InputKind& kind, std::ostream* out) { *out << kind.name; }

/// Of this build: volumes through ITK only where that was found.
const std::vector<InputKind>& input_kinds();
/// What is checked before a library reads volumes, without that library and its process.
std::vector<InputKind> volume_check_kinds();

} // namespace ockham::test
