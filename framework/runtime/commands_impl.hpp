// SPDX-License-Identifier: Apache-2.0
// What stands behind Commands while one pass records: the pass's uses, the real resources, and the
// Vulkan command buffer. Internal to the runtime.
#pragma once

#include "framework/gpu/descriptors.hpp"
#include "framework/gpu/device.hpp"
#include "framework/gpu/pipeline.hpp"
#include "framework/graph/compile.hpp"
#include "framework/runtime/bindings.hpp"
#include "framework/runtime/commands.hpp"
#include "framework/runtime/misuse.hpp"
#include "framework/runtime/raster_target.hpp"
#include "framework/runtime/resources.hpp"

namespace ockham {

/// What the passes of one queue record with in one execution.
struct Recording {
    gpu::Device& device;
    const Declaration& declaration;
    const Resources& resources;
    Bindings& bindings;
    gpu::DescriptorArena& descriptors;
    const QueueFamily& family; ///< of the queue that the plan gives the pass
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
    void set_stencil(std::uint8_t reference);
    void set_viewport(glm::ivec2 origin, glm::uvec2 extent);
    void push(std::span<const std::byte> values);
    void bind_indices(const BufferPart& indices);
    void draw(std::uint32_t vertices, std::uint32_t instances, std::uint32_t first_vertex,
        std::uint32_t first_instance);
    void draw_indexed(std::uint32_t indices, std::uint32_t instances, std::uint32_t first_index,
        std::int32_t vertex_offset, std::uint32_t first_instance);

    void fill(const BufferPart& buffer, std::uint32_t value);
    void clear(const ImagePart& image, const std::array<float, 4>& value);
    void copy(const BufferPart& from, const BufferPart& to, std::uint64_t bytes);
    void copy(const ImagePart& from, const ImagePart& to);

private:
    template <class... Args>
    [[noreturn]] void fail(
        const char* code, fmt::format_string<Args...> text, Args&&... args) const {
        fail_pass(recording_.declaration, id_, code, text, std::forward<Args>(args)...);
    }
    /// A part that a command touches, and the real thing behind it.
    struct Target {
        const Resource& resource;
        const ResourceDecl& decl;
        Part part; ///< ends resolved
    };
    /// The part must lie in one that the pass declared with this access.
    template <ResourceKind Kind>
    Target used(const PartOf<Kind>& target, Access access, const char* command) const;
    void expect_kind(PassKind kind, const char* command) const;
    void expect_pipeline(const char* command) const;
    const gpu::Pipeline& compute_pipeline(const ComputeCall& call) const;
    void prepare(const gpu::Pipeline& pipeline, const ComputeCall& call);
    void dispatch(const gpu::Pipeline& pipeline, const ComputeCall& call, glm::uvec3 groups);
    void bind_descriptors(const gpu::Pipeline& pipeline, VkPipelineBindPoint point);
    VkDescriptorBufferInfo buffer_info(const Use& use) const;
    VkDescriptorImageInfo image_info(const gpu::ShaderBinding& binding, const Use& use) const;
    void push_constants(const gpu::Pipeline& pipeline, std::span<const std::byte> values);

    Recording& recording_;
    PassId id_;
    const PassDecl& pass_;
    VkCommandBuffer commands_;
    const RasterTarget* target_;
    const gpu::Pipeline* raster_ = nullptr; ///< bound by bind()
    bool pushed_ = false;                   ///< since bind()
    std::uint64_t index_count_ = 0;         ///< of the bound index buffer
};

} // namespace ockham
