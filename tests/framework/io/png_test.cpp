// SPDX-License-Identifier: Apache-2.0
// PNG in and out, and the choice between PNG and EXR by name.
#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "framework/io/image_file.hpp"
#include "framework/io/png.hpp"
#include "tests/support/file_test.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>

namespace ockham {
namespace {

namespace fs = std::filesystem;

class Png : public test::FileTest {};

template <class Function>
std::string error_of(Function function) {
    try {
        function();
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::input);
        return error.what();
    }
    return "no error";
}

/// Without the care that files under test get: thousands of flushes to the disk take seconds.
void scribble(const fs::path& path, std::string_view bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
}

bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

/// Appends to a PNG under construction.
class PngBytes {
public:
    PngBytes() { text_ = "\x89PNG\r\n\x1a\n"; }
    PngBytes& chunk(const std::string& type, const std::string& data) {
        append_big_endian(data.size());
        text_ += type + data;
        append_big_endian(crc32(type + data));
        return *this;
    }
    PngBytes& header(unsigned width, unsigned height, int depth, int color_type) {
        std::string data(13, '\0');
        for (unsigned i = 0; i < 4; ++i) {
            data[i] = static_cast<char>(width >> (24 - 8 * i));
            data[4 + i] = static_cast<char>(height >> (24 - 8 * i));
        }
        data[8] = static_cast<char>(depth);
        data[9] = static_cast<char>(color_type);
        return chunk("IHDR", data);
    }
    /// Rows (each with its filter byte) in one stored zlib block; needs no compressor.
    PngBytes& pixels(const std::string& rows) {
        std::string data("\x78\x01\x01", 3);
        const auto size = static_cast<unsigned>(rows.size());
        for (const unsigned half : {size, ~size}) {
            data += {static_cast<char>(half), static_cast<char>(half >> 8)};
        }
        unsigned a = 1, b = 0;
        for (const char byte : rows) {
            a = (a + static_cast<unsigned char>(byte)) % 65521;
            b = (b + a) % 65521;
        }
        data += rows;
        for (const unsigned half : {b, a}) {
            data += {static_cast<char>(half >> 8), static_cast<char>(half)};
        }
        return chunk("IDAT", data);
    }
    const std::string& end() { return chunk("IEND", "").text_; }

private:
    void append_big_endian(std::size_t value) {
        for (int shift = 24; shift >= 0; shift -= 8) text_ += static_cast<char>(value >> shift);
    }
    static std::uint32_t crc32(const std::string& data) {
        std::uint32_t crc = ~0u;
        for (const char byte : data) {
            crc ^= static_cast<unsigned char>(byte);
            for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (crc & 1 ? 0xedb88320u : 0u);
        }
        return ~crc;
    }
    std::string text_;
};

TEST_F(Png, All256BytesSurviveARoundTrip) {
    std::vector<std::uint8_t> bytes(256 * 3);
    for (std::size_t i = 0; i < 256; ++i) {
        bytes[3 * i] = static_cast<std::uint8_t>(i);
        bytes[3 * i + 1] = static_cast<std::uint8_t>(255 - i);
        bytes[3 * i + 2] = static_cast<std::uint8_t>(i ^ 0x55);
    }
    save_png_srgb(file("a.png"), 32, 8, bytes);
    const Image image = load_png(file("a.png"));
    ASSERT_EQ(image.width(), 32);
    ASSERT_EQ(image.height(), 8);
    EXPECT_EQ(image.channels(), (std::vector<std::string>{"R", "G", "B"}));
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        EXPECT_EQ(image.plane(static_cast<int>(i % 3))[i / 3],
            srgb_decode(static_cast<float>(bytes[i]) / 255.0f));
    }
    save_png8(file("b.png"), image);
    EXPECT_EQ(read_text(file("a.png")), read_text(file("b.png")));
    EXPECT_EQ(files(), 2u);
}

TEST_F(Png, RoundsToNearestAndClamps) {
    Image image(6, 1, {"R", "G", "B"});
    const float below = srgb_decode(100.49f / 255.0f), above = srgb_decode(100.51f / 255.0f);
    const std::array<float, 6> values{below, above, -1.0f, 7.0f,
        std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()};
    const std::array<int, 6> expected{100, 101, 0, 255, 255, 0};
    for (int c = 0; c < 3; ++c) std::ranges::copy(values, image.plane(c).begin());
    save_png8(file("a.png"), image);
    const Image back = load_png(file("a.png"));
    for (int x = 0; x < 6; ++x) {
        EXPECT_EQ(std::lround(255.0f * srgb_encode(back.at(x, 0, 1))),
            expected[static_cast<std::size_t>(x)]);
    }
    ASSERT_EQ(warnings_.size(), 1u);
    EXPECT_TRUE(contains(warnings_[0], "3 values are NaN")) << warnings_[0];
}

TEST_F(Png, ExposureAndTonemap) {
    Image image(1, 1, {"R", "G", "B"});
    image.at(0, 0, 0) = 0.25f;
    image.at(0, 0, 1) = 0.1f;
    save_png8(file("bright.png"), image, 2.0f);
    const Image bright = load_png(file("bright.png"));
    EXPECT_EQ(bright.at(0, 0, 0), 1.0f * srgb_decode(1.0f));
    EXPECT_NEAR(bright.at(0, 0, 1), 0.4f, 0.003f);
    save_png8(file("aces.png"), image, 2.0f, Tonemap::aces);
    // 0.6 * (2.51 * 0.6 + 0.03) / (0.6 * (2.43 * 0.6 + 0.59) + 0.14)
    EXPECT_NEAR(load_png(file("aces.png")).at(0, 0, 0), 0.673291f, 0.004f);
}

TEST(Tonemap, RisesFromZeroToOne) {
    for (const Tonemap curve : {Tonemap::none, Tonemap::aces}) {
        float before = tonemap(-3.0f, curve);
        EXPECT_EQ(before, 0.0f);
        for (float x = 0.01f; x < 1e5f; x *= 1.5f) {
            const float y = tonemap(x, curve);
            EXPECT_GE(y, before);
            EXPECT_LE(y, 1.0f);
            before = y;
        }
        EXPECT_EQ(before, 1.0f);
        EXPECT_EQ(tonemap(std::numeric_limits<float>::infinity(), curve), 1.0f);
        EXPECT_EQ(tonemap(std::numeric_limits<float>::quiet_NaN(), curve), 0.0f);
    }
}

TEST_F(Png, AlphaIsWrittenOnRequestAndLinear) {
    Image image(2, 1, {"A", "R", "G", "B"});
    image.at(1, 0, 0) = 0.5f;
    save_png8(file("without.png"), image);
    EXPECT_FALSE(load_png(file("without.png")).find("A").has_value());
    save_png8(file("with.png"), image, 3.0f, Tonemap::none, true);
    const Image back = load_png(file("with.png"));
    ASSERT_TRUE(back.find("A").has_value());
    EXPECT_EQ(back.plane("A")[0], 0.0f);
    EXPECT_FLOAT_EQ(back.plane("A")[1], 128.0f / 255.0f);
}

TEST_F(Png, ReadsGreyAlphaAndSixteenBits) {
    scribble(
        file("grey.png"), PngBytes().header(2, 1, 8, 0).pixels(std::string("\0\x40\x80", 3)).end());
    const Image grey = load_png(file("grey.png"));
    for (int c = 0; c < 3; ++c) EXPECT_EQ(grey.at(1, 0, c), srgb_decode(128.0f / 255.0f));
    EXPECT_EQ(grey.channels().size(), 3u);

    scribble(file("grey_alpha.png"),
        PngBytes().header(1, 1, 8, 4).pixels(std::string("\0\x40\x80", 3)).end());
    const Image grey_alpha = load_png(file("grey_alpha.png"));
    EXPECT_EQ(grey_alpha.at(0, 0, 2), srgb_decode(64.0f / 255.0f));
    EXPECT_EQ(grey_alpha.plane("A")[0], 128.0f / 255.0f);

    scribble(file("deep.png"),
        PngBytes().header(1, 1, 16, 2).pixels(std::string("\0\x12\x34\x80\x01\xff\xff", 7)).end());
    const Image deep = load_png(file("deep.png"));
    EXPECT_EQ(deep.at(0, 0, 0), srgb_decode(static_cast<float>(0x1234) / 65535.0f));
    EXPECT_EQ(deep.at(0, 0, 1), srgb_decode(static_cast<float>(0x8001) / 65535.0f));
    EXPECT_EQ(deep.at(0, 0, 2), srgb_decode(1.0f));
}

TEST_F(Png, EveryDamagedByteIsAnError) {
    std::vector<std::uint8_t> bytes(12 * 9 * 3);
    for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i * 37);
    save_png_srgb(file("a.png"), 12, 9, bytes);
    const std::string whole = read_text(file("a.png"));
    for (std::size_t i = 0; i < whole.size(); ++i) {
        std::string damaged = whole;
        damaged[i] = static_cast<char>(damaged[i] ^ 0x10);
        scribble(file("damaged.png"), damaged);
        const std::string text = error_of([&] { load_png(file("damaged.png")); });
        ASSERT_TRUE(contains(text, "damaged.png' as PNG: ")) << "byte " << i << ": " << text;
    }
    for (std::size_t size = 0; size < whole.size(); ++size) {
        scribble(file("cut.png"), std::string_view(whole).substr(0, size));
        const std::string text = error_of([&] { load_png(file("cut.png")); });
        ASSERT_TRUE(contains(text, "cut.png' as PNG: ")) << size << " bytes: " << text;
    }
}

TEST_F(Png, RefusesWhatIsNoPng) {
    EXPECT_TRUE(contains(error_of([&] { load_png(file("missing.png")); }), "No such file"));
    EXPECT_TRUE(contains(error_of([&] { load_png(folder_); }), "it is a folder"));
    scribble(file("garbage.png"), std::string(1000, 'x'));
    EXPECT_TRUE(contains(error_of([&] { load_png(file("garbage.png")); }),
        "it does not begin with PNG's signature"));
    scribble(file("huge.png"), PngBytes().header(100000, 90000, 8, 2).pixels("").end());
    const std::string text = error_of([&] { load_png(file("huge.png")); });
    EXPECT_TRUE(contains(text, "huge.png' as PNG: ")) << text;
    scribble(file("large.png"), PngBytes().header(10000, 10000, 8, 2).pixels("").end());
    EXPECT_TRUE(contains(error_of([&] { load_png(file("large.png")); }),
        "it has 10000 x 10000 pixels of 3 channels, the limit is 268435456 values"));
    scribble(file("empty.png"), PngBytes().header(0, 5, 8, 2).pixels("").end());
    EXPECT_TRUE(contains(error_of([&] { load_png(file("empty.png")); }), "empty.png' as PNG: "));
    scribble(file("short.png"),
        PngBytes().header(2, 2, 8, 2).pixels(std::string("\0\1\2\3\4\5\6", 7)).end());
    EXPECT_TRUE(contains(error_of([&] { load_png(file("short.png")); }), "short.png' as PNG: "));
}

TEST_F(Png, OutputsThatCannotBeWritten) {
    const Image image(3, 3, {"R", "G", "B"});
    EXPECT_TRUE(contains(error_of([&] { save_png8("/dev/full", image); }), "No space left"));
    EXPECT_TRUE(contains(error_of([&] { save_png8(folder_, image); }), "it is a folder"));
    EXPECT_TRUE(
        contains(error_of([&] { save_png8(file("missing") / "a.png", image); }), "No such file"));
    EXPECT_TRUE(contains(error_of([&] {
        save_png8(file("a.png"), Image(1, 1, {"R", "Z"}));
    }),
        "a PNG needs channel G, the image has R, Z"));
    EXPECT_EQ(files(), 0u);
}

TEST_F(Png, ImageFilesAreChosenByExtension) {
    Image image(2, 2, {"R", "G", "B", "k"});
    image.at(1, 1, 3) = 5.0f;
    save_image(file("a.EXR"), image, 4.0f, Tonemap::aces);
    EXPECT_EQ(load_image(file("a.EXR")).plane("k")[3], 5.0f);
    save_image(file("a.png"), image);
    EXPECT_EQ(load_image(file("a.png")).channels().size(), 3u);
    for (const std::string leaf : {"a.jpg", "png", "a.", "a"}) {
        EXPECT_TRUE(contains(
            error_of([&] { save_image(file(leaf), image); }), "picture files end in .exr or .png"));
        EXPECT_TRUE(contains(error_of([&] { load_image(file(leaf)); }), leaf + "'"));
        EXPECT_NE(error_of([&] { is_exr_path(file(leaf)); }), "no error");
    }
    EXPECT_FALSE(is_exr_path("a.Png"));
    EXPECT_EQ(files(), 2u);
}

} // namespace
} // namespace ockham
