// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/verify/verify_execution.hpp"

#include "framework/graph/explain/words.hpp"

#include <fmt/format.h>

namespace ockham::verifier {

Execution::Execution(const Declaration& declaration, const Plan& plan,
    const Capabilities& capabilities, const Grids& grids, Report& report)
    : declaration_(declaration), plan_(plan), grids_(grids), report_(report), guards_(declaration),
      clocks_(plan.queues.size()), pieces_(grids.pieces()), tenants_(declaration.resources.size()),
      first_queue_(declaration.resources.size(), kNone),
      granularity_(std::max<std::uint64_t>(capabilities.buffer_image_granularity, 1)),
      heaps_(plan.heaps.size()) {
    for (const PlanQueue& queue : plan.queues)
        stages_.push_back(stages_on(
            capabilities.families.empty() ? QueueFamily{} : capabilities.families[queue.family]));
    meanings_.reserve(declaration.uses.size());
    for (const Use& use : declaration.uses)
        meanings_.push_back(meaning_of(use, declaration.resources[use.resource].kind));
    scopes_.reserve(plan.barriers.size());
    for (const Barrier& barrier : plan.barriers) scopes_.push_back(scopes_of(barrier));
    for (const Placement& placement : plan.placements)
        tenants_[placement.resource].placement = &placement;
    for (const Submission& submission : plan.submissions)
        for (std::uint32_t i = 0; i < submission.step_count; ++i)
            for (const Use& use : declaration.uses_of(plan.steps[submission.first_step + i].pass))
                if (first_queue_[use.resource] == kNone)
                    first_queue_[use.resource] = submission.queue;
}

void Execution::run() {
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

void Execution::prepare() {
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

bool Execution::rotates(ResourceId id) const {
    const ResourceDecl& resource = declaration_.resources[id];
    return resource.history_depth && rotates_[id - resource.history_age];
}

void Execution::enter() {
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

void Execution::enter(ResourceId id, std::uint32_t queue) {
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
        // Where no family is named, the first that uses any of it owns all of it.
        piece.owner = entry.queue_family == kNobody ? family : entry.queue_family;
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
            write.available.push_back({now, stages});
            write.add_visible(queue, stages, accesses);
            piece.reads.push_back({Event::What::caller, kNone, execution_, now, stages, accesses});
        }
    }
}

void Execution::submit(std::size_t index) {
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

void Execution::execute(const Step& step, std::uint32_t queue) {
    pass_ = step.pass;
    batch(step.first_barrier, step.barrier_count, queue);
    const PassDecl& pass = declaration_.passes[step.pass];
    const Point point = clocks_.advance(queue);
    // A guard that contradicts itself never consents: only the barriers are executed.
    const bool never = guards_.exclude(pass.guard, pass.guard);
    for (std::uint32_t use = pass.first_use; use < pass.first_use + pass.use_count; ++use) {
        if (never) break;
        const ResourceId id = declaration_.uses[use].resource;
        const Accessor accessor{step.pass, pass.guard, queue, meanings_[use]};
        begin(id, grids_.first(id), step.pass);
        grids_.each(id, grids_.of_use(use),
            [&](std::uint32_t piece) { access(accessor, id, piece, point); });
    }
    batch(step.first_release, step.release_count, queue);
}

void Execution::leave() {
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

void Execution::check_left(ResourceId id) {
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

void Execution::hand_back(ResourceId id, const AccessState& exit) {
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
                return fmt::format("{} is promised to family {}, but not released to it", name(),
                    exit.queue_family);
            });
        // Who acquires it synchronizes by the semaphore, and what nobody here touched is as it
        // was.
        if (!released && !is_untouched(piece)) expect_synchronized(caller, piece, id, index);
    }
}

bool Execution::is_untouched(const Piece& piece) {
    const auto by_caller = [](const Event& event) { return event.what == Event::What::caller; };
    return std::all_of(piece.writes.begin(), piece.writes.end(), by_caller) &&
           std::all_of(piece.reads.begin(), piece.reads.end(), by_caller);
}

std::string Execution::text_of(const Event& event) const {
    const char* const when = event.execution < execution_ && event.what != Event::What::caller
                                 ? " in the previous execution"
                                 : "";
    switch (event.what) {
    case Event::What::access:
        return fmt::format("the {} by {} at {}{}", writes_of(event.accesses) ? "write" : "read",
            report_.pass(event.pass), at(event.stages, event.accesses), when);
    case Event::What::barrier:
        return fmt::format("the transition for {}{}", report_.pass(event.pass, "the exit"), when);
    case Event::What::caller:
        break;
    }
    return fmt::format("what the caller did at {}", at(event.stages, event.accesses));
}

std::string Execution::text_of(const Accessor& accessor, ResourceId id, std::uint32_t piece) const {
    const Meaning& meaning = accessor.meaning;
    return fmt::format("{} {} {} at {}", report_.pass(accessor.pass),
        meaning.writes ? "writes" : "reads", report_.resource(id, grids_.part_of(piece)),
        at(meaning.stages, meaning.accesses));
}

std::string Execution::text_of(const Barrier& barrier) const {
    return fmt::format("the barrier on {} for {}", report_.resource(barrier.resource, barrier.part),
        report_.pass(pass_, "the exit"));
}

bool Execution::has(const Row& row, Point point, Stages stages, bool any, std::uint32_t queue) {
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

bool Execution::is_available(const Row& scope, std::uint32_t queue, const Write& write) {
    if (scope[kStageCount + write.at.queue] >= write.at.index) return true;
    for (const Availability& one : write.available)
        if (has(scope, one.at, one.stages, true, queue)) return true;
    return false;
}

bool Execution::is_available(std::uint32_t queue, std::uint32_t stage, const Write& write) const {
    if (is_available(clocks_.rows(queue)[stage], queue, write)) return true;
    for (const Availability& one : write.available)
        if (one.at.queue == queue && (one.stages >> stage & 1)) return true;
    return false;
}

bool Execution::waits(std::uint32_t queue, std::uint32_t stage, const Event& event) const {
    return covers(clocks_.rows(queue)[stage], queue, event) ||
           (event.any && event.at.queue == queue && (event.stages >> stage & 1));
}

std::string Execution::at(Stages stages, Accesses accesses) {
    return stages_text(flags_of(stages)) + "/" + access_text(access_flags_of(accesses));
}

void check_execution(const Declaration& declaration, const Plan& plan,
    const Capabilities& capabilities, const Grids& grids, Report& report) {
    Execution(declaration, plan, capabilities, grids, report).run();
}

} // namespace ockham::verifier
