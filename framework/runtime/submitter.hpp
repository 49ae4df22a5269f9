// SPDX-License-Identifier: Apache-2.0
// Submits the submissions of a plan: one with a fence, several with a timeline semaphore for each
// queue. Knows when a frame is over. For the executor only.
#pragma once

#include "framework/gpu/device.hpp"
#include "framework/graph/declaration.hpp"
#include "framework/graph/plan.hpp"
#include "framework/runtime/frame.hpp"

#include <vector>

namespace ockham {

/// What the caller of an import waits for and signals, in the next execution only.
struct ImportPoint {
    ResourceId resource = kNone;
    gpu::TimelinePoint wait;   ///< null semaphore: nothing
    gpu::TimelinePoint signal; ///< null semaphore: nothing
};

class Submitter {
public:
    /// `one_queue`: whatever queues the plan has, all are the main queue of the device. Throws
    /// Error(device) where the device lacks a queue of the plan.
    Submitter(
        gpu::Device& device, const Declaration& declaration, const Plan& plan, bool one_queue);
    ~Submitter();
    Submitter(const Submitter&) = delete;
    Submitter& operator=(const Submitter&) = delete;

    const gpu::QueueId& queue(std::uint32_t plan_queue) const { return queues_[plan_queue]; }
    /// `commands`: of each submission of the plan. Returns at once.
    void submit(Frame& frame, std::span<const std::vector<VkCommandBuffer>> commands,
        std::span<const ImportPoint> points);
    /// Waits until the frame is over, if it is in flight.
    void wait(Frame& frame);

private:
    /// Submissions that use an import; kNone where a queue has none.
    struct Users {
        std::vector<std::uint32_t> first; ///< by queue of the plan
        std::vector<std::uint32_t> last;  ///< by queue of the plan
        std::uint32_t end = 0;            ///< last of all as submitted
    };
    bool single() const { return plan_.submissions.size() <= 1; }
    bool uses(const Submission& submission, ResourceId id) const;
    Users users_of(ResourceId id) const;
    /// What the submission makes its queue's timeline in the next execution.
    std::uint64_t value_of(std::uint32_t submission) const;
    void add_points(std::uint32_t submission, const ImportPoint& point, const Users& users,
        std::vector<gpu::TimelinePoint>& waits, std::vector<gpu::TimelinePoint>& signals) const;
    void submit_nothing(Frame& frame, std::span<const ImportPoint> points);
    void add_queue_waits(const Submission& submission, std::span<const std::uint64_t> done,
        std::vector<gpu::TimelinePoint>& waits) const;

    gpu::Device& device_;
    const Declaration& declaration_;
    const Plan& plan_;
    std::vector<gpu::QueueId> queues_;     ///< real ones, by queue of the plan
    std::vector<VkSemaphore> timelines_;   ///< by queue of the plan; none where single()
    std::vector<std::uint64_t> completed_; ///< values that the past executions will reach
};

} // namespace ockham
