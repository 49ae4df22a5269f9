// SPDX-License-Identifier: Apache-2.0
#include "framework/runtime/commands.hpp"

#include "framework/runtime/commands_impl.hpp"

#include <algorithm>

namespace ockham {

namespace {

/// What every Vulkan device allows per axis.
constexpr std::uint32_t kMaxGroups = 65535;

/// Whether [first, first + count), not empty, lies in [begin, begin + size); no sum, so no
/// overflow.
bool is_inside(std::uint64_t first, std::uint64_t count, std::uint64_t begin, std::uint64_t size) {
    return first >= begin && first - begin < size && count > 0 && count <= size - (first - begin);
}

bool contains(const Part& outer, const Part& inner, ResourceKind kind) {
    if (kind == ResourceKind::buffer)
        return is_inside(inner.offset, inner.bytes, outer.offset, outer.bytes);
    return is_inside(inner.first_mip, inner.mips, outer.first_mip, outer.mips) &&
           is_inside(inner.first_layer, inner.layers, outer.first_layer, outer.layers);
}

/// Ends resolved; a part that begins beyond the resource is empty.
Part resolve(Part part, const ResourceDecl& resource) {
    const auto rest = [](auto size, auto first) { return first < size ? size - first : 0; };
    if (part.bytes == kRest) part.bytes = rest(resource.buffer.bytes, part.offset);
    if (part.mips == kRestOfMips) part.mips = rest(resource.image.mips, part.first_mip);
    if (part.layers == kRestOfLayers) part.layers = rest(resource.image.layers, part.first_layer);
    return part;
}

} // namespace

CommandsImpl::CommandsImpl(
    Recording& recording, PassId pass, VkCommandBuffer commands, const RasterTarget* target)
    : recording_(recording), id_(pass), pass_(recording.declaration.passes[pass]),
      commands_(commands), target_(target) {}

template <ResourceKind Kind>
CommandsImpl::Target CommandsImpl::used(
    const PartOf<Kind>& target, Access access, const char* command) const {
    const Declaration& declaration = recording_.declaration;
    const ResourceId id = target.handle.resource;
    if (id >= declaration.resources.size() || declaration.resources[id].kind != Kind) {
        fail("invalid-handle", "{} of a handle that names nothing in this graph", command);
    }
    const ResourceDecl& resource = declaration.resources[id];
    const Part part = resolve(target.part, resource);
    bool declared = false;
    for (const Use& use : declaration.uses_of(id_)) {
        if (use.resource != id || use.access != access) continue;
        declared = true;
        if (contains(part_of(declaration, use), part, Kind)) {
            return {recording_.resources[id], resource, part};
        }
    }
    if (declared) {
        fail("undeclared-part",
            "{} touches more of {} than the pass declared; name the same part in both", command,
            describe(resource));
    }
    fail("undeclared-access", "{} of {} needs the access '{}', which the pass did not declare",
        command, describe(resource), name_of(access));
}

void CommandsImpl::expect_kind(PassKind kind, const char* command) const {
    if (pass_.kind == kind) return;
    fail("wrong-pass-kind", "{} belongs in a {} pass, this is a {} pass", command, name_of(kind),
        name_of(pass_.kind));
}

void CommandsImpl::expect_pipeline(const char* command) const {
    expect_kind(PassKind::raster, command);
    if (!raster_) fail("no-pipeline", "{} before bind()", command);
}

VkDescriptorBufferInfo CommandsImpl::buffer_info(const Use& use) const {
    const gpu::Buffer& buffer = *recording_.resources[use.resource].buffer;
    const Part part = part_of(recording_.declaration, use);
    // Whole words, as far as there are.
    const std::uint64_t bytes = (part.bytes + 3) / 4 * 4;
    return {buffer.handle(), part.offset, std::min(bytes, buffer.bytes() - part.offset)};
}

VkDescriptorImageInfo CommandsImpl::image_info(
    const gpu::ShaderBinding& binding, const Use& use) const {
    VkSampler sampler = VK_NULL_HANDLE;
    if (binding.type == VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER) {
        sampler = recording_.device.sampler(
            use.filter == Filter::texel ? VK_FILTER_NEAREST : VK_FILTER_LINEAR,
            use.filter == Filter::linear_repeat ? VK_SAMPLER_ADDRESS_MODE_REPEAT
                                                : VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE);
    }
    const gpu::Image& image = *recording_.resources[use.resource].image;
    const gpu::ImageRange range = range_of(part_of(recording_.declaration, use));
    return {sampler, image.view(binding.view_type, range), state_of(use.access, use.stage).layout};
}

void CommandsImpl::bind_descriptors(const gpu::Pipeline& pipeline, VkPipelineBindPoint point) {
    const gpu::PipelineLayout& layout = *pipeline.layout;
    const std::vector<std::uint32_t>& uses = recording_.bindings.of(id_, pipeline);
    const std::size_t count = layout.slots.size();
    std::vector<VkDescriptorBufferInfo> buffers(count);
    std::vector<VkDescriptorImageInfo> images(count);
    std::vector<VkWriteDescriptorSet> writes(count);
    for (std::size_t i = 0; i < count; ++i) {
        const gpu::ShaderBinding& binding = layout.slots[i].binding;
        const Use& use = recording_.declaration.uses[uses[i]];
        const bool is_buffer = binding.type == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER ||
                               binding.type == VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
        if (is_buffer) {
            buffers[i] = buffer_info(use);
        } else {
            images[i] = image_info(binding, use);
        }
        writes[i] = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
            .dstBinding = binding.binding,
            .descriptorCount = 1,
            .descriptorType = binding.type,
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
        fail("push-size", "'{}' takes {} bytes of push constants, but got {}", pipeline.shaders,
            pipeline.layout->push_bytes, values.size());
    }
    if (values.empty()) return;
    vkCmdPushConstants(commands_, pipeline.layout->handle, pipeline.layout->push_stages, 0,
        static_cast<std::uint32_t>(values.size()), values.data());
}

const gpu::Pipeline& CommandsImpl::compute_pipeline(const ComputeCall& call) const {
    expect_kind(PassKind::compute, "a dispatch");
    try {
        return recording_.device.pipelines().compute(call.shader, call.specialization);
    } catch (const Error& error) {
        if (error.kind() != ErrorKind::input) throw;
        fail("bad-shader", "{}", error.what());
    }
}

void CommandsImpl::prepare(const gpu::Pipeline& pipeline, const ComputeCall& call) {
    vkCmdBindPipeline(commands_, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.handle);
    bind_descriptors(pipeline, VK_PIPELINE_BIND_POINT_COMPUTE);
    push_constants(pipeline, call.push);
}

void CommandsImpl::dispatch(const ComputeCall& call, glm::uvec3 groups) {
    dispatch(compute_pipeline(call), call, groups);
}

void CommandsImpl::dispatch(
    const gpu::Pipeline& pipeline, const ComputeCall& call, glm::uvec3 groups) {
    prepare(pipeline, call);
    for (int axis = 0; axis < 3; ++axis) {
        const std::uint32_t limit =
            std::min(kMaxGroups, recording_.device.limits().groups[static_cast<std::size_t>(axis)]);
        if (groups[axis] > limit) {
            fail("too-many-groups",
                "shader '{}' is dispatched over {} x {} x {} workgroups; at most {} fit on an "
                "axis, so use two axes or more work per group",
                call.shader, groups.x, groups.y, groups.z, limit);
        }
    }
    if (groups.x > 0 && groups.y > 0 && groups.z > 0) {
        vkCmdDispatch(commands_, groups.x, groups.y, groups.z);
    }
}

void CommandsImpl::dispatch_over(const ComputeCall& call, glm::uvec3 items) {
    const gpu::Pipeline& pipeline = compute_pipeline(call);
    const std::array<std::uint32_t, 3>& size = pipeline.local_size;
    const auto cover = [](std::uint32_t count, std::uint32_t group) {
        return count / group + (count % group != 0);
    };
    dispatch(pipeline, call,
        {cover(items.x, size[0]), cover(items.y, size[1]), cover(items.z, size[2])});
}

void CommandsImpl::dispatch_indirect(
    const ComputeCall& call, BufferHandle arguments, std::uint64_t offset_bytes) {
    prepare(compute_pipeline(call), call);
    const std::uint64_t bytes = arguments.resource < recording_.declaration.resources.size()
                                    ? recording_.resources[arguments.resource].bytes
                                    : 0;
    if (offset_bytes % 4 != 0 || bytes < 12 || offset_bytes > bytes - 12) {
        fail("bad-offset",
            "shader '{}': indirect arguments at byte {} of {} bytes; the offset must be a multiple "
            "of 4 with 12 bytes after it",
            call.shader, offset_bytes, bytes);
    }
    const Target target =
        used(arguments.range(offset_bytes, 12), Access::indirect, "an indirect dispatch");
    vkCmdDispatchIndirect(commands_, target.resource.buffer->handle(), offset_bytes);
}

void CommandsImpl::bind(const RasterCall& call) {
    expect_kind(PassKind::raster, "bind()");
    const gpu::RasterState state{.vertex_shader = std::string(call.vertex_shader),
        .fragment_shader = std::string(call.fragment_shader),
        .specialization = call.specialization,
        .depth_test = call.depth_test,
        .depth_write = call.depth_write,
        .depth_equal = call.depth_equal,
        .stencil_write = call.stencil_write,
        .stencil_equal = call.stencil_equal};
    try {
        raster_ = &recording_.device.pipelines().raster(state, target_->attachments);
    } catch (const Error& error) {
        if (error.kind() != ErrorKind::input) throw;
        fail("bad-shader", "{}", error.what());
    }
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

void CommandsImpl::set_stencil(std::uint8_t reference) {
    expect_kind(PassKind::raster, "set_stencil()");
    vkCmdSetStencilReference(commands_, VK_STENCIL_FACE_FRONT_AND_BACK, reference);
}

void CommandsImpl::set_viewport(glm::ivec2 origin, glm::uvec2 extent) {
    expect_kind(PassKind::raster, "set_viewport()");
    const VkViewport viewport{static_cast<float>(origin.x), static_cast<float>(origin.y),
        static_cast<float>(extent.x), static_cast<float>(extent.y), 0.0f, 1.0f};
    vkCmdSetViewport(commands_, 0, 1, &viewport);
}

void CommandsImpl::push(std::span<const std::byte> values) {
    expect_pipeline("push()");
    push_constants(*raster_, values);
    pushed_ = true;
}

void CommandsImpl::bind_indices(const BufferPart& indices) {
    expect_kind(PassKind::raster, "bind_indices()");
    const Target target = used(indices, Access::index, "bind_indices()");
    vkCmdBindIndexBuffer(
        commands_, target.resource.buffer->handle(), target.part.offset, VK_INDEX_TYPE_UINT32);
    index_count_ = target.part.bytes / 4;
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
        fail("bad-indices", "draw_indexed() of indices {} to {}, but {} are bound", first_index,
            std::uint64_t{first_index} + indices, index_count_);
    }
    vkCmdDrawIndexed(commands_, indices, instances, first_index, vertex_offset, first_instance);
}

void CommandsImpl::fill(const BufferPart& buffer, std::uint32_t value) {
    const Target to = used(buffer, Access::transfer_write, "fill()");
    const bool to_the_end = to.part.offset + to.part.bytes == to.resource.bytes;
    // Of an odd number of bytes, the words that exist.
    const std::uint64_t bytes = to_the_end
                                    ? std::min((to.part.bytes + 3) / 4 * 4,
                                          (to.resource.buffer->bytes() - to.part.offset) / 4 * 4)
                                    : to.part.bytes;
    if (to.part.offset % 4 != 0 || bytes % 4 != 0 || bytes < to.part.bytes) {
        fail("copy-size", "fill() of {} bytes from byte {} of {}; both must be multiples of 4",
            to.part.bytes, to.part.offset, describe(to.decl));
    }
    vkCmdFillBuffer(commands_, to.resource.buffer->handle(), to.part.offset, bytes, value);
}

void CommandsImpl::clear(const ImagePart& image, const std::array<float, 4>& value) {
    const Target to = used(image, Access::transfer_write, "clear()");
    const bool depth = to.resource.image->aspect() != VK_IMAGE_ASPECT_COLOR_BIT;
    const QueueFamily& family = recording_.family;
    if (!family.graphics && (depth || !family.compute)) {
        fail("wrong-queue",
            "clear() of {} needs a queue with {}, which the pass's queue lacks; prefer() another "
            "one, or clear it in a pass of its own",
            describe(to.decl), depth ? "graphics" : "compute");
    }
    gpu::clear(commands_, *to.resource.image, value, range_of(to.part));
}

void CommandsImpl::copy(const BufferPart& from, const BufferPart& to, std::uint64_t bytes) {
    const Target source = used(from, Access::transfer_read, "copy()");
    const Target target = used(to, Access::transfer_write, "copy()");
    if (bytes == kRest) bytes = source.part.bytes;
    if (bytes == 0 || bytes > source.part.bytes || bytes > target.part.bytes) {
        fail("copy-size", "copy() of {} bytes from {} bytes of {} to {} bytes of {}", bytes,
            source.part.bytes, describe(source.decl), target.part.bytes, describe(target.decl));
    }
    const VkBufferCopy region{source.part.offset, target.part.offset, bytes};
    vkCmdCopyBuffer(
        commands_, source.resource.buffer->handle(), target.resource.buffer->handle(), 1, &region);
}

void CommandsImpl::copy(const ImagePart& from, const ImagePart& to) {
    const Target source = used(from, Access::transfer_read, "copy()");
    const Target target = used(to, Access::transfer_write, "copy()");
    const gpu::Image& a = *source.resource.image;
    const gpu::Image& b = *target.resource.image;
    bool same = a.info().format == b.info().format && source.part.mips == target.part.mips &&
                source.part.layers == target.part.layers;
    std::vector<VkImageCopy> regions;
    for (std::uint32_t mip = 0; same && mip < source.part.mips; ++mip) {
        const VkExtent3D extent = gpu::mip_extent(a.info(), source.part.first_mip + mip);
        const VkExtent3D wanted = gpu::mip_extent(b.info(), target.part.first_mip + mip);
        same = extent.width == wanted.width && extent.height == wanted.height &&
               extent.depth == wanted.depth;
        regions.push_back({.srcSubresource = {.aspectMask = a.aspect(),
                               .mipLevel = source.part.first_mip + mip,
                               .baseArrayLayer = source.part.first_layer,
                               .layerCount = source.part.layers},
            .dstSubresource = {.aspectMask = b.aspect(),
                .mipLevel = target.part.first_mip + mip,
                .baseArrayLayer = target.part.first_layer,
                .layerCount = target.part.layers},
            .extent = extent});
    }
    if (!same) {
        const auto shape = [](const Target& t) {
            const VkExtent3D extent = gpu::mip_extent(t.resource.image->info(), t.part.first_mip);
            return fmt::format("{} ({}, {} x {} x {}, {} mips, {} layers)", describe(t.decl),
                gpu::name_of(t.decl.image.format), extent.width, extent.height, extent.depth,
                t.part.mips, t.part.layers);
        };
        fail("copy-shape", "copy() from {} to {}: format and size must be the same", shape(source),
            shape(target));
    }
    vkCmdCopyImage(commands_, a.handle(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, b.handle(),
        VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, static_cast<std::uint32_t>(regions.size()),
        regions.data());
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
void Commands::set_stencil(std::uint8_t reference) { impl_->set_stencil(reference); }
void Commands::set_viewport(glm::ivec2 origin, glm::uvec2 extent) {
    impl_->set_viewport(origin, extent);
}
void Commands::push(std::span<const std::byte> values) { impl_->push(values); }
void Commands::bind_indices(const BufferPart& indices) { impl_->bind_indices(indices); }
void Commands::draw(std::uint32_t vertices, std::uint32_t instances, std::uint32_t first_vertex,
    std::uint32_t first_instance) {
    impl_->draw(vertices, instances, first_vertex, first_instance);
}
void Commands::draw_indexed(std::uint32_t indices, std::uint32_t instances,
    std::uint32_t first_index, std::int32_t vertex_offset, std::uint32_t first_instance) {
    impl_->draw_indexed(indices, instances, first_index, vertex_offset, first_instance);
}
void Commands::fill(const BufferPart& buffer, std::uint32_t value) { impl_->fill(buffer, value); }
void Commands::clear(const ImagePart& image, const std::array<float, 4>& value) {
    impl_->clear(image, value);
}
void Commands::copy(const BufferPart& from, const BufferPart& to, std::uint64_t bytes) {
    impl_->copy(from, to, bytes);
}
void Commands::copy(const ImagePart& from, const ImagePart& to) { impl_->copy(from, to); }

} // namespace ockham
