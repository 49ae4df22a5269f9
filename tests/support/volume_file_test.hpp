// SPDX-License-Identifier: Apache-2.0
// Base of the tests of load_volume(): files written by the test, and what loading them says.
#pragma once

#include "framework/core/error.hpp"
#include "framework/io/volume_file.hpp"
#include "tests/support/file_test.hpp"
#include "tests/support/volume_bytes.hpp"

#include <nlohmann/json.hpp>

#include <fstream>
#include <string>
#include <string_view>

namespace ockham::test {

class VolumeFileTest : public FileTest {
protected:
    /// Without the care that files under test get: thousands of flushes to the disk take seconds.
    void scribble(const std::string& name, std::string_view bytes) {
        std::filesystem::create_directories(file(name).parent_path());
        std::ofstream(file(name), std::ios::binary) << bytes;
    }
    Volume load(const std::string& name) { return load_volume(file(name).string()); }
    /// The error, or "loaded". Other exceptions end the test.
    std::string refusal(const std::string& name) {
        try {
            load(name);
        } catch (const Error& error) {
            EXPECT_EQ(error.kind(), ErrorKind::input);
            EXPECT_EQ(std::string_view(error.what()).find('\n'), std::string::npos);
            return error.what();
        }
        return "loaded";
    }
    static void expect_contains(const std::string& text, std::string_view part) {
        EXPECT_NE(text.find(part), std::string::npos) << text << "\n lacks: " << part;
    }
};

} // namespace ockham::test
