// SPDX-License-Identifier: Apache-2.0
// Base of the tests of load_volume(): files written by the test, and what loading them says.
#pragma once

#include "framework/core/error.hpp"
#include "framework/io/volume_file.hpp"
#include "tests/support/file_test.hpp"

#include <nlohmann/json.hpp>
#include <zlib.h>

#include <cstring>
#include <fstream>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>

namespace ockham::test {

/// The bytes of `count` values first, first + 1, ...
template <class T>
std::string ramp(std::size_t count, T first) {
    std::string bytes(count * sizeof(T), '\0');
    for (std::size_t i = 0; i < count; ++i) {
        const T value = static_cast<T>(first + static_cast<T>(i));
        std::memcpy(bytes.data() + i * sizeof(T), &value, sizeof(T));
    }
    return bytes;
}

/// A gzip stream, or with `bits` of 15 a zlib stream.
inline std::string gzip(std::string_view bytes, int bits = 15 + 16) {
    std::string packed(bytes.size() + 100, '\0');
    z_stream stream{};
    deflateInit2(&stream, 9, Z_DEFLATED, bits, 8, Z_DEFAULT_STRATEGY);
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    stream.avail_in = static_cast<uInt>(bytes.size());
    stream.next_out = reinterpret_cast<Bytef*>(packed.data());
    stream.avail_out = static_cast<uInt>(packed.size());
    EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
    packed.resize(stream.total_out);
    deflateEnd(&stream);
    return packed;
}

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
