// SPDX-License-Identifier: Apache-2.0
#include "framework/runtime/planning.hpp"

#include "framework/gpu/device.hpp"
#include "framework/runtime/resources.hpp"

namespace ockham {

Capabilities capabilities_of(const gpu::Device& device) {
    const gpu::Limits& limits = device.limits();
    Capabilities capabilities{.families = {},
        .buffer_image_granularity = limits.buffer_image_granularity,
        .max_buffer_bytes = limits.buffer_bytes,
        .max_image_extent = limits.image_extent,
        .max_image_layers = limits.image_layers,
        .max_attachment_extent = limits.attachment_extent};
    for (const gpu::FamilyInfo& family : device.families()) {
        const bool used = family.queues > 0;
        capabilities.families.push_back({.graphics = used && family.graphics,
            .compute = used && family.compute,
            .transfer = used && family.transfer,
            .queues = family.queues});
    }
    return capabilities;
}

Plan make_plan(const gpu::Device& device, Graph& graph, const Policy& policy) {
    return make_plan(device, graph, policy, capabilities_of(device));
}

Plan make_plan(const gpu::Device& device, Graph& graph, const Policy& policy,
    const Capabilities& capabilities) {
    Declaration& declaration = graph.declaration();
    // Memory needs follow from usage bits, and these from what is culled: plan once without needs.
    Policy without_budget = policy;
    without_budget.memory_budget_bytes = 0;
    const Plan draft = compile(declaration, capabilities, without_budget);
    for (const Placement& placement : draft.placements) {
        ResourceDecl& resource = declaration.resources[placement.resource];
        const VkMemoryRequirements need =
            resource.kind == ResourceKind::buffer
                ? gpu::memory_requirements(
                      device, buffer_info(declaration, draft, placement.resource, {}))
                : gpu::memory_requirements(
                      device, image_info(declaration, draft, placement.resource, {}));
        resource.memory = {need.size, need.alignment, need.memoryTypeBits};
    }
    return compile(declaration, capabilities, policy);
}

} // namespace ockham
