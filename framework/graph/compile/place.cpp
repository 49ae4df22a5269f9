// SPDX-License-Identifier: Apache-2.0
#include "framework/core/error.hpp"
#include "framework/graph/compile/pack.hpp"
#include "framework/graph/compile/phases.hpp"
#include "framework/graph/explain/explain.hpp"

#include <algorithm>
#include <optional>

namespace ockham {

namespace {

/// One placement per resource that needs memory, by first use, without heap and offset.
std::vector<Placement> find_intervals(const Declaration& declaration, const Plan& plan) {
    std::vector<Placement> placements;
    placements.reserve(plan.resources.size());
    std::vector<std::uint32_t> placement_of(plan.resources.size(), kNone);
    const auto add = [&](ResourceId id, std::uint32_t step) {
        const ResourceDecl& resource = declaration.resources[id];
        if (resource.lifetime == Lifetime::external) return;
        placement_of[id] = static_cast<std::uint32_t>(placements.size());
        placements.push_back({id, 0, 0, memory_need(resource).bytes, step, step});
    };
    for (ResourceId id = 0; id < plan.resources.size(); ++id)
        if (plan.resources[id].cause == Verdict::Cause::ring) add(id, 0);
    for (std::uint32_t step = 0; step < plan.steps.size(); ++step)
        for (const Use& use : declaration.uses_of(plan.steps[step].pass)) {
            if (placement_of[use.resource] == kNone) add(use.resource, step);
            if (placement_of[use.resource] != kNone)
                placements[placement_of[use.resource]].last_step = step;
        }
    return placements;
}

/// What may run at the same time on several queues, by the waits of a plan.
class Concurrency {
public:
    Concurrency(const Declaration& declaration, const Plan& plan)
        : queues_(plan.queues.size()), submissions_(queues_),
          users_(plan.resources.size() * queues_, 0) {
        std::vector<std::vector<std::uint32_t>> over(queues_, std::vector<std::uint32_t>(queues_));
        for (const Submission& submission : plan.submissions) {
            std::vector<std::uint32_t>& mine = over[submission.queue];
            for (std::uint32_t i = 0; i < submission.wait_count; ++i) {
                const Wait& wait = plan.waits[submission.first_wait + i];
                const Known& known = submissions_[wait.queue][wait.value - 1];
                for (std::size_t queue = 0; queue < queues_; ++queue)
                    mine[queue] = std::max(mine[queue], known.over[queue]);
                mine[wait.queue] = std::max(mine[wait.queue], wait.value);
            }
            const std::uint32_t end = submission.first_step + submission.step_count;
            submissions_[submission.queue].push_back({mine, end});
            const auto value = static_cast<std::uint32_t>(submissions_[submission.queue].size());
            for (std::uint32_t step = submission.first_step; step < end; ++step)
                for (const Use& use : declaration.uses_of(plan.steps[step].pass))
                    users_[use.resource * queues_ + submission.queue] = value;
        }
    }

    /// The last step that may run before all users of the placement's resource are over: on each
    /// queue, up to the submission that knows they are. On one queue, order is enough.
    std::uint32_t end(const Placement& placement) const {
        const std::uint32_t* const users = users_.data() + placement.resource * queues_;
        std::uint32_t last = placement.last_step;
        for (std::size_t queue = 0; queue < queues_; ++queue) {
            const auto& all = submissions_[queue];
            const auto knows =
                std::partition_point(all.begin(), all.end(), [&](const Known& known) {
                    for (std::size_t other = 0; other < queues_; ++other)
                        if (other != queue && known.over[other] < users[other]) return true;
                    return false;
                });
            if (knows != all.begin()) last = std::max(last, (knows - 1)->end_step - 1);
        }
        return last;
    }

private:
    /// A submission: what is over when it begins, as a number of submissions of each queue.
    struct Known {
        std::vector<std::uint32_t> over;
        std::uint32_t end_step;
    };
    std::size_t queues_;
    std::vector<std::vector<Known>> submissions_; ///< of each queue
    std::vector<std::uint32_t> users_; ///< per resource and queue: the last submission, from 1
};

/// Packs the shared resources of one memory type into one heap.
void pack_heap(std::uint32_t heap, const std::vector<LiveRange>& ranges,
    const std::vector<std::uint32_t>& members, Plan& plan) {
    const Packing packing = pack(ranges);
    for (std::size_t i = 0; i < members.size(); ++i) {
        plan.placements[members[i]].heap = heap;
        plan.placements[members[i]].offset = packing.offsets[i];
    }
    plan.heaps[heap].bytes = packing.bytes;
}

/// Everything that shares memory, by memory type.
void place_shared(const Declaration& declaration, const Capabilities& capabilities,
    const Policy& policy, Plan& plan) {
    struct Pool {
        std::vector<LiveRange> ranges;
        std::vector<std::uint32_t> members; ///< into Plan::placements
    };
    std::vector<Pool> pools; // one per heap
    std::optional<Concurrency> concurrency;
    if (plan.queues.size() > 1) concurrency.emplace(declaration, plan);
    const std::uint64_t granularity =
        std::max<std::uint64_t>(capabilities.buffer_image_granularity, 1);
    for (std::uint32_t i = 0; i < plan.placements.size(); ++i) {
        const Placement& placement = plan.placements[i];
        const ResourceDecl& resource = declaration.resources[placement.resource];
        if (!shares_memory(resource)) continue;
        const MemoryNeed need = memory_need(resource);
        const auto found = std::find_if(plan.heaps.begin(), plan.heaps.end(),
            [&](const Heap& heap) { return heap.type_bits == need.type_bits; });
        const auto heap = static_cast<std::size_t>(found - plan.heaps.begin());
        if (found == plan.heaps.end()) {
            plan.heaps.push_back({need.type_bits, 0, true});
            Pool& pool = pools.emplace_back();
            pool.ranges.reserve(plan.placements.size() - i);
            pool.members.reserve(plan.placements.size() - i);
        }
        // Whole pages of the granularity each, so that no buffer shares one with an image.
        const std::uint64_t bytes = (need.bytes + granularity - 1) / granularity * granularity;
        LiveRange range{bytes, std::max(need.alignment, granularity), placement.first_step,
            concurrency ? concurrency->end(placement) : placement.last_step};
        if (!policy.alias_memory) {
            range.first = 0;
            range.last = static_cast<std::uint32_t>(plan.steps.size() - 1);
        }
        pools[heap].ranges.push_back(range);
        pools[heap].members.push_back(i);
    }
    for (std::uint32_t heap = 0; heap < pools.size(); ++heap)
        pack_heap(heap, pools[heap].ranges, pools[heap].members, plan);
}

/// In the order of the declaration, whatever the order of the steps.
std::uint64_t lower_bound(const Declaration& declaration, const Plan& plan) {
    std::uint64_t kept = 0;
    std::vector<std::uint64_t> change(plan.passes.size() + 1, 0); // modulo 2^64: may go down
    for (const Placement& placement : plan.placements) {
        if (!shares_memory(declaration.resources[placement.resource])) {
            kept += placement.bytes;
            continue;
        }
        change[plan.resources[placement.resource].pass] += placement.bytes;
        change[plan.resources[placement.resource].last_pass + 1] -= placement.bytes;
    }
    std::uint64_t live = 0, most = 0;
    for (const std::uint64_t pass : change) most = std::max(most, live += pass);
    return kept + most;
}

} // namespace

void place(const Declaration& declaration, const Capabilities& capabilities, const Policy& policy,
    Plan& plan) {
    plan.placements = find_intervals(declaration, plan);
    place_shared(declaration, capabilities, policy, plan);
    for (Placement& placement : plan.placements) {
        const ResourceDecl& resource = declaration.resources[placement.resource];
        if (shares_memory(resource)) continue;
        placement.heap = static_cast<std::uint32_t>(plan.heaps.size());
        plan.heaps.push_back({memory_need(resource).type_bits, placement.bytes, false});
    }

    for (const Heap& heap : plan.heaps) plan.bytes_peak += heap.bytes;
    plan.bytes_lower_bound = lower_bound(declaration, plan);
    if (policy.memory_budget_bytes && plan.bytes_peak > policy.memory_budget_bytes)
        fail_device("[over-budget] graph '{}' does not fit into {:.3f} MiB; shrink, split or raise "
                    "them{}",
            declaration.name, static_cast<double>(policy.memory_budget_bytes) / (1 << 20),
            needs_text(declaration, plan));
}

} // namespace ockham
