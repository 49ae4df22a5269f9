// SPDX-License-Identifier: Apache-2.0
#include "framework/gpu/pipeline_layout.hpp"

#include "framework/core/error.hpp"
#include "framework/gpu/device.hpp"

#include <algorithm>

namespace ockham::gpu {

PipelineLayout layout_of(std::span<const Reflection* const> shaders) {
    PipelineLayout layout;
    for (const Reflection* const shader : shaders) {
        if (shader->push_bytes > 0) {
            layout.push_bytes = std::max(layout.push_bytes, shader->push_bytes);
            layout.push_stages |= shader->stage;
        }
        for (const ShaderBinding& binding : shader->bindings) {
            const auto slot = std::ranges::find_if(layout.slots, [&](const auto& other) {
                return other.binding.set == binding.set && other.binding.binding == binding.binding;
            });
            if (slot == layout.slots.end()) {
                layout.slots.push_back({binding, shader->name, VkShaderStageFlags(shader->stage)});
                continue;
            }
            if (slot->binding.name != binding.name || slot->binding.type != binding.type) {
                fail_input(
                    "shaders '{}' and '{}' disagree about set {}, binding {}: '{}' and '{}'; "
                    "give one of them another number",
                    slot->shader, shader->name, binding.set, binding.binding, slot->binding.name,
                    binding.name);
            }
            slot->binding.reads |= binding.reads;
            slot->binding.writes |= binding.writes;
            slot->stages |= shader->stage;
        }
    }
    std::ranges::sort(layout.slots, {}, [](const PipelineLayout::Slot& slot) {
        return std::pair(slot.binding.set, slot.binding.binding);
    });
    return layout;
}

void expect_fits(
    const PipelineLayout& reloaded, const PipelineLayout& embedded, std::string_view shaders) {
    for (const PipelineLayout::Slot& slot : reloaded.slots) {
        const ShaderBinding& binding = slot.binding;
        const auto same = std::ranges::find(embedded.slots, binding.name,
            [](const PipelineLayout::Slot& other) { return other.binding.name; });
        if (same == embedded.slots.end()) {
            fail_input("shader '{}' uses binding '{}', which the one built in does not, so passes "
                       "may not declare it; rebuild the program",
                slot.shader, binding.name);
        }
        const ShaderBinding& known = same->binding;
        if (binding.type != known.type || binding.reads != known.reads ||
            binding.writes != known.writes || binding.view_type != known.view_type ||
            binding.format != known.format || slot.stages != same->stages) {
            fail_input("shader '{}' uses binding '{}' in another way (kind, format, direction or "
                       "stages) than the one built in, for which passes are declared; rebuild the "
                       "program",
                slot.shader, binding.name);
        }
    }
    if (reloaded.push_bytes != embedded.push_bytes) {
        fail_input("'{}' takes {} bytes of push constants, but {} as built in; rebuild the program",
            shaders, reloaded.push_bytes, embedded.push_bytes);
    }
}

void create_handles(const Device& device, PipelineLayout& layout, std::string_view shaders) {
    const auto in_set_0 =
        std::ranges::count_if(layout.slots, [](const auto& slot) { return slot.binding.set == 0; });
    layout.pushes_set_0 = device.pushes_descriptors() && in_set_0 > 0 &&
                          in_set_0 <= static_cast<std::ptrdiff_t>(device.limits().push_descriptors);

    const std::uint32_t set_count =
        layout.slots.empty() ? 0 : layout.slots.back().binding.set + 1; // sorted by set
    for (std::uint32_t set = 0; set < set_count; ++set) {
        std::vector<VkDescriptorSetLayoutBinding> rows;
        for (const PipelineLayout::Slot& slot : layout.slots) {
            if (slot.binding.set != set) continue;
            rows.push_back({.binding = slot.binding.binding,
                .descriptorType = slot.binding.type,
                .descriptorCount = 1,
                .stageFlags = slot.stages});
        }
        const bool pushed = set == 0 && layout.pushes_set_0;
        const VkDescriptorSetLayoutCreateInfo info{
            .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
            .flags =
                pushed
                    ? VkDescriptorSetLayoutCreateFlags{VK_DESCRIPTOR_SET_LAYOUT_CREATE_PUSH_DESCRIPTOR_BIT_KHR}
                    : 0,
            .bindingCount = static_cast<std::uint32_t>(rows.size()),
            .pBindings = rows.data()};
        VkDescriptorSetLayout handle = VK_NULL_HANDLE;
        expect(vkCreateDescriptorSetLayout(device.handle(), &info, nullptr, &handle),
            fmt::format("creating the descriptor layout of '{}'", shaders));
        layout.sets.push_back(handle);
    }
    const VkPushConstantRange push{
        .stageFlags = layout.push_stages, .offset = 0, .size = (layout.push_bytes + 3) / 4 * 4};
    const VkPipelineLayoutCreateInfo info{.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
        .setLayoutCount = static_cast<std::uint32_t>(layout.sets.size()),
        .pSetLayouts = layout.sets.data(),
        .pushConstantRangeCount = layout.push_bytes > 0 ? 1u : 0u,
        .pPushConstantRanges = &push};
    expect(vkCreatePipelineLayout(device.handle(), &info, nullptr, &layout.handle),
        fmt::format("creating the pipeline layout of '{}'", shaders));
}

} // namespace ockham::gpu
