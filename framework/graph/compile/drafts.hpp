// SPDX-License-Identifier: Apache-2.0
// Barriers before it is settled which of them are needed: what synchronize() and its helpers hand
// to each other. For synchronize*.cpp, gather.cpp, merge.cpp and prune.cpp.
#pragma once

#include "framework/graph/compile/pieces.hpp"
#include "framework/graph/plan.hpp"

#include <vector>

namespace ockham {

/// Points in time, counted over the steps in the order of the plan: 1 + the index of a step of this
/// execution; 0 for what the caller did just before it; of the execution before, `period` less.
using Time = std::int32_t;
inline Time time_of(std::uint32_t step) { return static_cast<Time>(step) + 1; }
inline Time period_of(const Plan& plan) { return static_cast<Time>(plan.steps.size()) + 1; }

/// A use that a barrier waits for.
struct Past {
    VkPipelineStageFlags2 stages = 0;
    Time when = 0;
    std::uint32_t queue = 0;
    /// Of a write that is not available yet, whose memory is taken over: its number. Else kNone.
    std::uint32_t write = kNone;
};
/// Numbers the last writes of pieces, in this execution and in the one before.
inline std::uint32_t write_of(PieceId piece, bool before) { return 2 * piece + before; }

/// What is known of a barrier beside its own fields; one for each of Plan::barriers meanwhile.
struct Draft {
    PieceId piece = 0;
    std::uint32_t step = 0; ///< before which it is executed; the number of steps: at the exit
    std::uint32_t first_past = 0, past_count = 0; ///< all that it must order before its dst_stages
    Time from_when = 0;                           ///< when Barrier::from was
    bool release = false;                         ///< executed after `step`, with the releases
    bool light = false; ///< nothing becomes visible or another layout by it
    bool dead = false;
};

/// Moves barriers to earlier steps, so that fewer batches hold them all. Those that are no releases
/// must be sorted by step, and are not any more.
void gather(const Plan& plan, std::vector<Draft>& drafts, const std::vector<Past>& pasts);

/// By step, releases after the others; else the order stays.
void sort(Plan& plan, std::vector<Draft>& drafts);

/// Barriers of one batch on neighbouring parts that are else equal become one; the others are dead.
/// `drafts` must be sorted.
void merge(const Declaration& declaration, Plan& plan, std::vector<Draft>& drafts,
    std::vector<Past>& pasts);

/// Marks those of the light ones dead that order nothing, and make nothing available, that others
/// do not, in this execution or across two; takes away stages that add nothing. `drafts` must be
/// sorted.
void prune(Plan& plan, std::vector<Draft>& drafts, const std::vector<Past>& pasts);

} // namespace ockham
