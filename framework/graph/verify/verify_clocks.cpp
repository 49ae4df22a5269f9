// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/verify/verify_clocks.hpp"

#include <algorithm>

namespace ockham::verifier {

namespace {

void join(Row& row, const Row& other) {
    for (std::size_t i = 0; i < row.size(); ++i) row[i] = std::max(row[i], other[i]);
}

} // namespace

Scopes scopes_of(const Barrier& barrier) {
    Scopes scopes;
    scopes.src = stages_of(barrier.src_stages);
    scopes.dst = stages_of(barrier.dst_stages);
    scopes.src_access = accesses_of(barrier.src_access);
    scopes.dst_access = accesses_of(barrier.dst_access);
    scopes.first = with_earlier(scopes.src);
    scopes.second = with_later(scopes.dst);
    return scopes;
}

Clocks::Clocks(std::size_t queues) : queues_(queues) {
    // Point 1 of every queue stands for what was complete before anything here.
    for (Queue& queue : queues_)
        for (Row& row : queue.rows) row.fill(1);
}

Row Clocks::first_scope(Point at, const Scopes& scopes) const {
    Row first;
    first.fill(1);
    each_bit(
        scopes.first, [&](std::uint32_t stage) { join(first, queues_[at.queue].rows[stage]); });
    each_bit(scopes.first, [&](std::uint32_t stage) { first[stage] = at.index - 1; });
    return first;
}

void Clocks::let_wait(std::uint32_t queue, const Row& first, const Scopes& scopes) {
    each_bit(scopes.second, [&](std::uint32_t stage) { join(queues_[queue].rows[stage], first); });
}

Clocks::Signal Clocks::signal(std::uint32_t queue) const {
    Signal signal{};
    for (const Row& row : queues_[queue].rows)
        for (std::uint32_t i = 0; i < kQueues; ++i)
            signal[i] = std::max(signal[i], row[kStageCount + i]);
    signal[queue] = queues_[queue].now;
    return signal;
}

void Clocks::wait(std::uint32_t queue, const Signal& signal, Stages stages) {
    each_bit(with_later(stages), [&](std::uint32_t stage) {
        for (std::uint32_t i = 0; i < kQueues; ++i) {
            std::uint32_t& known = queues_[queue].rows[stage][kStageCount + i];
            known = std::max(known, signal[i]);
        }
    });
    each_bit(stages, [&](std::uint32_t stage) {
        for (std::uint32_t i = 0; i < kQueues; ++i) {
            std::uint32_t& seen = queues_[queue].seen[stage][i];
            seen = std::max(seen, signal[i]);
        }
    });
}

} // namespace ockham::verifier
