// SPDX-License-Identifier: Apache-2.0
// Plans by what they were made from: a graph declared anew, but equal, costs a look-up instead of
// planning. Holds plans only, nothing of a device. Used by runtime; callable from several threads.
#pragma once

#include "framework/graph/compile.hpp"
#include "framework/graph/graph.hpp"

#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

namespace ockham {

class PlanCache {
public:
    /// Keeps as many plans as `capacity` (>= 1), those used last.
    explicit PlanCache(std::size_t capacity = 32);

    /// The plan of the graph. `make`, a function without arguments, is called where there is none
    /// yet, and its errors are thrown. Memory needs that it fills in must follow from the rest of
    /// the declaration, as those of one device do: one cache for each device.
    /// With Policy::paranoid it is always called, and aborts where an equal graph got another plan.
    template <class Make>
    std::shared_ptr<const Plan> get(
        const Graph& graph, const Capabilities& capabilities, const Policy& policy, Make make) {
        const Fingerprint key = key_of(graph, capabilities, policy);
        std::shared_ptr<const Plan> plan = find(key);
        if (plan && policy.paranoid) compare(graph, *plan, make());
        return plan ? plan : insert(key, make());
    }
    /// The same, made by compile().
    std::shared_ptr<const Plan> get(
        const Graph& graph, const Capabilities& capabilities = {}, const Policy& policy = {}) {
        return get(graph, capabilities, policy,
            [&] { return compile(graph.declaration(), capabilities, policy); });
    }

    std::size_t size() const;
    void clear();

private:
    struct Entry {
        Fingerprint key;
        std::shared_ptr<const Plan> plan;
    };
    static Fingerprint key_of(
        const Graph& graph, const Capabilities& capabilities, const Policy& policy);
    static void compare(const Graph& graph, const Plan& kept, const Plan& made);
    std::shared_ptr<const Plan> find(const Fingerprint& key);
    /// What another thread has inserted meanwhile stays.
    std::shared_ptr<const Plan> insert(const Fingerprint& key, Plan plan);

    mutable std::mutex mutex_;
    std::size_t capacity_;
    std::vector<Entry> entries_; ///< the one used last at the end
};

} // namespace ockham
