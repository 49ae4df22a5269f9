// SPDX-License-Identifier: Apache-2.0
#include "framework/runtime/planning.hpp"

#include "framework/gpu/device.hpp"
#include "framework/graph/plan_cache.hpp"
#include "framework/graph/shuffle.hpp"
#include "framework/runtime/resources.hpp"

#include <cstdlib>

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

namespace {

/// Keeps in the declaration what the resources that the plan places take on the device.
void ask_memory(const gpu::Device& device, Declaration& declaration, const Plan& plan) {
    for (const Placement& placement : plan.placements) {
        const ResourceId id = placement.resource;
        const VkMemoryRequirements need =
            declaration.resources[id].kind == ResourceKind::buffer
                ? gpu::memory_requirements(device, buffer_info(declaration, plan, id, {}))
                : gpu::memory_requirements(device, image_info(declaration, plan, id, {}));
        declaration.resources[id].memory = {need.size, need.alignment, need.memoryTypeBits};
    }
}

/// With OCKHAM_SHUFFLE=N as of passes declared in a random order, the same for the same N.
Plan compile_as_asked(
    const Declaration& declaration, const Capabilities& capabilities, const Policy& policy) {
    const char* const seed = std::getenv("OCKHAM_SHUFFLE");
    return seed ? compile_shuffled(
                      declaration, capabilities, policy, std::strtoull(seed, nullptr, 10))
                : compile(declaration, capabilities, policy);
}

} // namespace

Plan make_plan(const gpu::Device& device, Graph& graph, const Policy& policy,
    const Capabilities& capabilities, PlanCache* cache) {
    Declaration& declaration = graph.declaration();
    const auto plan_anew = [&] {
        // Memory needs follow from usage bits, and these from what is culled: plan once without.
        Policy without_budget = policy;
        without_budget.memory_budget_bytes = 0;
        ask_memory(
            device, declaration, compile_as_asked(declaration, capabilities, without_budget));
        return compile_as_asked(declaration, capabilities, policy);
    };
    if (!cache) return plan_anew();
    Plan plan = *cache->get(graph, capabilities, policy, plan_anew);
    ask_memory(device, declaration, plan);
    return plan;
}

} // namespace ockham
