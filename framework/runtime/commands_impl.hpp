// SPDX-License-Identifier: Apache-2.0
// What stands behind Commands while one pass records: the pass's uses, the real resources, and the
// Vulkan command buffer. Internal to the runtime.
#pragma once

#include "framework/gpu/buffer.hpp"
#include "framework/gpu/descriptors.hpp"
#include "framework/gpu/device.hpp"
#include "framework/gpu/image.hpp"
#include "framework/gpu/pipeline.hpp"
#include "framework/runtime/commands.hpp"

#include <set>

namespace ockham {

/// The real thing behind a declared resource; both null while it is culled or not bound.
struct Resource {
    const gpu::Buffer* buffer = nullptr;
    const gpu::Image* image = nullptr;
    /// Some pass of the graph writes it.
    bool written = false;
};

/// Attachments of a raster pass.
struct RasterTarget {
    std::vector<gpu::Attachment> attachments;
    std::vector<VkClearValue> clears; ///< one per attachment
    VkRenderPass render_pass = VK_NULL_HANDLE;
    VkFramebuffer framebuffer = VK_NULL_HANDLE;
    VkExtent2D extent{};
};

/// What all passes of one executor record with.
struct Recording {
    gpu::Device& device;
    const Declaration& declaration;
    const std::vector<Resource>& resources;
    gpu::DescriptorArena& descriptors;
    std::set<const gpu::Pipeline*>& pipelines; ///< all that were ever bound
};

class CommandsImpl {
public:
    /// `target` is null except for raster passes, whose render pass has begun.
    CommandsImpl(
        Recording& recording, PassId pass, VkCommandBuffer commands, const RasterTarget* target);

    void dispatch(const ComputeCall& call, glm::uvec3 groups);
    void dispatch_over(const ComputeCall& call, glm::uvec3 items);
    void dispatch_indirect(
        const ComputeCall& call, BufferHandle arguments, std::uint64_t offset_bytes);

    void bind(const RasterCall& call);
    void set_cull(Commands::Cull mode, bool front_is_clockwise);
    void push(std::span<const std::byte> values);
    void bind_indices(BufferHandle indices);
    void draw(std::uint32_t vertices, std::uint32_t instances, std::uint32_t first_vertex,
        std::uint32_t first_instance);
    void draw_indexed(std::uint32_t indices, std::uint32_t instances, std::uint32_t first_index,
        std::int32_t vertex_offset, std::uint32_t first_instance);

    void fill(BufferHandle buffer, std::uint32_t value);
    void clear(ImageHandle image, const std::array<float, 4>& value);
    void copy(BufferHandle from, BufferHandle to, std::uint64_t bytes);
    void copy(ImageHandle from, ImageHandle to);

private:
    /// Throws Error(input) that starts with the pass.
    template <class... Args>
    [[noreturn]] void fail(fmt::format_string<Args...> text, Args&&... args) const {
        fail_input("pass '{}': {}", pass_.name, fmt::format(text, std::forward<Args>(args)...));
    }
    std::span<const Use> uses() const;
    /// The pass's use of a resource, which must have this access.
    const Resource& used(ResourceId id, Access access, const char* command) const;
    const std::string& name_of(ResourceId id) const;
    void expect_kind(PassKind kind, const char* command) const;
    void expect_pipeline(const char* command) const;
    const gpu::Pipeline& prepare(const ComputeCall& call);
    void bind_descriptors(const gpu::Pipeline& pipeline, VkPipelineBindPoint point);
    const Use& match(const gpu::Pipeline& pipeline, const gpu::PipelineLayout::Slot& slot) const;
    VkDescriptorBufferInfo buffer_info(
        const gpu::Pipeline& pipeline, const gpu::PipelineLayout::Slot& slot, const Use& use) const;
    VkDescriptorImageInfo image_info(
        const gpu::Pipeline& pipeline, const gpu::PipelineLayout::Slot& slot, const Use& use) const;
    void push_constants(const gpu::Pipeline& pipeline, std::span<const std::byte> values);

    Recording& recording_;
    const PassDecl& pass_;
    VkCommandBuffer commands_;
    const RasterTarget* target_;
    const gpu::Pipeline* raster_ = nullptr; ///< bound by bind()
    bool pushed_ = false;                   ///< since bind()
    std::uint64_t index_count_ = 0;         ///< of the bound index buffer
};

} // namespace ockham
