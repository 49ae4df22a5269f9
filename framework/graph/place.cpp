// SPDX-License-Identifier: Apache-2.0
#include "framework/core/error.hpp"
#include "framework/graph/explain.hpp"
#include "framework/graph/pack.hpp"
#include "framework/graph/phases.hpp"

#include <algorithm>

namespace ockham {

namespace {

MemoryNeed need_of(const ResourceDecl& resource) {
    return resource.memory.bytes ? resource.memory : estimate_memory(resource);
}

bool is_shared(const ResourceDecl& resource) {
    return resource.lifetime == Lifetime::transient && !resource.exported;
}

/// One placement per resource that needs memory, by first use, without heap and offset.
std::vector<Placement> find_intervals(const Declaration& declaration, const Plan& plan) {
    std::vector<Placement> placements;
    std::vector<std::uint32_t> placement_of(declaration.resources.size(), kNone);
    for (std::uint32_t step = 0; step < plan.steps.size(); ++step) {
        const PassDecl& pass = declaration.passes[plan.steps[step].pass];
        for (std::uint32_t i = 0; i < pass.use_count; ++i) {
            const ResourceId id = declaration.uses[pass.first_use + i].resource;
            const ResourceDecl& resource = declaration.resources[id];
            if (resource.lifetime == Lifetime::external) continue;
            if (placement_of[id] == kNone) {
                placement_of[id] = static_cast<std::uint32_t>(placements.size());
                placements.push_back({id, 0, 0, need_of(resource).bytes, step, step});
            }
            placements[placement_of[id]].last_step = step;
        }
    }
    return placements;
}

/// Packs the shared resources of one memory type into one heap; `members` index placements.
void pack_heap(const Declaration& declaration, const Capabilities& capabilities,
    const Policy& policy, std::uint32_t heap, const std::vector<std::uint32_t>& members,
    Plan& plan) {
    const std::uint64_t granularity =
        std::max<std::uint64_t>(capabilities.buffer_image_granularity, 1);
    const auto end = static_cast<std::uint32_t>(plan.steps.size() - 1);
    std::vector<LiveRange> ranges;
    ranges.reserve(members.size());
    for (const std::uint32_t member : members) {
        const Placement& placement = plan.placements[member];
        const MemoryNeed need = need_of(declaration.resources[placement.resource]);
        // Whole pages of the granularity each, so that no buffer shares one with an image.
        const std::uint64_t bytes = (need.bytes + granularity - 1) / granularity * granularity;
        ranges.push_back({bytes, std::max(need.alignment, granularity),
            policy.alias_memory ? placement.first_step : 0,
            policy.alias_memory ? placement.last_step : end});
    }
    const Packing packing = pack(ranges);
    for (std::size_t i = 0; i < members.size(); ++i) {
        plan.placements[members[i]].heap = heap;
        plan.placements[members[i]].offset = packing.offsets[i];
    }
    plan.heaps[heap].bytes = packing.bytes;
}

std::uint64_t lower_bound(const Declaration& declaration, const Plan& plan) {
    std::vector<LiveRange> ranges;
    ranges.reserve(plan.placements.size());
    const auto end = static_cast<std::uint32_t>(plan.steps.size());
    for (const Placement& p : plan.placements) {
        const bool shared = is_shared(declaration.resources[p.resource]);
        ranges.push_back({p.bytes, 1, shared ? p.first_step : 0, shared ? p.last_step : end - 1});
    }
    return live_bytes(ranges);
}

[[noreturn]] void fail_budget(
    const Declaration& declaration, const Policy& policy, const Plan& plan) {
    constexpr double mib = 1 << 20;
    constexpr std::size_t rows = 10;
    std::vector<Placement> largest = plan.placements;
    std::stable_sort(largest.begin(), largest.end(),
        [](const Placement& a, const Placement& b) { return a.bytes > b.bytes; });
    std::string table;
    for (std::size_t i = 0; i < std::min(rows, largest.size()); ++i)
        table +=
            fmt::format("\n  {:10.3f} MiB  {:<24} {}", static_cast<double>(largest[i].bytes) / mib,
                declaration.resources[largest[i].resource].name,
                reason_of_resource(declaration, plan, largest[i].resource));
    fail_device("[over-budget] graph '{}': its {} resources need {:.3f} MiB, the memory budget is "
                "{:.3f} MiB and this order of passes needs at least {:.3f} MiB; shrink, "
                "split or raise it. The largest:{}",
        declaration.name, plan.placements.size(), static_cast<double>(plan.bytes_peak) / mib,
        static_cast<double>(policy.memory_budget_bytes) / mib,
        static_cast<double>(plan.bytes_lower_bound) / mib, table);
}

} // namespace

void place(const Declaration& declaration, const Capabilities& capabilities, const Policy& policy,
    Plan& plan) {
    plan.placements = find_intervals(declaration, plan);

    std::vector<std::vector<std::uint32_t>> members; // per shared heap
    for (std::uint32_t i = 0; i < plan.placements.size(); ++i) {
        const ResourceDecl& resource = declaration.resources[plan.placements[i].resource];
        if (!is_shared(resource)) continue;
        const std::uint32_t type_bits = need_of(resource).type_bits;
        const auto found = std::find_if(plan.heaps.begin(), plan.heaps.end(),
            [&](const Heap& heap) { return heap.type_bits == type_bits; });
        const auto heap = static_cast<std::size_t>(found - plan.heaps.begin());
        if (found == plan.heaps.end()) {
            plan.heaps.push_back({type_bits, 0, true});
            members.emplace_back();
        }
        members[heap].push_back(i);
    }
    for (std::uint32_t heap = 0; heap < members.size(); ++heap)
        pack_heap(declaration, capabilities, policy, heap, members[heap], plan);

    for (Placement& placement : plan.placements) {
        const ResourceDecl& resource = declaration.resources[placement.resource];
        if (is_shared(resource)) continue;
        placement.heap = static_cast<std::uint32_t>(plan.heaps.size());
        plan.heaps.push_back({need_of(resource).type_bits, placement.bytes, false});
    }

    for (const Heap& heap : plan.heaps) plan.bytes_peak += heap.bytes;
    plan.bytes_lower_bound = lower_bound(declaration, plan);
    if (policy.memory_budget_bytes && plan.bytes_peak > policy.memory_budget_bytes)
        fail_budget(declaration, policy, plan);
}

} // namespace ockham
