// SPDX-License-Identifier: Apache-2.0
// Ockham inside another program: its device, its queues, its command buffers, its images, its
// memory.
#include "framework/gpu/image.hpp"
#include "framework/gpu/transfer.hpp"
#include "framework/runtime/executor.hpp"
#include "tests/framework/runtime/small_passes.hpp"
#include "tests/support/gpu_fixture.hpp"

#include <optional>

namespace ockham {
namespace {

using test::add_gradient;
using test::add_mark;
using test::add_one;
using test::error_of;
using test::read_as;

/// A program with a Vulkan device of its own: the first that there is, and its first queue.
class Host {
public:
    Host() {
        const VkApplicationInfo application{
            .sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .apiVersion = VK_API_VERSION_1_3};
        const char* layer = "VK_LAYER_KHRONOS_validation";
        const VkInstanceCreateInfo instance_info{.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
            .pApplicationInfo = &application,
            .enabledLayerCount = 1,
            .ppEnabledLayerNames = &layer};
        EXPECT_EQ(vkCreateInstance(&instance_info, nullptr, &instance), VK_SUCCESS);
        std::uint32_t count = 1;
        vkEnumeratePhysicalDevices(instance, &count, &physical);
        v12.pNext = &v13;
        v12.scalarBlockLayout = v12.timelineSemaphore = VK_TRUE;
        v13.synchronization2 = v13.maintenance4 = VK_TRUE;
        features.pNext = &v12;
        features.features.shaderStorageImageExtendedFormats = VK_TRUE;
        const float priority = 1;
        const VkDeviceQueueCreateInfo queue_info{
            .sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
            .queueCount = 1,
            .pQueuePriorities = &priority};
        const VkDeviceCreateInfo device_info{.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
            .pNext = &features,
            .queueCreateInfoCount = 1,
            .pQueueCreateInfos = &queue_info};
        EXPECT_EQ(vkCreateDevice(physical, &device_info, nullptr, &device), VK_SUCCESS);
        vkGetDeviceQueue(device, 0, 0, &queue);
        const VkCommandPoolCreateInfo pool_info{
            .sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
        EXPECT_EQ(vkCreateCommandPool(device, &pool_info, nullptr, &pool), VK_SUCCESS);
    }
    ~Host() {
        vkDestroyCommandPool(device, pool, nullptr);
        vkDestroyDevice(device, nullptr);
        vkDestroyInstance(instance, nullptr);
    }
    Host(const Host&) = delete;
    Host& operator=(const Host&) = delete;

    gpu::ExternalDevice handles() const {
        return {.instance = instance,
            .physical = physical,
            .device = device,
            .queues = {{queue, 0}},
            .features = &features};
    }
    VkCommandBuffer begin() const {
        const VkCommandBufferAllocateInfo info{
            .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
            .commandPool = pool,
            .commandBufferCount = 1};
        VkCommandBuffer commands = VK_NULL_HANDLE;
        EXPECT_EQ(vkAllocateCommandBuffers(device, &info, &commands), VK_SUCCESS);
        const VkCommandBufferBeginInfo begin{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
        EXPECT_EQ(vkBeginCommandBuffer(commands, &begin), VK_SUCCESS);
        return commands;
    }
    void submit(VkCommandBuffer commands) const {
        EXPECT_EQ(vkEndCommandBuffer(commands), VK_SUCCESS);
        const VkSubmitInfo info{.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
            .commandBufferCount = 1,
            .pCommandBuffers = &commands};
        EXPECT_EQ(vkQueueSubmit(queue, 1, &info, VK_NULL_HANDLE), VK_SUCCESS);
    }

    VkInstance instance = VK_NULL_HANDLE;
    VkPhysicalDevice physical = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    VkQueue queue = VK_NULL_HANDLE;
    VkCommandPool pool = VK_NULL_HANDLE;
    VkPhysicalDeviceVulkan13Features v13{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
    VkPhysicalDeviceVulkan12Features v12{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES};
    VkPhysicalDeviceFeatures2 features{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2};
};

class EmbeddingTest : public test::GpuTest {};

TEST_F(EmbeddingTest, OnTheDeviceOfAnother) {
    const Host host;
    for (int life = 0; life < 2; ++life) { // what ends is ours alone
        gpu::Device device(host.handles());
        Graph graph("embedded");
        const BufferHandle marks =
            add_mark(graph, "mark", graph.create_persistent_buffer("marks", {256}), 3);
        graph.export_resource(marks, "checked");
        Executor executor(device, std::move(graph));
        executor.execute();
        executor.execute();
        EXPECT_EQ(read_as<std::uint32_t>(executor, marks), std::vector<std::uint32_t>(64, 6));
    }
    EXPECT_EQ(vkDeviceWaitIdle(host.device), VK_SUCCESS);
}

TEST_F(EmbeddingTest, WhatWasNotEnabledIsNamed) {
    Host host;
    host.v12.scalarBlockLayout = VK_FALSE;
    host.v13.maintenance4 = VK_FALSE;
    const std::string text = error_of([&] { gpu::Device device(host.handles()); });
    EXPECT_NE(text.find("scalarBlockLayout, maintenance4"), std::string::npos) << text;
    gpu::ExternalDevice handles = host.handles();
    handles.features = nullptr;
    EXPECT_NE(
        error_of([&] { gpu::Device device(handles); }).find("synchronization2"), std::string::npos);
    Host other;
    handles = other.handles();
    handles.queues.clear();
    EXPECT_NE(
        error_of([&] { gpu::Device device(handles); }).find("first queue"), std::string::npos);
}

/// Frames in flight: the caller submits and waits at the end only.
TEST_F(EmbeddingTest, RecordsIntoCommandBuffersOfTheCaller) {
    const Host host;
    gpu::Device device(host.handles(), {.force_descriptor_sets = true});
    // The caller's image, as a swapchain's would be.
    const VkImageCreateInfo info{.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
        .imageType = VK_IMAGE_TYPE_2D,
        .format = VK_FORMAT_R32_SFLOAT,
        .extent = {7, 5, 1},
        .mipLevels = 1,
        .arrayLayers = 1,
        .samples = VK_SAMPLE_COUNT_1_BIT,
        .usage = VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT};
    VkImage theirs = VK_NULL_HANDLE;
    ASSERT_EQ(vkCreateImage(host.device, &info, nullptr, &theirs), VK_SUCCESS);
    VkMemoryRequirements need;
    vkGetImageMemoryRequirements(host.device, theirs, &need);
    const VkMemoryAllocateInfo memory_info{
        .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .allocationSize = need.size};
    VkDeviceMemory memory = VK_NULL_HANDLE;
    ASSERT_EQ(vkAllocateMemory(host.device, &memory_info, nullptr, &memory), VK_SUCCESS);
    ASSERT_EQ(vkBindImageMemory(host.device, theirs, memory, 0), VK_SUCCESS);
    {
        const gpu::Image image(device,
            {.format = info.format, .width = 7, .height = 5, .usage = info.usage, .name = "theirs"},
            theirs);
        Graph graph("recorded");
        ImageHandle target =
            graph.import_image("target", {.format = info.format, .width = 7, .height = 5}, {});
        auto offset = std::make_shared<float>(0.0f);
        PassBuilder pass = graph.add_compute_pass("gradient");
        target = pass.write("target", target);
        pass.record([offset](Commands& commands) {
            commands.dispatch(
                {.shader = "test/gradient.comp", .push = as_push(*offset)}, {1, 1, 1});
        });
        const BufferHandle marks =
            add_mark(graph, "mark", graph.create_persistent_buffer("marks", {256}), 2);
        const BufferHandle next = add_one(graph, "next", marks, graph.create_buffer("next", {256}));
        graph.export_resource(next, "checked");
        Executor executor(device, std::move(graph), Policy{}, {.slots = 3});
        executor.bind(target, image);
        for (int frame = 0; frame < 3; ++frame) {
            *offset = static_cast<float>(frame);
            const VkCommandBuffer commands = host.begin();
            executor.record(commands);
            host.submit(commands);
        }
        ASSERT_EQ(vkQueueWaitIdle(host.queue), VK_SUCCESS);
        EXPECT_EQ(executor.read(target).at(6, 4, 0), 408.0f);
        EXPECT_EQ(read_as<std::uint32_t>(executor, marks)[63], 6u);
        EXPECT_EQ(read_as<std::uint32_t>(executor, next)[63], 7u);
        EXPECT_TRUE(executor.times().empty());
    }
    vkDestroyImage(host.device, theirs, nullptr); // it is still theirs
    vkFreeMemory(host.device, memory, nullptr);
}

/// A framebuffer lives as long as what was recorded with it may be pending.
TEST_F(EmbeddingTest, BindingLeavesAloneWhatIsPending) {
    const auto make = [&](const char* name) {
        return gpu::Image(device(),
            {.format = VK_FORMAT_R32_SFLOAT,
                .width = 4,
                .height = 4,
                .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                .name = name});
    };
    const gpu::Image images[] = {make("a"), make("b"), make("c")};
    Graph graph("drawn");
    const AccessState copied = state_of(Access::transfer_read, Stage::fixed);
    const ImageHandle target = graph.import_image(
        "target", {.format = VK_FORMAT_R32_SFLOAT, .width = 4, .height = 4}, {}, copied);
    const ImageHandle cleared =
        graph.add_raster_pass("clear").color(target, LoadOp::clear, {3, 0, 0, 0});
    graph.export_resource(cleared, "checked");
    Executor executor(device(), std::move(graph), Policy{}, {.slots = 2});
    executor.bind(target, images[0]);
    for (int turn = 0; turn < 6; ++turn) {
        // Recorded, then bound, then submitted.
        device().run("recorded", [&](VkCommandBuffer commands) {
            executor.record(commands);
            executor.bind(target, images[(turn + 1) % 3]);
        });
        const auto texels =
            gpu::download(device(), images[turn % 3], VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
        EXPECT_EQ(reinterpret_cast<const float*>(texels.data())[15], 3.0f);
    }
    for (int turn = 0; turn < 6; ++turn) {
        executor.submit();
        executor.bind(target, images[(turn + 1) % 3]);
    }
    executor.execute();
    EXPECT_EQ(executor.read(target).at(3, 3, 0), 3.0f);
}

TEST_F(EmbeddingTest, TakesMemoryFromTheCaller) {
    const Host host;
    std::uint64_t taken = 0;
    std::uint32_t given = 0, returned = 0;
    {
        gpu::Device device(host.handles(),
            {.memory_hook = {.allocate =
                                 [&](const VkMemoryAllocateInfo& info, VkDeviceMemory& memory) {
                                     taken += info.allocationSize;
                                     ++given;
                                     return vkAllocateMemory(host.device, &info, nullptr, &memory);
                                 },
                 .free =
                     [&](VkDeviceMemory memory) {
                         ++returned;
                         vkFreeMemory(host.device, memory, nullptr);
                     }}});
        Graph graph("hooked");
        const ImageHandle image = add_gradient(graph, "gradient",
            graph.create_image(
                "image", {.format = VK_FORMAT_R32_SFLOAT, .width = 64, .height = 64}));
        graph.export_resource(image, "checked");
        Executor executor(device, std::move(graph));
        executor.execute();
        EXPECT_EQ(executor.read(image).at(63, 63, 0), 6363.0f);
        EXPECT_GE(taken, device.allocator().bytes_reserved());
        EXPECT_GT(given, 0u);
    }
    EXPECT_EQ(given, returned);

    // Its refusal is an error with a name.
    gpu::Device device(host.handles(),
        {.memory_hook = {.allocate = [](const VkMemoryAllocateInfo&,
                                         VkDeviceMemory&) { return VK_ERROR_OUT_OF_DEVICE_MEMORY; },
             .free = [](VkDeviceMemory) {}}});
    Graph graph("refused");
    (void)add_mark(graph, "mark", graph.create_persistent_buffer("marks", {256}), 1);
    const std::string text = error_of([&] { const Executor executor(device, std::move(graph)); });
    EXPECT_NE(text.find("'marks'"), std::string::npos) << text;
    EXPECT_NE(text.find("memory"), std::string::npos) << text;
}

} // namespace
} // namespace ockham
