// SPDX-License-Identifier: Apache-2.0
// What goes up comes down: buffers, and every mip of every layer of images.
#include "framework/core/rng.hpp"
#include "framework/gpu/transfer.hpp"
#include "tests/support/gpu_fixture.hpp"

#include <algorithm>
#include <map>

namespace ockham::gpu {
namespace {

constexpr VkBufferUsageFlags kBufferUsage =
    VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
constexpr VkImageUsageFlags kImageUsage =
    VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;

std::vector<std::byte> noise(std::size_t bytes, std::uint64_t seed) {
    Pcg32 rng(seed);
    std::vector<std::byte> values(bytes);
    for (std::byte& value : values) value = static_cast<std::byte>(rng.next() >> 24);
    return values;
}

class TransferTest : public test::GpuTest {};

TEST_F(TransferTest, Buffers) {
    const std::vector<std::byte> bytes = noise(1000, 1);
    const Buffer buffer(device(), {.bytes = 1200, .usage = kBufferUsage, .name = "buffer"});
    Uploader uploader(device());
    uploader.add(buffer, bytes, 100);
    uploader.add(buffer, std::span(bytes).first(8), 0);
    uploader.add(buffer, {}, 0);
    uploader.finish();
    EXPECT_EQ(download(device(), buffer, 100, 1000), bytes);
    const std::vector<std::byte> head = download(device(), buffer, 0, 8);
    EXPECT_TRUE(std::equal(head.begin(), head.end(), bytes.begin()));
    EXPECT_TRUE(download(device(), buffer, 0, 0).empty());
}

TEST_F(TransferTest, ABufferLargerThanOneBatch) {
    constexpr std::size_t kBytes = (std::size_t{130} << 20) + 12;
    std::vector<std::byte> bytes(kBytes);
    for (std::size_t i = 0; i < kBytes; i += 4096) bytes[i] = static_cast<std::byte>(i >> 12);
    bytes.back() = std::byte{9};
    const Buffer buffer(device(), {.bytes = kBytes, .usage = kBufferUsage, .name = "large"});
    upload(device(), buffer, bytes);
    EXPECT_TRUE(download(device(), buffer, 0, kBytes) == bytes);
}

TEST_F(TransferTest, ArraysWithMipsOfAllKindsOfFormats) {
    for (const VkFormat format : {VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_R8G8B8A8_SRGB,
             VK_FORMAT_R8_UNORM, VK_FORMAT_R16G16_SFLOAT, VK_FORMAT_R32G32B32A32_SFLOAT}) {
        const ImageInfo info{.format = format,
            .width = 13,
            .height = 6,
            .layers = 3,
            .mips = 4,
            .usage = kImageUsage,
            .name = name_of(format)};
        const Image image(device(), info);
        const std::uint32_t texel = find_format(format)->texel_bytes;
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<std::byte>> sent;
        Uploader uploader(device());
        for (std::uint32_t layer = 0; layer < 3; ++layer) {
            for (std::uint32_t mip = 0; mip < 4; ++mip) {
                const std::uint32_t width = std::max(13u >> mip, 1u);
                const std::uint32_t height = std::max(6u >> mip, 1u);
                auto& bytes = sent[{layer, mip}];
                // Zero as the exponents' top bits, so that no float is a NaN.
                bytes = noise(std::size_t{texel} * width * height, layer * 4 + mip);
                for (std::byte& byte : bytes) byte &= std::byte{0x3f};
                uploader.add(image, layer, mip, bytes);
            }
        }
        uploader.finish();
        for (const auto& [where, bytes] : sent) {
            EXPECT_EQ(download(device(), image, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                          where.first, where.second),
                bytes)
                << info.name << " layer " << where.first << " mip " << where.second;
        }
    }
}

TEST_F(TransferTest, AVolumeLargerThanOneBatch) {
    // 65 slices of 1 MiB: cut after the 64th.
    const Image image(device(), {.format = VK_FORMAT_R8_UNORM,
                                    .width = 1024,
                                    .height = 1024,
                                    .depth = 65,
                                    .usage = kImageUsage,
                                    .name = "volume"});
    std::vector<std::byte> bytes(std::size_t{65} << 20);
    for (std::size_t i = 0; i < bytes.size(); i += 1021) bytes[i] = static_cast<std::byte>(i >> 10);
    upload(device(), image, 0, 0, bytes);
    EXPECT_TRUE(download(device(), image, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL) == bytes);
}

TEST_F(TransferTest, VolumesAndDepth) {
    const Image volume(device(), {.format = VK_FORMAT_R8_UNORM,
                                     .width = 5,
                                     .height = 4,
                                     .depth = 3,
                                     .usage = kImageUsage,
                                     .name = "volume"});
    const std::vector<std::byte> voxels = noise(60, 3);
    upload(device(), volume, 0, 0, voxels);
    EXPECT_EQ(download(device(), volume, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL), voxels);
    const Image depth(device(), {.format = VK_FORMAT_D32_SFLOAT,
                                    .width = 2,
                                    .height = 2,
                                    .usage = kImageUsage,
                                    .name = "depth"});
    const std::vector<float> depths{0.0f, 0.25f, 0.5f, 1.0f};
    upload(device(), depth, 0, 0, std::as_bytes(std::span(depths)));
    const std::vector<std::byte> bytes =
        download(device(), depth, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    EXPECT_EQ(decode_texels(*find_format(VK_FORMAT_D32_SFLOAT), bytes), depths);
}

TEST(Formats, DecodeToFloats) {
    const std::uint8_t bytes[] = {0, 51, 255, 128};
    const auto decode = [&](VkFormat format) {
        return decode_texels(*find_format(format), std::as_bytes(std::span(bytes)));
    };
    EXPECT_EQ(
        decode(VK_FORMAT_R8G8B8A8_UNORM), (std::vector<float>{0.0f, 0.2f, 1.0f, 128.0f / 255.0f}));
    EXPECT_EQ(decode(VK_FORMAT_R8G8B8A8_UINT), (std::vector<float>{0, 51, 255, 128}));
    EXPECT_EQ(decode(VK_FORMAT_R16_UINT), (std::vector<float>{51 * 256, 128 * 256 + 255}));
    const std::uint16_t halves[] = {0x3c00, 0x3555, 0xc000, 0x0001};
    const auto values = decode_texels(
        *find_format(VK_FORMAT_R16G16B16A16_SFLOAT), std::as_bytes(std::span(halves)));
    EXPECT_EQ(values, (std::vector<float>{1.0f, 0x1.554p-2f, -2.0f, 0x1p-24f}));
}

} // namespace
} // namespace ockham::gpu
