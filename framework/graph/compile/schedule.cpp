// SPDX-License-Identifier: Apache-2.0
#include "framework/core/error.hpp"
#include "framework/graph/compile/phases.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

namespace ockham {

namespace {

constexpr std::uint32_t kQueues = 3; ///< main, async compute, transfer
/// Per queue: how many of its steps, or a step, or kNone.
using PerQueue = std::array<std::uint32_t, kQueues>;
constexpr PerQueue kNobody{kNone, kNone, kNone};

/// The queue of each wish; equal ones are one queue.
struct Choice {
    PlanQueue main, async_compute, transfer;
};

/// First family, other than `but`, that fits.
template <class Fits>
std::uint32_t find_family(const std::vector<QueueFamily>& families, std::uint32_t but, Fits fits) {
    for (std::uint32_t i = 0; i < families.size(); ++i)
        if (i != but && families[i].queues > 0 && fits(families[i])) return i;
    return kNone;
}

Choice choose_queues(const std::vector<QueueFamily>& families) {
    if (families.empty()) return {};
    Choice choice;
    const std::uint32_t main =
        find_family(families, kNone, [](const QueueFamily& f) { return f.graphics && f.compute; });
    check(main != kNone, "no queue family has graphics and compute");
    choice.main = choice.async_compute = choice.transfer = {main, 0};

    std::uint32_t async =
        find_family(families, main, [](const QueueFamily& f) { return f.compute && !f.graphics; });
    if (async == kNone && families[main].queues >= 2)
        choice.async_compute.index = 1;
    else if (async == kNone)
        async = find_family(families, main, [](const QueueFamily& f) { return f.compute; });
    if (async != kNone) choice.async_compute = {async, 0};

    const std::uint32_t transfer = find_family(families, main,
        [](const QueueFamily& f) { return f.transfer && !f.compute && !f.graphics; });
    if (transfer != kNone) choice.transfer = {transfer, 0};
    return choice;
}

PlanQueue queue_for(const Choice& choice, const PassDecl& pass) {
    if (pass.queue == QueueWish::async_compute && pass.kind != PassKind::raster)
        return choice.async_compute;
    if (pass.queue == QueueWish::transfer && pass.kind == PassKind::transfer)
        return choice.transfer;
    return choice.main;
}

/// Moves steps to their queues. Until it regroups them at the end, steps are numbered in their
/// present order, which is one in which they could run on a single queue.
class Scheduler {
public:
    Scheduler(const Declaration& declaration, const Pieces& pieces, Plan& plan)
        : declaration_(declaration), pieces_(pieces), plan_(plan),
          queue_of_(plan.steps.size() + 1, 0), met_(declaration.resources.size(), 0),
          past_(plan.steps.size() + 1) {}

    /// False: one queue would do as well, and nothing has been changed.
    bool run(const Choice& choice) {
        if (!assign_queues(choice)) return false;
        find_concurrent();
        find_dependences();
        if (!find_waits()) return false;
        plan_.queues = std::move(queues_);
        plan_.concurrent = std::move(concurrent_);
        submit();
        return true;
    }

private:
    /// The users of a piece since content, layout or owner last changed.
    struct Epoch {
        PerQueue last = kNobody;        ///< users, on each queue the latest
        PerQueue last_before = kNobody; ///< users of the epoch before
        std::uint32_t opener = kNone;   ///< its first user, where others rely on its barriers
        std::uint32_t family = kNone;
        VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;
        bool written = false;
        bool pending = false; ///< the caller's uses, for which the first user must wait
    };

    std::uint32_t family_of(std::uint32_t queue) const { return queues_[queue].family; }

    bool assign_queues(const Choice& choice) {
        queues_ = {choice.main};
        for (std::uint32_t step = 0; step < plan_.steps.size(); ++step) {
            const PlanQueue queue = queue_for(choice, declaration_.passes[plan_.steps[step].pass]);
            auto found = std::find(queues_.begin(), queues_.end(), queue);
            if (found == queues_.end()) found = queues_.insert(found, queue);
            queue_of_[step] = static_cast<std::uint32_t>(found - queues_.begin());
        }
        return queues_.size() > 1;
    }

    /// Resources that live on and are used by several families never change owner. All ages of a
    /// history are one in turn.
    void find_concurrent() {
        std::vector<std::uint32_t> families(declaration_.resources.size(), 0); // bit per queue
        for (std::uint32_t step = 0; step < plan_.steps.size(); ++step) {
            std::uint32_t first = 0; // queue that stands for its family
            while (family_of(first) != family_of(queue_of_[step])) ++first;
            for (const Use& use : declaration_.uses_of(plan_.steps[step].pass)) {
                const ResourceDecl& resource = declaration_.resources[use.resource];
                families[use.resource - resource.history_age] |= 1u << first;
            }
        }
        for (ResourceId id = 0; id < families.size(); ++id) // what the exit may touch on queue 0
            if (may_have_exit(id)) families[id - declaration_.resources[id].history_age] |= 1;
        concurrent_.assign(families.size(), 0);
        for (ResourceId id = 0; id < families.size(); ++id) {
            const ResourceDecl& resource = declaration_.resources[id];
            const bool kept = !shares_memory(resource) && resource.lifetime != Lifetime::external;
            concurrent_[id] =
                kept && std::popcount(families[id - resource.history_age]) > 1 ? 1 : 0;
        }
    }

    void depend(std::uint32_t step, std::uint32_t on) {
        if (on != kNone && on != step && queue_of_[on] != queue_of_[step])
            dependences_.push_back({step, on});
    }
    void depend(std::uint32_t step, const PerQueue& on) {
        for (const std::uint32_t other : on) depend(step, other);
    }

    /// Between queues only: what each step must wait for.
    void find_dependences() {
        std::vector<Epoch> epochs(pieces_.count());
        const auto exit = static_cast<std::uint32_t>(plan_.steps.size());
        for (PieceId piece = 0; piece < epochs.size(); ++piece) {
            const ResourceDecl& resource = declaration_.resources[pieces_.resource_of(piece)];
            if (resource.lifetime != Lifetime::external) continue;
            if (resource.entry.queue_family != VK_QUEUE_FAMILY_IGNORED)
                epochs[piece].family = resource.entry.queue_family;
            if (resource.kind == ResourceKind::image) epochs[piece].layout = resource.entry.layout;
            epochs[piece].pending = resource.entry.stages != 0;
        }
        std::uint32_t last_effect = kNone;
        for (std::uint32_t step = 0; step < exit; ++step) {
            const PassId pass = plan_.steps[step].pass;
            if (!declaration_.passes[pass].side_effect.empty())
                depend(step, std::exchange(last_effect, step));
            for (const Use& use : declaration_.uses_of(pass))
                pieces_.each(
                    use, [&](PieceId piece) { find_dependence(step, use, epochs[piece]); });
            for (const Use& use : declaration_.uses_of(pass)) meet_rest(step, use, epochs);
        }
        // The exit barriers come last, on queue 0.
        for (PieceId piece = 0; piece < epochs.size(); ++piece) {
            if (!may_have_exit(pieces_.resource_of(piece))) continue;
            has_exit_ = true;
            depend(exit, epochs[piece].last);
        }
        std::stable_sort(dependences_.begin(), dependences_.end(),
            [](const Dependence& a, const Dependence& b) { return a.step < b.step; });
    }

    /// Left in a state that was promised, or, in pieces, in one layout.
    bool may_have_exit(ResourceId id) const {
        const ResourceDecl& resource = declaration_.resources[id];
        if (shares_memory(resource) || plan_.resources[id].culled) return false;
        const bool promised =
            resource.lifetime == Lifetime::external &&
            (resource.exit.stages != 0 || resource.exit.layout != VK_IMAGE_LAYOUT_UNDEFINED ||
                resource.exit.queue_family != VK_QUEUE_FAMILY_IGNORED);
        return promised || (resource.kind == ResourceKind::image && pieces_.count(id) > 1);
    }

    void find_dependence(std::uint32_t step, const Use& use, Epoch& epoch) {
        const ResourceDecl& resource = declaration_.resources[use.resource];
        const std::uint32_t queue = queue_of_[step];
        const std::uint32_t family = family_of(queue);
        const VkImageLayout layout = resource.kind == ResourceKind::image
                                         ? state_of(use.access, use.stage).layout
                                         : VK_IMAGE_LAYOUT_UNDEFINED;
        const bool moves =
            !concurrent_[use.resource] && epoch.family != kNone && epoch.family != family;
        const bool changes = moves || layout != epoch.layout || epoch.pending;
        if (!writes(use.access) && !epoch.written && !changes) {
            depend(step, epoch.last_before);
            depend(step, epoch.opener);
            epoch.last[queue] = step;
            epoch.family = family;
            return;
        }
        if (moves) release(epoch);
        depend(step, epoch.last);
        epoch.last_before = epoch.last;
        epoch.last = kNobody;
        epoch.last[queue] = step;
        epoch.opener = changes ? step : kNone;
        epoch.family = family;
        epoch.layout = layout;
        epoch.written = writes(use.access);
        epoch.pending = false;
    }

    /// What the caller owns is taken over as a whole where a part of it is used first.
    void meet_rest(std::uint32_t step, const Use& use, std::vector<Epoch>& epochs) {
        const ResourceId id = use.resource;
        if (declaration_.resources[id].lifetime != Lifetime::external || met_[id]) return;
        met_[id] = 1;
        const std::uint32_t queue = queue_of_[step];
        const PieceId first = pieces_.first(id);
        for (PieceId piece = first; piece < first + pieces_.count(id); ++piece) {
            Epoch& epoch = epochs[piece];
            if (epoch.last[queue] == step) continue;
            if (epoch.family == kNone || epoch.family == family_of(queue)) {
                epoch.family = family_of(queue);
                epoch.last[queue] = step;
            } else {
                find_dependence(step, use, epoch);
            }
        }
    }

    /// A family gives a resource up after its latest user; its other queues must be done by then.
    void release(const Epoch& epoch) {
        std::uint32_t latest = 0;
        for (const std::uint32_t user : epoch.last)
            if (user != kNone) latest = std::max(latest, user);
        depend(latest, epoch.last);
    }

    /// Finds out what each step knows to be over when it begins, and the waits that it needs for
    /// that. False: every step needs all before it to be over.
    bool find_waits() {
        const auto exit = static_cast<std::uint32_t>(plan_.steps.size());
        PerQueue counts{}; // steps so far
        std::array<PerQueue, kQueues> present{};
        position_.resize(exit + 1);
        bool serial = true;
        auto next = dependences_.begin();
        for (std::uint32_t step = 0; step <= exit; ++step) {
            const std::uint32_t queue = queue_of_[step];
            PerQueue& past = past_[step];
            past = present[queue];
            PerQueue latest = kNobody; // that this step waits for
            for (; next != dependences_.end() && next->step == step; ++next) {
                const std::uint32_t other = queue_of_[next->on];
                if (position_[next->on] <= past[other]) continue;
                if (latest[other] == kNone || latest[other] < next->on) latest[other] = next->on;
            }
            for (std::uint32_t other = 0; other < kQueues; ++other) {
                const std::uint32_t on = latest[other];
                const bool implied =
                    on != kNone &&
                    std::any_of(latest.begin(), latest.end(), [&](std::uint32_t third) {
                        return third != kNone && third != on &&
                               past_[third][other] >= position_[on];
                    });
                if (on != kNone && !implied) waits_.push_back({step, on});
            }
            for (const std::uint32_t on : latest)
                if (on != kNone)
                    for (std::uint32_t i = 0; i < kQueues; ++i)
                        past[i] = std::max(past[i], on_queue(on, i));
            if (step == exit) break;
            position_[step] = ++counts[queue];
            for (std::uint32_t i = 0; i < kQueues; ++i)
                serial &= i == queue || past[i] == counts[i];
            past[queue] = counts[queue] - 1;
            present[queue] = past;
            present[queue][queue] = counts[queue];
        }
        return !serial;
    }
    /// How many steps of queue `queue` are over when `step` is.
    std::uint32_t on_queue(std::uint32_t step, std::uint32_t queue) const {
        return queue == queue_of_[step] ? position_[step] : past_[step][queue];
    }

    /// Cuts each queue's steps before those that wait and behind those that are waited for.
    void submit() {
        const auto exit = static_cast<std::uint32_t>(plan_.steps.size());
        std::vector<std::uint8_t> cut_behind(exit, 0);
        for (const Dependence& wait : waits_) cut_behind[wait.on] = 1;
        std::vector<std::uint32_t> submission_of(exit);
        std::vector<std::uint32_t> values; // per submission: which of its queue's
        PerQueue open = kNobody, counts{};
        auto wait = waits_.begin();
        const auto begin = [&](std::uint32_t step) {
            const std::uint32_t queue = queue_of_[step];
            open[queue] = static_cast<std::uint32_t>(values.size());
            values.push_back(++counts[queue]);
            const auto first_wait = static_cast<std::uint32_t>(plan_.waits.size());
            for (; wait != waits_.end() && wait->step == step; ++wait)
                plan_.waits.push_back(
                    {.queue = queue_of_[wait->on], .value = values[submission_of[wait->on]]});
            plan_.submissions.push_back({.queue = queue,
                .first_wait = first_wait,
                .wait_count = static_cast<std::uint32_t>(plan_.waits.size()) - first_wait});
        };
        for (std::uint32_t step = 0; step < exit; ++step) {
            const std::uint32_t queue = queue_of_[step];
            const bool must_wait = wait != waits_.end() && wait->step == step;
            if (must_wait || open[queue] == kNone) begin(step);
            submission_of[step] = open[queue];
            ++plan_.submissions[open[queue]].step_count;
            if (cut_behind[step]) open[queue] = kNone;
        }
        if (has_exit_ && (wait != waits_.end() || plan_.submissions.back().queue != 0)) begin(exit);
        regroup(submission_of);
    }

    void regroup(const std::vector<std::uint32_t>& submission_of) {
        std::vector<std::uint32_t> next;
        std::uint32_t first = 0;
        for (Submission& submission : plan_.submissions) {
            submission.first_step = first;
            next.push_back(first);
            first += submission.step_count;
        }
        std::vector<Step> steps(plan_.steps.size());
        for (std::uint32_t step = 0; step < steps.size(); ++step)
            steps[next[submission_of[step]]++] = plan_.steps[step];
        plan_.steps = std::move(steps);
    }

    struct Dependence {
        std::uint32_t step, on;
    };

    const Declaration& declaration_;
    const Pieces& pieces_;
    Plan& plan_;
    std::vector<PlanQueue> queues_;
    std::vector<std::uint8_t> concurrent_;
    std::vector<std::uint32_t> queue_of_; ///< per step, and of the exit: queue 0
    std::vector<std::uint8_t> met_;       ///< per resource of the caller: used before
    std::vector<Dependence> dependences_, waits_;
    std::vector<std::uint32_t> position_; ///< per step: which of its queue's, from 1
    std::vector<PerQueue> past_;          ///< per step: steps of each queue that are over by then
    bool has_exit_ = false;
};

} // namespace

void schedule(const Declaration& declaration, const Pieces& pieces,
    const Capabilities& capabilities, const Policy& policy, Plan& plan) {
    const Choice choice = choose_queues(capabilities.families);
    const bool wishes = std::any_of(plan.steps.begin(), plan.steps.end(),
        [&](const Step& step) { return declaration.passes[step.pass].queue != QueueWish::main; });
    if (policy.async_queues && wishes && Scheduler(declaration, pieces, plan).run(choice)) return;
    plan.queues = {choice.main};
    plan.submissions = {{.step_count = static_cast<std::uint32_t>(plan.steps.size())}};
    plan.concurrent.assign(declaration.resources.size(), 0);
}

} // namespace ockham
