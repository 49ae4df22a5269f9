// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/plan_cache.hpp"

#include "framework/core/error.hpp"

#include <algorithm>
#include <bit>

namespace ockham {

PlanCache::PlanCache(std::size_t capacity) : capacity_(capacity) {
    check(capacity >= 1, "a plan cache holds at least one plan");
}

std::size_t PlanCache::size() const {
    const std::lock_guard lock(mutex_);
    return entries_.size();
}

void PlanCache::clear() {
    const std::lock_guard lock(mutex_);
    entries_.clear();
}

Fingerprint PlanCache::key_of(
    const Graph& graph, const Capabilities& capabilities, const Policy& policy) {
    Fingerprint key = graph.fingerprint();
    key.mix(std::uint64_t{capabilities.families.size()});
    for (const QueueFamily& family : capabilities.families)
        key.mix(std::uint64_t{family.queues} << 3 | std::uint64_t{family.graphics} << 2 |
                std::uint64_t{family.compute} << 1 | std::uint64_t{family.transfer});
    key.mix(capabilities.buffer_image_granularity);
    key.mix(capabilities.max_buffer_bytes);
    key.mix(std::uint64_t{capabilities.max_image_extent} << 32 | capabilities.max_image_layers);
    key.mix(std::uint64_t{capabilities.max_attachment_extent});
    key.mix(std::uint64_t{policy.alias_memory} << 9 | std::uint64_t{policy.async_queues} << 8 |
            static_cast<std::uint64_t>(policy.order));
    key.mix(std::bit_cast<std::uint64_t>(policy.batch_memory));
    key.mix(policy.memory_budget_bytes);
    return key;
}

void PlanCache::compare(const Graph& graph, const Plan& kept, const Plan& made) {
    if (kept == made) return;
    abort_check(std::source_location::current(),
        fmt::format("graph '{}': its plan differs from the kept plan of an equal declaration; "
                    "something that decides plans is missing in Graph::fingerprint()",
            graph.name()));
}

std::shared_ptr<const Plan> PlanCache::find(const Fingerprint& key) {
    const std::lock_guard lock(mutex_);
    // Backwards: in a loop of frames it is the last.
    const auto found = std::find_if(
        entries_.rbegin(), entries_.rend(), [&](const Entry& entry) { return entry.key == key; });
    if (found == entries_.rend()) return nullptr;
    std::rotate(entries_.rbegin(), found, found + 1);
    return entries_.back().plan;
}

std::shared_ptr<const Plan> PlanCache::insert(const Fingerprint& key, Plan plan) {
    auto shared = std::make_shared<const Plan>(std::move(plan));
    const std::lock_guard lock(mutex_);
    const auto found = std::find_if(
        entries_.begin(), entries_.end(), [&](const Entry& entry) { return entry.key == key; });
    if (found != entries_.end()) return found->plan;
    if (entries_.size() == capacity_) entries_.erase(entries_.begin());
    entries_.push_back({key, shared});
    return shared;
}

} // namespace ockham
