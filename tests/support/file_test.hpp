// SPDX-License-Identifier: Apache-2.0
// Base of tests that write files: a folder of its own for each test, removed afterwards, and the
// warnings that were logged meanwhile.
#pragma once

#include "framework/core/log.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <vector>

namespace ockham::test {

class FileTest : public testing::Test {
protected:
    FileTest() {
        const testing::TestInfo& test = *testing::UnitTest::GetInstance()->current_test_info();
        folder_ = std::filesystem::path(testing::TempDir()) /
                  fmt::format("ockham_{}_{}_{}", test.test_suite_name(), test.name(), ::getpid());
        std::filesystem::create_directories(folder_);
        log::set_sink([this](log::Level level, std::string_view text) {
            if (level == log::Level::warning) warnings_.emplace_back(text);
        });
    }
    ~FileTest() override {
        log::set_sink({});
        std::filesystem::remove_all(folder_);
    }
    std::filesystem::path file(const std::string& leaf) const { return folder_ / leaf; }
    /// How many files the folder has.
    std::size_t files() const {
        using std::filesystem::directory_iterator;
        return static_cast<std::size_t>(
            std::distance(directory_iterator(folder_), directory_iterator()));
    }

    std::filesystem::path folder_;
    std::vector<std::string> warnings_;
};

} // namespace ockham::test
