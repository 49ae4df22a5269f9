// SPDX-License-Identifier: Apache-2.0
// The part of verify() that executes the plan in mind, several times back to back. Per piece of a
// resource it keeps the layout, the owner, the last writes with whom they are visible to, and the
// reads since. Guarded passes may have happened or not: both are kept.
#include "framework/graph/verify_clocks.hpp"
#include "framework/graph/words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <utility>

namespace ockham::verifier {

namespace {

using Kind = Violation::Kind;

constexpr std::uint32_t kNobody = VK_QUEUE_FAMILY_IGNORED;
/// Guard of what a former execution did: its answers are not known any more.
constexpr GuardId kMaybe = kNone - 1;

/// An access, or what a barrier does: a layout transition, an acquisition.
struct Event {
    enum class What : std::uint8_t { access, barrier, caller };
    What what = What::access;
    PassId pass = kNone;
    std::uint32_t execution = 0;
    Point at;
    Stages stages = 0; ///< of a barrier: its second scope
    Accesses accesses = 0;
    GuardId guard = kNone;
    /// Who comes after an access waits for all of its stages, after a barrier for any.
    bool any = false;
};

/// Of a write: it is available to whatever waits for this barrier.
struct Availability {
    Point at;
    Stages stages = 0;
};

struct Write : Event {
    std::array<Availability, 4> available{};
    std::uint32_t available_count = 0;
    std::uint32_t queue = 0; ///< that `visible` speaks of
    std::array<Accesses, kStageCount> visible{};

    void add_available(Availability availability) {
        available[available_count % available.size()] = availability;
        available_count =
            std::min(available_count + 1, static_cast<std::uint32_t>(available.size()));
    }
    void add_visible(std::uint32_t on, Stages stages_of_barrier, Accesses accesses_of_barrier) {
        if (queue != on) visible = {};
        queue = on;
        each_bit(
            stages_of_barrier, [&](std::uint32_t stage) { visible[stage] |= accesses_of_barrier; });
    }
};

/// A release that no acquire has answered.
struct Transfer {
    bool pending = false;
    bool by_caller = false;
    std::uint32_t from = kNobody, to = kNobody;
    VkImageLayout old_layout = VK_IMAGE_LAYOUT_UNDEFINED, new_layout = VK_IMAGE_LAYOUT_UNDEFINED;
    Point at;
};

struct Piece {
    VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;
    std::uint32_t owner = kNobody;
    std::uint32_t taken = 0; ///< the execution, from 1, in which memory was surely taken over
    Point transition;        ///< the latest
    Transfer transfer;
    bool content = false;         ///< whatever was answered
    bool lost = false;            ///< content by a transition, and not surely replaced since
    std::vector<GuardId> writers; ///< that gave it content if they consented
    std::vector<Write> writes;
    std::vector<Event> reads;
};

/// Of resources in memory that others may use, too.
struct Tenant {
    const Placement* placement = nullptr;
    std::uint32_t begun = 0;       ///< the execution, from 1, in which it was last used
    ResourceId taken_by = kNone;   ///< since then
    std::vector<ResourceId> under; ///< from whom it took its bytes
};

/// One access to check: by a pass, or by the caller at the end.
struct Accessor {
    PassId pass = kNone;
    GuardId guard = kNone;
    std::uint32_t queue = 0;
    Meaning meaning;
};

class Execution {
public:
    Execution(const Declaration& declaration, const Plan& plan, const Capabilities& capabilities,
        const Grids& grids, Report& report)
        : declaration_(declaration), plan_(plan), grids_(grids), report_(report),
          guards_(declaration), clocks_(plan.queues.size()), pieces_(grids.pieces()),
          tenants_(declaration.resources.size()), first_queue_(declaration.resources.size(), kNone),
          granularity_(std::max<std::uint64_t>(capabilities.buffer_image_granularity, 1)),
          heaps_(plan.heaps.size()) {
        for (const PlanQueue& queue : plan.queues)
            stages_.push_back(
                stages_on(capabilities.families.empty() ? QueueFamily{}
                                                        : capabilities.families[queue.family]));
        meanings_.reserve(declaration.uses.size());
        for (const Use& use : declaration.uses)
            meanings_.push_back(meaning_of(use, declaration.resources[use.resource].kind));
        scopes_.reserve(plan.barriers.size());
        for (const Barrier& barrier : plan.barriers) scopes_.push_back(scopes_of(barrier));
        for (const Placement& placement : plan.placements)
            tenants_[placement.resource].placement = &placement;
        for (const Submission& submission : plan.submissions)
            for (std::uint32_t i = 0; i < submission.step_count; ++i)
                for (const Use& use :
                    declaration.uses_of(plan.steps[submission.first_step + i].pass))
                    if (first_queue_[use.resource] == kNone)
                        first_queue_[use.resource] = submission.queue;
    }

    void run() {
        check_barriers();
        prepare();
        std::uint32_t rounds = 2;
        for (const ResourceDecl& resource : declaration_.resources)
            rounds = std::max(rounds, 2 + resource.history_depth);
        for (execution_ = 1; execution_ <= rounds; ++execution_) {
            enter();
            for (std::size_t i = 0; i < plan_.submissions.size(); ++i) submit(i);
            leave();
        }
    }

private:
    // ---- Text -----------------------------------------------------------------------------------

    static std::string at(Stages stages, Accesses accesses) {
        return stages_text(flags_of(stages)) + "/" + access_text(access_flags_of(accesses));
    }

    std::string text_of(const Event& event) const {
        const char* const when = event.execution < execution_ && event.what != Event::What::caller
                                     ? " in the previous execution"
                                     : "";
        switch (event.what) {
        case Event::What::access:
            return fmt::format("the {} by {} at {}{}", writes_of(event.accesses) ? "write" : "read",
                report_.pass(event.pass), at(event.stages, event.accesses), when);
        case Event::What::barrier:
            return fmt::format(
                "the transition for {}{}", report_.pass(event.pass, "the exit"), when);
        case Event::What::caller:
            break;
        }
        return fmt::format("what the caller did at {}", at(event.stages, event.accesses));
    }

    std::string text_of(const Accessor& accessor, ResourceId id, std::uint32_t piece) const {
        const Meaning& meaning = accessor.meaning;
        return fmt::format("{} {} {} at {}", report_.pass(accessor.pass),
            meaning.writes ? "writes" : "reads", report_.resource(id, grids_.part_of(piece)),
            at(meaning.stages, meaning.accesses));
    }

    std::string text_of(const Barrier& barrier) const {
        return fmt::format("the barrier on {} for {}",
            report_.resource(barrier.resource, barrier.part), report_.pass(pass_, "the exit"));
    }

    /// Adds a violation about a piece; `text` is called only if it is new.
    template <class Text>
    void say(Kind kind, std::uint32_t piece, PassId earlier, PassId later, Text text) {
        Violation violation{kind, grids_.resource_of(piece), {}, earlier, later, {}};
        if (!report_.wants(violation)) return;
        violation.part = grids_.part_of(piece);
        violation.text = text();
        report_.add(std::move(violation));
    }

    // ---- What happens before what ---------------------------------------------------------------

    static bool has(const Row& row, Point point, Stages stages, bool any, std::uint32_t queue) {
        if (row[kStageCount + point.queue] >= point.index) return true; // a semaphore, or long ago
        if (point.queue != queue) return false;
        bool some = false, all = stages != 0;
        each_bit(stages, [&](std::uint32_t stage) {
            const bool reached = row[stage] >= point.index;
            some |= reached;
            all &= reached;
        });
        return any ? some : all;
    }

    /// Whether everything in the scope comes after the event.
    static bool covers(const Row& scope, std::uint32_t queue, const Event& event) {
        return has(scope, event.at, event.stages, event.any, queue);
    }

    static bool is_available(const Row& scope, std::uint32_t queue, const Write& write) {
        if (scope[kStageCount + write.at.queue] >= write.at.index) return true;
        for (std::uint32_t i = 0; i < write.available_count; ++i)
            if (has(scope, write.available[i].at, write.available[i].stages, true, queue))
                return true;
        return false;
    }

    /// The clocks of one stage as a scope: a barrier on the same queue that names the stage
    /// counts, an earlier access in the same stage does not.
    bool waits(std::uint32_t queue, std::uint32_t stage, const Event& event) const {
        return covers(clocks_.rows(queue)[stage], queue, event) ||
               (event.any && event.at.queue == queue && (event.stages >> stage & 1));
    }

    bool is_available(std::uint32_t queue, std::uint32_t stage, const Write& write) const {
        if (is_available(clocks_.rows(queue)[stage], queue, write)) return true;
        for (std::uint32_t i = 0; i < write.available_count; ++i)
            if (write.available[i].at.queue == queue && (write.available[i].stages >> stage & 1))
                return true;
        return false;
    }

    bool can_meet(GuardId a, GuardId b) const {
        return a == kMaybe || b == kMaybe || !guards_.exclude(a, b);
    }

    // ---- Executions -----------------------------------------------------------------------------

    bool is_external(ResourceId id) const {
        return declaration_.resources[id].lifetime == Lifetime::external;
    }
    bool is_image(ResourceId id) const {
        return declaration_.resources[id].kind == ResourceKind::image;
    }
    std::span<Piece> pieces_of(ResourceId id) {
        return {pieces_.data() + grids_.first(id), grids_.count(id)};
    }
    std::uint32_t family_of(std::uint32_t queue) const { return plan_.queues[queue].family; }

    /// What every barrier must be, wherever it stands; the queue is known only when it executes.
    void check_barriers() {
        for (std::size_t i = 0; i < plan_.barriers.size(); ++i) {
            const Barrier& barrier = plan_.barriers[i];
            const Scopes& scopes = scopes_[i];
            const std::uint32_t piece = grids_.first(barrier.resource);
            pass_ = barrier.to;
            if ((scopes.src_access & ~possible_in(scopes.src)) ||
                (scopes.dst_access & ~possible_in(scopes.dst)))
                say(Kind::malformed, piece, barrier.from, barrier.to, [&] {
                    return fmt::format(
                        "{} names an access that none of its stages performs: {} -> {}",
                        text_of(barrier), at(scopes.src, scopes.src_access),
                        at(scopes.dst, scopes.dst_access));
                });
            if ((barrier.src_family == kNobody) != (barrier.dst_family == kNobody))
                say(Kind::malformed, piece, barrier.from, barrier.to, [&] {
                    return fmt::format("{} names one queue family, not both", text_of(barrier));
                });
            if (barrier.new_layout == VK_IMAGE_LAYOUT_UNDEFINED &&
                barrier.old_layout != barrier.new_layout)
                say(Kind::malformed, piece, barrier.from, barrier.to,
                    [&] { return fmt::format("{} leads to layout undefined", text_of(barrier)); });
        }
    }

    /// Persistent resources are zero, in the state in which an execution leaves them.
    void prepare() {
        rotates_.assign(declaration_.resources.size(), 1);
        for (ResourceId id = 0; id < rotates_.size(); ++id)
            if (!tenants_[id].placement) rotates_[id - declaration_.resources[id].history_age] = 0;
        for (ResourceId id = 0; id < rotates_.size(); ++id) {
            const ResourceDecl& resource = declaration_.resources[id];
            if (resource.lifetime != Lifetime::persistent) continue;
            ResourceId left = id; // whose state of the last execution it comes in
            if (rotates(id)) left = resource.history_age ? id - 1 : id + resource.history_depth;
            for (Piece& piece : pieces_of(id)) {
                if (is_image(id)) piece.layout = plan_.final_states[left].layout;
                piece.content = true; // complete, and visible to all
            }
        }
    }

    /// Histories change places where all of their ages have memory.
    bool rotates(ResourceId id) const {
        const ResourceDecl& resource = declaration_.resources[id];
        return resource.history_depth && rotates_[id - resource.history_age];
    }

    /// The caller's resources come as promised; former answers are not known any more.
    void enter() {
        for (Piece& piece : pieces_) {
            for (Write& write : piece.writes)
                if (write.guard != kNone) write.guard = kMaybe;
            for (Event& read : piece.reads)
                if (read.guard != kNone) read.guard = kMaybe;
            piece.writers.clear();
        }
        for (ResourceId id = 0; id < tenants_.size(); ++id)
            if (is_external(id) && first_queue_[id] != kNone) enter(id, first_queue_[id]);
        signals_.assign(plan_.queues.size(), {});
        submitted_.assign(plan_.queues.size(), false);
    }

    void enter(ResourceId id, std::uint32_t queue) {
        const AccessState& entry = declaration_.resources[id].entry;
        const Point now = clocks_.advance(queue);
        // Stages that the queue does not have cannot be waited for there: the caller has done so.
        const Stages stages = stages_of(entry.stages) & stages_[queue];
        const Accesses accesses = accesses_of(entry.access);
        const std::uint32_t family = family_of(queue);
        for (Piece& piece : pieces_of(id)) {
            piece = {};
            piece.layout = is_image(id) ? entry.layout : VK_IMAGE_LAYOUT_UNDEFINED;
            piece.content = !is_image(id) || entry.layout != VK_IMAGE_LAYOUT_UNDEFINED;
            piece.owner = entry.queue_family;
            if (entry.queue_family != kNobody && entry.queue_family != family)
                piece.transfer = {true, true, entry.queue_family, family, entry.layout,
                    VK_IMAGE_LAYOUT_UNDEFINED, {0, 1}};
            if (stages == 0 || piece.transfer.pending) continue; // complete, or by semaphore
            Write& write = piece.writes.emplace_back();
            write.what = Event::What::caller;
            write.execution = execution_;
            write.at = now;
            write.stages = stages;
            write.accesses = accesses;
            write.queue = queue;
            if (writes_of(accesses)) {
                write.accesses = writes_of(accesses);
            } else { // somebody wrote before, and the caller's last accesses saw it
                write.any = true;
                write.add_available({now, stages});
                write.add_visible(queue, stages, accesses);
                piece.reads.push_back(
                    {Event::What::caller, kNone, execution_, now, stages, accesses});
            }
        }
    }

    void submit(std::size_t index) {
        const Submission& submission = plan_.submissions[index];
        const std::uint32_t queue = submission.queue;
        const Stages all = stages_of(VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT);
        if (!submitted_[queue] && !last_signals_.empty())
            for (std::uint32_t other = 0; other < plan_.queues.size(); ++other)
                if (other != queue) clocks_.wait(queue, last_signals_[other], all);
        submitted_[queue] = true;
        for (std::uint32_t i = 0; i < submission.wait_count; ++i) {
            const Wait& wait = plan_.waits[submission.first_wait + i];
            clocks_.wait(queue, signals_[wait.queue][wait.value - 1], stages_of(wait.stages));
        }
        for (std::uint32_t i = 0; i < submission.step_count; ++i)
            execute(plan_.steps[submission.first_step + i], queue);
        if (index + 1 == plan_.submissions.size()) {
            pass_ = kNone;
            batch(plan_.first_exit_barrier, plan_.exit_barrier_count, queue);
        }
        signals_[queue].push_back(clocks_.signal(queue));
    }

    void execute(const Step& step, std::uint32_t queue) {
        pass_ = step.pass;
        batch(step.first_barrier, step.barrier_count, queue);
        const PassDecl& pass = declaration_.passes[step.pass];
        const Point point = clocks_.advance(queue);
        for (std::uint32_t use = pass.first_use; use < pass.first_use + pass.use_count; ++use) {
            const ResourceId id = declaration_.uses[use].resource;
            const Accessor accessor{step.pass, pass.guard, queue, meanings_[use]};
            begin(id, grids_.first(id), step.pass);
            grids_.each(id, grids_.of_use(use),
                [&](std::uint32_t piece) { access(accessor, id, piece, point); });
        }
        batch(step.first_release, step.release_count, queue);
    }

    // ---- Memory that resources share ------------------------------------------------------------

    /// Whose bytes the resource lies on: those that used them last. Buffers and images count as
    /// overlapping where they share a page of the granularity.
    std::vector<ResourceId> owners_below(ResourceId id) const {
        std::vector<ResourceId> owners;
        const Placement* const placement = tenants_[id].placement;
        if (!placement) return owners;
        const std::uint64_t begin = placement->offset, end = begin + placement->bytes;
        const std::uint64_t first_page = begin / granularity_ * granularity_;
        const std::uint64_t end_page = (end + granularity_ - 1) / granularity_ * granularity_;
        const auto& segments = heaps_[placement->heap];
        auto segment = std::lower_bound(segments.begin(), segments.end(), first_page,
            [](const Segment& s, std::uint64_t offset) { return s.end <= offset; });
        // What begins before the page may still end inside of it, in the page of another kind.
        if (segment != segments.begin()) --segment;
        for (; segment != segments.end() && segment->begin < end_page; ++segment) {
            const bool bytes = segment->begin < end && begin < segment->end;
            const bool page =
                segment->begin < end_page &&
                first_page < (segment->end + granularity_ - 1) / granularity_ * granularity_ &&
                is_image(segment->owner) != is_image(id);
            if ((bytes || page) && segment->owner != id) owners.push_back(segment->owner);
        }
        std::sort(owners.begin(), owners.end());
        owners.erase(std::unique(owners.begin(), owners.end()), owners.end());
        return owners;
    }

    /// Transient content begins anew in each execution; other owners of the bytes lose them.
    void begin(ResourceId id, std::uint32_t piece, PassId pass) {
        if (declaration_.resources[id].lifetime != Lifetime::transient) return;
        Tenant& tenant = tenants_[id];
        if (tenant.begun == execution_) {
            if (tenant.taken_by != kNone)
                say(Kind::alias, piece, kNone, pass, [&] {
                    return fmt::format("{} uses {}, but {} has taken its memory",
                        report_.pass(pass), report_.resource(id),
                        report_.resource(tenant.taken_by));
                });
            return;
        }
        tenant.begun = execution_;
        tenant.under = owners_below(id);
        for (Piece& one : pieces_of(id)) {
            one.content = one.lost = false;
            one.owner = kNobody;
            one.transfer = {};
            if (tenant.taken_by != kNone) { // ordered before who took it
                one.layout = VK_IMAGE_LAYOUT_UNDEFINED;
                one.writes.clear();
                one.reads.clear();
            }
        }
        tenant.taken_by = kNone;
        for (const ResourceId owner : tenant.under) tenants_[owner].taken_by = id;
        if (tenant.placement) occupy(*tenant.placement);
    }

    void occupy(const Placement& placement) {
        auto& segments = heaps_[placement.heap];
        const std::uint64_t begin = placement.offset, end = begin + placement.bytes;
        const auto first = std::lower_bound(segments.begin(), segments.end(), begin,
            [](const Segment& s, std::uint64_t offset) { return s.end <= offset; });
        const auto last = std::lower_bound(first, segments.end(), end,
            [](const Segment& s, std::uint64_t offset) { return s.begin < offset; });
        std::array<Segment, 3> fresh;
        std::size_t count = 0;
        if (first != last && first->begin < begin)
            fresh[count++] = {first->begin, begin, first->owner};
        fresh[count++] = {begin, end, placement.resource};
        if (first != last && (last - 1)->end > end)
            fresh[count++] = {end, (last - 1)->end, (last - 1)->owner};
        const auto where = segments.erase(first, last);
        segments.insert(where, fresh.begin(), fresh.begin() + static_cast<std::ptrdiff_t>(count));
    }

    // ---- Barriers -------------------------------------------------------------------------------

    void batch(std::uint32_t first, std::uint32_t count, std::uint32_t queue) {
        if (count == 0) return;
        const Point point = clocks_.advance(queue);
        first_scopes_.clear();
        for (std::uint32_t i = first; i < first + count; ++i)
            first_scopes_.push_back(clocks_.first_scope(point, scopes_[i]));
        for (std::uint32_t i = 0; i < count; ++i)
            clocks_.let_wait(queue, first_scopes_[i], scopes_[first + i]);
        for (std::uint32_t i = 0; i < count; ++i)
            apply(plan_.barriers[first + i], first + i, point, first_scopes_[i]);
    }

    void apply(const Barrier& barrier, std::uint32_t index, Point point, const Row& scope) {
        const ResourceId id = barrier.resource;
        const Scopes& scopes = scopes_[index];
        const std::uint32_t first = grids_.first(id);
        if ((scopes.src | scopes.dst) & ~stages_[point.queue])
            say(Kind::malformed, first, barrier.from, pass_, [&] {
                return fmt::format("{} is on queue {}, whose family has no stage {}",
                    text_of(barrier), point.queue,
                    stages_text(flags_of((scopes.src | scopes.dst) & ~stages_[point.queue])));
            });
        const bool transfers = barrier.src_family != barrier.dst_family;
        const bool releases = transfers && barrier.src_family == family_of(point.queue);
        const bool acquires = transfers && barrier.dst_family == family_of(point.queue);
        if (transfers && !releases && !acquires)
            say(Kind::ownership, first, barrier.from, pass_, [&] {
                return fmt::format("{} moves it from family {} to {}, but is executed on family {}",
                    text_of(barrier), barrier.src_family, barrier.dst_family,
                    family_of(point.queue));
            });
        const bool changes = is_image(id) && barrier.old_layout != barrier.new_layout;
        if (changes || acquires) begin(id, first, pass_);
        if (barrier.hazard == Hazard::alias)
            for (const ResourceId owner :
                tenants_[id].begun == execution_ ? tenants_[id].under : owners_below(id))
                for (Piece& piece : pieces_of(owner)) pass_on(piece, scopes, point, scope);
        grids_.each(id, grids_.of_barrier(index), [&](std::uint32_t piece) {
            pass_on(pieces_[piece], scopes, point, scope);
            expect_owner(barrier, piece, point, acquires);
            if (releases)
                release(barrier, piece, point, scope);
            else if (changes || acquires)
                transition(barrier, scopes, piece, point, scope, acquires);
        });
    }

    /// Makes writes available and visible.
    static void pass_on(Piece& piece, const Scopes& scopes, Point point, const Row& scope) {
        for (Write& write : piece.writes) {
            const bool names = !write.any && write.at.queue == point.queue &&
                               (write.stages & ~scopes.src) == 0 &&
                               (write.accesses & ~scopes.src_access) == 0;
            if (!names && !is_available(scope, point.queue, write)) continue;
            if (names) write.add_available({point, scopes.second});
            write.add_visible(point.queue, scopes.dst, scopes.dst_access);
        }
    }

    void expect_owner(const Barrier& barrier, std::uint32_t index, Point point, bool acquires) {
        const ResourceId id = barrier.resource;
        Piece& piece = pieces_[index];
        if (plan_.concurrent[id]) {
            if (barrier.src_family != barrier.dst_family)
                say(Kind::ownership, index, barrier.from, pass_, [&] {
                    return fmt::format(
                        "{} moves a resource between families that all own it", text_of(barrier));
                });
            return;
        }
        // What has no content worth keeping need not change owners.
        const bool anew = is_image(id)
                              ? barrier.old_layout == VK_IMAGE_LAYOUT_UNDEFINED
                              : declaration_.resources[id].lifetime == Lifetime::transient &&
                                    tenants_[id].begun != execution_;
        if (acquires || anew) return;
        if (piece.transfer.pending)
            say(Kind::ownership, index, barrier.from, pass_, [&] {
                return fmt::format("{} comes between its release to family {} and the acquire",
                    text_of(barrier), piece.transfer.to);
            });
        else if (piece.owner != kNobody && piece.owner != family_of(point.queue))
            say(Kind::ownership, index, barrier.from, pass_, [&] {
                return fmt::format("{} is executed on family {}, but family {} owns it",
                    text_of(barrier), family_of(point.queue), piece.owner);
            });
    }

    /// Waits for all that was done with the piece, and finds its writes available.
    void expect_done(
        const Barrier& barrier, Piece& piece, std::uint32_t index, Point point, const Row& scope) {
        const auto waits_for = [&](const Event& event) {
            if (covers(scope, point.queue, event)) return true;
            say(Kind::execution, index, event.pass, pass_, [&] {
                return fmt::format("{} changes it from {} to {}, but does not wait for {}",
                    text_of(barrier), layout_text(barrier.old_layout),
                    layout_text(barrier.new_layout), text_of(event));
            });
            return false;
        };
        for (const Write& write : piece.writes) {
            if (!waits_for(write)) continue;
            const bool now = std::any_of(write.available.begin(),
                write.available.begin() + write.available_count, [&](const Availability& a) {
                    return a.at.queue == point.queue && a.at.index == point.index;
                });
            // Made available by this batch: by a barrier that names it, so by this one or a twin.
            if (!now && !is_available(scope, point.queue, write))
                say(Kind::memory, index, write.pass, pass_, [&] {
                    return fmt::format(
                        "{} changes it before {} is available", text_of(barrier), text_of(write));
                });
        }
        for (const Event& read : piece.reads) waits_for(read);
    }

    void expect_layout(const Barrier& barrier, std::uint32_t index) {
        const Piece& piece = pieces_[index];
        if (!is_image(barrier.resource) || barrier.old_layout == VK_IMAGE_LAYOUT_UNDEFINED ||
            barrier.old_layout == piece.layout)
            return;
        say(Kind::layout, index, barrier.from, pass_, [&] {
            return fmt::format("{} expects layout {}, but it is in {}", text_of(barrier),
                layout_text(barrier.old_layout), layout_text(piece.layout));
        });
    }

    void release(const Barrier& barrier, std::uint32_t index, Point point, const Row& scope) {
        Piece& piece = pieces_[index];
        expect_layout(barrier, index);
        expect_done(barrier, piece, index, point, scope);
        piece.transfer = {true, false, barrier.src_family, barrier.dst_family, barrier.old_layout,
            barrier.new_layout, point};
    }

    /// Layout transitions and acquisitions: all that was before is behind them.
    void transition(const Barrier& barrier, const Scopes& scopes, std::uint32_t index, Point point,
        const Row& scope, bool acquires) {
        Piece& piece = pieces_[index];
        if (piece.transition.queue == point.queue && piece.transition.index == point.index)
            say(Kind::layout, index, barrier.from, pass_, [&] {
                return fmt::format("{} is not the only one in its batch", text_of(barrier));
            });
        piece.transition = point;
        if (acquires)
            acquire(barrier, index, scope);
        else
            expect_layout(barrier, index);
        if (!acquires || piece.transfer.by_caller) expect_done(barrier, piece, index, point, scope);
        if (declaration_.resources[barrier.resource].lifetime == Lifetime::transient &&
            piece.taken != execution_) {
            for (const ResourceId owner : tenants_[barrier.resource].under)
                for (Piece& below : pieces_of(owner))
                    expect_done(barrier, below, index, point, scope);
            piece.taken = execution_;
        }
        if (is_image(barrier.resource)) {
            if (barrier.old_layout == VK_IMAGE_LAYOUT_UNDEFINED) {
                piece.lost |= piece.content || !piece.writers.empty();
                piece.content = false;
                piece.writers.clear();
            }
            piece.layout = barrier.new_layout;
        }
        piece.owner = family_of(point.queue);
        piece.transfer = {};
        piece.reads.clear();
        piece.writes.clear();
        Write& write = piece.writes.emplace_back();
        write.what = Event::What::barrier;
        write.any = true;
        write.pass = pass_;
        write.execution = execution_;
        write.at = point;
        write.stages = scopes.second;
        write.add_available({point, scopes.second});
        write.add_visible(point.queue, scopes.dst, scopes.dst_access);
    }

    void acquire(const Barrier& barrier, std::uint32_t index, const Row& scope) {
        const Transfer& transfer = pieces_[index].transfer;
        const auto complain = [&](std::string text) {
            say(Kind::ownership, index, barrier.from, pass_, [&] {
                return fmt::format("{} acquires it from family {}, but {}", text_of(barrier),
                    barrier.src_family, text);
            });
        };
        if (!transfer.pending) return complain("nothing has released it");
        if (transfer.from != barrier.src_family || transfer.to != barrier.dst_family)
            return complain(fmt::format("family {} released it to {}", transfer.from, transfer.to));
        if (!is_image(barrier.resource) && transfer.by_caller) return;
        if (transfer.by_caller ? transfer.old_layout != barrier.old_layout
                               : transfer.old_layout != barrier.old_layout ||
                                     transfer.new_layout != barrier.new_layout)
            return complain(fmt::format("in layouts {} -> {}, while the release says {} -> {}",
                layout_text(barrier.old_layout), layout_text(barrier.new_layout),
                layout_text(transfer.old_layout), layout_text(transfer.new_layout)));
        if (!transfer.by_caller && scope[kStageCount + transfer.at.queue] < transfer.at.index)
            complain("does not wait for the release");
    }

    // ---- Accesses -------------------------------------------------------------------------------

    void access(const Accessor& accessor, ResourceId id, std::uint32_t index, Point point) {
        Piece& piece = pieces_[index];
        const Meaning& meaning = accessor.meaning;
        if (is_image(id) && piece.layout != meaning.layout)
            say(Kind::layout, index, kNone, accessor.pass, [&] {
                return fmt::format("{}, which expects layout {}, but it is in {}",
                    text_of(accessor, id, index), layout_text(meaning.layout),
                    layout_text(piece.layout));
            });
        use_content(accessor, id, index);
        expect_synchronized(accessor, piece, id, index);
        if (declaration_.resources[id].lifetime == Lifetime::transient &&
            piece.taken != execution_) {
            for (const ResourceId owner : tenants_[id].under)
                for (const Piece& below : pieces_of(owner)) expect_gone(accessor, below, id, index);
            if (meaning.writes && accessor.guard == kNone) piece.taken = execution_;
        }
        const Event event{Event::What::access, accessor.pass, execution_, point, meaning.stages,
            meaning.writes ? writes_of(meaning.accesses) : meaning.accesses, accessor.guard};
        if (!meaning.writes)
            add_read(piece, event);
        else
            add_write(piece, event);
    }

    /// Content and ownership: both ask what is left of what was written before.
    void use_content(const Accessor& accessor, ResourceId id, std::uint32_t index) {
        Piece& piece = pieces_[index];
        const Meaning& meaning = accessor.meaning;
        const std::uint32_t family = family_of(accessor.queue);
        const bool has_content = piece.content || !piece.writers.empty();
        // Without a transfer, a buffer may be replaced; an image must come anew from UNDEFINED.
        const bool keeps = is_image(id) || meaning.needs ||
                           (has_content && !(meaning.replaces && accessor.guard == kNone));
        if (!plan_.concurrent[id] && keeps) {
            if (piece.transfer.pending)
                say(Kind::ownership, index, kNone, accessor.pass, [&] {
                    return fmt::format(
                        "{} on family {}, but it is being moved from family {} to {}",
                        text_of(accessor, id, index), family, piece.transfer.from,
                        piece.transfer.to);
                });
            else if (piece.owner != kNobody && piece.owner != family)
                say(Kind::ownership, index, kNone, accessor.pass, [&] {
                    return fmt::format("{} on family {}, but family {} owns it",
                        text_of(accessor, id, index), family, piece.owner);
                });
        }
        piece.owner = family;
        piece.transfer = {};
        if (meaning.needs && declaration_.resources[id].history_age && !rotates(id))
            say(Kind::content, index, kNone, accessor.pass, [&] {
                return fmt::format("{}, but not all ages of its history have memory, so that they "
                                   "never change places",
                    text_of(accessor, id, index));
            });
        if (meaning.needs && !piece.content && !guards_.cover(piece.writers, accessor.guard))
            say(Kind::content, index, kNone, accessor.pass, [&] {
                return fmt::format("{}, but {}", text_of(accessor, id, index),
                    piece.lost ? "a transition from layout undefined has lost the content"
                               : "nothing has written it");
            });
        if (!meaning.writes || piece.content) return;
        if (accessor.guard == kNone) {
            piece.content = true;
            piece.lost = false;
            piece.writers.clear();
        } else {
            piece.writers.push_back(accessor.guard);
            if (guards_.cover(piece.writers, kNone)) {
                piece.content = true;
                piece.lost = false;
                piece.writers.clear();
            }
        }
    }

    /// Reads wait for writes and see them; writes wait for reads, too.
    void expect_synchronized(
        const Accessor& accessor, const Piece& piece, ResourceId id, std::uint32_t index) {
        const Meaning& meaning = accessor.meaning;
        for (const Write& write : piece.writes) {
            if (!can_meet(write.guard, accessor.guard)) continue;
            each_bit(meaning.stages, [&](std::uint32_t stage) {
                const auto bit = static_cast<Stages>(1u << stage);
                if (!waits(accessor.queue, stage, write)) {
                    say(Kind::execution, index, write.pass, accessor.pass, [&] {
                        return fmt::format("{}, but nothing makes its {} wait for {}",
                            text_of(accessor, id, index), stages_text(flags_of(bit)),
                            text_of(write));
                    });
                    return;
                }
                // A write after a write needs it available, only a read needs it visible:
                // "location- ordered" in
                // https://docs.vulkan.org/spec/latest/appendices/memorymodel.html
                if (meaning.writes && !is_available(accessor.queue, stage, write))
                    say(Kind::memory, index, write.pass, accessor.pass, [&] {
                        return fmt::format("{}, but nothing makes {} available before",
                            text_of(accessor, id, index), text_of(write));
                    });
                if (!meaning.needs || clocks_.is_seen(accessor.queue, stage, write.at)) return;
                const Accesses visible =
                    write.queue == accessor.queue ? write.visible[stage] : Accesses{0};
                const Accesses blind =
                    meaning.accesses & ~writes_of(meaning.accesses) & possible_in(bit) & ~visible;
                if (blind)
                    say(Kind::memory, index, write.pass, accessor.pass, [&] {
                        return fmt::format("{}, but nothing makes {} visible to {}",
                            text_of(accessor, id, index), text_of(write), at(bit, blind));
                    });
            });
        }
        if (!meaning.writes) return;
        for (const Event& read : piece.reads) {
            if (!can_meet(read.guard, accessor.guard)) continue;
            each_bit(meaning.stages, [&](std::uint32_t stage) {
                if (!waits(accessor.queue, stage, read))
                    say(Kind::execution, index, read.pass, accessor.pass, [&] {
                        return fmt::format("{}, but nothing makes it wait for {}",
                            text_of(accessor, id, index), text_of(read));
                    });
            });
        }
    }

    /// Who had the memory before is done with it, and its writes cannot come late.
    void expect_gone(
        const Accessor& accessor, const Piece& below, ResourceId id, std::uint32_t index) {
        const auto gone = [&](const Event& event, bool available) {
            if (available) return;
            say(Kind::alias, index, event.pass, accessor.pass, [&] {
                return fmt::format(
                    "{} where memory is handed over, but nothing makes it wait for {}",
                    text_of(accessor, id, index), text_of(event));
            });
        };
        each_bit(accessor.meaning.stages, [&](std::uint32_t stage) {
            for (const Write& write : below.writes)
                gone(write, waits(accessor.queue, stage, write) &&
                                is_available(accessor.queue, stage, write));
            for (const Event& read : below.reads) gone(read, waits(accessor.queue, stage, read));
        });
    }

    static void add_read(Piece& piece, const Event& event) {
        for (Event& read : piece.reads)
            if (read.at.queue == event.at.queue && read.stages == event.stages &&
                read.guard == event.guard && read.what == event.what) {
                read = event; // who waits for the later one has waited for both
                return;
            }
        piece.reads.push_back(event);
    }

    /// A write that may not happen hides only those that happen at most with it.
    void add_write(Piece& piece, const Event& event) {
        if (event.guard == kNone) {
            piece.writes.clear();
            piece.reads.clear();
        } else {
            std::erase_if(piece.writes, [&](const Write& write) {
                return write.guard != kNone && write.guard != kMaybe &&
                       guards_.implies(write.guard, event.guard);
            });
        }
        static_cast<Event&>(piece.writes.emplace_back()) = event;
        piece.writes.back().queue = event.at.queue;
    }

    // ---- The end --------------------------------------------------------------------------------

    void leave() {
        for (ResourceId id = 0; id < tenants_.size(); ++id) {
            if (first_queue_[id] == kNone) continue;
            const ResourceDecl& resource = declaration_.resources[id];
            if (resource.lifetime != Lifetime::transient || resource.exported) check_left(id);
            if (resource.lifetime == Lifetime::external) hand_back(id, resource.exit);
        }
        last_signals_.clear();
        for (const auto& signals : signals_)
            last_signals_.push_back(signals.empty() ? Clocks::Signal{} : signals.back());
        for (ResourceId id = 0; id < tenants_.size(); ++id) {
            const std::uint32_t depth = declaration_.resources[id].history_depth;
            if (!rotates(id) || declaration_.resources[id].history_age != 0) continue;
            const auto first = pieces_.begin() + grids_.first(id);
            const auto count = static_cast<std::ptrdiff_t>(grids_.count(id));
            std::rotate(first, first + depth * count, first + (depth + 1) * count);
        }
    }

    /// A released image is in the new layout once the caller has acquired it.
    static VkImageLayout layout_left(const Piece& piece) {
        return piece.transfer.pending ? piece.transfer.new_layout : piece.layout;
    }

    /// What is kept is as the plan says, and whole.
    void check_left(ResourceId id) {
        const VkImageLayout said = plan_.final_states[id].layout;
        for (std::uint32_t i = 0; i < grids_.count(id); ++i) {
            const std::uint32_t index = grids_.first(id) + i;
            const Piece& piece = pieces_[index];
            const VkImageLayout layout = layout_left(piece);
            // Parts of an exported image that nothing writes stay as they were: undefined.
            const bool untouched = layout == VK_IMAGE_LAYOUT_UNDEFINED &&
                                   declaration_.resources[id].lifetime == Lifetime::transient;
            if (is_image(id) && layout != said && !untouched)
                say(Kind::layout, index, kNone, kNone, [&] {
                    return fmt::format("{} is left in layout {}, but the plan says {}",
                        report_.resource(id, grids_.part_of(index)), layout_text(layout),
                        layout_text(said));
                });
            if (piece.lost)
                say(Kind::content, index, kNone, kNone, [&] {
                    return fmt::format(
                        "{} is kept, but a transition from layout undefined has lost its content",
                        report_.resource(id, grids_.part_of(index)));
                });
        }
    }

    void hand_back(ResourceId id, const AccessState& exit) {
        Accessor caller;
        caller.meaning.stages = stages_of(exit.stages);
        caller.meaning.accesses = accesses_of(exit.access);
        caller.meaning.writes = writes_of(caller.meaning.accesses) != 0;
        caller.meaning.needs = true;
        for (std::uint32_t i = 0; i < grids_.count(id); ++i) {
            const std::uint32_t index = grids_.first(id) + i;
            const Piece& piece = pieces_[index];
            const auto name = [&] { return report_.resource(id, grids_.part_of(index)); };
            if (is_image(id) && exit.layout != VK_IMAGE_LAYOUT_UNDEFINED &&
                layout_left(piece) != exit.layout)
                say(Kind::layout, index, kNone, kNone, [&] {
                    return fmt::format("{} is promised to the caller in layout {}, but left in {}",
                        name(), layout_text(exit.layout), layout_text(layout_left(piece)));
                });
            const bool released = piece.transfer.pending && piece.transfer.to == exit.queue_family;
            if (exit.queue_family != kNobody && !released &&
                (piece.transfer.pending || piece.owner != exit.queue_family))
                say(Kind::ownership, index, kNone, kNone, [&] {
                    return fmt::format("{} is promised to family {}, but not released to it",
                        name(), exit.queue_family);
                });
            // Who acquires it synchronizes by the semaphore, and what nobody here touched is as it
            // was.
            if (!released && !is_untouched(piece)) expect_synchronized(caller, piece, id, index);
        }
    }

    static bool is_untouched(const Piece& piece) {
        const auto by_caller = [](const Event& event) { return event.what == Event::What::caller; };
        return std::all_of(piece.writes.begin(), piece.writes.end(), by_caller) &&
               std::all_of(piece.reads.begin(), piece.reads.end(), by_caller);
    }

    /// Bytes of a heap and who used them last.
    struct Segment {
        std::uint64_t begin = 0, end = 0;
        ResourceId owner = kNone;
    };

    const Declaration& declaration_;
    const Plan& plan_;
    const Grids& grids_;
    Report& report_;
    Guards guards_;
    Clocks clocks_;
    std::vector<Piece> pieces_;
    std::vector<Tenant> tenants_;
    std::vector<std::uint32_t> first_queue_; ///< per resource; kNone: not used
    std::uint64_t granularity_;
    std::vector<std::vector<Segment>> heaps_; ///< sorted, disjoint
    std::vector<Stages> stages_;              ///< per queue
    std::vector<Meaning> meanings_;           ///< per use
    std::vector<Scopes> scopes_;              ///< per barrier
    std::vector<std::uint8_t> rotates_;       ///< per present age
    std::vector<Row> first_scopes_;           ///< of the present batch
    std::uint32_t execution_ = 0;
    PassId pass_ = kNone;                              ///< whose batch it is; kNone: the exit's
    std::vector<std::vector<Clocks::Signal>> signals_; ///< per queue, of this execution
    std::vector<Clocks::Signal> last_signals_;         ///< per queue, of the previous execution
    std::vector<bool> submitted_;
};

} // namespace

void check_execution(const Declaration& declaration, const Plan& plan,
    const Capabilities& capabilities, const Grids& grids, Report& report) {
    Execution(declaration, plan, capabilities, grids, report).run();
}

} // namespace ockham::verifier
