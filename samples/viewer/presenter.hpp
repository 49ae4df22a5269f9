// SPDX-License-Identifier: Apache-2.0
// Shows a picture of the host with Dear ImGui over it, one frame in flight. With its swapchain the
// only part of the viewer that calls Vulkan; render graphs do not know of it.
#pragma once

#include "framework/gpu/buffer.hpp"
#include "framework/gpu/image.hpp"
#include "samples/viewer/swapchain.hpp"

#include <glm/glm.hpp>

#include <cstdint>
#include <optional>
#include <vector>

namespace ockham::viewer {

/// Display-encoded picture, four bytes (R, G, B, unused) per pixel, top row first.
struct Canvas {
    glm::ivec2 size{0};
    std::vector<std::uint8_t> rgba;
    std::uint64_t version = 0; ///< another one: other content
};

class Presenter {
public:
    /// `device` must have been made with the window's extensions and device_extensions(). Both must
    /// outlive this object. One at a time: Dear ImGui has one context.
    Presenter(Window& window, gpu::Device& device);
    ~Presenter();
    Presenter(const Presenter&) = delete;
    Presenter& operator=(const Presenter&) = delete;

    static std::vector<std::string> device_extensions();

    /// Begins a frame of Dear ImGui; call end() then. False where there is nothing to draw to: the
    /// window is minimised.
    bool begin();
    /// Draws `canvas` scaled to size `extent` at `origin` (pixels of the window, cut off at its
    /// borders), ImGui's widgets over it, and presents. Waits for the frame before, not for this.
    /// True: presented. With `shot` it waits, and puts there what the window shows.
    bool end(const Canvas& canvas, glm::ivec2 origin, glm::ivec2 extent, Canvas* shot = nullptr);

private:
    void make_frame_objects();
    void start_imgui();
    void make_room(glm::uvec2 size);
    void upload(const Canvas& canvas, VkCommandBuffer commands);
    void record(const Swapchain::Target& target, glm::ivec2 origin, glm::ivec2 extent);
    void record_shot(const Swapchain::Target& target);
    void read_shot(Canvas& shot);
    void destroy();

    Window& window_;
    gpu::Device& device_;
    Swapchain swapchain_;
    VkDescriptorPool descriptors_ = VK_NULL_HANDLE;
    VkCommandPool pool_ = VK_NULL_HANDLE;
    VkCommandBuffer commands_ = VK_NULL_HANDLE;
    VkFence done_ = VK_NULL_HANDLE;
    VkSemaphore acquired_ = VK_NULL_HANDLE;
    bool imgui_ = false;
    std::optional<gpu::Buffer> staging_, shot_;
    std::optional<gpu::Image> canvas_;
    glm::ivec2 shown_{0};       ///< size of the canvas that is in there
    std::uint64_t version_ = 0; ///< and its version; 0: none
};

} // namespace ockham::viewer
