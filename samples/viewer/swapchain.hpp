// SPDX-License-Identifier: Apache-2.0
// The images of a window: surface, format, and a target to draw each of them, made anew when the
// window has another size. Draws nothing. Called by the viewer's presenter.
#pragma once

#include "framework/gpu/image.hpp"

#include <glm/glm.hpp>

#include <cstdint>
#include <vector>

namespace ockham::gpu {
class Device;
} // namespace ockham::gpu

namespace ockham::viewer {

class Window;

/// A structure of Vulkan that is zero but for its type.
template <class Info>
Info info_of(VkStructureType type) {
    Info info{};
    info.sType = type;
    return info;
}

class Swapchain {
public:
    /// Of an image of the window.
    struct Target {
        VkImage image = VK_NULL_HANDLE;
        VkImageView view = VK_NULL_HANDLE;
        VkFramebuffer framebuffer = VK_NULL_HANDLE;
        VkSemaphore drawn = VK_NULL_HANDLE; ///< present() waits for it
    };

    /// `device` must have been made with the window's extensions and VK_KHR_swapchain. Both must
    /// outlive this object. Throws Error(device) where it cannot show anything there.
    Swapchain(Window& window, gpu::Device& device);
    ~Swapchain();
    Swapchain(const Swapchain&) = delete;
    Swapchain& operator=(const Swapchain&) = delete;

    /// Makes the images as large as the window. False where there is nothing to draw to: it is
    /// minimised.
    bool fit();
    /// The next image, once `acquired` is signalled; null where fit() must be called first.
    const Target* acquire(VkSemaphore acquired);
    /// Shows the image that was acquired last.
    void present();

    glm::uvec2 size() const { return size_; }
    VkFormat format() const { return format_.format; }
    /// One color attachment in that format, which is loaded and then presented.
    VkRenderPass render_pass() const { return render_pass_; }

private:
    void choose_format();
    void make_render_pass();
    void make_images();
    void make_targets();
    void destroy_targets();
    void destroy();

    Window& window_;
    gpu::Device& device_;
    VkSurfaceKHR surface_ = VK_NULL_HANDLE;
    VkSurfaceFormatKHR format_{};
    VkRenderPass render_pass_ = VK_NULL_HANDLE;
    VkSwapchainKHR swapchain_ = VK_NULL_HANDLE;
    glm::uvec2 size_{0};
    std::vector<Target> targets_;
    std::uint32_t index_ = 0; ///< of the target that was acquired last
    bool stale_ = true;       ///< the images no longer fit the window
};

} // namespace ockham::viewer
