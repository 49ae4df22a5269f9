// SPDX-License-Identifier: Apache-2.0
#include "framework/runtime/submitter.hpp"

#include "framework/core/error.hpp"
#include "framework/gpu/wait.hpp"

#include <algorithm>

namespace ockham {

Submitter::Submitter(
    gpu::Device& device, const Declaration& declaration, const Plan& plan, bool one_queue)
    : device_(device), declaration_(declaration), plan_(plan), completed_(plan.queues.size(), 0) {
    const std::span<const gpu::FamilyInfo> families = device.families();
    for (const PlanQueue& queue : plan.queues) {
        queues_.push_back(
            one_queue ? device.main_queue() : gpu::QueueId{queue.family, queue.index});
        const gpu::QueueId real = queues_.back();
        if (real.family >= families.size() || real.index >= families[real.family].queues) {
            fail_device("graph '{}' is planned for queue {} of family {}, which '{}' does not "
                        "have; plan it with make_plan() for this device",
                declaration.name, real.index, real.family, device.info().name);
        }
    }
    if (single()) return;
    for (std::size_t i = 0; i < queues_.size(); ++i) {
        const VkSemaphoreTypeCreateInfo type{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO,
            .semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE};
        const VkSemaphoreCreateInfo info{
            .sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, .pNext = &type};
        gpu::expect(vkCreateSemaphore(
                        device.handle(), &info, nullptr, &timelines_.emplace_back(VK_NULL_HANDLE)),
            "creating a timeline semaphore");
        gpu::set_name(device, VK_OBJECT_TYPE_SEMAPHORE, timelines_.back(),
            fmt::format("{}, queue {}", declaration.name, i));
    }
}

Submitter::~Submitter() {
    for (const VkSemaphore timeline : timelines_) {
        vkDestroySemaphore(device_.handle(), timeline, nullptr);
    }
}

bool Submitter::uses(const Submission& submission, ResourceId id) const {
    const auto touches = [&](const Barrier& barrier) { return barrier.resource == id; };
    for (std::uint32_t i = 0; i < submission.step_count; ++i) {
        const PassId pass = plan_.steps[submission.first_step + i].pass;
        const auto used = [&](const Use& use) { return use.resource == id; };
        if (std::ranges::any_of(declaration_.uses_of(pass), used)) return true;
    }
    return &submission == &plan_.submissions.back() &&
           std::ranges::any_of(plan_.exit_barriers(), touches);
}

Submitter::Users Submitter::users_of(ResourceId id) const {
    Users users{.first = std::vector(queues_.size(), kNone),
        .last = std::vector(queues_.size(), kNone),
        .end = static_cast<std::uint32_t>(plan_.submissions.size() - 1)};
    bool any = false;
    for (std::uint32_t i = 0; i < plan_.submissions.size(); ++i) {
        if (!uses(plan_.submissions[i], id)) continue;
        const std::uint32_t queue = plan_.submissions[i].queue;
        if (users.first[queue] == kNone) users.first[queue] = i;
        users.last[queue] = users.end = i;
        any = true;
    }
    // Unused imports are waited for and signalled too, so that nobody waits in vain.
    if (!any) users.first[plan_.submissions[users.end].queue] = users.end;
    return users;
}

std::uint64_t Submitter::value_of(std::uint32_t index) const {
    const std::uint32_t queue = plan_.submissions[index].queue;
    const auto first = plan_.submissions.begin();
    return completed_[queue] +
           static_cast<std::uint64_t>(std::count_if(first, first + index + 1,
               [&](const Submission& submission) { return submission.queue == queue; }));
}

void Submitter::add_points(std::uint32_t index, const ImportPoint& point, const Users& users,
    std::vector<gpu::TimelinePoint>& waits, std::vector<gpu::TimelinePoint>& signals) const {
    const std::uint32_t own = plan_.submissions[index].queue;
    if (users.first[own] == index && point.wait.semaphore) waits.push_back(point.wait);
    if (users.end != index || !point.signal.semaphore) return;
    // Queues end in no order, so whoever signals waits for the others.
    for (std::uint32_t queue = 0; queue < queues_.size(); ++queue) {
        const std::uint32_t last = users.last[queue];
        if (queue != own && last != kNone) waits.push_back({timelines_[queue], value_of(last)});
    }
    signals.push_back(point.signal);
}

/// What the plan lists and, for the first submission of a queue, the end of the past executions on
/// the others. `done`: submissions of each queue in this execution.
void Submitter::add_queue_waits(const Submission& submission, std::span<const std::uint64_t> done,
    std::vector<gpu::TimelinePoint>& waits) const {
    for (std::uint32_t i = 0; i < submission.wait_count; ++i) {
        const Wait& wait = plan_.waits[submission.first_wait + i];
        waits.push_back({timelines_[wait.queue], completed_[wait.queue] + wait.value, wait.stages});
    }
    if (done[submission.queue] > 0) return;
    for (std::uint32_t queue = 0; queue < timelines_.size(); ++queue) {
        if (queue == submission.queue || completed_[queue] == 0) continue;
        waits.push_back({timelines_[queue], completed_[queue]});
    }
}

void Submitter::submit(Frame& frame, std::span<const std::vector<VkCommandBuffer>> commands,
    std::span<const ImportPoint> points) {
    if (plan_.submissions.empty()) return submit_nothing(frame, points);
    std::vector<std::uint64_t> done(queues_.size(), 0);
    std::vector<Users> users;
    for (const ImportPoint& point : points) users.push_back(users_of(point.resource));
    frame.ends = completed_;
    for (std::uint32_t i = 0; i < plan_.submissions.size(); ++i) {
        const Submission& submission = plan_.submissions[i];
        std::vector<gpu::TimelinePoint> waits, signals;
        for (std::size_t k = 0; k < points.size(); ++k)
            add_points(i, points[k], users[k], waits, signals);
        VkFence fence = VK_NULL_HANDLE;
        if (single()) {
            fence = frame.fence;
        } else {
            add_queue_waits(submission, done, waits);
            signals.push_back({timelines_[submission.queue],
                completed_[submission.queue] + done[submission.queue] + 1});
        }
        device_.submit({.queue = queues_[submission.queue],
                           .commands = commands[i],
                           .waits = waits,
                           .signals = signals,
                           .fence = fence},
            declaration_.name);
        frame.in_flight = true;
        frame.ends[submission.queue] = completed_[submission.queue] + ++done[submission.queue];
    }
    completed_ = frame.ends;
}

/// For whoever waits for the points of a plan that does nothing.
void Submitter::submit_nothing(Frame& frame, std::span<const ImportPoint> points) {
    std::vector<gpu::TimelinePoint> waits, signals;
    for (const ImportPoint& point : points) {
        if (point.wait.semaphore) waits.push_back(point.wait);
        if (point.signal.semaphore) signals.push_back(point.signal);
    }
    device_.submit({.queue = queues_.front(),
                       .commands = {},
                       .waits = waits,
                       .signals = signals,
                       .fence = frame.fence},
        declaration_.name);
    frame.in_flight = true;
}

void Submitter::wait(Frame& frame) {
    if (!frame.in_flight) return;
    frame.in_flight = false;
    VkResult result = VK_SUCCESS;
    if (single()) {
        result = gpu::wait_out([&] {
            return vkWaitForFences(device_.handle(), 1, &frame.fence, VK_TRUE, UINT64_MAX);
        });
        if (result == VK_SUCCESS) result = vkResetFences(device_.handle(), 1, &frame.fence);
    } else {
        const VkSemaphoreWaitInfo info{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO,
            .semaphoreCount = static_cast<std::uint32_t>(timelines_.size()),
            .pSemaphores = timelines_.data(),
            .pValues = frame.ends.data()};
        result =
            gpu::wait_out([&] { return vkWaitSemaphores(device_.handle(), &info, UINT64_MAX); });
    }
    gpu::expect(
        result, fmt::format("executing '{}' on '{}'", declaration_.name, device_.info().name));
}

} // namespace ockham
