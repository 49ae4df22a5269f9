// SPDX-License-Identifier: Apache-2.0
// Walks over the steps and drafts a barrier wherever the next use of a piece needs one. Which of
// those that only order execution are needed, prune() says; last, those of neighbours are merged.
#include "framework/graph/arrivals.hpp"
#include "framework/graph/drafts.hpp"
#include "framework/graph/owners.hpp"
#include "framework/graph/phases.hpp"

#include <algorithm>
#include <array>
#include <tuple>

namespace ockham {

namespace {

constexpr VkAccessFlags2 kWriteAccess =
    VK_ACCESS_2_SHADER_WRITE_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT |
    VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT |
    VK_ACCESS_2_TRANSFER_WRITE_BIT | VK_ACCESS_2_HOST_WRITE_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;

/// What the walk asks about a resource, in one byte.
enum : std::uint8_t {
    kImage = 1,
    kTransient = 2,
    kExternal = 4,
    kPersistent = 8,
    kConcurrent = 16,
    kExported = 32,
    kMet = 64, ///< external, and used before in this execution
};

/// How a piece was left. Its content dates from a write, or from the layout transition that let
/// readers in.
struct Tail {
    VkPipelineStageFlags2 stages = 0; ///< that made the content; of a transition: that wait for it
    VkAccessFlags2 written = 0;       ///< by which accesses; 0 for transitions
    /// Where else it is visible than through `barrier`.
    VkPipelineStageFlags2 seen_stages = 0;
    VkAccessFlags2 seen_access = 0;
    AccessState used; ///< by the write, or by all reads since
    Time when = 0;    ///< of the content
    /// The barrier that let the first readers in; a read in another stage extends it. kNone if
    /// there was none in this execution.
    std::uint32_t barrier = kNone;
    std::uint32_t reads = kNone; ///< since then: the newest
    PassId pass = kNone;         ///< the last that used it, in this execution
    std::uint32_t step = kNone;  ///< its step,
    std::uint32_t submission = 0;
    std::uint32_t family = VK_QUEUE_FAMILY_IGNORED; ///< that owns it; IGNORED: whoever comes
    std::uint8_t queue = 0, barrier_queue = 0, last_queue = 0;
    bool flushed = true;  ///< what was written is available
    bool started = false; ///< used in this execution
    bool known = false;   ///< used in any

    VkAccessFlags2 unavailable() const { return flushed ? 0 : written; }
};

/// Uses since the content was made, newest first, one for each run of equal stages.
struct Read {
    Past past;
    std::uint32_t before = kNone;
};

/// The next use of a piece, or its exit.
struct Next {
    AccessState state;
    PassId pass = kNone;
    std::uint32_t step = 0;
    std::uint32_t submission = 0;
    std::uint32_t queue = 0;
    bool written = false;
    bool needs = false;    ///< content before it
    bool discards = false; ///< all content before it, in every execution
};

/// Accesses by their meaning, so that the walk looks up instead of asking.
struct Meaning {
    AccessState state;
    bool written = false;
    std::uint32_t usage[2] = {}; ///< of buffers, of images
};
constexpr std::size_t kAccesses = static_cast<std::size_t>(Access::host_read) + 1;
constexpr std::size_t kShaderStages = static_cast<std::size_t>(Stage::fixed) + 1;

const Meaning& meaning_of(const Use& use) {
    static const auto table = [] {
        std::array<Meaning, kAccesses * kShaderStages> rows;
        for (std::size_t i = 0; i < rows.size(); ++i) {
            const auto access = static_cast<Access>(i / kShaderStages);
            rows[i] = {state_of(access, static_cast<Stage>(i % kShaderStages)), writes(access),
                {buffer_usage(access), image_usage(access)}};
        }
        return rows;
    }();
    return table[static_cast<std::size_t>(use.access) * kShaderStages +
                 static_cast<std::size_t>(use.stage)];
}

bool contains(std::uint64_t set, std::uint64_t subset) { return (subset & ~set) == 0; }

class Synchronizer {
public:
    Synchronizer(const Declaration& declaration, const Pieces& pieces,
        const Capabilities& capabilities, const Policy& policy, Plan& plan)
        : declaration_(declaration), pieces_(pieces), policy_(policy), plan_(plan), arrivals_(plan),
          tails_(pieces.count()), flags_(declaration.resources.size()) {
        for (const PlanQueue& queue : plan.queues)
            queues_.push_back(capabilities.families.empty() ? QueueFamily{}
                                                            : capabilities.families[queue.family]);
    }

    void run() {
        plan_.barriers.reserve(2 * plan_.steps.size());
        drafts_.reserve(2 * plan_.steps.size());
        begin();
        settle_kept();
        walk(0);
        leave(0);
        set_final_states();
        hand_memory_over();
        finish();
    }

private:
    // ---- What is there before the execution

    void begin() {
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
            }
            flags_[id] = flags;
            if (flags & kExternal)
                std::fill_n(tails_.begin() + pieces_.first(id), pieces_.count(id),
                    entry_of(resource, flags));
        }
    }

    static Tail entry_of(const ResourceDecl& resource, std::uint8_t flags) {
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

    /// The caller hands a resource over as a whole, where the first of its pieces is used.
    void meet_rest(ResourceId id, const Next& next) {
        const PieceId first = pieces_.first(id);
        for (PieceId piece = first; piece < first + pieces_.count(id); ++piece) {
            Tail& tail = tails_[piece];
            if (tail.started) continue;
            meet_caller(tail, next);
            if (tail.family == VK_QUEUE_FAMILY_IGNORED || tail.family == family_of(next.queue))
                settle(tail, next);
            else
                take_over(piece, id, tail, next);
        }
        flags_[id] |= kMet;
    }

    /// What the caller did is waited for where the piece is first used. For stages that this queue
    /// does not have, the caller has waited.
    void meet_caller(Tail& tail, const Next& next) const {
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

    /// How one execution leaves persistent resources is how the next finds them; of a history, the
    /// next age does. Found by executing them, without effect, until it is settled.
    void settle_kept() {
        for (std::uint32_t round = 0; round < rounds_; ++round) {
            walk(kPersistent);
            leave(kPersistent);
            turn();
        }
    }

    void turn() {
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

    /// Whose state the resource has on entry.
    ResourceId source_of(ResourceId id) const {
        const std::uint32_t depth = declaration_.resources[id].history_depth;
        if (depth == 0) return id;
        const std::uint32_t age = declaration_.resources[id].history_age;
        const ResourceId first = id - age;
        for (ResourceId other = first; other <= first + depth; ++other)
            if (plan_.resources[other].culled) return id; // it does not turn
        return age == 0 ? first + depth : id - 1;
    }

    /// The same tail, seen from the next execution.
    Tail before(Tail tail, std::vector<Read>& reads) const {
        if (tail.barrier != kNone) {
            tail.seen_stages = plan_.barriers[tail.barrier].dst_stages;
            tail.seen_access = plan_.barriers[tail.barrier].dst_access;
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

    // ---- The walk

    /// Over uses of resources with all of these flags.
    void walk(std::uint8_t which) {
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

    void set_use(Next& next, const Use& use, bool always) const {
        const Meaning& meaning = meaning_of(use);
        next.state = meaning.state;
        if (!(flags_[use.resource] & kImage)) next.state.layout = VK_IMAGE_LAYOUT_UNDEFINED;
        next.written = meaning.written;
        next.needs = needs_content(use);
        next.discards = always && replaces_content(use);
    }

    void touch(PieceId piece, ResourceId id, const Next& next) {
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
        const bool moves = tail.family != family && tail.family != VK_QUEUE_FAMILY_IGNORED &&
                           !(flags & kConcurrent);
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

    std::uint32_t family_of(std::uint32_t queue) const {
        return plan_.queues.empty() ? 0 : plan_.queues[queue].family;
    }

    /// Whether the content is visible to what `next` reads.
    bool sees(const Tail& tail, const Next& next, bool arrived) const {
        const VkAccessFlags2 access = next.state.access & ~kWriteAccess;
        const VkPipelineStageFlags2 stages = next.state.stages;
        if (access == 0 || !next.needs) return true;
        if (arrived && has_stages(arrivals_.stages(next.submission), stages)) return true;
        if (tail.barrier != kNone && tail.barrier_queue == next.queue) {
            const Barrier& barrier = plan_.barriers[tail.barrier];
            if (contains(barrier.dst_stages, stages) && contains(barrier.dst_access, access))
                return true;
        }
        return tail.flushed && contains(tail.seen_stages, stages) &&
               contains(tail.seen_access, access);
    }
    static bool has_stages(VkPipelineStageFlags2 mask, VkPipelineStageFlags2 stages) {
        return mask & VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT || contains(mask, stages);
    }

    void leave_tail(Tail& tail, const Next& next, std::uint32_t barrier) {
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

    void add_read(Tail& tail, const Next& next) {
        if (tail.reads == kNone) {
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

    void settle(Tail& tail, const Next& next) const {
        tail.pass = next.pass;
        tail.step = next.step;
        tail.submission = next.submission;
        tail.last_queue = static_cast<std::uint8_t>(next.queue);
        tail.family = family_of(next.queue);
    }

    // ---- Drafts

    /// What must be waited for before the piece may be used otherwise: the reads, unless there are
    /// none the content too, or where it is not available. Without what the submission has seen
    /// completed.
    VkPipelineStageFlags2 add_pasts(const Tail& tail, std::uint32_t submission, std::uint32_t queue,
        bool content, Time shift = 0, std::uint32_t write = kNone) {
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

    struct Relation {
        bool changes = false; ///< the layout
        bool seen = false;    ///< the content, by what reads it next
        bool arrived = false; ///< by a semaphore
    };

    /// Drafts what orders `next` behind the tail; kNone if there is nothing to wait for.
    std::uint32_t draft(
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
            barrier.src_stages =
                add_pasts(tail, next.submission, next.queue, barrier.src_access != 0);
        }
        draft.past_count = static_cast<std::uint32_t>(pasts_.size()) - draft.first_past;
        draft.light = !relation.changes && relation.seen && barrier.src_access == 0;
        if (draft.light) {
            if (draft.past_count == 0) return kNone;
            barrier.dst_access = 0;
        }
        if (barrier.src_stages == 0 && tail.stages != 0) barrier.src_stages = after_waits(next);
        if (relation.changes && next.discards)
            barrier.old_layout = VK_IMAGE_LAYOUT_UNDEFINED; // it need not survive the transition
        barrier.hazard = hazard_of(tail, next);
        return add(barrier, draft);
    }

    /// A stage behind the semaphores that the submission waited for.
    VkPipelineStageFlags2 after_waits(const Next& next) const {
        if (arrivals_.one_queue()) return 0;
        const VkPipelineStageFlags2 mask = arrivals_.stages(next.submission);
        return has_stages(mask, next.state.stages) ? next.state.stages : mask;
    }

    static Hazard hazard_of(const Tail& tail, const Next& next) {
        if (next.pass == kNone) return Hazard::exit;
        if (tail.used.stages == 0 && tail.used.layout == VK_IMAGE_LAYOUT_UNDEFINED)
            return Hazard::first_use;
        const bool read = tail.reads != kNone || !(tail.used.access & kWriteAccess);
        if (!read) return next.needs ? Hazard::read_after_write : Hazard::write_after_write;
        if (next.written) return Hazard::write_after_read;
        return tail.used.layout == next.state.layout ? Hazard::read_after_write : Hazard::layout;
    }

    Barrier barrier_to(ResourceId id, const Tail& tail, const Next& next) const {
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

    std::uint32_t add(const Barrier& barrier, const Draft& draft) {
        plan_.barriers.push_back(barrier);
        drafts_.push_back(draft);
        return static_cast<std::uint32_t>(drafts_.size() - 1);
    }

    /// The first use of what has no content yet. Whose memory it takes over is known at the end.
    void begin_anew(PieceId piece, ResourceId id, Tail& tail, const Next& next) {
        Barrier barrier = barrier_to(id, tail, next);
        barrier.hazard = Hazard::first_use;
        firsts_.push_back(
            {add(barrier, {.piece = piece, .step = next.step}), next.submission, next.queue});
        leave_tail(tail, next, kNone);
    }

    /// Gets the piece, content included, from the queue family that owns it.
    void take_over(PieceId piece, ResourceId id, Tail& tail, const Next& next) {
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

    /// Gives it up behind the last step that used it.
    void release(
        PieceId piece, ResourceId id, const Tail& tail, const Next& next, std::uint32_t family) {
        Draft draft{.piece = piece, .step = tail.step, .release = true};
        draft.first_past = static_cast<std::uint32_t>(pasts_.size());
        Barrier barrier = barrier_to(id, tail, next);
        barrier.hazard = Hazard::release;
        const bool arrived = arrivals_.covers(tail.submission, tail.queue, tail.when);
        barrier.src_access = arrived ? 0 : tail.unavailable();
        barrier.src_stages =
            add_pasts(tail, tail.submission, tail.last_queue, barrier.src_access != 0);
        if (!barrier.src_stages && arrived) barrier.src_stages = tail.used.stages; // behind waits
        barrier.dst_stages = barrier.dst_access = 0;
        barrier.src_family = tail.family;
        barrier.dst_family = family;
        draft.past_count = static_cast<std::uint32_t>(pasts_.size()) - draft.first_past;
        has_releases_ = true;
        add(barrier, draft);
    }

    // ---- The end of the execution

    /// External resources go into the state that was promised; kept images whose pieces are in
    /// several layouts into one.
    void leave(std::uint8_t which) {
        const bool some = !pieces_.whole();
        for (ResourceId id = 0; id < flags_.size(); ++id) {
            if (!contains(flags_[id], which)) continue;
            if (flags_[id] & kExternal)
                exit(id);
            else if (some && (flags_[id] & kImage) && (flags_[id] & (kPersistent | kExported)) &&
                     pieces_.count(id) > 1)
                unify(id);
        }
    }

    Next at_exit(const AccessState& state) const {
        Next next;
        next.state = state;
        next.step = static_cast<std::uint32_t>(plan_.steps.size());
        if (!plan_.submissions.empty())
            next.submission = static_cast<std::uint32_t>(plan_.submissions.size() - 1);
        next.written = (state.access & kWriteAccess) != 0;
        next.needs = true;
        return next;
    }

    void exit(ResourceId id) {
        if (!(flags_[id] & kMet)) return;
        const ResourceDecl& resource = declaration_.resources[id];
        const bool image = flags_[id] & kImage;
        const bool stays = resource.exit.layout == VK_IMAGE_LAYOUT_UNDEFINED || !image;
        const std::uint32_t to = resource.exit.queue_family;
        if (stays && image && pieces_.count(id) > 1) unify(id);
        if (stays && resource.exit.stages == 0 && to == VK_QUEUE_FAMILY_IGNORED) return;
        const PieceId first = pieces_.first(id);
        for (PieceId piece = first; piece < first + pieces_.count(id); ++piece) {
            Tail& tail = tails_[piece];
            Next next = at_exit(resource.exit);
            if (stays) next.state.layout = tail.used.layout;
            const bool changes = tail.used.layout != next.state.layout;
            if (to != VK_QUEUE_FAMILY_IGNORED && to != tail.family)
                give_back(piece, id, tail, next, to);
            else if (to != VK_QUEUE_FAMILY_IGNORED && to != family_of(0))
                settle_there(piece, id, tail, next); // semaphores do the rest
            else if (changes || (tail.started && resource.exit.stages))
                touch(piece, id, next);
            tail.used = next.state;
        }
    }

    /// To the caller's queue family, who does the other half.
    void give_back(
        PieceId piece, ResourceId id, Tail& tail, const Next& next, std::uint32_t family) {
        const bool here = tail.family == family_of(0); // with the other exit barriers
        if (here) {
            tail.submission = next.submission;
            tail.last_queue = 0;
        }
        release(piece, id, tail, next, family);
        if (here) {
            drafts_.back().step = next.step;
            drafts_.back().release = false;
        }
        tail.family = family;
    }

    /// Into the exit layout, behind the last step that used it.
    void settle_there(PieceId piece, ResourceId id, const Tail& tail, const Next& next) {
        if (tail.used.layout == next.state.layout) return;
        release(piece, id, tail, next, tail.family);
        Barrier& barrier = plan_.barriers.back();
        barrier.hazard = Hazard::exit;
        barrier.src_family = barrier.dst_family = VK_QUEUE_FAMILY_IGNORED;
    }

    /// Of the pieces that this execution uses; UNDEFINED if it uses none.
    VkImageLayout most_common_layout(ResourceId id) const {
        const PieceId first = pieces_.first(id), end = first + pieces_.count(id);
        VkImageLayout best = VK_IMAGE_LAYOUT_UNDEFINED;
        std::ptrdiff_t most = 0;
        for (PieceId piece = first; piece < end; ++piece) {
            const VkImageLayout layout = tails_[piece].used.layout;
            const std::ptrdiff_t count = std::count_if(tails_.begin() + first, tails_.begin() + end,
                [&](const Tail& tail) { return tail.started && tail.used.layout == layout; });
            if (count > most) {
                most = count;
                best = layout;
            }
        }
        return best;
    }

    /// All pieces into one layout, so that the resource as a whole has one.
    void unify(ResourceId id) {
        const PieceId first = pieces_.first(id), end = first + pieces_.count(id);
        const VkImageLayout layout = most_common_layout(id);
        if (layout == VK_IMAGE_LAYOUT_UNDEFINED) return;
        AccessState state; // as the others in that layout were used
        for (PieceId piece = first; piece < end; ++piece)
            if (tails_[piece].started && tails_[piece].used.layout == layout) {
                state.stages |= tails_[piece].used.stages;
                state.access |= tails_[piece].used.access & ~kWriteAccess;
            }
        state.layout = layout;
        const Next next = at_exit(state);
        // What is never used comes in the layout in which the resource is left, or another age.
        const bool all = (flags_[id] & kExternal) || source_of(id) != id;
        for (PieceId piece = first; piece < end; ++piece)
            if (tails_[piece].used.layout != layout && (tails_[piece].known || all))
                touch(piece, id, next);
    }

    void set_final_states() {
        plan_.final_states.assign(flags_.size(), {});
        for (ResourceId id = 0; id < flags_.size(); ++id) {
            AccessState& state = plan_.final_states[id];
            bool used = false;
            for (PieceId piece = pieces_.first(id), end = piece + pieces_.count(id); piece < end;
                 ++piece) {
                const Tail& tail = tails_[piece];
                if (!tail.known) continue;
                used = true;
                state.stages |= tail.used.stages;
                state.access |= tail.used.access;
                state.layout = tail.used.layout;
                state.queue_family = tail.used.queue_family;
            }
            if (!used) continue;
            const bool image = flags_[id] & kImage;
            const auto both = [&](VkFlags of_image, VkFlags of_buffer) {
                plan_.usages[id] |= image ? of_image : of_buffer;
            };
            if (flags_[id] & (kExported | kPersistent))
                both(VK_IMAGE_USAGE_TRANSFER_SRC_BIT, VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
            if (flags_[id] & kPersistent)
                both(VK_IMAGE_USAGE_TRANSFER_DST_BIT, VK_BUFFER_USAGE_TRANSFER_DST_BIT);
        }
        for (ResourceId id = 0; id < flags_.size(); ++id)
            if ((flags_[id] & kPersistent) && source_of(id) != id) {
                // Ages change places, so they are created alike.
                const ResourceId first = id - declaration_.resources[id].history_age;
                plan_.usages[first] |= plan_.usages[id];
                plan_.usages[id] |= plan_.usages[first];
            }
        for (ResourceId id = 0; id < flags_.size(); ++id)
            if ((flags_[id] & kPersistent) && source_of(id) != id)
                plan_.usages[id] = plan_.usages[id - declaration_.resources[id].history_age];
    }

    // ---- Memory handed over

    struct First {
        std::uint32_t draft = kNone;
        std::uint32_t submission = 0, queue = 0;
    };

    /// First uses wait for those who used the memory before.
    void hand_memory_over() {
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

    void take_memory(const Owner& owner, const First& first, Barrier& barrier, Draft& draft) {
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

    // ---- The plan's barriers

    void finish() {
        const bool batched = policy_.order == Order::batched;
        if (batched) gather(plan_, drafts_, pasts_);
        if (has_releases_ || batched) sort();
        if (!pieces_.whole()) merge();
        prune(plan_, drafts_, pasts_);
        const auto steps = static_cast<std::uint32_t>(plan_.steps.size());
        std::uint32_t kept = 0, at = 0;
        const auto take = [&](std::uint32_t step, bool release) {
            const std::uint32_t first = kept;
            for (;
                 at < drafts_.size() && drafts_[at].step == step && drafts_[at].release == release;
                 ++at) {
                if (drafts_[at].dead) continue;
                if (kept != at) plan_.barriers[kept] = plan_.barriers[at];
                if (pieces_.whole()) plan_.barriers[kept].part = pieces_.part_of(drafts_[at].piece);
                ++kept;
            }
            return std::pair{first, kept - first};
        };
        for (std::uint32_t i = 0; i < steps; ++i) {
            Step& step = plan_.steps[i];
            std::tie(step.first_barrier, step.barrier_count) = take(i, false);
            std::tie(step.first_release, step.release_count) = take(i, true);
        }
        std::tie(plan_.first_exit_barrier, plan_.exit_barrier_count) = take(steps, false);
        plan_.barriers.resize(kept);
    }

    /// By step, releases after the others; else as drafted.
    void sort() {
        std::vector<std::uint32_t> order(drafts_.size());
        for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
        std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
            return std::pair{drafts_[a].step, drafts_[a].release} <
                   std::pair{drafts_[b].step, drafts_[b].release};
        });
        std::vector<Barrier> barriers;
        std::vector<Draft> drafts;
        for (const std::uint32_t i : order) {
            barriers.push_back(plan_.barriers[i]);
            drafts.push_back(drafts_[i]);
        }
        plan_.barriers = std::move(barriers);
        drafts_ = std::move(drafts);
    }

    /// Equal barriers on neighbouring pieces become one.
    void merge() {
        for (std::size_t i = 0; i < drafts_.size(); ++i)
            plan_.barriers[i].part = pieces_.part_of(drafts_[i].piece);
        for (std::size_t first = 0, end = 0; first < drafts_.size(); first = end) {
            for (end = first + 1; end < drafts_.size() &&
                                  drafts_[end].step == drafts_[first].step &&
                                  drafts_[end].release == drafts_[first].release;)
                ++end;
            for (bool again = true; again;) {
                again = false;
                for (std::size_t i = first; i < end; ++i)
                    for (std::size_t k = first; k < i; ++k) again |= join(k, i);
            }
        }
    }

    /// Makes the barrier at `other` part of that at `into`, if they differ in their parts only and
    /// those make one.
    bool join(std::size_t into, std::size_t other) {
        Barrier &a = plan_.barriers[into], &b = plan_.barriers[other];
        Draft &x = drafts_[into], &y = drafts_[other];
        if (a.resource != b.resource || x.dead || y.dead || x.light != y.light) return false;
        Barrier alike = b;
        alike.part = a.part;
        alike.from = a.from;
        if (alike != a || !join(a.part, b.part, flags_[a.resource] & kImage)) return false;
        if (y.from_when > x.from_when) {
            x.from_when = y.from_when;
            a.from = b.from;
        }
        if (x.first_past + x.past_count != y.first_past && y.past_count) { // copy to the end
            const std::uint32_t first = static_cast<std::uint32_t>(pasts_.size());
            for (std::uint32_t i = 0; i < x.past_count; ++i)
                pasts_.push_back(Past(pasts_[x.first_past + i]));
            for (std::uint32_t i = 0; i < y.past_count; ++i)
                pasts_.push_back(Past(pasts_[y.first_past + i]));
            x.first_past = first;
        }
        x.past_count += y.past_count;
        y.dead = true;
        return true;
    }

    static bool join(Part& a, const Part& b, bool image) {
        if (!image) {
            if (a.offset + a.bytes == b.offset)
                a.bytes += b.bytes;
            else if (b.offset + b.bytes == a.offset)
                a = {.offset = b.offset, .bytes = a.bytes + b.bytes};
            else
                return false;
            return true;
        }
        if (a.first_layer == b.first_layer && a.layers == b.layers &&
            a.first_mip + a.mips == b.first_mip) {
            a.mips += b.mips;
            return true;
        }
        if (a.first_mip == b.first_mip && a.mips == b.mips &&
            a.first_layer + a.layers == b.first_layer) {
            a.layers += b.layers;
            return true;
        }
        return false;
    }

    const Declaration& declaration_;
    const Pieces& pieces_;
    const Policy& policy_;
    Plan& plan_;
    const Arrivals arrivals_;
    std::vector<QueueFamily> queues_; ///< per queue of the plan
    std::vector<Tail> tails_;         ///< per piece, as the walk has left it so far
    std::vector<std::uint8_t> flags_; ///< per resource
    std::vector<Read> reads_;
    std::vector<Draft> drafts_; ///< one per element of Plan::barriers
    std::vector<Past> pasts_;
    std::vector<First> firsts_;
    std::uint32_t rounds_ = 0; ///< until histories are settled; 0: nothing is persistent
    std::uint32_t submission_ = 0;
    bool has_releases_ = false;
};

} // namespace

void synchronize(const Declaration& declaration, const Pieces& pieces,
    const Capabilities& capabilities, const Policy& policy, Plan& plan) {
    Synchronizer(declaration, pieces, capabilities, policy, plan).run();
}

} // namespace ockham
