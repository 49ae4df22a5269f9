// SPDX-License-Identifier: Apache-2.0
// Walks over the steps and drafts a barrier wherever the next use of a piece needs one. Which of
// those that only order execution are needed, prune() says; last, those of neighbours are merged.
#include "framework/graph/compile/synchronizer.hpp"

#include <array>
#include <tuple>

namespace ockham::sync {

namespace {

/// Accesses by their meaning, so that the walk looks up instead of asking.
struct Meaning {
    AccessState state;
    bool written = false;
    std::uint32_t usage[2] = {}; ///< of buffers, of images
};
constexpr std::size_t kAccesses = static_cast<std::size_t>(Access::host_read) + 1;
constexpr std::size_t kShaderStages = static_cast<std::size_t>(Stage::fixed) + 1;

const auto kMeanings = [] {
    std::array<Meaning, kAccesses * kShaderStages> rows;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const auto access = static_cast<Access>(i / kShaderStages);
        rows[i] = {state_of(access, static_cast<Stage>(i % kShaderStages)), writes(access),
            {buffer_usage(access), image_usage(access)}};
    }
    return rows;
}();
const Meaning& meaning_of(const Use& use) {
    return kMeanings[static_cast<std::size_t>(use.access) * kShaderStages +
                     static_cast<std::size_t>(use.stage)];
}

} // namespace

void Synchronizer::walk(std::uint8_t which) {
    Next next;
    const auto steps = static_cast<std::uint32_t>(plan_.steps.size());
    const bool one = arrivals_.one_queue();
    std::uint32_t end = one ? steps : 0; // of the submission
    for (std::uint32_t step = 0; step < steps; ++step) {
        while (step >= end) { // not taken where there is one queue
            const Submission& submission = plan_.submissions[next.submission = submission_++];
            next.queue = submission.queue;
            end = submission.first_step + submission.step_count;
        }
        next.step = step;
        next.pass = plan_.steps[step].pass;
        const PassDecl& pass = declaration_.passes[next.pass];
        const bool always = pass.guard == kNone;
        bool meets = false; // a resource of the caller for the first time
        for (const Use& use : declaration_.uses_of(next.pass)) {
            const std::uint8_t flags = flags_[use.resource];
            if (!contains(flags, which)) continue;
            plan_.usages[use.resource] |= meaning_of(use).usage[flags & kImage];
            set_use(next, use, always);
            pieces_.each(use, [&](PieceId piece) { touch(piece, use.resource, next); });
            meets = meets || ((flags & kExternal) && !(flags & kMet));
        }
        if (!meets) continue;
        for (const Use& use : declaration_.uses_of(next.pass)) {
            if (!(flags_[use.resource] & kExternal) || (flags_[use.resource] & kMet)) continue;
            set_use(next, use, always);
            meet_rest(use.resource, next);
        }
    }
    submission_ = 0;
}

void Synchronizer::set_use(Next& next, const Use& use, bool always) const {
    const Meaning& meaning = meaning_of(use);
    next.state = meaning.state;
    if (!(flags_[use.resource] & kImage)) next.state.layout = VK_IMAGE_LAYOUT_UNDEFINED;
    next.written = meaning.written;
    next.needs = needs_content(use);
    next.discards = always && replaces_content(use);
}

void Synchronizer::touch(PieceId piece, ResourceId id, const Next& next) {
    Tail& tail = tails_[piece];
    const std::uint8_t flags = flags_[id];
    if (!tail.started) {
        tail.started = tail.known = true;
        if (flags & kTransient) {
            begin_anew(piece, id, tail, next);
            return;
        }
        if ((flags & kExternal) && !(flags & kMet)) meet_caller(tail, next);
    }
    const std::uint32_t family = family_of(next.queue);
    const bool moves =
        tail.family != family && tail.family != VK_QUEUE_FAMILY_IGNORED && !(flags & kConcurrent);
    if (moves && !(next.discards && tail.step != kNone)) {
        take_over(piece, id, tail, next);
        return;
    }
    const bool arrived = arrivals_.covers(next.submission, tail.queue, tail.when);
    const bool changes = (flags & kImage) && (tail.used.layout != next.state.layout || moves);
    const bool seen = sees(tail, next, arrived);
    if (next.written || changes) {
        const std::uint32_t barrier = draft(piece, id, tail, next, {changes, seen, arrived});
        leave_tail(tail, next, next.written ? kNone : barrier);
        return;
    }
    if (!seen) {
        if (tail.barrier != kNone && tail.barrier_queue == next.queue) {
            plan_.barriers[tail.barrier].dst_stages |= next.state.stages;
            plan_.barriers[tail.barrier].dst_access |= next.state.access;
        } else {
            tail.barrier = draft(piece, id, tail, next, {changes, seen, arrived});
            tail.barrier_queue = static_cast<std::uint8_t>(next.queue);
            tail.flushed = true;
        }
    }
    add_read(tail, next);
}

bool Synchronizer::sees(const Tail& tail, const Next& next, bool arrived) const {
    const VkAccessFlags2 access = next.state.access & ~kWriteAccess;
    const VkPipelineStageFlags2 stages = next.state.stages;
    if (access == 0 || !next.needs) return true;
    if (arrived && has_stages(arrivals_.stages(next.submission), stages)) return true;
    if (tail.barrier != kNone && tail.barrier_queue == next.queue) {
        const Barrier& barrier = plan_.barriers[tail.barrier];
        if (contains(barrier.dst_stages, stages) && contains(barrier.dst_access, access))
            return true;
    }
    return tail.flushed && contains(tail.seen_stages, stages) && contains(tail.seen_access, access);
}

void Synchronizer::leave_tail(Tail& tail, const Next& next, std::uint32_t barrier) {
    tail.stages = next.state.stages;
    tail.written = next.state.access & (next.written ? kWriteAccess : 0);
    tail.flushed = !next.written;
    tail.seen_stages = 0;
    tail.seen_access = 0;
    tail.used = next.state;
    tail.when = time_of(next.step);
    tail.queue = static_cast<std::uint8_t>(next.queue);
    tail.barrier = barrier;
    tail.barrier_queue = static_cast<std::uint8_t>(next.queue);
    tail.reads = kNone;
    if (next.written)
        settle(tail, next);
    else
        add_read(tail, next);
}

void Synchronizer::add_read(Tail& tail, const Next& next) {
    if (tail.reads == kNone || tail.pass == kNone) { // the first since, or in this execution
        tail.used = next.state;
    } else {
        tail.used.stages |= next.state.stages;
        tail.used.access |= next.state.access;
    }
    const Past past{next.state.stages, time_of(next.step), next.queue};
    if (tail.reads != kNone && reads_[tail.reads].past.stages == past.stages &&
        reads_[tail.reads].past.queue == past.queue) {
        reads_[tail.reads].past.when = past.when;
    } else {
        reads_.push_back({past, tail.reads});
        tail.reads = static_cast<std::uint32_t>(reads_.size() - 1);
    }
    settle(tail, next);
}

void Synchronizer::settle(Tail& tail, const Next& next) const {
    tail.pass = next.pass;
    tail.step = next.step;
    tail.submission = next.submission;
    tail.last_queue = static_cast<std::uint8_t>(next.queue);
    tail.family = family_of(next.queue);
}

void Synchronizer::finish() {
    const bool batched = policy_.order == Order::batched;
    if (batched) gather(plan_, drafts_, pasts_);
    if (has_releases_ || batched) sort(plan_, drafts_);
    for (std::size_t i = 0; i < drafts_.size(); ++i)
        plan_.barriers[i].part = pieces_.part_of(drafts_[i].piece);
    if (!pieces_.whole()) merge(declaration_, plan_, drafts_, pasts_);
    prune(plan_, drafts_, pasts_);
    std::uint32_t kept = 0, at = 0;
    const auto take = [&](std::uint32_t step, bool release) {
        const std::uint32_t first = kept;
        for (; at < drafts_.size() && drafts_[at].step == step && drafts_[at].release == release;
             ++at)
            if (!drafts_[at].dead) plan_.barriers[kept++] = plan_.barriers[at];
        return std::pair{first, kept - first};
    };
    const auto steps = static_cast<std::uint32_t>(plan_.steps.size());
    for (std::uint32_t i = 0; i < steps; ++i) {
        Step& step = plan_.steps[i];
        std::tie(step.first_barrier, step.barrier_count) = take(i, false);
        std::tie(step.first_release, step.release_count) = take(i, true);
    }
    std::tie(plan_.first_exit_barrier, plan_.exit_barrier_count) = take(steps, false);
    plan_.barriers.resize(kept);
}

} // namespace ockham::sync

namespace ockham {

void synchronize(const Declaration& declaration, const Pieces& pieces,
    const Capabilities& capabilities, const Policy& policy, Plan& plan) {
    sync::Synchronizer(declaration, pieces, capabilities, policy, plan).run();
}

} // namespace ockham
