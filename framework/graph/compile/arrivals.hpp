// SPDX-License-Identifier: Apache-2.0
// What each submission of a plan finds completed because it waited for other queues, directly or
// through others. Called by synchronize.cpp; trivial for plans of one queue.
#pragma once

#include "framework/graph/compile/drafts.hpp"

namespace ockham {

class Arrivals {
public:
    explicit Arrivals(const Plan& plan);
    bool one_queue() const { return queues_ == 1; }

    /// Whether what `queue` did at `when` is complete, available, and visible to stages() before
    /// the first barrier of the submission. False for what only the order on a queue puts before.
    bool covers(std::uint32_t submission, std::uint32_t queue, Time when) const {
        return queues_ > 1 && ends_[submission * queues_ + queue] > when;
    }
    /// What all waits before and of the submission have in common.
    VkPipelineStageFlags2 stages(std::uint32_t submission) const { return stages_[submission]; }

private:
    void add_round(const Plan& plan);

    std::uint32_t queues_;
    /// Per submission and queue: all earlier than this are complete.
    std::vector<Time> ends_;
    std::vector<VkPipelineStageFlags2> stages_;
    std::vector<Time> entry_; ///< per queue and queue: of the executions before
};

} // namespace ockham
