// SPDX-License-Identifier: Apache-2.0
// Happens-before on the queues of a plan, as clocks. Exact, because execution dependencies on one
// queue are monotone: what orders a command after another orders it after all before that one in
// the same stage. Knows no resources. Included by verify*.cpp only.
#pragma once

#include "framework/graph/verify/verify_model.hpp"

#include <array>
#include <vector>

namespace ockham::verifier {

inline constexpr std::uint32_t kQueues = 4; ///< at most

/// A point on a queue: commands and barrier batches count up from 1, each queue for itself.
struct Point {
    std::uint32_t queue = 0;
    std::uint32_t index = 0;
};

/// For one stage of one queue: up to which point commands that come next wait for others. First per
/// stage of the same queue, then all stages of each queue, which semaphores wait for.
using Row = std::array<std::uint32_t, kStageCount + kQueues>;
using Matrix = std::array<Row, kStageCount>;

/// Execution and memory dependencies of one barrier, in compact sets.
struct Scopes {
    Stages src = 0, dst = 0; ///< those named
    Accesses src_access = 0, dst_access = 0;
    Stages first = 0, second = 0; ///< execution scopes
};
Scopes scopes_of(const Barrier& barrier);

class Clocks {
public:
    explicit Clocks(std::size_t queues);

    /// The next command or batch on the queue.
    Point advance(std::uint32_t queue) { return {queue, ++queues_[queue].now}; }
    Point now(std::uint32_t queue) const { return {queue, queues_[queue].now}; }

    /// What the first scope of a barrier at that point takes in: all in the row happens before it.
    Row first_scope(Point at, const Scopes& scopes) const;
    /// Lets what comes next in the second scope wait for `first`. The barriers of a batch act as
    /// one: take all their first scopes, then let all wait.
    void let_wait(std::uint32_t queue, const Row& first, const Scopes& scopes);
    const Matrix& rows(std::uint32_t queue) const { return queues_[queue].rows; }

    /// All that happens before a signal after everything so far on the queue.
    using Signal = std::array<std::uint32_t, kQueues>;
    Signal signal(std::uint32_t queue) const;
    void wait(std::uint32_t queue, const Signal& signal, Stages stages);
    /// Whether a semaphore has made all writes up to the point visible to the stage.
    bool is_seen(std::uint32_t queue, std::uint32_t stage, Point point) const {
        return queues_[queue].seen[stage][point.queue] >= point.index;
    }

private:
    struct Queue {
        std::uint32_t now = 1;
        Matrix rows;
        std::array<Signal, kStageCount> seen{};
    };
    std::vector<Queue> queues_;
};

} // namespace ockham::verifier
