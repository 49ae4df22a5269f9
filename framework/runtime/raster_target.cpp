// SPDX-License-Identifier: Apache-2.0
#include "framework/runtime/raster_target.hpp"

#include "framework/gpu/device.hpp"

#include <fmt/format.h>

namespace ockham {

namespace {

/// Indices of the attachments among the declaration's uses: colours in order, then depth.
std::vector<std::uint32_t> attachments_of(const Declaration& declaration, PassId pass) {
    std::vector<std::uint32_t> uses;
    const PassDecl& decl = declaration.passes[pass];
    for (const Access access : {Access::color_attachment, Access::depth_attachment}) {
        for (std::uint32_t i = decl.first_use; i < decl.first_use + decl.use_count; ++i) {
            if (declaration.uses[i].access == access) uses.push_back(i);
        }
    }
    return uses;
}

VkAttachmentLoadOp load_op(LoadOp load) {
    switch (load) {
    case LoadOp::clear:
        return VK_ATTACHMENT_LOAD_OP_CLEAR;
    case LoadOp::load:
        return VK_ATTACHMENT_LOAD_OP_LOAD;
    case LoadOp::discard:
        break;
    }
    return VK_ATTACHMENT_LOAD_OP_DONT_CARE;
}

} // namespace

RasterTargets::RasterTargets(
    gpu::Device& device, const Declaration& declaration, const Resources& resources)
    : device_(device), declaration_(declaration), resources_(resources),
      targets_(declaration.passes.size()) {}

RasterTargets::~RasterTargets() {
    for (const auto& of_pass : targets_) {
        for (const auto& [views, target] : of_pass) {
            vkDestroyFramebuffer(device_.handle(), target.framebuffer, nullptr);
        }
    }
}

const RasterTarget& RasterTargets::of(PassId pass) {
    const std::vector<std::uint32_t> uses = attachments_of(declaration_, pass);
    Views views;
    for (const std::uint32_t i : uses) {
        const Use& use = declaration_.uses[i];
        gpu::ImageRange range = range_of(part_of(declaration_, use));
        range.mips = range.layers = 1;
        views.push_back(resources_[use.resource].image->view(VK_IMAGE_VIEW_TYPE_2D, range));
    }
    const auto found = targets_[pass].find(views);
    if (found != targets_[pass].end()) return found->second;
    return targets_[pass].emplace(views, create(pass, uses, views)).first->second;
}

RasterTarget RasterTargets::create(
    PassId pass, const std::vector<std::uint32_t>& uses, const Views& views) {
    RasterTarget target;
    target.uses = uses;
    for (const std::uint32_t i : uses) {
        const Use& use = declaration_.uses[i];
        const gpu::ImageInfo& info = resources_[use.resource].image->info();
        const VkExtent3D extent = gpu::mip_extent(info, part_of(declaration_, use).first_mip);
        target.extent = {extent.width, extent.height}; // of all, as compile() has checked
        target.attachments.push_back(
            {info.format, load_op(use.load), use.access == Access::depth_attachment});
    }
    const std::string& name = declaration_.passes[pass].name;
    target.render_pass = device_.pipelines().render_pass(target.attachments);
    const VkFramebufferCreateInfo info{.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO,
        .renderPass = target.render_pass,
        .attachmentCount = static_cast<std::uint32_t>(views.size()),
        .pAttachments = views.data(),
        .width = target.extent.width,
        .height = target.extent.height,
        .layers = 1};
    gpu::expect(vkCreateFramebuffer(device_.handle(), &info, nullptr, &target.framebuffer),
        fmt::format("creating the framebuffer of pass '{}'", name));
    gpu::set_name(device_, VK_OBJECT_TYPE_FRAMEBUFFER, target.framebuffer, name);
    return target;
}

std::vector<VkFramebuffer> RasterTargets::forget(ResourceId id) {
    std::vector<VkFramebuffer> forgotten;
    for (PassId pass = 0; pass < targets_.size(); ++pass) {
        for (const std::uint32_t i : attachments_of(declaration_, pass)) {
            if (declaration_.uses[i].resource != id) continue;
            for (const auto& [views, target] : targets_[pass]) {
                forgotten.push_back(target.framebuffer);
            }
            targets_[pass].clear();
        }
    }
    return forgotten;
}

void begin_raster(
    VkCommandBuffer commands, const Declaration& declaration, const RasterTarget& target) {
    std::vector<VkClearValue> clears;
    for (std::size_t i = 0; i < target.uses.size(); ++i) {
        clears.push_back(gpu::clear_value(
            target.attachments[i].format, declaration.clears[target.uses[i]]));
    }
    const VkRenderPassBeginInfo begin{.sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO,
        .renderPass = target.render_pass,
        .framebuffer = target.framebuffer,
        .renderArea = {.extent = target.extent},
        .clearValueCount = static_cast<std::uint32_t>(clears.size()),
        .pClearValues = clears.data()};
    vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
    const VkViewport viewport{0, 0, static_cast<float>(target.extent.width),
        static_cast<float>(target.extent.height), 0, 1};
    const VkRect2D scissor{.extent = target.extent};
    vkCmdSetViewport(commands, 0, 1, &viewport);
    vkCmdSetScissor(commands, 0, 1, &scissor);
    vkCmdSetCullMode(commands, VK_CULL_MODE_NONE);
    vkCmdSetFrontFace(commands, VK_FRONT_FACE_COUNTER_CLOCKWISE);
    vkCmdSetStencilReference(commands, VK_STENCIL_FACE_FRONT_AND_BACK, 0);
}

} // namespace ockham
