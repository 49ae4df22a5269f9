// SPDX-License-Identifier: Apache-2.0
#include "framework/runtime/resources.hpp"

#include "framework/core/error.hpp"
#include "framework/gpu/device.hpp"
#include "framework/gpu/device_lost.hpp"
#include "framework/graph/explain/explain.hpp"
#include "framework/graph/format.hpp"
#include "framework/runtime/barriers.hpp"
#include "framework/runtime/misuse.hpp"

#include <algorithm>
#include <map>

namespace ockham {

namespace {

/// A quiet NaN as float, no plausible integer.
constexpr std::uint32_t kPoison = 0x7fc0dead;

/// Ids of all ages of a resource; of most the only one.
std::pair<ResourceId, ResourceId> ages_of(const Declaration& declaration, ResourceId id) {
    const ResourceDecl& resource = declaration.resources[id];
    const ResourceId first = id - resource.history_age;
    return {first, first + resource.history_depth + 1};
}

std::uint32_t usage_of(const Declaration& declaration, const Plan& plan, ResourceId id) {
    std::uint32_t usage = 0;
    const auto [first, end] = ages_of(declaration, id);
    for (ResourceId age = first; age < end; ++age) usage |= plan.usages[age];
    return usage;
}

bool kept(const ResourceDecl& resource) {
    return resource.lifetime == Lifetime::persistent || resource.exported;
}

/// Kept and used beside the main family, or by several: nobody owns it then.
bool is_shared(const Declaration& declaration, const Plan& plan, ResourceId id) {
    if (!kept(declaration.resources[id])) return false;
    const auto [first, end] = ages_of(declaration, id);
    for (ResourceId age = first; age < end; ++age) {
        if (plan.concurrent[age]) return true;
    }
    for (const Submission& submission : plan.submissions) {
        if (plan.queues[submission.queue].family == plan.queues[0].family) continue;
        for (std::uint32_t i = 0; i < submission.step_count; ++i) {
            const PassId pass = plan.steps[submission.first_step + i].pass;
            for (const Use& use : declaration.uses_of(pass)) {
                if (use.resource >= first && use.resource < end) return true;
            }
        }
    }
    return false;
}

std::vector<std::uint32_t> sharing(const Declaration& declaration, const Plan& plan, ResourceId id,
    const std::vector<std::uint32_t>& families) {
    if (families.size() < 2 || !is_shared(declaration, plan, id)) return {};
    return families;
}

bool same_description(const ResourceDecl& a, const ResourceDecl& b) {
    const ImageDesc& x = a.image;
    const ImageDesc& y = b.image;
    return a.kind == b.kind && a.lifetime == b.lifetime && a.history_depth == b.history_depth &&
           a.history_age == b.history_age && a.buffer.bytes == b.buffer.bytes &&
           x.format == y.format && x.width == y.width && x.height == y.height &&
           x.depth == y.depth && x.layers == y.layers && x.mips == y.mips;
}

void record_copy(VkCommandBuffer commands, const Resource& from, const Resource& to) {
    if (from.buffer) {
        const VkBufferCopy region{0, 0, std::min(from.buffer->bytes(), to.buffer->bytes())};
        vkCmdCopyBuffer(commands, from.buffer->handle(), to.buffer->handle(), 1, &region);
        return;
    }
    const gpu::ImageInfo& info = from.image->info();
    std::vector<VkImageCopy> regions;
    for (std::uint32_t mip = 0; mip < info.mips; ++mip) {
        const VkImageSubresourceLayers layers{
            .aspectMask = from.image->aspect(), .mipLevel = mip, .layerCount = info.layers};
        regions.push_back({.srcSubresource = layers,
            .dstSubresource = layers,
            .extent = gpu::mip_extent(info, mip)});
    }
    vkCmdCopyImage(commands, from.image->handle(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
        to.image->handle(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, info.mips, regions.data());
}

/// All of a resource as bytes without gaps: mips one after the other, each layer by layer.
std::vector<VkBufferImageCopy> tight_regions(const gpu::Image& image, std::uint64_t& bytes) {
    const gpu::ImageInfo& info = image.info();
    std::vector<VkBufferImageCopy> regions;
    bytes = 0;
    for (std::uint32_t mip = 0; mip < info.mips; ++mip) {
        const VkExtent3D extent = gpu::mip_extent(info, mip);
        regions.push_back({.bufferOffset = bytes,
            .imageSubresource = {.aspectMask = image.aspect(),
                .mipLevel = mip,
                .layerCount = info.layers},
            .imageExtent = extent});
        bytes += std::uint64_t{texel_bytes(info.format)} * extent.width * extent.height *
                 extent.depth * info.layers;
    }
    return regions;
}

std::uint64_t content_bytes(const Resource& resource) {
    if (resource.buffer) return resource.buffer->bytes();
    std::uint64_t bytes = 0;
    tight_regions(*resource.image, bytes);
    return bytes;
}

void record_zero(VkCommandBuffer commands, const Resource& resource) {
    if (resource.buffer) {
        vkCmdFillBuffer(commands, resource.buffer->handle(), 0, VK_WHOLE_SIZE, 0);
    } else {
        gpu::clear(commands, *resource.image, {0, 0, 0, 0});
    }
}

} // namespace

gpu::BufferInfo buffer_info(const Declaration& declaration, const Plan& plan, ResourceId id,
    const std::vector<std::uint32_t>& families) {
    const ResourceDecl& resource = declaration.resources[id];
    // Whole words, so that fills cover all of it.
    return {.bytes = (resource.buffer.bytes + 3) / 4 * 4,
        .usage = usage_of(declaration, plan, id),
        .name = resource.name,
        .families = sharing(declaration, plan, id, families)};
}

gpu::ImageInfo image_info(const Declaration& declaration, const Plan& plan, ResourceId id,
    const std::vector<std::uint32_t>& families) {
    const ResourceDecl& resource = declaration.resources[id];
    const ImageDesc& desc = resource.image;
    return {.format = desc.format,
        .width = desc.width,
        .height = desc.height,
        .depth = desc.depth,
        .layers = desc.layers,
        .mips = desc.mips,
        .usage = usage_of(declaration, plan, id),
        .name = resource.name,
        .aliased = !kept(resource),
        .families = sharing(declaration, plan, id, families)};
}

std::vector<std::uint32_t> families_of(const Plan& plan) {
    std::vector<std::uint32_t> families;
    for (const PlanQueue& queue : plan.queues) families.push_back(queue.family);
    std::ranges::sort(families);
    families.erase(std::ranges::unique(families).begin(), families.end());
    return families;
}

gpu::ImageRange range_of(const Part& part) {
    return {part.first_mip, part.mips, part.first_layer, part.layers};
}

Resources::Resources(gpu::Device& device, const Graph& graph, const Plan& plan, bool one_family)
    : device_(device), graph_(graph), plan_(plan) {
    const std::vector<ResourceDecl>& declared = declaration().resources;
    resources_.resize(declared.size());
    layouts_.resize(declared.size(), VK_IMAGE_LAYOUT_UNDEFINED);
    for (ResourceId id = 0; id < declared.size(); ++id) {
        resources_[id].bytes = declared[id].buffer.bytes;
    }
    create_heaps();
    buffers_.reserve(plan_.placements.size());
    images_.reserve(plan_.placements.size());
    const std::vector<std::uint32_t> families =
        one_family ? std::vector<std::uint32_t>{} : families_of(plan_);
    for (const Placement& placement : plan_.placements) create(placement, families);
    for (ResourceId id = 0; id < declared.size(); ++id) {
        if (declared[id].history_depth == 0 || declared[id].history_age != 0) continue;
        const auto [first, end] = ages_of(declaration(), id);
        const bool whole = std::all_of(resources_.begin() + first, resources_.begin() + end,
            [](const Resource& resource) { return resource.buffer || resource.image; });
        if (whole) rings_.push_back({first, end - first});
    }
    clear_persistent();
}

void Resources::create_heaps() {
    // At least what a buffer over all of it wants, for poison.
    std::vector<std::uint64_t> alignments(plan_.heaps.size(), 256);
    std::vector<const char*> names(plan_.heaps.size(), "transient resources");
    for (const Placement& placement : plan_.placements) {
        const ResourceDecl& resource = declaration().resources[placement.resource];
        alignments[placement.heap] =
            std::max(alignments[placement.heap], resource.memory.alignment);
        if (!plan_.heaps[placement.heap].shared) names[placement.heap] = resource.name.c_str();
    }
    try {
        for (std::size_t i = 0; i < plan_.heaps.size(); ++i) {
            heaps_.push_back(device_.allocator().allocate(
                {plan_.heaps[i].bytes, alignments[i], plan_.heaps[i].type_bits},
                gpu::MemoryUse::device, names[i]));
        }
    } catch (const gpu::DeviceLost&) {
        throw;
    } catch (const Error& error) { // whose text tells what the device holds
        throw Error(error.kind(), error.what() + needs_text(declaration(), plan_));
    }
}

void Resources::create(const Placement& placement, const std::vector<std::uint32_t>& families) {
    const ResourceId id = placement.resource;
    const gpu::Memory& heap = heaps_[placement.heap];
    if (declaration().resources[id].kind == ResourceKind::buffer) {
        resources_[id].buffer = &buffers_.emplace_back(
            device_, buffer_info(declaration(), plan_, id, families), heap, placement.offset);
    } else {
        resources_[id].image = &images_.emplace_back(
            device_, image_info(declaration(), plan_, id, families), heap, placement.offset);
    }
}

/// Between the final state, or nothing at all, and a copy.
Barrier Resources::state_barrier(
    ResourceId id, bool into_copy, bool from_nothing, Access copy) const {
    const AccessState state = from_nothing ? AccessState{} : plan_.final_states[id];
    const AccessState copying = state_of(copy, Stage::fixed);
    const AccessState& src = into_copy ? state : copying;
    const AccessState& dst = into_copy ? copying : state;
    return {.resource = id,
        .src_stages = src.stages,
        .dst_stages = dst.stages,
        .src_access = src.access,
        .dst_access = dst.access,
        .old_layout = src.layout,
        .new_layout = dst.layout};
}

void Resources::clear_persistent() {
    std::vector<ResourceId> fresh;
    for (const Placement& placement : plan_.placements) {
        const ResourceDecl& resource = declaration().resources[placement.resource];
        if (resource.lifetime == Lifetime::persistent) fresh.push_back(placement.resource);
    }
    if (fresh.empty()) return;
    for (const ResourceId id : fresh) layouts_[id] = plan_.final_states[id].layout;
    device_.run("clearing persistent resources", [&](VkCommandBuffer commands) {
        BarrierBatch before, after;
        for (const ResourceId id : fresh) {
            before.add(state_barrier(id, true, true, Access::transfer_write), resources_[id]);
            after.add(state_barrier(id, false, false, Access::transfer_write), resources_[id]);
        }
        before.record(commands);
        for (const ResourceId id : fresh) record_zero(commands, resources_[id]);
        after.record(commands);
    });
}

void Resources::keep_content(const Resources& old) {
    std::map<std::string_view, ResourceId> names;
    for (ResourceId id = 0; id < old.resources_.size(); ++id) {
        names.emplace(old.declaration().resources[id].name, id);
    }
    std::vector<std::pair<ResourceId, ResourceId>> pairs; ///< old and new
    for (const Placement& placement : plan_.placements) {
        const ResourceDecl& resource = declaration().resources[placement.resource];
        const auto found = names.find(resource.name);
        if (resource.lifetime != Lifetime::persistent || found == names.end()) continue;
        const Resource& source = old.resources_[found->second];
        if (!source.buffer && !source.image) continue; // culled there
        if (same_description(resource, old.declaration().resources[found->second])) {
            pairs.emplace_back(found->second, placement.resource);
        }
    }
    if (pairs.empty()) return;
    device_.run("keeping persistent resources", [&](VkCommandBuffer commands) {
        BarrierBatch before, after;
        for (const auto& [from, to] : pairs) {
            before.add(
                old.state_barrier(from, true, false, Access::transfer_read), old.resources_[from]);
            before.add(state_barrier(to, true, false, Access::transfer_write), resources_[to]);
            after.add(state_barrier(to, false, false, Access::transfer_write), resources_[to]);
        }
        record_full_barrier(commands);
        before.record(commands);
        for (const auto& [from, to] : pairs) {
            record_copy(commands, old.resources_[from], resources_[to]);
        }
        after.record(commands);
    });
}

std::vector<ResourceId> Resources::persistent() const {
    std::vector<ResourceId> ids;
    for (const Placement& placement : plan_.placements) {
        const ResourceDecl& resource = declaration().resources[placement.resource];
        if (resource.lifetime == Lifetime::persistent) ids.push_back(placement.resource);
    }
    std::ranges::sort(ids);
    return ids;
}

std::vector<std::byte> Resources::content(ResourceId id) const {
    const gpu::Buffer staging(device_, {.bytes = content_bytes(resources_[id]),
                                           .usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                                           .name = "saved content",
                                           .memory = gpu::MemoryUse::readback});
    copy_content(id, staging, Access::transfer_read);
    return {staging.mapped().begin(), staging.mapped().end()};
}

void Resources::set_content(ResourceId id, std::span<const std::byte> bytes) {
    const gpu::Buffer staging(device_, {.bytes = content_bytes(resources_[id]),
                                           .usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT,
                                           .name = "saved content",
                                           .memory = gpu::MemoryUse::upload});
    if (bytes.size() != staging.bytes()) {
        fail_graph(declaration(), "content-mismatch", "{} holds {} bytes, but {} were saved",
            describe(declaration().resources[id]), staging.bytes(), bytes.size());
    }
    std::ranges::copy(bytes, staging.mapped().begin());
    copy_content(id, staging, Access::transfer_write);
}

/// Between a resource in its final state and all of a buffer.
void Resources::copy_content(ResourceId id, const gpu::Buffer& staging, Access access) const {
    const Resource& resource = resources_[id];
    const bool read = access == Access::transfer_read;
    device_.run("saved content", [&](VkCommandBuffer commands) {
        BarrierBatch before, after;
        before.add(state_barrier(id, true, false, access), resource);
        after.add(state_barrier(id, false, false, access), resource);
        record_full_barrier(commands);
        before.record(commands);
        if (resource.buffer) {
            const VkBufferCopy region{0, 0, staging.bytes()};
            const VkBuffer own = resource.buffer->handle(), other = staging.handle();
            vkCmdCopyBuffer(commands, read ? own : other, read ? other : own, 1, &region);
        } else {
            std::uint64_t bytes = 0;
            const std::vector<VkBufferImageCopy> regions = tight_regions(*resource.image, bytes);
            const auto count = static_cast<std::uint32_t>(regions.size());
            if (read) {
                vkCmdCopyImageToBuffer(commands, resource.image->handle(),
                    VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, staging.handle(), count, regions.data());
            } else {
                vkCmdCopyBufferToImage(commands, staging.handle(), resource.image->handle(),
                    VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, count, regions.data());
            }
        }
        after.record(commands);
        record_full_barrier(commands);
    });
}

void Resources::rotate(int by) {
    for (const Ring& ring : rings_) {
        const auto first = resources_.begin() + ring.first;
        const auto end = first + ring.count;
        std::rotate(first, by > 0 ? end - 1 : first + 1, end);
    }
}

void Resources::finish() {
    for (ResourceId id = 0; id < layouts_.size(); ++id) {
        if (!plan_.resources[id].culled) layouts_[id] = plan_.final_states[id].layout;
    }
}

const ResourceDecl& Resources::external(ResourceId id, ResourceKind kind) const {
    check(id < resources_.size() && declaration().resources[id].kind == kind,
        "bind() of a handle that is not of this graph");
    const ResourceDecl& resource = declaration().resources[id];
    if (resource.lifetime != Lifetime::external) {
        fail_graph(declaration(), "not-imported", "{} is not imported, so nothing can be bound",
            describe(resource));
    }
    return resource;
}

void Resources::expect_usage(ResourceId id, std::uint32_t found, const std::string& name) const {
    const std::uint32_t missing = plan_.usages[id] & ~found;
    if (missing == 0) return;
    fail_graph(declaration(), "missing-usage",
        "'{}' cannot stand for {}: it lacks usage bits {:#x} (has {:#x}); create it with them",
        name, describe(declaration().resources[id]), missing, found);
}

void Resources::bind(ResourceId id, const gpu::Buffer& buffer) {
    const ResourceDecl& resource = external(id, ResourceKind::buffer);
    if (buffer.bytes() < resource.buffer.bytes) {
        fail_graph(declaration(), "import-mismatch",
            "buffer '{}' with {} bytes cannot stand for {} with {}", buffer.name(), buffer.bytes(),
            describe(resource), resource.buffer.bytes);
    }
    expect_usage(id, buffer.usage(), buffer.name());
    resources_[id].buffer = &buffer;
}

void Resources::bind(ResourceId id, const gpu::Image& image) {
    const ResourceDecl& resource = external(id, ResourceKind::image);
    const gpu::ImageInfo& found = image.info();
    const ImageDesc& wanted = resource.image;
    if (found.format != wanted.format || found.width != wanted.width ||
        found.height != wanted.height || found.depth != wanted.depth ||
        found.layers != wanted.layers || found.mips != wanted.mips) {
        fail_graph(declaration(), "import-mismatch",
            "image '{}' ({}, {} x {} x {}, {} layers, {} mips) cannot stand for {} ({}, "
            "{} x {} x {}, {} layers, {} mips)",
            image.name(), gpu::name_of(found.format), found.width, found.height, found.depth,
            found.layers, found.mips, describe(resource), gpu::name_of(wanted.format), wanted.width,
            wanted.height, wanted.depth, wanted.layers, wanted.mips);
    }
    expect_usage(id, found.usage, image.name());
    resources_[id].image = &image;
    layouts_[id] = resource.entry.layout;
}

void Resources::expect_bound() const {
    for (ResourceId id = 0; id < resources_.size(); ++id) {
        const ResourceDecl& resource = declaration().resources[id];
        if (resource.lifetime != Lifetime::external || plan_.resources[id].culled) continue;
        if (!resources_[id].buffer && !resources_[id].image) {
            fail_graph(declaration(), "unbound-import",
                "nothing is bound to {}; call bind() before executing", describe(resource));
        }
        const VkImageLayout entry = resource.entry.layout;
        if (resources_[id].image && entry != VK_IMAGE_LAYOUT_UNDEFINED && layouts_[id] != entry) {
            fail_graph(declaration(), "entry-layout",
                "{} enters in layout {} but was left in {}; import it with an exit state, or "
                "bind() it again once it is back",
                describe(resource), static_cast<int>(entry), static_cast<int>(layouts_[id]));
        }
    }
}

void Resources::enable_poison() {
    poisons_.resize(heaps_.size());
    for (const Placement& placement : plan_.placements) {
        const ResourceDecl& resource = declaration().resources[placement.resource];
        std::optional<gpu::Buffer>& poison = poisons_[placement.heap];
        if (resource.lifetime != Lifetime::transient || poison) continue;
        const gpu::Memory& heap = heaps_[placement.heap];
        const gpu::BufferInfo info{.bytes = plan_.heaps[placement.heap].bytes / 4 * 4,
            .usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT,
            .name = "poison"};
        const VkMemoryRequirements need = gpu::memory_requirements(device_, info);
        if (!(need.memoryTypeBits >> heap.type() & 1) || heap.offset() % need.alignment != 0) {
            fail_device("'{}' cannot poison memory of type {}, which no buffer may use; switch "
                        "poison off",
                device_.info().name, heap.type());
        }
        poison.emplace(device_, info, heap, 0);
    }
}

void Resources::record_poison(VkCommandBuffer commands, std::uint32_t step) const {
    bool any = false;
    for (const Placement& placement : plan_.placements) {
        const ResourceDecl& resource = declaration().resources[placement.resource];
        if (placement.first_step != step || resource.lifetime != Lifetime::transient) continue;
        if (!any) record_full_barrier(commands);
        any = true;
        const gpu::Buffer& poison = *poisons_[placement.heap];
        const std::uint64_t offset = (placement.offset + 3) / 4 * 4;
        const std::uint64_t end = std::min(placement.offset + placement.bytes, poison.bytes());
        if (end / 4 * 4 > offset) {
            vkCmdFillBuffer(commands, poison.handle(), offset, end / 4 * 4 - offset, kPoison);
        }
    }
    if (any) record_full_barrier(commands);
}

} // namespace ockham
