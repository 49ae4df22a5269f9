// SPDX-License-Identifier: Apache-2.0
// EXR in and out: what is written comes back bit for bit; what others write is read; damaged files
// and outputs that cannot be written end in one clear error.
#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "framework/io/exr.hpp"
#include "tests/support/file_test.hpp"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDeepFrameBuffer.h>
#include <OpenEXR/ImfDeepScanLineOutputFile.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfTiledOutputFile.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>

namespace ockham {
namespace {

namespace fs = std::filesystem;

class Exr : public test::FileTest {};

Image sample_image(int width = 7, int height = 5) {
    Image image(width, height, {"R", "G", "B", "A", "depth.Z", "k"});
    for (int c = 0; c < 6; ++c) {
        for (std::size_t i = 0; i < image.pixels(); ++i) {
            image.plane(c)[i] = std::sin(static_cast<float>(i) + 10.0f * static_cast<float>(c)) * 3;
        }
    }
    image.at(0, 0, 0) = std::numeric_limits<float>::quiet_NaN();
    image.at(1, 0, 0) = std::numeric_limits<float>::infinity();
    image.at(2, 0, 0) = std::numeric_limits<float>::denorm_min();
    image.at(3, 0, 0) = -0.0f;
    image.metadata = {{"ockham.command", "adaptive_aa --m 4"}, {"comments", "two\nlines, \u00e4"}};
    return image;
}

bool same_bits(std::span<const float> a, std::span<const float> b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

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

TEST_F(Exr, FloatsComeBackBitForBit) {
    for (const auto& [width, height] : {std::pair{4, 1}, std::pair{7, 5}, std::pair{64, 64}}) {
        const Image image = sample_image(width, height);
        save_exr(file("a.exr"), image);
        const Image back = load_exr(file("a.exr"));
        EXPECT_EQ(back.width(), image.width());
        EXPECT_EQ(back.height(), image.height());
        EXPECT_EQ(back.channels(), image.channels());
        EXPECT_EQ(back.metadata, image.metadata);
        for (const std::string& channel : image.channels()) {
            EXPECT_TRUE(same_bits(back.plane(channel), image.plane(channel))) << channel;
        }
    }
    EXPECT_EQ(files(), 1u);
    EXPECT_TRUE(warnings_.empty());
}

TEST_F(Exr, HalvesAreRoundedToNearestAndClamped) {
    Image image(6, 1, {"R", "Y"});
    const std::array<float, 6> in{1.0f + 0x1p-11f, 1.0f + 0x1.8p-11f, 1e6f, -1e6f, 65504.0f,
        std::numeric_limits<float>::infinity()};
    const std::array<float, 6> out{1.0f, 1.0f + 0x1p-10f, 65504.0f, -65504.0f, 65504.0f,
        std::numeric_limits<float>::infinity()};
    std::ranges::copy(in, image.plane("R").begin());
    save_exr(file("half.exr"), image, true);
    const Image back = load_exr(file("half.exr"));
    EXPECT_TRUE(same_bits(back.plane("R"), out));
    ASSERT_EQ(warnings_.size(), 1u);
    EXPECT_TRUE(contains(warnings_[0], "2 values were beyond the largest half")) << warnings_[0];
}

TEST_F(Exr, ReadsTilesUnsignedAndOffsetWindows) {
    const Imath::Box2i display({0, 0}, {99, 99}), data({-3, 20}, {36, 48}); // 40 x 29
    const std::size_t width = 40, height = 29;
    std::vector<std::uint32_t> ids(width * height);
    std::vector<Imath::half> red(width * height);
    for (std::size_t i = 0; i < ids.size(); ++i) {
        ids[i] = static_cast<std::uint32_t>(i * 3);
        red[i] = static_cast<float>(i) / 8.0f;
    }
    Imf::Header header(display, data);
    header.setTileDescription(Imf::TileDescription(16, 8, Imf::MIPMAP_LEVELS));
    header.channels().insert("id", Imf::Channel(Imf::UINT));
    header.channels().insert("R", Imf::Channel(Imf::HALF));
    {
        Imf::TiledOutputFile out(file("tiles.exr").c_str(), header);
        Imf::FrameBuffer frame;
        frame.insert("id", Imf::Slice::Make(Imf::UINT, ids.data(), data));
        frame.insert("R", Imf::Slice::Make(Imf::HALF, red.data(), data));
        out.setFrameBuffer(frame);
        for (int level = 0; level < out.numLevels(); ++level) {
            out.writeTiles(0, out.numXTiles(level) - 1, 0, out.numYTiles(level) - 1, level);
        }
    }
    const Image image = load_exr(file("tiles.exr"));
    ASSERT_EQ(image.width(), 40);
    ASSERT_EQ(image.height(), 29);
    EXPECT_EQ(image.channels(), (std::vector<std::string>{"R", "id"}));
    for (std::size_t i = 0; i < ids.size(); ++i) {
        EXPECT_EQ(image.plane("id")[i], static_cast<float>(ids[i]));
        EXPECT_EQ(image.plane("R")[i], static_cast<float>(red[i]));
    }
    ASSERT_EQ(warnings_.size(), 1u);
    EXPECT_TRUE(contains(warnings_[0], "40 x 29")) << warnings_[0];
}

TEST_F(Exr, ReadsTheFirstOfSeveralPartsAndSaysSo) {
    std::array<Imf::Header, 2> headers{Imf::Header(4, 2), Imf::Header(4, 2)};
    for (std::size_t i = 0; i < 2; ++i) {
        headers[i].setName(i == 0 ? "left" : "right");
        headers[i].setType(Imf::SCANLINEIMAGE);
        headers[i].channels().insert("Y", Imf::Channel(Imf::FLOAT));
    }
    {
        Imf::MultiPartOutputFile out(file("parts.exr").c_str(), headers.data(), 2);
        for (int i = 0; i < 2; ++i) {
            const Imath::Box2i window = headers[static_cast<std::size_t>(i)].dataWindow();
            std::vector<float> values(8, i == 0 ? 0.25f : 0.75f);
            Imf::FrameBuffer frame;
            frame.insert("Y", Imf::Slice::Make(Imf::FLOAT, values.data(), window));
            Imf::OutputPart part(out, i);
            part.setFrameBuffer(frame);
            part.writePixels(window.max.y + 1);
        }
    }
    const Image image = load_exr(file("parts.exr"));
    EXPECT_EQ(image.width(), 4);
    EXPECT_EQ(image.at(3, 1, 0), 0.25f);
    EXPECT_TRUE(image.metadata.empty()) << "the part's name and type are not text of the picture";
    ASSERT_EQ(warnings_.size(), 1u);
    EXPECT_TRUE(contains(warnings_[0], "has 2 parts: only the first is read")) << warnings_[0];
}

TEST_F(Exr, RefusesDeepAndSubsampledData) {
    Imf::Header deep(2, 2);
    deep.setType(Imf::DEEPSCANLINE);
    deep.compression() = Imf::ZIPS_COMPRESSION;
    deep.channels().insert("Z", Imf::Channel(Imf::FLOAT));
    {
        std::array<unsigned, 4> counts{};
        std::array<float*, 4> samples{};
        Imf::DeepFrameBuffer frame;
        frame.insertSampleCountSlice(
            Imf::Slice(Imf::UINT, reinterpret_cast<char*>(counts.data()), 4, 8));
        frame.insert("Z", Imf::DeepSlice(Imf::FLOAT, reinterpret_cast<char*>(samples.data()),
                              sizeof(float*), 2 * sizeof(float*), sizeof(float)));
        Imf::DeepScanLineOutputFile out(file("deep.exr").c_str(), deep);
        out.setFrameBuffer(frame);
        out.writePixels(2);
    }
    EXPECT_TRUE(contains(error_of([&] { load_exr(file("deep.exr")); }), "it holds deep data"));

    Imf::Header subsampled(4, 4);
    subsampled.channels().insert("RY", Imf::Channel(Imf::HALF, 2, 2));
    {
        std::array<Imath::half, 16> values{};
        Imf::FrameBuffer frame;
        frame.insert(
            "RY", Imf::Slice(Imf::HALF, reinterpret_cast<char*>(values.data()), 2, 4, 2, 2));
        Imf::OutputFile out(file("subsampled.exr").c_str(), subsampled);
        out.setFrameBuffer(frame);
        out.writePixels(4);
    }
    EXPECT_TRUE(contains(
        error_of([&] { load_exr(file("subsampled.exr")); }), "its channel 'RY' is subsampled"));
}

TEST_F(Exr, RefusesHugeWindowsWithNumbers) {
    // A small file's data window, made huge in place: four ints after the attribute's head.
    save_exr(file("a.exr"), Image(2, 2, {"Y"}));
    std::string bytes = read_text(file("a.exr"));
    const std::string head("dataWindow\0box2i\0\x10\0\0\0", 21);
    const std::size_t at = bytes.find(head) + head.size();
    ASSERT_LT(at, bytes.size());
    const std::array<std::int32_t, 4> window{0, 0, 199999999, 1};
    std::memcpy(bytes.data() + at, window.data(), sizeof(window));
    scribble(file("huge.exr"), bytes);
    const std::string text = error_of([&] { load_exr(file("huge.exr")); });
    EXPECT_TRUE(
        contains(text, "huge.exr' as OpenEXR: its data window has 200000000 x 2 pixels of 1 "
                       "channels, the limit is 268435456 values"))
        << text;
}

TEST_F(Exr, EveryTruncationIsAnError) {
    save_exr(file("a.exr"), sample_image());
    const std::string whole = read_text(file("a.exr"));
    for (std::size_t size = 0; size < whole.size(); ++size) {
        scribble(file("cut.exr"), std::string_view(whole).substr(0, size));
        const std::string text = error_of([&] { load_exr(file("cut.exr")); });
        ASSERT_TRUE(contains(text, "cut.exr' as OpenEXR: ")) << size << " bytes: " << text;
    }
}

TEST_F(Exr, DamagedBytesGiveAnImageOrAnError) {
    save_exr(file("a.exr"), sample_image());
    const std::string whole = read_text(file("a.exr"));
    std::size_t refused = 0;
    for (std::size_t i = 0; i < whole.size(); ++i) {
        std::string damaged = whole;
        damaged[i] = static_cast<char>(damaged[i] ^ 0xff);
        scribble(file("damaged.exr"), damaged);
        const std::string text = error_of([&] { load_exr(file("damaged.exr")); });
        refused += text != "no error";
    }
    EXPECT_GT(refused, whole.size() / 2);
}

TEST_F(Exr, RefusesWhatIsNoExr) {
    EXPECT_TRUE(contains(error_of([&] { load_exr(file("missing.exr")); }), "No such file"));
    EXPECT_TRUE(contains(error_of([&] { load_exr(folder_); }), "it is a folder"));
    scribble(file("garbage.exr"), std::string(1000, 'x'));
    const std::string text = error_of([&] { load_exr(file("garbage.exr")); });
    EXPECT_TRUE(contains(text, "garbage.exr' as OpenEXR: ")) << text;
}

TEST_F(Exr, RefusesReservedMetadata) {
    for (const std::string key : {"channels", "type", "dataWindow", ""}) {
        Image image(1, 1, {"R"});
        image.metadata[key] = "x";
        EXPECT_TRUE(contains(error_of([&] { save_exr(file("a.exr"), image); }),
            fmt::format("the metadata key '{}' is reserved", key)));
    }
    EXPECT_EQ(files(), 0u);
}

TEST_F(Exr, OutputsThatCannotBeWritten) {
    const Image image = sample_image();
    EXPECT_TRUE(contains(error_of([&] { save_exr("/dev/full", image); }), "No space left"));
    EXPECT_TRUE(contains(error_of([&] { save_exr(folder_, image); }), "it is a folder"));
    EXPECT_TRUE(
        contains(error_of([&] { save_exr(file("missing") / "a.exr", image); }), "No such file"));
    EXPECT_EQ(files(), 0u);
    save_exr("/dev/null", image);
}

TEST_F(Exr, AFailedWriteKeepsTheOldFile) {
    save_exr(file("a.exr"), Image(3, 2, {"R"}));
    Image image(1, 1, {"R"});
    image.metadata["channels"] = "x";
    EXPECT_NE(error_of([&] { save_exr(file("a.exr"), image); }), "no error");
    EXPECT_EQ(load_exr(file("a.exr")).width(), 3);
    EXPECT_EQ(files(), 1u);
}

} // namespace
} // namespace ockham
