// SPDX-License-Identifier: Apache-2.0
// Render passes and framebuffers of raster passes, made when first needed and kept by the views
// that they draw to. For the recorder only.
#pragma once

#include "framework/gpu/pipeline.hpp"
#include "framework/graph/declaration.hpp"
#include "framework/runtime/resources.hpp"

#include <map>
#include <vector>

namespace ockham {

/// Attachments of a raster pass.
struct RasterTarget {
    std::vector<gpu::Attachment> attachments;
    std::vector<std::uint32_t> uses; ///< one per attachment, index into Declaration::uses
    VkRenderPass render_pass = VK_NULL_HANDLE;
    VkFramebuffer framebuffer = VK_NULL_HANDLE;
    VkExtent2D extent{}; ///< of the mip that is drawn to
};

class RasterTargets {
public:
    RasterTargets(gpu::Device& device, const Declaration& declaration, const Resources& resources);
    ~RasterTargets();
    RasterTargets(const RasterTargets&) = delete;
    RasterTargets& operator=(const RasterTargets&) = delete;

    const RasterTarget& of(PassId pass);
    /// Lets go of those that draw to the resource, whose views may be gone. The caller destroys
    /// them once nothing that was recorded with them is pending.
    std::vector<VkFramebuffer> forget(ResourceId id);

private:
    using Views = std::vector<VkImageView>;
    RasterTarget create(PassId pass, const std::vector<std::uint32_t>& uses, const Views& views);

    gpu::Device& device_;
    const Declaration& declaration_;
    const Resources& resources_;
    std::vector<std::map<Views, RasterTarget>> targets_; ///< by PassId
};

/// Begins the render pass over all of the target, with viewport, scissor and default cull state.
void begin_raster(
    VkCommandBuffer commands, const Declaration& declaration, const RasterTarget& target);

} // namespace ockham
