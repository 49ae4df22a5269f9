// SPDX-License-Identifier: Apache-2.0
#include "samples/viewer/presenter.hpp"

#include "framework/core/error.hpp"
#include "framework/gpu/device.hpp"
#include "framework/gpu/transfer.hpp"
#include "samples/viewer/window.hpp"

#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_vulkan.h>

#include <algorithm>
#include <cstring>

namespace ockham::viewer {
namespace {

using gpu::expect;

void check_result(VkResult result) { expect(result, "drawing the widgets"); }

/// Makes what `from` has done to the image visible to `to`.
void change_layout(VkCommandBuffer commands, VkImage image, VkImageLayout before,
    VkImageLayout after, VkPipelineStageFlags2 from, VkAccessFlags2 from_access,
    VkPipelineStageFlags2 to, VkAccessFlags2 to_access) {
    const VkImageMemoryBarrier2 barrier{.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
        .pNext = nullptr,
        .srcStageMask = from,
        .srcAccessMask = from_access,
        .dstStageMask = to,
        .dstAccessMask = to_access,
        .oldLayout = before,
        .newLayout = after,
        .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .image = image,
        .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1}};
    VkDependencyInfo info{};
    info.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO;
    info.imageMemoryBarrierCount = 1;
    info.pImageMemoryBarriers = &barrier;
    vkCmdPipelineBarrier2(commands, &info);
}

/// The part of a blit that lies inside the target: [origin, origin + extent) shows [0, source).
VkImageBlit clipped_blit(
    glm::ivec2 origin, glm::ivec2 extent, glm::ivec2 source, glm::ivec2 target) {
    VkImageBlit blit{};
    blit.srcSubresource = blit.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    const glm::ivec2 first = glm::clamp(origin, glm::ivec2(0), target);
    const glm::ivec2 last = glm::clamp(origin + extent, glm::ivec2(0), target);
    const glm::vec2 scale = glm::vec2(source) / glm::vec2(glm::max(extent, glm::ivec2(1)));
    const glm::ivec2 from =
        glm::clamp(glm::ivec2(glm::vec2(first - origin) * scale), glm::ivec2(0), source);
    const glm::ivec2 to =
        glm::clamp(glm::ivec2(glm::round(glm::vec2(last - origin) * scale)), from, source);
    blit.srcOffsets[0] = {from.x, from.y, 0};
    blit.srcOffsets[1] = {to.x, to.y, 1};
    blit.dstOffsets[0] = {first.x, first.y, 0};
    blit.dstOffsets[1] = {last.x, last.y, 1};
    return blit;
}

bool is_empty(const VkImageBlit& blit) {
    const auto none = [](const VkOffset3D* o) { return o[0].x >= o[1].x || o[0].y >= o[1].y; };
    return none(blit.srcOffsets) || none(blit.dstOffsets);
}

} // namespace

std::vector<std::string> Presenter::device_extensions() {
    return {VK_KHR_SWAPCHAIN_EXTENSION_NAME};
}

Presenter::Presenter(Window& window, gpu::Device& device)
    : window_(window), device_(device), swapchain_(window, device) {
    try {
        make_frame_objects();
        start_imgui();
    } catch (...) {
        destroy();
        throw;
    }
}

Presenter::~Presenter() { destroy(); }

void Presenter::destroy() {
    vkDeviceWaitIdle(device_.handle());
    if (imgui_) {
        ImGui_ImplVulkan_Shutdown();
        ImGui_ImplGlfw_Shutdown();
    }
    canvas_.reset();
    staging_.reset();
    const VkDevice device = device_.handle();
    vkDestroySemaphore(device, acquired_, nullptr);
    vkDestroyFence(device, done_, nullptr);
    vkDestroyCommandPool(device, pool_, nullptr);
    vkDestroyDescriptorPool(device, descriptors_, nullptr);
}

void Presenter::make_frame_objects() {
    const VkDevice device = device_.handle();
    const VkDescriptorPoolSize font{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1};
    auto descriptors =
        info_of<VkDescriptorPoolCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO);
    descriptors.maxSets = 1;
    descriptors.poolSizeCount = 1;
    descriptors.pPoolSizes = &font;
    expect(vkCreateDescriptorPool(device, &descriptors, nullptr, &descriptors_),
        "making the widgets' descriptors");
    auto pool = info_of<VkCommandPoolCreateInfo>(VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO);
    pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
    pool.queueFamilyIndex = device_.queue_family();
    expect(vkCreateCommandPool(device, &pool, nullptr, &pool_), "making a command pool");
    auto commands =
        info_of<VkCommandBufferAllocateInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO);
    commands.commandPool = pool_;
    commands.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
    commands.commandBufferCount = 1;
    expect(vkAllocateCommandBuffers(device, &commands, &commands_), "making a command buffer");
    auto fence = info_of<VkFenceCreateInfo>(VK_STRUCTURE_TYPE_FENCE_CREATE_INFO);
    fence.flags = VK_FENCE_CREATE_SIGNALED_BIT;
    expect(vkCreateFence(device, &fence, nullptr, &done_), "making a fence");
    const auto semaphore = info_of<VkSemaphoreCreateInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO);
    expect(vkCreateSemaphore(device, &semaphore, nullptr, &acquired_), "making a semaphore");
}

void Presenter::start_imgui() {
    if (!ImGui_ImplGlfw_InitForVulkan(window_.handle(), true))
        fail_device("Dear ImGui cannot use this window");
    ImGui_ImplVulkan_InitInfo info{};
    info.Instance = device_.instance();
    info.PhysicalDevice = device_.physical();
    info.Device = device_.handle();
    info.QueueFamily = device_.queue_family();
    info.Queue = device_.main_queue_handle();
    info.DescriptorPool = descriptors_;
    info.MinImageCount = 2;
    info.ImageCount = 2; // frames in flight are one: fewer than these copies of its vertices
    info.MSAASamples = VK_SAMPLE_COUNT_1_BIT;
    info.CheckVkResultFn = check_result;
    ImGui_ImplVulkan_Init(&info, swapchain_.render_pass());
    imgui_ = true;
    device_.run("uploading the font",
        [](VkCommandBuffer commands) { ImGui_ImplVulkan_CreateFontsTexture(commands); });
    ImGui_ImplVulkan_DestroyFontUploadObjects();
}

bool Presenter::begin() {
    if (!swapchain_.fit()) return false;
    ImGui_ImplVulkan_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();
    return true;
}

/// Makes room for the canvas, and some more: it changes its size with every drag.
void Presenter::make_room(glm::uvec2 size) {
    if (canvas_ && canvas_->info().width >= size.x && canvas_->info().height >= size.y) return;
    constexpr std::uint32_t kStep = 512;
    const glm::uvec2 room = (size + kStep) / kStep * kStep; // at least one pixel more
    staging_.emplace(device_, gpu::BufferInfo{.bytes = std::uint64_t{4} * room.x * room.y,
                                  .usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT,
                                  .name = "canvas_staging",
                                  .memory = gpu::MemoryUse::upload});
    canvas_.emplace(
        device_, gpu::ImageInfo{.format = VK_FORMAT_R8G8B8A8_UNORM,
                     .width = room.x,
                     .height = room.y,
                     .usage = VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                     .name = "canvas"});
}

void Presenter::upload(const Canvas& canvas, VkCommandBuffer commands) {
    if (canvas.rgba.empty() || version_ == canvas.version) return;
    const glm::uvec2 size(canvas.size);
    make_room(size);
    shown_ = canvas.size;
    std::memcpy(staging_->mapped().data(), canvas.rgba.data(), canvas.rgba.size());
    version_ = canvas.version;
    change_layout(commands, canvas_->handle(), VK_IMAGE_LAYOUT_UNDEFINED,
        VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, 0,
        VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT);
    // All of it, and its last column and row once more: what a filter sees beyond its border.
    std::vector<VkBufferImageCopy> copies;
    for (const glm::uvec2 beyond : {glm::uvec2(0, 0), {1, 0}, {0, 1}, {1, 1}}) {
        const glm::uvec2 from = beyond * (size - 1u);
        VkBufferImageCopy copy{};
        copy.bufferOffset = std::uint64_t{4} * (std::uint64_t{from.y} * size.x + from.x);
        copy.bufferRowLength = size.x;
        copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
        copy.imageOffset = {
            static_cast<int>(beyond.x * size.x), static_cast<int>(beyond.y * size.y), 0};
        copy.imageExtent = {size.x - from.x, size.y - from.y, 1};
        copies.push_back(copy);
    }
    vkCmdCopyBufferToImage(commands, staging_->handle(), canvas_->handle(),
        VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, static_cast<std::uint32_t>(copies.size()),
        copies.data());
    change_layout(commands, canvas_->handle(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
        VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
        VK_ACCESS_2_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
        VK_ACCESS_2_TRANSFER_READ_BIT);
}

void Presenter::record(const Swapchain::Target& target, glm::ivec2 origin, glm::ivec2 extent) {
    const glm::uvec2 size = swapchain_.size();
    // Out of the semaphore's wait, which is for all stages.
    change_layout(commands_, target.image, VK_IMAGE_LAYOUT_UNDEFINED,
        VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, 0,
        VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT);
    const VkClearColorValue background{{0.055f, 0.059f, 0.066f, 1.0f}};
    const VkImageSubresourceRange all{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    vkCmdClearColorImage(
        commands_, target.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &background, 1, &all);
    if (canvas_) {
        change_layout(commands_, target.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
            VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
            VK_ACCESS_2_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
            VK_ACCESS_2_TRANSFER_WRITE_BIT);
        const VkImageBlit blit = clipped_blit(origin, extent, shown_, glm::ivec2(size));
        if (!is_empty(blit)) {
            vkCmdBlitImage(commands_, canvas_->handle(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                target.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &blit,
                shown_ == extent ? VK_FILTER_NEAREST : VK_FILTER_LINEAR);
        }
    }
    change_layout(commands_, target.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
        VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
        VK_ACCESS_2_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
        VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT);
    auto pass = info_of<VkRenderPassBeginInfo>(VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO);
    pass.renderPass = swapchain_.render_pass();
    pass.framebuffer = target.framebuffer;
    pass.renderArea.extent = {size.x, size.y};
    vkCmdBeginRenderPass(commands_, &pass, VK_SUBPASS_CONTENTS_INLINE);
    ImGui_ImplVulkan_RenderDrawData(ImGui::GetDrawData(), commands_);
    vkCmdEndRenderPass(commands_);
}

void Presenter::record_shot(const Swapchain::Target& target) {
    const glm::uvec2 size = swapchain_.size();
    shot_.emplace(device_, gpu::BufferInfo{.bytes = std::uint64_t{4} * size.x * size.y,
                               .usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                               .name = "screenshot",
                               .memory = gpu::MemoryUse::readback});
    change_layout(commands_, target.image, VK_IMAGE_LAYOUT_PRESENT_SRC_KHR,
        VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
        VK_ACCESS_2_MEMORY_WRITE_BIT, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
        VK_ACCESS_2_TRANSFER_READ_BIT);
    VkBufferImageCopy copy{};
    copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    copy.imageExtent = {size.x, size.y, 1};
    vkCmdCopyImageToBuffer(
        commands_, target.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, shot_->handle(), 1, &copy);
    change_layout(commands_, target.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
        VK_IMAGE_LAYOUT_PRESENT_SRC_KHR, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
        VK_ACCESS_2_TRANSFER_READ_BIT, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, 0);
    const VkMemoryBarrier2 host{.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
        .pNext = nullptr,
        .srcStageMask = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
        .srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT,
        .dstStageMask = VK_PIPELINE_STAGE_2_HOST_BIT,
        .dstAccessMask = VK_ACCESS_2_HOST_READ_BIT};
    auto info = info_of<VkDependencyInfo>(VK_STRUCTURE_TYPE_DEPENDENCY_INFO);
    info.memoryBarrierCount = 1;
    info.pMemoryBarriers = &host;
    vkCmdPipelineBarrier2(commands_, &info);
}

void Presenter::read_shot(Canvas& shot) {
    expect(vkWaitForFences(device_.handle(), 1, &done_, VK_TRUE, ~std::uint64_t{0}),
        "waiting for a screenshot");
    shot.size = glm::ivec2(swapchain_.size());
    shot.rgba.resize(shot_->bytes());
    std::memcpy(shot.rgba.data(), shot_->mapped().data(), shot.rgba.size());
    if (swapchain_.format() == VK_FORMAT_B8G8R8A8_UNORM) {
        for (std::size_t i = 0; i < shot.rgba.size(); i += 4)
            std::swap(shot.rgba[i], shot.rgba[i + 2]);
    }
    shot_.reset();
}

bool Presenter::end(const Canvas& canvas, glm::ivec2 origin, glm::ivec2 extent, Canvas* shot) {
    ImGui::Render();
    const VkDevice device = device_.handle();
    expect(vkWaitForFences(device, 1, &done_, VK_TRUE, ~std::uint64_t{0}), "waiting for a frame");
    const Swapchain::Target* const target = swapchain_.acquire(acquired_);
    if (!target) return false;

    expect(vkResetFences(device, 1, &done_), "resetting a fence");
    auto begin = info_of<VkCommandBufferBeginInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO);
    begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    expect(vkBeginCommandBuffer(commands_, &begin), "recording a frame of the window");
    upload(canvas, commands_);
    record(*target, origin, extent);
    if (shot) record_shot(*target);
    expect(vkEndCommandBuffer(commands_), "recording a frame of the window");
    const gpu::TimelinePoint wait{.semaphore = acquired_};
    const gpu::TimelinePoint signal{.semaphore = target->drawn};
    device_.submit({.queue = device_.main_queue(),
                       .commands = {&commands_, 1},
                       .waits = {&wait, 1},
                       .signals = {&signal, 1},
                       .fence = done_},
        "drawing the window");
    swapchain_.present();
    if (shot) read_shot(*shot);
    return true;
}

} // namespace ockham::viewer
