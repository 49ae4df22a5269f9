// SPDX-License-Identifier: Apache-2.0
#include "framework/runtime/commands.hpp"

#include "framework/core/error.hpp"
#include "framework/runtime/commands_impl.hpp"

#include <algorithm>

namespace ockham {

namespace {

/// What every Vulkan device allows per axis.
constexpr std::uint32_t kMaxGroups = 65535;

const char* describe(VkDescriptorType type) {
    switch (type) {
    case VK_DESCRIPTOR_TYPE_STORAGE_BUFFER:
        return "a storage buffer";
    case VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER:
        return "a uniform buffer";
    case VK_DESCRIPTOR_TYPE_STORAGE_IMAGE:
        return "a storage image";
    case VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER:
        return "a sampled image";
    default:
        return "something else";
    }
}

const char* describe(PassKind kind) {
    switch (kind) {
    case PassKind::compute:
        return "compute";
    case PassKind::raster:
        return "raster";
    case PassKind::transfer:
        return "transfer";
    }
    return "?";
}

VkShaderStageFlags vulkan_stage(Stage stage) {
    switch (stage) {
    case Stage::compute:
        return VK_SHADER_STAGE_COMPUTE_BIT;
    case Stage::vertex:
        return VK_SHADER_STAGE_VERTEX_BIT;
    case Stage::fragment:
        return VK_SHADER_STAGE_FRAGMENT_BIT;
    case Stage::fixed:
        break;
    }
    return 0;
}

VkDescriptorType descriptor_of(Access access, ResourceKind kind) {
    switch (access) {
    case Access::sampled:
        return VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    case Access::uniform:
        return VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
    default:
        return kind == ResourceKind::image ? VK_DESCRIPTOR_TYPE_STORAGE_IMAGE
                                           : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    }
}

} // namespace

CommandsImpl::CommandsImpl(
    Recording& recording, PassId pass, VkCommandBuffer commands, const RasterTarget* target)
    : recording_(recording), pass_(recording.declaration.passes[pass]), commands_(commands),
      target_(target) {}

std::span<const Use> CommandsImpl::uses() const {
    return {recording_.declaration.uses.data() + pass_.first_use, pass_.use_count};
}

const std::string& CommandsImpl::name_of(ResourceId id) const {
    static const std::string nothing = "(no resource)";
    return id < recording_.declaration.resources.size() ? recording_.declaration.resources[id].name
                                                        : nothing;
}

const Resource& CommandsImpl::used(ResourceId id, Access access, const char* command) const {
    for (const Use& use : uses()) {
        if (use.resource == id && use.access == access) return recording_.resources[id];
    }
    fail("{} of '{}' needs the access '{}', which the pass did not declare", command, name_of(id),
        ockham::name_of(access));
}

void CommandsImpl::expect_kind(PassKind kind, const char* command) const {
    if (pass_.kind == kind) return;
    fail("{} belongs in a {} pass, this is a {} pass", command, describe(kind),
        describe(pass_.kind));
}

void CommandsImpl::expect_pipeline(const char* command) const {
    expect_kind(PassKind::raster, command);
    if (!raster_) fail("{} before bind()", command);
}

const Use& CommandsImpl::match(
    const gpu::Pipeline& pipeline, const gpu::PipelineLayout::Slot& slot) const {
    const gpu::ShaderBinding& binding = slot.binding;
    const Declaration& declaration = recording_.declaration;
    const auto found = std::ranges::find(
        uses(), binding.name, [&](const Use& use) { return declaration.detail_of(use).binding; });
    if (found == uses().end()) {
        std::vector<std::string_view> declared;
        for (const Use& use : uses()) {
            const std::string& name = declaration.detail_of(use).binding;
            if (!name.empty()) declared.push_back(name);
        }
        fail("shader '{}' uses binding '{}', which the pass did not declare; it declared: {}",
            slot.shader, binding.name, fmt::join(declared, ", "));
    }
    const Use& use = *found;
    const ResourceDecl& resource = declaration.resources[use.resource];
    if (descriptor_of(use.access, resource.kind) != binding.type) {
        fail("shader '{}', binding '{}' is {} in the shader, but declared as {} ('{}' of {} '{}')",
            slot.shader, binding.name, describe(binding.type),
            describe(descriptor_of(use.access, resource.kind)), ockham::name_of(use.access),
            resource.kind == ResourceKind::image ? "image" : "buffer", resource.name);
    }
    const bool may_read = use.access != Access::storage_write;
    const bool may_write = writes(use.access);
    if (binding.writes && !may_write) {
        fail("shader '{}' may write binding '{}', but the pass declared it '{}'; qualify it "
             "readonly in the shader, or declare the write",
            slot.shader, binding.name, ockham::name_of(use.access));
    }
    if (binding.reads && !may_read) {
        fail("shader '{}' may read binding '{}', but the pass declared it '{}'; qualify it "
             "writeonly in the shader, or declare read_write",
            slot.shader, binding.name, ockham::name_of(use.access));
    }
    if (!binding.writes && use.access == Access::storage_write) {
        fail("shader '{}' cannot write binding '{}', which it qualifies readonly, but the pass "
             "declared it '{}'",
            slot.shader, binding.name, ockham::name_of(use.access));
    }
    // Content that no pass writes is complete before the execution, whoever reads it.
    const VkShaderStageFlags declared = vulkan_stage(use.stage);
    const bool covered = (slot.stages & ~declared) == 0;
    if (!(slot.stages & declared) || (!covered && recording_.resources[use.resource].written)) {
        fail("'{}' uses binding '{}' in other shader stages ({:#x}) than the pass declared ({})",
            pipeline.shaders, binding.name, slot.stages, ockham::name_of(use.stage));
    }
    return use;
}

VkDescriptorBufferInfo CommandsImpl::buffer_info(
    const gpu::Pipeline& pipeline, const gpu::PipelineLayout::Slot& slot, const Use& use) const {
    const gpu::Buffer& buffer = *recording_.resources[use.resource].buffer;
    const gpu::Limits& limits = recording_.device.limits();
    const std::uint64_t limit = slot.binding.type == VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER
                                    ? limits.uniform_bytes
                                    : limits.storage_bytes;
    if (buffer.bytes() > limit) {
        fail("'{}', binding '{}': buffer '{}' has {} bytes, the device binds at most {} as {}",
            pipeline.shaders, slot.binding.name, buffer.name(), buffer.bytes(), limit,
            describe(slot.binding.type));
    }
    return {buffer.handle(), 0, VK_WHOLE_SIZE};
}

VkDescriptorImageInfo CommandsImpl::image_info(
    const gpu::Pipeline& pipeline, const gpu::PipelineLayout::Slot& slot, const Use& use) const {
    const gpu::ShaderBinding& binding = slot.binding;
    const gpu::Image& image = *recording_.resources[use.resource].image;
    const bool sampled = binding.type == VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    const bool is_3d = image.info().depth > 1;
    if (is_3d != (binding.view_type == VK_IMAGE_VIEW_TYPE_3D)) {
        fail("'{}', binding '{}': the shader wants a {} image, but '{}' is {}", pipeline.shaders,
            binding.name, is_3d ? "2D" : "3D", image.name(), is_3d ? "3D" : "2D");
    }
    if (!sampled && binding.format != VK_FORMAT_UNDEFINED &&
        binding.format != image.info().format) {
        fail("'{}', binding '{}': the shader declares format {}, but image '{}' is {}",
            pipeline.shaders, binding.name, gpu::name_of(binding.format), image.name(),
            gpu::name_of(image.info().format));
    }
    VkSampler sampler = VK_NULL_HANDLE;
    if (sampled) {
        const bool linear = use.filter != Filter::texel;
        if (linear && !(recording_.device.format_features(image.info().format) &
                          VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT)) {
            fail("'{}', binding '{}': the device cannot filter format {} of image '{}' linearly; "
                 "use Filter::texel",
                pipeline.shaders, binding.name, gpu::name_of(image.info().format), image.name());
        }
        sampler = recording_.device.sampler(linear ? VK_FILTER_LINEAR : VK_FILTER_NEAREST,
            use.filter == Filter::linear_repeat ? VK_SAMPLER_ADDRESS_MODE_REPEAT
                                                : VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE);
    }
    return {
        sampler, image.view(binding.view_type, sampled), state_of(use.access, use.stage).layout};
}

void CommandsImpl::bind_descriptors(const gpu::Pipeline& pipeline, VkPipelineBindPoint point) {
    const gpu::PipelineLayout& layout = *pipeline.layout;
    const std::size_t count = layout.slots.size();
    std::vector<VkDescriptorBufferInfo> buffers(count);
    std::vector<VkDescriptorImageInfo> images(count);
    std::vector<VkWriteDescriptorSet> writes(count);
    for (std::size_t i = 0; i < count; ++i) {
        const gpu::PipelineLayout::Slot& slot = layout.slots[i];
        const Use& use = match(pipeline, slot);
        const bool is_buffer = slot.binding.type == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER ||
                               slot.binding.type == VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
        if (is_buffer) {
            buffers[i] = buffer_info(pipeline, slot, use);
        } else {
            images[i] = image_info(pipeline, slot, use);
        }
        writes[i] = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
            .dstBinding = slot.binding.binding,
            .descriptorCount = 1,
            .descriptorType = slot.binding.type,
            .pImageInfo = is_buffer ? nullptr : &images[i],
            .pBufferInfo = is_buffer ? &buffers[i] : nullptr};
    }
    // The slots are sorted by set.
    std::size_t first = 0;
    for (std::uint32_t set = 0; set < layout.sets.size(); ++set) {
        std::size_t end = first;
        while (end < count && layout.slots[end].binding.set == set) ++end;
        const auto in_set = static_cast<std::uint32_t>(end - first);
        VkWriteDescriptorSet* const begin = writes.data() + first;
        first = end;
        if (set == 0 && layout.pushes_set_0) {
            recording_.device.push_descriptor_set()(
                commands_, point, layout.handle, set, in_set, begin);
            continue;
        }
        const VkDescriptorSet handle = recording_.descriptors.allocate(layout.sets[set]);
        for (std::uint32_t i = 0; i < in_set; ++i) begin[i].dstSet = handle;
        vkUpdateDescriptorSets(recording_.device.handle(), in_set, begin, 0, nullptr);
        vkCmdBindDescriptorSets(commands_, point, layout.handle, set, 1, &handle, 0, nullptr);
    }
}

void CommandsImpl::push_constants(
    const gpu::Pipeline& pipeline, std::span<const std::byte> values) {
    if (values.size() != pipeline.layout->push_bytes) {
        fail("'{}' takes {} bytes of push constants, but got {}", pipeline.shaders,
            pipeline.layout->push_bytes, values.size());
    }
    if (values.empty()) return;
    vkCmdPushConstants(commands_, pipeline.layout->handle, pipeline.layout->push_stages, 0,
        static_cast<std::uint32_t>(values.size()), values.data());
}

const gpu::Pipeline& CommandsImpl::prepare(const ComputeCall& call) {
    expect_kind(PassKind::compute, "a dispatch");
    const gpu::Pipeline* pipeline = nullptr;
    try {
        pipeline = &recording_.device.pipelines().compute(call.shader, call.specialization);
    } catch (const Error& error) {
        throw Error(error.kind(), fmt::format("pass '{}': {}", pass_.name, error.what()));
    }
    recording_.pipelines.insert(pipeline);
    vkCmdBindPipeline(commands_, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline->handle);
    bind_descriptors(*pipeline, VK_PIPELINE_BIND_POINT_COMPUTE);
    push_constants(*pipeline, call.push);
    return *pipeline;
}

void CommandsImpl::dispatch(const ComputeCall& call, glm::uvec3 groups) {
    prepare(call);
    for (int axis = 0; axis < 3; ++axis) {
        const std::uint32_t limit =
            std::min(kMaxGroups, recording_.device.limits().groups[static_cast<std::size_t>(axis)]);
        if (groups[axis] > limit) {
            fail("shader '{}' is dispatched over {} x {} x {} workgroups; at most {} fit on an "
                 "axis, so use two axes or more work per group",
                call.shader, groups.x, groups.y, groups.z, limit);
        }
    }
    if (groups.x > 0 && groups.y > 0 && groups.z > 0) {
        vkCmdDispatch(commands_, groups.x, groups.y, groups.z);
    }
}

void CommandsImpl::dispatch_over(const ComputeCall& call, glm::uvec3 items) {
    expect_kind(PassKind::compute, "a dispatch");
    std::array<std::uint32_t, 3> size{};
    try {
        size = recording_.device.pipelines().compute(call.shader, call.specialization).local_size;
    } catch (const Error& error) {
        throw Error(error.kind(), fmt::format("pass '{}': {}", pass_.name, error.what()));
    }
    const auto cover = [](std::uint32_t count, std::uint32_t group) {
        return count / group + (count % group != 0);
    };
    dispatch(call, {cover(items.x, size[0]), cover(items.y, size[1]), cover(items.z, size[2])});
}

void CommandsImpl::dispatch_indirect(
    const ComputeCall& call, BufferHandle arguments, std::uint64_t offset_bytes) {
    prepare(call);
    const gpu::Buffer& buffer =
        *used(arguments.resource, Access::indirect, "an indirect dispatch").buffer;
    if (offset_bytes % 4 != 0 || offset_bytes + 12 > buffer.bytes()) {
        fail("shader '{}': indirect arguments at byte {} of '{}' with {} bytes; the offset must be "
             "a multiple of 4 with 12 bytes after it",
            call.shader, offset_bytes, buffer.name(), buffer.bytes());
    }
    vkCmdDispatchIndirect(commands_, buffer.handle(), offset_bytes);
}

void CommandsImpl::bind(const RasterCall& call) {
    expect_kind(PassKind::raster, "bind()");
    const gpu::RasterState state{.vertex_shader = std::string(call.vertex_shader),
        .fragment_shader = std::string(call.fragment_shader),
        .specialization = call.specialization,
        .depth_test = call.depth_test,
        .depth_write = call.depth_write};
    try {
        raster_ = &recording_.device.pipelines().raster(state, target_->attachments);
    } catch (const Error& error) {
        throw Error(error.kind(), fmt::format("pass '{}': {}", pass_.name, error.what()));
    }
    recording_.pipelines.insert(raster_);
    vkCmdBindPipeline(commands_, VK_PIPELINE_BIND_POINT_GRAPHICS, raster_->handle);
    bind_descriptors(*raster_, VK_PIPELINE_BIND_POINT_GRAPHICS);
    pushed_ = raster_->layout->push_bytes == 0;
}

void CommandsImpl::set_cull(Commands::Cull mode, bool front_is_clockwise) {
    expect_kind(PassKind::raster, "set_cull()");
    const bool back = mode == Commands::Cull::back;
    vkCmdSetCullMode(commands_, VkCullModeFlags(back ? VK_CULL_MODE_BACK_BIT : VK_CULL_MODE_NONE));
    vkCmdSetFrontFace(
        commands_, front_is_clockwise ? VK_FRONT_FACE_CLOCKWISE : VK_FRONT_FACE_COUNTER_CLOCKWISE);
}

void CommandsImpl::push(std::span<const std::byte> values) {
    expect_pipeline("push()");
    push_constants(*raster_, values);
    pushed_ = true;
}

void CommandsImpl::bind_indices(BufferHandle indices) {
    expect_kind(PassKind::raster, "bind_indices()");
    const gpu::Buffer& buffer = *used(indices.resource, Access::index, "bind_indices()").buffer;
    vkCmdBindIndexBuffer(commands_, buffer.handle(), 0, VK_INDEX_TYPE_UINT32);
    index_count_ = buffer.bytes() / 4;
}

void CommandsImpl::draw(std::uint32_t vertices, std::uint32_t instances, std::uint32_t first_vertex,
    std::uint32_t first_instance) {
    expect_pipeline("draw()");
    if (!pushed_) push_constants(*raster_, {});
    vkCmdDraw(commands_, vertices, instances, first_vertex, first_instance);
}

void CommandsImpl::draw_indexed(std::uint32_t indices, std::uint32_t instances,
    std::uint32_t first_index, std::int32_t vertex_offset, std::uint32_t first_instance) {
    expect_pipeline("draw_indexed()");
    if (!pushed_) push_constants(*raster_, {});
    if (std::uint64_t{first_index} + indices > index_count_) {
        fail("draw_indexed() of indices {} to {}, but {} are bound", first_index,
            std::uint64_t{first_index} + indices, index_count_);
    }
    vkCmdDrawIndexed(commands_, indices, instances, first_index, vertex_offset, first_instance);
}

void CommandsImpl::fill(BufferHandle buffer, std::uint32_t value) {
    const Resource& to = used(buffer.resource, Access::transfer_write, "fill()");
    if (to.buffer->bytes() % 4 != 0) {
        fail("fill() of '{}' with {} bytes, which is no multiple of 4", to.buffer->name(),
            to.buffer->bytes());
    }
    vkCmdFillBuffer(commands_, to.buffer->handle(), 0, VK_WHOLE_SIZE, value);
}

void CommandsImpl::clear(ImageHandle image, const std::array<float, 4>& value) {
    const gpu::Image& to = *used(image.resource, Access::transfer_write, "clear()").image;
    gpu::clear(commands_, to, value);
}

void CommandsImpl::copy(BufferHandle from, BufferHandle to, std::uint64_t bytes) {
    const gpu::Buffer& source = *used(from.resource, Access::transfer_read, "copy()").buffer;
    const gpu::Buffer& target = *used(to.resource, Access::transfer_write, "copy()").buffer;
    if (bytes == 0 || bytes > source.bytes() || bytes > target.bytes()) {
        fail("copy() of {} bytes from '{}' with {} to '{}' with {}", bytes, source.name(),
            source.bytes(), target.name(), target.bytes());
    }
    const VkBufferCopy region{0, 0, bytes};
    vkCmdCopyBuffer(commands_, source.handle(), target.handle(), 1, &region);
}

void CommandsImpl::copy(ImageHandle from, ImageHandle to) {
    const gpu::Image& source = *used(from.resource, Access::transfer_read, "copy()").image;
    const gpu::Image& target = *used(to.resource, Access::transfer_write, "copy()").image;
    const gpu::ImageInfo& a = source.info();
    const gpu::ImageInfo& b = target.info();
    if (a.format != b.format || a.width != b.width || a.height != b.height || a.depth != b.depth ||
        a.layers != b.layers || a.mips != b.mips) {
        fail("copy() from '{}' ({}, {} x {} x {}) to '{}' ({}, {} x {} x {}): format and size must "
             "be the same",
            a.name, gpu::name_of(a.format), a.width, a.height, a.depth, b.name,
            gpu::name_of(b.format), b.width, b.height, b.depth);
    }
    std::vector<VkImageCopy> regions(a.mips);
    for (std::uint32_t mip = 0; mip < a.mips; ++mip) {
        const VkImageSubresourceLayers layers{
            .aspectMask = source.aspect(), .mipLevel = mip, .layerCount = a.layers};
        regions[mip] = {.srcSubresource = layers,
            .dstSubresource = layers,
            .extent = {std::max(a.width >> mip, 1u), std::max(a.height >> mip, 1u),
                std::max(a.depth >> mip, 1u)}};
    }
    vkCmdCopyImage(commands_, source.handle(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
        target.handle(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, a.mips, regions.data());
}

void Commands::dispatch(const ComputeCall& call, glm::uvec3 groups) {
    impl_->dispatch(call, groups);
}
void Commands::dispatch_over(const ComputeCall& call, glm::uvec3 items) {
    impl_->dispatch_over(call, items);
}
void Commands::dispatch_indirect(
    const ComputeCall& call, BufferHandle arguments, std::uint64_t offset_bytes) {
    impl_->dispatch_indirect(call, arguments, offset_bytes);
}
void Commands::bind(const RasterCall& call) { impl_->bind(call); }
void Commands::set_cull(Cull mode, bool front_is_clockwise) {
    impl_->set_cull(mode, front_is_clockwise);
}
void Commands::push(std::span<const std::byte> values) { impl_->push(values); }
void Commands::bind_indices(BufferHandle indices) { impl_->bind_indices(indices); }
void Commands::draw(std::uint32_t vertices, std::uint32_t instances, std::uint32_t first_vertex,
    std::uint32_t first_instance) {
    impl_->draw(vertices, instances, first_vertex, first_instance);
}
void Commands::draw_indexed(std::uint32_t indices, std::uint32_t instances,
    std::uint32_t first_index, std::int32_t vertex_offset, std::uint32_t first_instance) {
    impl_->draw_indexed(indices, instances, first_index, vertex_offset, first_instance);
}
void Commands::fill(BufferHandle buffer, std::uint32_t value) { impl_->fill(buffer, value); }
void Commands::clear(ImageHandle image, const std::array<float, 4>& value) {
    impl_->clear(image, value);
}
void Commands::copy(BufferHandle from, BufferHandle to, std::uint64_t bytes) {
    impl_->copy(from, to, bytes);
}
void Commands::copy(ImageHandle from, ImageHandle to) { impl_->copy(from, to); }

} // namespace ockham
