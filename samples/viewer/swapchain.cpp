// SPDX-License-Identifier: Apache-2.0
#include "samples/viewer/swapchain.hpp"

#include "framework/core/error.hpp"
#include "framework/gpu/device.hpp"
#include "samples/viewer/window.hpp"

#include <GLFW/glfw3.h>

#include <algorithm>

namespace ockham::viewer {

using gpu::expect;

Swapchain::Swapchain(Window& window, gpu::Device& device) : window_(window), device_(device) {
    try {
        expect(glfwCreateWindowSurface(device.instance(), window.handle(), nullptr, &surface_),
            "making a surface of the window");
        VkBool32 presents = VK_FALSE;
        expect(vkGetPhysicalDeviceSurfaceSupportKHR(
                   device.physical(), device.queue_family(), surface_, &presents),
            "asking whether the device can present");
        if (!presents)
            fail_device(
                "'{}' cannot present to this desktop; choose another by --gpu", device.info().name);
        choose_format();
        make_render_pass();
        make_images();
    } catch (...) {
        destroy();
        throw;
    }
}

Swapchain::~Swapchain() { destroy(); }

void Swapchain::destroy() {
    vkDeviceWaitIdle(device_.handle());
    destroy_targets();
    vkDestroySwapchainKHR(device_.handle(), swapchain_, nullptr);
    vkDestroyRenderPass(device_.handle(), render_pass_, nullptr);
    vkDestroySurfaceKHR(device_.instance(), surface_, nullptr);
}

/// Eight bits that are shown as they are: widgets and canvas are display-encoded already.
void Swapchain::choose_format() {
    std::uint32_t count = 0;
    vkGetPhysicalDeviceSurfaceFormatsKHR(device_.physical(), surface_, &count, nullptr);
    std::vector<VkSurfaceFormatKHR> formats(count);
    expect(
        vkGetPhysicalDeviceSurfaceFormatsKHR(device_.physical(), surface_, &count, formats.data()),
        "asking for the window's formats");
    for (const VkFormat wanted : {VK_FORMAT_B8G8R8A8_UNORM, VK_FORMAT_R8G8B8A8_UNORM}) {
        const auto found = std::ranges::find_if(formats, [&](const VkSurfaceFormatKHR& f) {
            return f.format == wanted && f.colorSpace == VK_COLOR_SPACE_SRGB_NONLINEAR_KHR;
        });
        if (found != formats.end()) {
            format_ = *found;
            return;
        }
    }
    fail_device("the window has no format of eight bits per channel that '{}' can draw",
        device_.info().name);
}

void Swapchain::make_render_pass() {
    VkAttachmentDescription color{};
    color.format = format_.format;
    color.samples = VK_SAMPLE_COUNT_1_BIT;
    color.loadOp = VK_ATTACHMENT_LOAD_OP_LOAD; // the picture is there
    color.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    color.stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
    color.stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
    color.initialLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
    color.finalLayout = VK_IMAGE_LAYOUT_PRESENT_SRC_KHR;
    const VkAttachmentReference reference{0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
    VkSubpassDescription subpass{};
    subpass.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS;
    subpass.colorAttachmentCount = 1;
    subpass.pColorAttachments = &reference;
    auto info = info_of<VkRenderPassCreateInfo>(VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO);
    info.attachmentCount = 1;
    info.pAttachments = &color;
    info.subpassCount = 1;
    info.pSubpasses = &subpass;
    expect(vkCreateRenderPass(device_.handle(), &info, nullptr, &render_pass_),
        "making the widgets' render pass");
}

void Swapchain::destroy_targets() {
    for (const Target& target : targets_) {
        vkDestroyFramebuffer(device_.handle(), target.framebuffer, nullptr);
        vkDestroyImageView(device_.handle(), target.view, nullptr);
        vkDestroySemaphore(device_.handle(), target.drawn, nullptr);
    }
    targets_.clear();
}

void Swapchain::make_images() {
    const VkDevice device = device_.handle();
    expect(vkDeviceWaitIdle(device), "waiting before the window's images change");
    VkSurfaceCapabilitiesKHR can{};
    expect(vkGetPhysicalDeviceSurfaceCapabilitiesKHR(device_.physical(), surface_, &can),
        "asking what the window can show");
    glm::uvec2 size(window_.size());
    if (can.currentExtent.width != ~0u) size = {can.currentExtent.width, can.currentExtent.height};
    size = glm::clamp(size, glm::uvec2(can.minImageExtent.width, can.minImageExtent.height),
        glm::uvec2(can.maxImageExtent.width, can.maxImageExtent.height));
    size_ = size;
    stale_ = size.x == 0 || size.y == 0;
    if (stale_) return; // minimised
    destroy_targets();
    auto info = info_of<VkSwapchainCreateInfoKHR>(VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR);
    info.surface = surface_;
    info.minImageCount = std::max(can.minImageCount, 2u);
    info.imageFormat = format_.format;
    info.imageColorSpace = format_.colorSpace;
    info.imageExtent = {size.x, size.y};
    info.imageArrayLayers = 1;
    info.imageUsage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT |
                      VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
    if ((can.supportedUsageFlags & info.imageUsage) != info.imageUsage)
        fail_device("'{}' cannot copy pictures to this window", device_.info().name);
    info.preTransform = can.currentTransform;
    info.compositeAlpha = can.supportedCompositeAlpha & VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR
                              ? VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR
                              : VK_COMPOSITE_ALPHA_INHERIT_BIT_KHR;
    info.presentMode = VK_PRESENT_MODE_FIFO_KHR;
    info.clipped = VK_TRUE;
    info.oldSwapchain = swapchain_;
    VkSwapchainKHR swapchain = VK_NULL_HANDLE;
    expect(vkCreateSwapchainKHR(device, &info, nullptr, &swapchain), "making the window's images");
    vkDestroySwapchainKHR(device, swapchain_, nullptr);
    swapchain_ = swapchain;
    make_targets();
}

void Swapchain::make_targets() {
    const VkDevice device = device_.handle();
    std::uint32_t count = 0;
    vkGetSwapchainImagesKHR(device, swapchain_, &count, nullptr);
    std::vector<VkImage> images(count);
    expect(vkGetSwapchainImagesKHR(device, swapchain_, &count, images.data()),
        "getting the window's images");
    targets_.resize(images.size());
    for (std::size_t i = 0; i < images.size(); ++i) {
        Target& target = targets_[i];
        target.image = images[i];
        auto view = info_of<VkImageViewCreateInfo>(VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO);
        view.image = target.image;
        view.viewType = VK_IMAGE_VIEW_TYPE_2D;
        view.format = format_.format;
        view.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
        expect(vkCreateImageView(device, &view, nullptr, &target.view), "viewing a window's image");
        auto frame = info_of<VkFramebufferCreateInfo>(VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO);
        frame.renderPass = render_pass_;
        frame.attachmentCount = 1;
        frame.pAttachments = &target.view;
        frame.width = size_.x;
        frame.height = size_.y;
        frame.layers = 1;
        expect(vkCreateFramebuffer(device, &frame, nullptr, &target.framebuffer),
            "making a window's framebuffer");
        const auto semaphore =
            info_of<VkSemaphoreCreateInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO);
        expect(vkCreateSemaphore(device, &semaphore, nullptr, &target.drawn), "making a semaphore");
    }
}

bool Swapchain::fit() {
    const glm::uvec2 size(window_.size());
    if (size.x == 0 || size.y == 0) return false;
    if (stale_ || size != size_) make_images();
    return !stale_;
}

const Swapchain::Target* Swapchain::acquire(VkSemaphore acquired) {
    const VkResult result = vkAcquireNextImageKHR(
        device_.handle(), swapchain_, ~std::uint64_t{0}, acquired, VK_NULL_HANDLE, &index_);
    if (result == VK_ERROR_OUT_OF_DATE_KHR) {
        stale_ = true;
        return nullptr;
    }
    if (result != VK_SUBOPTIMAL_KHR) expect(result, "acquiring an image of the window");
    return &targets_[index_];
}

void Swapchain::present() {
    auto info = info_of<VkPresentInfoKHR>(VK_STRUCTURE_TYPE_PRESENT_INFO_KHR);
    info.waitSemaphoreCount = 1;
    info.pWaitSemaphores = &targets_[index_].drawn;
    info.swapchainCount = 1;
    info.pSwapchains = &swapchain_;
    info.pImageIndices = &index_;
    const VkResult result = vkQueuePresentKHR(device_.main_queue_handle(), &info);
    if (result == VK_ERROR_OUT_OF_DATE_KHR || result == VK_SUBOPTIMAL_KHR)
        stale_ = true;
    else
        expect(result, "presenting to the window");
}

} // namespace ockham::viewer
