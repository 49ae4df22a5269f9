// SPDX-License-Identifier: Apache-2.0
#include "framework/core/memory_table.hpp"
#include "framework/graph/describe.hpp"
#include "framework/graph/explain/explain.hpp"
#include "framework/graph/explain/timeline.hpp"
#include "framework/graph/explain/words.hpp"

#include <algorithm>
#include <array>

namespace ockham {

namespace {

const Placement* placement_of(const Plan& plan, ResourceId id) {
    const auto found = std::find_if(plan.placements.begin(), plan.placements.end(),
        [&](const Placement& placement) { return placement.resource == id; });
    return found == plan.placements.end() ? nullptr : &*found;
}

/// Why a resource shares memory with no other at all; empty where it may.
std::string loner(const Declaration& declaration, const Plan& plan, ResourceId id) {
    const ResourceDecl& resource = declaration.resources[id];
    if (plan.resources[id].culled)
        return fmt::format("'{}' is culled and has no memory", resource.name);
    if (resource.lifetime == Lifetime::external)
        return fmt::format("'{}' lives in the caller's memory", resource.name);
    if (resource.history_depth)
        return fmt::format(
            "'{}' is part of a history, which the next executions still read", resource.name);
    if (resource.lifetime == Lifetime::persistent)
        return fmt::format("'{}' is persistent: the next execution finds it", resource.name);
    if (resource.exported)
        return fmt::format(
            "'{}' is exported: its content is wanted after the execution", resource.name);
    return {};
}

std::string steps_text(
    const Declaration& declaration, const Plan& plan, std::uint32_t first, std::uint32_t last) {
    const std::string& from = declaration.passes[plan.steps[first].pass].name;
    if (first == last) return fmt::format("in step {} ('{}')", first, from);
    return fmt::format("in steps {} to {} ('{}' to '{}')", first, last, from,
        declaration.passes[plan.steps[last].pass].name);
}

/// The queue of every step that uses the resource, as a set of bits.
std::uint64_t queues_of(const Declaration& declaration, const Plan& plan, ResourceId id) {
    const std::vector<std::uint32_t> queues = queue_of_steps(plan);
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < plan.steps.size(); ++i)
        for (const Use& use : declaration.uses_of(plan.steps[i].pass))
            if (use.resource == id) bits |= std::uint64_t{1} << (queues[i] % 64);
    return bits;
}

} // namespace

std::string why_not_shared(
    const Declaration& declaration, const Plan& plan, ResourceId a, ResourceId b) {
    const std::string& name_a = declaration.resources[a].name;
    const std::string& name_b = declaration.resources[b].name;
    if (a == b) return fmt::format("'{}' is one resource", name_a);
    for (const ResourceId id : {a, b})
        if (std::string why = loner(declaration, plan, id); !why.empty()) return why;
    const Placement* const first = placement_of(plan, a);
    const Placement* const second = placement_of(plan, b);
    if (!first || !second) return fmt::format("'{}' has no memory", first ? name_b : name_a);
    if (first->heap != second->heap)
        return fmt::format("'{}' and '{}' need different types of memory ({:#x} and {:#x})", name_a,
            name_b, plan.heaps[first->heap].type_bits, plan.heaps[second->heap].type_bits);
    const std::uint32_t from = std::max(first->first_step, second->first_step);
    const std::uint32_t to = std::min(first->last_step, second->last_step);
    if (from <= to)
        return fmt::format(
            "'{}' and '{}' both live {}", name_a, name_b, steps_text(declaration, plan, from, to));
    const std::uint64_t begin = std::max(first->offset, second->offset);
    const std::uint64_t end =
        std::min(first->offset + first->bytes, second->offset + second->bytes);
    if (begin < end)
        return fmt::format("'{}' and '{}' share {} at offset {} of heap {}", name_a, name_b,
            size_text(end - begin), begin, first->heap);
    if (queues_of(declaration, plan, a) != queues_of(declaration, plan, b))
        return fmt::format("'{}' and '{}' are used on different queues, which may run at the same "
                           "time",
            name_a, name_b);
    return fmt::format("'{}' and '{}' never live together, but lie apart: sharing was switched off "
                       "or would save nothing",
        name_a, name_b);
}

std::string needs_text(const Declaration& declaration, const Plan& plan) {
    constexpr double mib = 1 << 20;
    std::vector<MemoryRow> rows;
    for (const Placement& placement : plan.placements)
        rows.push_back({placement.bytes, declaration.resources[placement.resource].name,
            reason_of_resource(declaration, plan, placement.resource)});
    return fmt::format("\ngraph '{}' needs {:.3f} MiB for {} resources, in this order of passes at "
                       "least {:.3f} MiB; the largest:{}",
        declaration.name, static_cast<double>(plan.bytes_peak) / mib, plan.placements.size(),
        static_cast<double>(plan.bytes_lower_bound) / mib, memory_table(std::move(rows)));
}

Peak memory_peak(const Plan& plan) {
    std::vector<std::int64_t> change(plan.steps.size() + 1, 0);
    const auto lives = [&](const Placement& placement, std::uint32_t step) {
        return !plan.heaps[placement.heap].shared ||
               (placement.first_step <= step && step <= placement.last_step);
    };
    for (const Placement& placement : plan.placements) {
        const bool shared = plan.heaps[placement.heap].shared;
        const auto bytes = static_cast<std::int64_t>(placement.bytes);
        change[shared ? placement.first_step : 0] += bytes;
        if (shared) change[placement.last_step + 1] -= bytes;
    }
    Peak peak;
    std::int64_t bytes = 0;
    for (std::uint32_t step = 0; step < plan.steps.size(); ++step) {
        bytes += change[step];
        if (static_cast<std::uint64_t>(bytes) <= peak.bytes) continue;
        peak.bytes = static_cast<std::uint64_t>(bytes);
        peak.step = step;
    }
    std::vector<const Placement*> live;
    for (const Placement& placement : plan.placements)
        if (lives(placement, peak.step)) live.push_back(&placement);
    std::stable_sort(live.begin(), live.end(),
        [](const Placement* x, const Placement* y) { return x->bytes > y->bytes; });
    for (const Placement* placement : live) peak.live.push_back(placement->resource);
    return peak;
}

double memory_ratio(const Plan& plan) {
    return plan.bytes_lower_bound == 0
               ? 1.0
               : static_cast<double>(plan.bytes_peak) / static_cast<double>(plan.bytes_lower_bound);
}

} // namespace ockham
