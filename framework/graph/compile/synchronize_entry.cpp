// SPDX-License-Identifier: Apache-2.0
// In which state an execution finds what the caller, or the execution before, has left.
#include "framework/graph/compile/synchronizer.hpp"

#include <algorithm>

namespace ockham::sync {

void Synchronizer::begin() {
    plan_.usages.assign(flags_.size(), 0);
    for (ResourceId id = 0; id < flags_.size(); ++id) {
        const ResourceDecl& resource = declaration_.resources[id];
        std::uint8_t flags = resource.kind == ResourceKind::image ? kImage : 0;
        if (resource.exported) flags |= kExported;
        if (!plan_.concurrent.empty() && plan_.concurrent[id]) flags |= kConcurrent;
        if (resource.lifetime == Lifetime::transient) flags |= kTransient;
        if (resource.lifetime == Lifetime::external) flags |= kExternal;
        if (resource.lifetime == Lifetime::persistent) {
            flags |= kPersistent;
            rounds_ = std::max(rounds_, resource.history_depth + 1);
            Tail zero; // at first, and visible to all
            zero.seen_stages = ~VkPipelineStageFlags2{0};
            zero.seen_access = ~VkAccessFlags2{0};
            std::fill_n(tails_.begin() + pieces_.first(id), pieces_.count(id), zero);
        }
        flags_[id] = flags;
        if (flags & kExternal)
            std::fill_n(
                tails_.begin() + pieces_.first(id), pieces_.count(id), entry_of(resource, flags));
    }
}

Tail Synchronizer::entry_of(const ResourceDecl& resource, std::uint8_t flags) {
    Tail tail;
    tail.used = resource.entry;
    if (!(flags & kImage)) tail.used.layout = VK_IMAGE_LAYOUT_UNDEFINED;
    tail.stages = resource.entry.stages;
    tail.written = resource.entry.access & kWriteAccess;
    tail.flushed = tail.written == 0;
    tail.family = resource.entry.queue_family;
    if (tail.flushed) {
        // Who read it saw what it holds; if nobody did, everybody may.
        const bool all = tail.stages == 0;
        tail.seen_stages = all ? ~VkPipelineStageFlags2{0} : tail.stages;
        tail.seen_access = all ? ~VkAccessFlags2{0} : resource.entry.access;
    }
    return tail;
}

void Synchronizer::meet_rest(ResourceId id, const Next& next) {
    const PieceId first = pieces_.first(id);
    for (PieceId piece = first; piece < first + pieces_.count(id); ++piece) {
        Tail& tail = tails_[piece];
        if (tail.started) continue;
        meet_caller(tail, next);
        if (tail.family == VK_QUEUE_FAMILY_IGNORED || tail.family == family_of(next.queue)) {
            settle(tail, next);
        } else {
            take_over(piece, id, tail, next);
            tail.started = true; // the exit follows the acquire
        }
        tail.pass = kNone; // nobody has used it yet
    }
    flags_[id] |= kMet;
}

void Synchronizer::meet_caller(Tail& tail, const Next& next) const {
    tail.queue = static_cast<std::uint8_t>(next.queue);
    if (queues_.empty() || queues_[next.queue].graphics) return;
    constexpr VkPipelineStageFlags2 any =
        VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT |
        VK_PIPELINE_STAGE_2_COPY_BIT | VK_PIPELINE_STAGE_2_CLEAR_BIT |
        VK_PIPELINE_STAGE_2_HOST_BIT | VK_PIPELINE_STAGE_2_TOP_OF_PIPE_BIT |
        VK_PIPELINE_STAGE_2_BOTTOM_OF_PIPE_BIT;
    constexpr VkPipelineStageFlags2 compute =
        VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT;
    tail.stages &= any | (queues_[next.queue].compute ? compute : 0);
    if (tail.stages) return;
    tail.written = 0;
    tail.flushed = true;
    tail.seen_stages = ~VkPipelineStageFlags2{0};
    tail.seen_access = ~VkAccessFlags2{0};
}

void Synchronizer::settle_kept() {
    for (std::uint32_t round = 0; round < rounds_; ++round) {
        walk(kPersistent);
        leave(kPersistent);
        turn();
    }
}

void Synchronizer::turn() {
    std::vector<Tail> tails = tails_;
    std::vector<Read> reads;
    for (ResourceId id = 0; id < flags_.size(); ++id) {
        if (!(flags_[id] & kPersistent)) continue;
        const PieceId from = pieces_.first(source_of(id)), to = pieces_.first(id);
        for (std::uint32_t i = 0; i < pieces_.count(id); ++i)
            tails[to + i] = before(tails_[from + i], reads);
    }
    tails_ = std::move(tails);
    reads_ = std::move(reads);
    plan_.barriers.clear();
    drafts_.clear();
    pasts_.clear();
}

ResourceId Synchronizer::source_of(ResourceId id) const {
    const std::uint32_t depth = declaration_.resources[id].history_depth;
    if (depth == 0) return id;
    const std::uint32_t age = declaration_.resources[id].history_age;
    const ResourceId first = id - age;
    for (ResourceId other = first; other <= first + depth; ++other)
        if (plan_.resources[other].culled) return id; // it does not turn
    return age == 0 ? first + depth : id - 1;
}

Tail Synchronizer::before(Tail tail, std::vector<Read>& reads) const {
    if (tail.barrier != kNone) {
        const Barrier& barrier = plan_.barriers[tail.barrier];
        // Both, where that is all stages with all accesses again.
        const bool same_stages = tail.seen_stages == barrier.dst_stages;
        const bool same_access = tail.seen_access == barrier.dst_access;
        tail.seen_stages = barrier.dst_stages | (same_access ? tail.seen_stages : 0);
        tail.seen_access = barrier.dst_access | (same_stages ? tail.seen_access : 0);
    }
    tail.barrier = kNone;
    tail.pass = kNone;
    tail.step = kNone;
    tail.started = false;
    tail.when -= period_of(plan_);
    std::uint32_t next = tail.reads;
    std::uint32_t* link = &tail.reads;
    std::size_t at = 0;
    for (; next != kNone; next = reads_[next].before) {
        *link = static_cast<std::uint32_t>(reads.size());
        reads.push_back(reads_[next]);
        reads.back().past.when -= period_of(plan_);
        at = reads.size() - 1;
        link = &reads[at].before;
    }
    *link = kNone;
    return tail;
}

void Synchronizer::hand_memory_over() {
    if (firsts_.empty()) return;
    const Owners owners(plan_);
    for (const First& first : firsts_) {
        Barrier& barrier = plan_.barriers[first.draft];
        Draft& draft = drafts_[first.draft];
        const bool image = flags_[barrier.resource] & kImage;
        draft.first_past = static_cast<std::uint32_t>(pasts_.size());
        for (const Owner& owner : owners.of(barrier.resource))
            take_memory(owner, first, barrier, draft);
        draft.past_count = static_cast<std::uint32_t>(pasts_.size()) - draft.first_past;
        if (image) {
            if (!barrier.src_stages) {
                Next next;
                next.state.stages = barrier.dst_stages;
                next.submission = first.submission;
                barrier.src_stages = after_waits(next);
            }
        } else {
            draft.light = true;
            draft.dead = draft.past_count == 0;
            if (barrier.src_access == 0) barrier.dst_access = 0;
        }
    }
}

void Synchronizer::take_memory(
    const Owner& owner, const First& first, Barrier& barrier, Draft& draft) {
    const Time shift = owner.before ? -period_of(plan_) : 0;
    const bool self = owner.resource == barrier.resource;
    if (!self) barrier.hazard = Hazard::alias;
    const PieceId begin = pieces_.first(owner.resource);
    for (PieceId piece = begin; piece < begin + pieces_.count(owner.resource); ++piece) {
        const Tail& tail = tails_[piece];
        if (!tail.started || (self && piece != draft.piece)) continue;
        const bool arrived = arrivals_.covers(first.submission, tail.queue, tail.when + shift);
        const VkAccessFlags2 unavailable = arrived ? 0 : tail.unavailable();
        barrier.src_stages |= add_pasts(tail, first.submission, first.queue, unavailable != 0,
            shift, unavailable ? write_of(piece, owner.before) : kNone);
        barrier.src_access |= unavailable;
        const Time when = time_of(tail.step);
        if (!owner.before && when > draft.from_when) {
            draft.from_when = when;
            barrier.from = tail.pass;
        }
    }
}

} // namespace ockham::sync
