// SPDX-License-Identifier: Apache-2.0
// The pages that tests hold to what they say: README.md, CONTRIBUTING.md, docs/ and the samples'.
// OCKHAM_SOURCE_DIR is where they are.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace ockham::test {

inline const std::filesystem::path kRoot = OCKHAM_SOURCE_DIR;

inline std::vector<std::string> read_lines(const std::filesystem::path& path) {
    std::ifstream file(path);
    EXPECT_TRUE(file) << path;
    std::vector<std::string> lines;
    for (std::string line; std::getline(file, line);) lines.push_back(line);
    return lines;
}

/// In the order of their paths.
inline std::vector<std::filesystem::path> documents() {
    std::vector<std::filesystem::path> all{kRoot / "README.md", kRoot / "CONTRIBUTING.md"};
    for (const char* folder : {"docs", "samples"}) {
        for (const auto& entry : std::filesystem::recursive_directory_iterator(kRoot / folder))
            if (entry.path().extension() == ".md") all.push_back(entry.path());
    }
    std::sort(all.begin(), all.end());
    return all;
}

} // namespace ockham::test
