// SPDX-License-Identifier: Apache-2.0
// Parts of resources on a device: mips, layers and ranges that are written, read, copied and drawn
// to one by one, compared with the same on the host.
#include "framework/runtime/executor.hpp"
#include "tests/framework/runtime/small_passes.hpp"
#include "tests/support/gpu_fixture.hpp"

#include <fmt/format.h>

namespace ockham {
namespace {

using test::add_gradient;
using test::add_numbers;
using test::error_of;
using test::read_as;

class PartsTest : public test::GpuTest {};

constexpr std::uint32_t kWidth = 13, kHeight = 9, kMips = 4;
constexpr ImageDesc kChain{
    .format = VK_FORMAT_R32_SFLOAT, .width = kWidth, .height = kHeight, .mips = kMips};

/// Sums of 2 x 2 texels, fewer at odd edges, where Vulkan's sizes round down: texels beyond twice
/// the size are lost.
std::vector<float> halve(
    const std::vector<float>& above, std::uint32_t width, std::uint32_t height) {
    const std::uint32_t w = std::max(width / 2, 1u), h = std::max(height / 2, 1u);
    std::vector<float> below(w * h);
    for (std::uint32_t y = 0; y < h; ++y) {
        for (std::uint32_t x = 0; x < w; ++x) {
            for (std::uint32_t i = 0; i < 4; ++i) {
                const std::uint32_t sx = 2 * x + (i & 1), sy = 2 * y + (i >> 1);
                if (sx < width && sy < height) below[y * w + x] += above[sy * width + sx];
            }
        }
    }
    return below;
}

std::vector<float> gradient(std::uint32_t width, std::uint32_t height, float offset) {
    std::vector<float> texels;
    for (std::uint32_t y = 0; y < height; ++y) {
        for (std::uint32_t x = 0; x < width; ++x) {
            texels.push_back(static_cast<float>(x + 100 * y) + offset);
        }
    }
    return texels;
}

std::vector<float> texels_of(Executor& executor, const ImagePart& part) {
    const Image image = executor.read(part);
    const std::span<const float> plane = image.plane(0);
    return {plane.begin(), plane.end()};
}

void expect_chain(Executor& executor, ImageHandle image, float offset) {
    std::vector<float> expected = gradient(kWidth, kHeight, offset);
    for (std::uint32_t mip = 0; mip < kMips; ++mip) {
        EXPECT_EQ(texels_of(executor, image.mip(mip)), expected) << "mip " << mip;
        expected = halve(expected, std::max(kWidth >> mip, 1u), std::max(kHeight >> mip, 1u));
    }
}

TEST_F(PartsTest, MipChainByCompute) {
    Graph graph("mips_by_compute");
    ImageHandle image = graph.create_image("chain", kChain);
    image = add_gradient(graph, "top", image.mip(0), 3);
    for (std::uint32_t mip = 1; mip < kMips; ++mip) {
        PassBuilder pass = graph.add_compute_pass(fmt::format("halve_{}", mip));
        pass.sample("source", image.mip(mip - 1));
        image = pass.write("target", image.mip(mip));
        pass.record([mip](Commands& commands) {
            commands.dispatch_over({.shader = "test/halve.comp"},
                {std::max(kWidth >> mip, 1u), std::max(kHeight >> mip, 1u), 1});
        });
    }
    graph.export_resource(image, "checked");
    Executor executor(device(), std::move(graph));
    for (int execution = 0; execution < 2; ++execution) executor.execute();
    expect_chain(executor, image, 3);
}

TEST_F(PartsTest, MipChainByRaster) {
    Graph graph("mips_by_raster");
    ImageHandle image = graph.create_image("chain", kChain);
    image = add_gradient(graph, "top", image.mip(0), 5);
    for (std::uint32_t mip = 1; mip < kMips; ++mip) {
        PassBuilder pass = graph.add_raster_pass(fmt::format("halve_{}", mip));
        pass.sample("source", image.mip(mip - 1), Stage::fragment);
        image = pass.color(image.mip(mip));
        pass.record([](Commands& commands) {
            commands.bind({.vertex_shader = "test/full.vert",
                .fragment_shader = "test/halve.frag",
                .depth_test = false,
                .depth_write = false});
            commands.draw(3);
        });
    }
    graph.export_resource(image, "checked");
    Executor executor(device(), std::move(graph));
    for (int execution = 0; execution < 2; ++execution) executor.execute();
    expect_chain(executor, image, 5);
}

TEST_F(PartsTest, LayersWrittenClearedAndCopiedApart) {
    constexpr ImageDesc desc{
        .format = VK_FORMAT_R32_SFLOAT, .width = 7, .height = 5, .layers = 4, .mips = 2};
    Graph graph("layers");
    ImageHandle image = graph.create_image("array", desc);
    image = add_gradient(graph, "layer_2", image.mip(0).layer(2), 1000);
    image = add_gradient(graph, "layer_0", image.mip(0).layer(0), 0);
    PassBuilder clear = graph.add_transfer_pass("clear");
    const ImagePart rest = image.mips(1, 1);
    image = clear.copy_to(rest);
    clear.record([rest](Commands& commands) { commands.clear(rest, {0.5f, 0, 0, 0}); });
    PassBuilder copy = graph.add_transfer_pass("copy");
    const ImagePart from = image.mip(0).layer(2), to = image.mip(0).layer(1);
    copy.copy_from(from);
    image = copy.copy_to(to);
    copy.record([from, to](Commands& commands) { commands.copy(from, to); });
    PassBuilder last = graph.add_transfer_pass("clear_last");
    const ImagePart end = image.mip(0).layer(3);
    image = last.copy_to(end);
    last.record([end](Commands& commands) { commands.clear(end, {7, 0, 0, 0}); });
    graph.export_resource(image, "checked");
    Executor executor(device(), std::move(graph));
    for (int execution = 0; execution < 2; ++execution) executor.execute();
    EXPECT_EQ(texels_of(executor, image.mip(0).layer(0)), gradient(7, 5, 0));
    EXPECT_EQ(texels_of(executor, image.mip(0).layer(1)), gradient(7, 5, 1000));
    EXPECT_EQ(texels_of(executor, image.mip(0).layer(2)), gradient(7, 5, 1000));
    EXPECT_EQ(texels_of(executor, image.mip(0).layer(3)), std::vector<float>(35, 7));
    for (std::uint32_t layer = 0; layer < 4; ++layer) {
        EXPECT_EQ(texels_of(executor, image.mip(1).layer(layer)), std::vector<float>(6, 0.5f));
    }
}

TEST_F(PartsTest, RangesOfABuffer) {
    Graph graph("ranges");
    BufferHandle buffer = graph.create_buffer("buffer", {1024});
    buffer = add_numbers(graph, "third", buffer.range(512, 256), 5, 2);
    buffer = add_numbers(graph, "first", buffer.range(0, 256), 1);
    PassBuilder fill = graph.add_transfer_pass("fill");
    const BufferPart last = buffer.range(768, 256);
    buffer = fill.copy_to(last);
    fill.record([last](Commands& commands) { commands.fill(last, 9); });
    // Reads one range and writes its neighbour in one pass.
    PassBuilder next = graph.add_compute_pass("second");
    next.read("source", buffer.range(512, 256));
    buffer = next.write("target", buffer.range(256, 256));
    next.record([](Commands& commands) {
        commands.dispatch_over({.shader = "test/add_one.comp"}, {64, 1, 1});
    });
    PassBuilder copy = graph.add_transfer_pass("copy");
    const BufferPart from = buffer.range(256, 128), to = buffer.range(896, 128);
    copy.copy_from(from);
    buffer = copy.copy_to(to);
    copy.record([from, to](Commands& commands) { commands.copy(from, to); });
    graph.export_resource(buffer, "checked");
    Executor executor(device(), std::move(graph));
    for (int execution = 0; execution < 2; ++execution) executor.execute();
    const auto values = read_as<std::uint32_t>(executor, buffer);
    for (std::uint32_t i = 0; i < 64; ++i) {
        ASSERT_EQ(values[i], i + 1);
        ASSERT_EQ(values[64 + i], 2 * i + 6);
        ASSERT_EQ(values[128 + i], 2 * i + 5);
        ASSERT_EQ(values[192 + i], i < 32 ? 9 : 2 * (i - 32) + 6);
    }
}

TEST_F(PartsTest, CommandsKeepToTheDeclaredPart) {
    Graph graph("keeps");
    const BufferHandle buffer = graph.create_persistent_buffer("buffer", {1024});
    PassBuilder fill = graph.add_transfer_pass("fill");
    (void)fill.copy_to(buffer.range(256, 256));
    fill.side_effect("is tested");
    fill.record([buffer](Commands& commands) { commands.fill(buffer.range(256, 512), 1); });
    Executor executor(device(), std::move(graph));
    const std::string text = error_of([&] { executor.execute(); });
    EXPECT_NE(text.find("[undeclared-part]"), std::string::npos) << text;
    EXPECT_NE(text.find("'fill' (parts_test.cpp:"), std::string::npos) << text;
    EXPECT_NE(text.find("'buffer' (parts_test.cpp:"), std::string::npos) << text;
}

} // namespace
} // namespace ockham
