// SPDX-License-Identifier: Apache-2.0
// The barriers between two uses of a piece.
#include "framework/graph/compile/synchronizer.hpp"

namespace ockham::sync {

VkPipelineStageFlags2 Synchronizer::add_pasts(const Tail& tail, std::uint32_t submission,
    std::uint32_t queue, bool content, Time shift, std::uint32_t write) {
    VkPipelineStageFlags2 stages = 0;
    const auto add = [&](Past past) {
        past.when += shift;
        // What other queues did is waited for by semaphores only.
        if (past.stages == 0 || past.queue != queue ||
            arrivals_.covers(submission, past.queue, past.when))
            return;
        stages |= past.stages;
        pasts_.push_back(past);
    };
    if (content || tail.reads == kNone) add({tail.stages, tail.when, tail.queue, write});
    for (std::uint32_t read = tail.reads; read != kNone; read = reads_[read].before)
        add(reads_[read].past);
    return stages;
}

std::uint32_t Synchronizer::draft(
    PieceId piece, ResourceId id, const Tail& tail, const Next& next, Relation relation) {
    Draft draft{.piece = piece, .step = next.step};
    draft.first_past = static_cast<std::uint32_t>(pasts_.size());
    draft.from_when = tail.step == kNone ? 0 : time_of(tail.step);
    Barrier barrier = barrier_to(id, tail, next);
    const bool reads_only = !next.written && !relation.changes;
    barrier.src_access = relation.arrived ? 0 : tail.unavailable();
    if (reads_only && !relation.arrived && tail.queue == next.queue) {
        // Flushed before or not: naming the write again needs no chain to who did it.
        barrier.src_stages = tail.stages;
        barrier.src_access = tail.written;
        pasts_.push_back({tail.stages, tail.when, tail.queue});
    } else if (!reads_only) {
        barrier.src_stages = add_pasts(tail, next.submission, next.queue, barrier.src_access != 0);
    }
    draft.past_count = static_cast<std::uint32_t>(pasts_.size()) - draft.first_past;
    draft.light = !relation.changes && relation.seen && barrier.src_access == 0;
    if (draft.light) {
        if (draft.past_count == 0) return kNone;
        barrier.dst_access = 0;
    }
    if (barrier.src_stages == 0 && (tail.stages != 0 || tail.reads != kNone))
        barrier.src_stages = after_waits(next);
    if (relation.changes && next.discards)
        barrier.old_layout = VK_IMAGE_LAYOUT_UNDEFINED; // it need not survive the transition
    barrier.hazard = hazard_of(tail, next);
    return add(barrier, draft);
}

VkPipelineStageFlags2 Synchronizer::after_waits(const Next& next) const {
    if (arrivals_.one_queue()) return 0;
    const VkPipelineStageFlags2 mask = arrivals_.stages(next.submission);
    return has_stages(mask, next.state.stages) ? next.state.stages : mask;
}

Hazard Synchronizer::hazard_of(const Tail& tail, const Next& next) {
    if (next.pass == kNone) return Hazard::exit;
    if (tail.used.stages == 0 && tail.used.layout == VK_IMAGE_LAYOUT_UNDEFINED)
        return Hazard::first_use;
    const bool read = tail.reads != kNone || !(tail.used.access & kWriteAccess);
    if (!read) return next.needs ? Hazard::read_after_write : Hazard::write_after_write;
    if (next.written) return Hazard::write_after_read;
    return tail.used.layout == next.state.layout ? Hazard::read_after_write : Hazard::layout;
}

Barrier Synchronizer::barrier_to(ResourceId id, const Tail& tail, const Next& next) const {
    Barrier barrier;
    barrier.resource = id;
    barrier.from = tail.pass;
    barrier.to = next.pass;
    barrier.dst_stages = next.state.stages;
    barrier.dst_access = next.state.access;
    barrier.old_layout = tail.used.layout;
    barrier.new_layout = next.state.layout;
    return barrier;
}

std::uint32_t Synchronizer::add(const Barrier& barrier, const Draft& draft) {
    plan_.barriers.push_back(barrier);
    drafts_.push_back(draft);
    return static_cast<std::uint32_t>(drafts_.size() - 1);
}

void Synchronizer::begin_anew(PieceId piece, ResourceId id, Tail& tail, const Next& next) {
    Barrier barrier = barrier_to(id, tail, next);
    barrier.hazard = Hazard::first_use;
    firsts_.push_back(
        {add(barrier, {.piece = piece, .step = next.step}), next.submission, next.queue});
    leave_tail(tail, next, kNone);
}

void Synchronizer::take_over(PieceId piece, ResourceId id, Tail& tail, const Next& next) {
    const std::uint32_t from = tail.family, to = family_of(next.queue);
    if (tail.step != kNone) release(piece, id, tail, next, to); // else the caller does
    Barrier barrier = barrier_to(id, tail, next);
    barrier.hazard = Hazard::acquire;
    barrier.src_family = from;
    barrier.dst_family = to;
    barrier.src_stages = after_waits(next);
    if (!barrier.src_stages) barrier.src_stages = next.state.stages;
    const std::uint32_t index = add(barrier, {.piece = piece, .step = next.step});
    leave_tail(tail, next, next.written ? kNone : index);
}

void Synchronizer::release(
    PieceId piece, ResourceId id, const Tail& tail, const Next& next, std::uint32_t family) {
    Draft draft{.piece = piece, .step = tail.step, .release = true};
    draft.first_past = static_cast<std::uint32_t>(pasts_.size());
    Barrier barrier = barrier_to(id, tail, next);
    barrier.hazard = Hazard::release;
    const bool arrived = arrivals_.covers(tail.submission, tail.queue, tail.when);
    barrier.src_access = arrived ? 0 : tail.unavailable();
    barrier.src_stages = add_pasts(tail, tail.submission, tail.last_queue, barrier.src_access != 0);
    if (!barrier.src_stages && arrived) barrier.src_stages = tail.used.stages; // behind waits
    barrier.dst_stages = barrier.dst_access = 0;
    barrier.src_family = tail.family;
    barrier.dst_family = family;
    draft.past_count = static_cast<std::uint32_t>(pasts_.size()) - draft.first_past;
    has_releases_ = true;
    add(barrier, draft);
}

} // namespace ockham::sync
