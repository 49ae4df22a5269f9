// SPDX-License-Identifier: Apache-2.0
// The block allocator: pieces never overlap, come back whole, and stay inside the budget.
#include "framework/core/error.hpp"
#include "framework/core/rng.hpp"
#include "framework/gpu/buffer.hpp"
#include "framework/gpu/image.hpp"
#include "framework/gpu/memory.hpp"
#include "tests/support/gpu_fixture.hpp"

#include <algorithm>

namespace ockham::gpu {
namespace {

using test::error_of;

constexpr std::uint32_t kAnyType = ~std::uint32_t{0};

class MemoryTest : public test::GpuTest {};

TEST_F(MemoryTest, PiecesAreAlignedDisjointAndComeBack) {
    Allocator allocator(device().physical(), device().handle(), 0);
    Pcg32 rng(1);
    std::vector<Memory> pieces;
    for (int step = 0; step < 2000; ++step) {
        if (!pieces.empty() && rng.below(5) < 2) {
            const std::size_t i = rng.below(static_cast<std::uint32_t>(pieces.size()));
            std::swap(pieces[i], pieces.back());
            pieces.pop_back();
            continue;
        }
        const std::uint64_t alignment = std::uint64_t{1} << rng.below(13);
        const std::uint64_t bytes = 1 + rng.below(1u << rng.below(18));
        pieces.push_back(
            allocator.allocate({bytes, alignment, kAnyType}, MemoryUse::device, "piece"));
        ASSERT_EQ(pieces.back().offset() % alignment, 0u);
        ASSERT_GE(pieces.back().bytes(), bytes);
    }
    std::vector<const Memory*> order;
    std::uint64_t sum = 0;
    for (const Memory& piece : pieces) {
        order.push_back(&piece);
        sum += piece.bytes();
    }
    EXPECT_EQ(allocator.bytes_used(), sum);
    EXPECT_EQ(allocator.bytes_reserved() % Allocator::kBlockBytes, 0u);
    std::ranges::sort(order, {}, [](const Memory* piece) {
        return std::pair(reinterpret_cast<std::uint64_t>(piece->handle()), piece->offset());
    });
    for (std::size_t i = 1; i < order.size(); ++i) {
        if (order[i]->handle() != order[i - 1]->handle()) continue;
        ASSERT_GE(order[i]->offset(), order[i - 1]->offset() + order[i - 1]->bytes());
    }
    pieces.clear();
    EXPECT_EQ(allocator.bytes_used(), 0u);
    EXPECT_EQ(allocator.bytes_reserved(), 0u);
}

TEST_F(MemoryTest, FreedNeighboursMerge) {
    Allocator allocator(device().physical(), device().handle(), 0);
    constexpr std::uint64_t kQuarter = Allocator::kBlockBytes / 4;
    std::vector<Memory> pieces;
    for (int i = 0; i < 4; ++i) {
        pieces.push_back(
            allocator.allocate({kQuarter, 16, kAnyType}, MemoryUse::device, "quarter"));
    }
    EXPECT_EQ(allocator.bytes_reserved(), Allocator::kBlockBytes);
    pieces[2] = Memory();
    pieces[1] = Memory();
    const Memory half = allocator.allocate({2 * kQuarter, 16, kAnyType}, MemoryUse::device, "half");
    EXPECT_EQ(allocator.bytes_reserved(), Allocator::kBlockBytes);
}

TEST_F(MemoryTest, LargeRequestsGetTheirOwnBlock) {
    Allocator allocator(device().physical(), device().handle(), 0);
    constexpr std::uint64_t kBytes = Allocator::kBlockBytes + 4096;
    const Memory large = allocator.allocate({kBytes, 16, kAnyType}, MemoryUse::device, "large");
    EXPECT_EQ(allocator.bytes_reserved(), kBytes);
    EXPECT_EQ(large.offset(), 0u);
}

TEST_F(MemoryTest, HostMemoryIsMapped) {
    Allocator allocator(device().physical(), device().handle(), 0);
    const Memory upload = allocator.allocate({64, 16, kAnyType}, MemoryUse::upload, "upload");
    const Memory readback = allocator.allocate({64, 16, kAnyType}, MemoryUse::readback, "back");
    const Memory local = allocator.allocate({64, 16, kAnyType}, MemoryUse::device, "local");
    ASSERT_NE(upload.mapped(), nullptr);
    ASSERT_NE(readback.mapped(), nullptr);
    EXPECT_EQ(local.mapped(), nullptr);
    upload.mapped()[63] = std::byte{7};
    EXPECT_EQ(upload.mapped()[63], std::byte{7});
}

TEST_F(MemoryTest, AHookGetsItsMemoryBackUnmapped) {
    const VkDevice vk = device().handle();
    int returned = 0;
    const MemoryHook hook{.allocate =
                              [=](const VkMemoryAllocateInfo& info, VkDeviceMemory& memory) {
                                  return vkAllocateMemory(vk, &info, nullptr, &memory);
                              },
        .free =
            [&](VkDeviceMemory memory) {
                // Validation objects where it is mapped already.
                void* mapped = nullptr;
                if (returned == 0) {
                    EXPECT_EQ(vkMapMemory(vk, memory, 0, VK_WHOLE_SIZE, 0, &mapped), VK_SUCCESS);
                    vkUnmapMemory(vk, memory);
                }
                vkFreeMemory(vk, memory, nullptr);
                ++returned;
            }};
    Allocator allocator(device().physical(), vk, 0, hook);
    {
        const Memory upload = allocator.allocate({64, 16, kAnyType}, MemoryUse::upload, "upload");
        EXPECT_NE(upload.mapped(), nullptr);
    }
    EXPECT_EQ(returned, 1);
    { const Memory local = allocator.allocate({64, 16, kAnyType}, MemoryUse::device, "local"); }
    EXPECT_EQ(returned, 2);
}

TEST_F(MemoryTest, TheBudgetIsKeptWithNumbers) {
    Device limited({.memory_budget_bytes = std::uint64_t{8} << 20});
    const BufferInfo half{.bytes = std::uint64_t{5} << 20,
        .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
        .name = "five"};
    const Buffer first(limited, half);
    try {
        const Buffer second(limited, half);
        FAIL() << "the budget was exceeded";
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::device);
        EXPECT_STREQ(error.what(),
            "'five' needs 5.0 MiB of GPU memory, but of the budget of 8.0 MiB already 5.0 MiB are "
            "in use; raise --memory-budget or ask for less\n"
            "In use on the device:\n"
            "       5.000 MiB  five                     for the device alone");
    }
}

TEST_F(MemoryTest, ImpossibleImagesAreRefusedByName) {
    const ImageInfo info{.format = VK_FORMAT_R8G8B8A8_UNORM,
        .width = 1u << 30,
        .height = 1,
        .usage = VK_IMAGE_USAGE_SAMPLED_BIT,
        .name = "wide"};
    std::string text = error_of([&] { Image image(device(), info); });
    EXPECT_NE(text.find("'wide'"), std::string::npos) << text;
    EXPECT_NE(text.find("1073741824"), std::string::npos) << text;
    ImageInfo storage = info;
    storage.width = 4;
    storage.format = VK_FORMAT_R8G8B8A8_SRGB;
    storage.usage = VK_IMAGE_USAGE_STORAGE_BIT;
    text = error_of([&] { Image image(device(), storage); });
    EXPECT_NE(text.find("RGBA8_SRGB"), std::string::npos) << text;
}

} // namespace
} // namespace ockham::gpu
