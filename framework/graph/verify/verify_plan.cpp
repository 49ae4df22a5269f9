// SPDX-License-Identifier: Apache-2.0
// The parts of verify() that need no execution: indices, queues, order, culling, memory, usages.
#include "framework/graph/verify/verify_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>

namespace ockham::verifier {

namespace {

using Kind = Violation::Kind;

template <class... Args>
void say(Report& report, Kind kind, ResourceId resource, PassId earlier, PassId later,
    fmt::format_string<Args...> text, Args&&... args) {
    Violation violation{kind, resource, {}, earlier, later, {}};
    if (!report.wants(violation)) return;
    violation.text = fmt::format(text, std::forward<Args>(args)...);
    report.add(std::move(violation));
}

/// Families as compile() sees them: one that can do all, where none are given.
std::vector<QueueFamily> families_of(const Capabilities& capabilities) {
    return capabilities.families.empty() ? std::vector<QueueFamily>{{}} : capabilities.families;
}

bool can_execute(const QueueFamily& family, PassKind kind) {
    switch (kind) {
    case PassKind::compute:
        return family.compute;
    case PassKind::raster:
        return family.graphics;
    case PassKind::transfer:
        return family.transfer || family.graphics || family.compute;
    }
    return false;
}

bool is_kept(const ResourceDecl& resource) {
    return resource.lifetime == Lifetime::persistent || resource.exported;
}

/// [first, first + count) lies within `size` elements.
bool in_range(std::uint64_t first, std::uint64_t count, std::size_t size) {
    return first + count <= size;
}

bool check_barrier(const Declaration& declaration, const Barrier& barrier, Report& report) {
    if (barrier.resource >= declaration.resources.size()) {
        say(report, Kind::malformed, barrier.resource, barrier.from, barrier.to,
            "a barrier names resource {} of {}", barrier.resource, declaration.resources.size());
        return false;
    }
    if (!is_inside(declaration.resources[barrier.resource], barrier.part)) {
        say(report, Kind::malformed, barrier.resource, barrier.from, barrier.to,
            "a barrier names a part that is not inside {}", report.resource(barrier.resource));
        return false;
    }
    return true;
}

bool check_sizes(const Declaration& declaration, const Plan& plan, Report& report) {
    const std::size_t passes = declaration.passes.size(), resources = declaration.resources.size();
    if (plan.passes.size() == passes && plan.resources.size() == resources &&
        plan.final_states.size() == resources && plan.usages.size() == resources &&
        plan.concurrent.size() == resources)
        return true;
    say(report, Kind::malformed, kNone, kNone, kNone,
        "the plan is of another declaration: it has {} passes and {} resources, not {} and {}",
        plan.passes.size(), plan.resources.size(), passes, resources);
    return false;
}

} // namespace

bool check_shape(const Declaration& declaration, const Plan& plan, const Capabilities& capabilities,
    Report& report) {
    if (!check_sizes(declaration, plan, report)) return false;
    const auto bad = [&](const char* what, std::size_t index) {
        say(report, Kind::malformed, kNone, kNone, kNone, "{} {} of the plan is out of range", what,
            index);
    };
    const std::vector<QueueFamily> families = families_of(capabilities);
    for (std::size_t i = 0; i < plan.queues.size(); ++i)
        if (plan.queues[i].family >= families.size()) bad("queue", i);
    for (std::size_t i = 0; i < plan.submissions.size(); ++i) {
        const Submission& submission = plan.submissions[i];
        if (submission.queue >= plan.queues.size() ||
            !in_range(submission.first_step, submission.step_count, plan.steps.size()) ||
            !in_range(submission.first_wait, submission.wait_count, plan.waits.size()))
            bad("submission", i);
    }
    for (std::size_t i = 0; i < plan.waits.size(); ++i)
        if (plan.waits[i].queue >= plan.queues.size()) bad("wait", i);
    for (std::size_t i = 0; i < plan.steps.size(); ++i) {
        const Step& step = plan.steps[i];
        if (step.pass >= declaration.passes.size() ||
            !in_range(step.first_barrier, step.barrier_count, plan.barriers.size()) ||
            !in_range(step.first_release, step.release_count, plan.barriers.size()))
            bad("step", i);
    }
    if (!in_range(plan.first_exit_barrier, plan.exit_barrier_count, plan.barriers.size()))
        bad("exit", 0);
    for (std::size_t i = 0; i < plan.placements.size(); ++i)
        if (plan.placements[i].resource >= declaration.resources.size() ||
            plan.placements[i].heap >= plan.heaps.size())
            bad("placement", i);
    for (const Barrier& barrier : plan.barriers) check_barrier(declaration, barrier, report);
    return report.empty();
}

namespace {

void check_queues(const Plan& plan, const std::vector<QueueFamily>& families, Report& report) {
    constexpr std::size_t most = 4; // what clocks are made for
    if (plan.queues.empty() || plan.queues.size() > most) {
        say(report, Kind::submission, kNone, kNone, kNone, "the plan has {} queues, not 1 to {}",
            plan.queues.size(), most);
        return;
    }
    for (std::size_t i = 0; i < plan.queues.size(); ++i) {
        const PlanQueue& queue = plan.queues[i];
        if (queue.index >= families[queue.family].queues)
            say(report, Kind::submission, kNone, kNone, kNone,
                "queue {} is number {} of family {}, which has {}", i, queue.index, queue.family,
                families[queue.family].queues);
        for (std::size_t k = 0; k < i; ++k)
            if (plan.queues[k] == queue)
                say(report, Kind::submission, kNone, kNone, kNone,
                    "queues {} and {} of the plan are the same", k, i);
    }
    const QueueFamily& main = families[plan.queues[0].family];
    if (!main.graphics || !main.compute)
        say(report, Kind::submission, kNone, kNone, kNone,
            "queue 0 is of family {}, which lacks {}", plan.queues[0].family,
            main.graphics ? "compute" : "graphics");
}

/// Waits refer to submissions that come earlier in Plan::submissions.
void check_waits(const Plan& plan, Report& report) {
    std::vector<std::uint32_t> submitted(plan.queues.size(), 0);
    for (std::size_t i = 0; i < plan.submissions.size(); ++i) {
        const Submission& submission = plan.submissions[i];
        for (std::uint32_t k = 0; k < submission.wait_count; ++k) {
            const Wait& wait = plan.waits[submission.first_wait + k];
            if (wait.value == 0 || wait.value > submitted[wait.queue])
                say(report, Kind::submission, kNone, kNone, kNone,
                    "submission {} waits until queue {} has completed {} submissions, but {} come "
                    "before it",
                    i, wait.queue, wait.value, submitted[wait.queue]);
            if (wait.stages == 0)
                say(report, Kind::submission, kNone, kNone, kNone,
                    "submission {} waits for queue {} with no stage", i, wait.queue);
        }
        ++submitted[submission.queue];
    }
}

} // namespace

void check_submissions(const Declaration& declaration, const Plan& plan,
    const Capabilities& capabilities, Report& report) {
    const std::vector<QueueFamily> families = families_of(capabilities);
    check_queues(plan, families, report);
    if (!report.empty()) return;
    std::uint32_t next = 0;
    for (std::size_t i = 0; i < plan.submissions.size(); ++i) {
        const Submission& submission = plan.submissions[i];
        if (submission.first_step != next)
            say(report, Kind::submission, kNone, kNone, kNone,
                "submission {} begins with step {}, but step {} comes next", i,
                submission.first_step, next);
        if (submission.step_count == 0 && i + 1 != plan.submissions.size())
            say(report, Kind::submission, kNone, kNone, kNone, "submission {} has no steps", i);
        next = submission.first_step + submission.step_count;
        const std::uint32_t family = plan.queues[submission.queue].family;
        for (std::uint32_t s = submission.first_step; s < next; ++s) {
            const PassDecl& pass = declaration.passes[plan.steps[s].pass];
            if (!can_execute(families[family], pass.kind))
                say(report, Kind::submission, kNone, kNone, plan.steps[s].pass,
                    "{} is on queue {} of family {}, which cannot execute it",
                    report.pass(plan.steps[s].pass), submission.queue, family);
        }
    }
    if (next != plan.steps.size())
        say(report, Kind::submission, kNone, kNone, kNone, "{} of {} steps are submitted", next,
            plan.steps.size());
    if (plan.exit_barrier_count && (plan.submissions.empty() || plan.submissions.back().queue != 0))
        say(report, Kind::submission, kNone, kNone, kNone,
            "the exit barriers belong into the last submission, which is not on queue 0");
    check_waits(plan, report);
}

void check_order(
    const Declaration& declaration, const Plan& plan, const Grids& grids, Report& report) {
    std::vector<std::uint32_t> step_of(declaration.passes.size(), kNone);
    for (std::uint32_t step = 0; step < plan.steps.size(); ++step) {
        const PassId pass = plan.steps[step].pass;
        if (step_of[pass] != kNone)
            say(report, Kind::order, kNone, pass, pass, "{} is executed twice", report.pass(pass));
        step_of[pass] = step;
    }
    /// Of one piece, in the order of the declaration: who wrote last, who read last since.
    struct Past {
        PassId writer = kNone, reader = kNone;
    };
    std::vector<Past> pieces(grids.pieces());
    PassId side_effect = kNone;
    const auto expect = [&](PassId earlier, PassId later, ResourceId id, const char* why) {
        if (earlier == kNone || earlier == later || step_of[earlier] < step_of[later]) return;
        say(report, Kind::order, id, earlier, later, "{} comes before {}, {} {}",
            report.pass(later), report.pass(earlier), why, id == kNone ? "" : report.resource(id));
    };
    for (PassId id = 0; id < declaration.passes.size(); ++id) {
        const PassDecl& pass = declaration.passes[id];
        if (plan.passes[id].culled && step_of[id] != kNone)
            say(report, Kind::order, kNone, kNone, id, "{} is culled, but executed",
                report.pass(id));
        if (!plan.passes[id].culled && step_of[id] == kNone)
            say(report, Kind::order, kNone, kNone, id, "{} is kept, but not executed",
                report.pass(id));
        if (step_of[id] == kNone) continue;
        if (!pass.side_effect.empty()) {
            expect(side_effect, id, kNone, "which also has a side effect and was declared first");
            side_effect = id;
        }
        for (std::uint32_t u = pass.first_use; u < pass.first_use + pass.use_count; ++u) {
            const Use& use = declaration.uses[u];
            const Meaning meaning = meaning_of(use, declaration.resources[use.resource].kind);
            grids.each(use.resource, grids.of_use(u), [&](std::uint32_t piece) {
                Past& past = pieces[piece];
                expect(past.writer, id, use.resource,
                    meaning.writes ? "which writes first" : "which writes what it reads:");
                if (meaning.writes) {
                    expect(past.reader, id, use.resource, "which reads the older content of");
                    past = {id, kNone};
                } else if (past.reader == kNone || step_of[past.reader] < step_of[id]) {
                    past.reader = id;
                }
            });
            if (meaning.usage & ~plan.usages[use.resource])
                say(report, Kind::usage, use.resource, kNone, id,
                    "{} uses {}, which is created without usage bits {:#x}", report.pass(id),
                    report.resource(use.resource), meaning.usage & ~plan.usages[use.resource]);
        }
    }
}

void check_culling(
    const Declaration& declaration, const Plan& plan, const Grids& grids, Report& report) {
    // Whether the content of a piece is wanted after the point reached, walking back. `at_end`
    // grows with what histories pass on, until nothing is added: the least fixpoint.
    const Guards guards(declaration);
    std::vector<std::uint8_t> at_end(grids.pieces(), 0), wanted;
    std::vector<std::uint8_t> needed(declaration.passes.size(), 0);
    for (std::uint32_t piece = 0; piece < at_end.size(); ++piece) {
        const ResourceDecl& resource = declaration.resources[grids.resource_of(piece)];
        at_end[piece] = resource.exported ||
                        (resource.lifetime != Lifetime::transient && resource.history_depth == 0);
    }
    for (bool grew = true; grew;) {
        grew = false;
        wanted = at_end;
        for (auto id = static_cast<PassId>(declaration.passes.size()); id-- > 0;) {
            const PassDecl& pass = declaration.passes[id];
            const auto each_use = [&](auto visit) {
                for (std::uint32_t u = pass.first_use; u < pass.first_use + pass.use_count; ++u) {
                    const Use& use = declaration.uses[u];
                    const Meaning meaning =
                        meaning_of(use, declaration.resources[use.resource].kind);
                    grids.each(use.resource, grids.of_use(u),
                        [&](std::uint32_t piece) { visit(use, meaning, wanted[piece]); });
                }
            };
            bool live = !pass.side_effect.empty();
            ResourceId why = kNone;
            each_use([&](const Use& use, const Meaning& meaning, std::uint8_t is_wanted) {
                if (!meaning.writes || !is_wanted) return;
                live = true;
                why = use.resource;
            });
            if (!live || guards.exclude(pass.guard, pass.guard)) continue;
            needed[id] = 1;
            if (plan.passes[id].culled)
                say(report, Kind::culling, why, kNone, id, "{} is culled, but {}", report.pass(id),
                    why == kNone
                        ? "has a side effect"
                        : fmt::format("what it writes to {} is needed", report.resource(why)));
            // Only what happens in every execution replaces.
            each_use([&](const Use&, const Meaning& meaning, std::uint8_t& is_wanted) {
                if (meaning.replaces && pass.guard == kNone) is_wanted = 0;
            });
            each_use([&](const Use&, const Meaning& meaning, std::uint8_t& is_wanted) {
                if (meaning.needs) is_wanted = 1;
            });
        }
        for (std::uint32_t piece = 0; piece < at_end.size(); ++piece) {
            // What is wanted of age + 1 at the beginning, `age` must hold at the end.
            const ResourceId id = grids.resource_of(piece);
            const ResourceDecl& resource = declaration.resources[id];
            if (resource.history_depth == 0 || at_end[piece]) continue;
            const bool oldest = resource.history_age == resource.history_depth;
            const ResourceId next = oldest ? id - resource.history_depth : id + 1;
            if (!wanted[grids.first(next) + (piece - grids.first(id))]) continue;
            at_end[piece] = 1;
            grew = true;
        }
    }
}

namespace {

/// Bytes and alignment that a resource needs: the runtime's word, else what compile.hpp promises
/// for planning without a device.
MemoryNeed memory_need(const ResourceDecl& resource) {
    if (resource.memory.bytes) return resource.memory;
    MemoryNeed need{resource.buffer.bytes, 256, ~std::uint32_t{0}};
    if (resource.kind == ResourceKind::buffer) return need;
    const ImageDesc& image = resource.image;
    std::uint64_t texels = 0;
    for (std::uint32_t mip = 0; mip < image.mips; ++mip) {
        const auto size = [&](std::uint32_t all) {
            return std::uint64_t{std::max(all >> mip, 1u)};
        };
        texels += size(image.width) * size(image.height) * size(image.depth);
    }
    need.bytes = texels * image.layers * texel_bytes(image.format);
    return need;
}

void check_placement(
    const Declaration& declaration, const Plan& plan, const Placement& placement, Report& report) {
    const ResourceId id = placement.resource;
    const Heap& heap = plan.heaps[placement.heap];
    const MemoryNeed need = memory_need(declaration.resources[id]);
    const auto complain = [&](const std::string& text) {
        say(report, Kind::placement, id, kNone, kNone, "{} {}", report.resource(id), text);
    };
    if (placement.offset + placement.bytes > heap.bytes)
        complain(fmt::format("ends at byte {} of heap {}, which has {}",
            placement.offset + placement.bytes, placement.heap, heap.bytes));
    if (placement.bytes < need.bytes)
        complain(fmt::format("needs {} bytes and is given {}", need.bytes, placement.bytes));
    if (placement.offset % std::max<std::uint64_t>(need.alignment, 1) != 0)
        complain(fmt::format(
            "is at byte {}, no multiple of its alignment {}", placement.offset, need.alignment));
    if (heap.type_bits == 0 || (heap.type_bits & ~need.type_bits))
        complain(fmt::format("is in heap {} of memory types {:#x}, but may only be in {:#x}",
            placement.heap, heap.type_bits, need.type_bits));
}

} // namespace

void check_placements(const Declaration& declaration, const Plan& plan, Report& report) {
    const std::size_t resources = declaration.resources.size();
    // Uses by steps, as placements count them.
    struct Interval {
        std::uint32_t first = kNone, last = kNone;
    };
    std::vector<Interval> intervals(resources);
    for (std::uint32_t step = 0; step < plan.steps.size(); ++step)
        for (const Use& use : declaration.uses_of(plan.steps[step].pass)) {
            Interval& interval = intervals[use.resource];
            if (interval.first == kNone) interval.first = step;
            interval.last = step;
        }
    std::vector<std::uint32_t> placed(resources, 0);
    std::vector<ResourceId> tenant(plan.heaps.size(), kNone); // of heaps that are not shared
    for (const Placement& placement : plan.placements) {
        const ResourceId id = placement.resource;
        const ResourceDecl& resource = declaration.resources[id];
        check_placement(declaration, plan, placement, report);
        if (placed[id]++)
            say(report, Kind::placement, id, kNone, kNone, "{} is placed twice",
                report.resource(id));
        if (resource.lifetime == Lifetime::external)
            say(report, Kind::placement, id, kNone, kNone, "{} is the caller's, but placed",
                report.resource(id));
        const Interval used = intervals[id];
        if (used.first != kNone &&
            (placement.first_step != used.first || placement.last_step != used.last))
            say(report, Kind::placement, id, kNone, kNone,
                "{} is used in steps {}-{}, but placed for {}-{}", report.resource(id), used.first,
                used.last, placement.first_step, placement.last_step);
        if (plan.heaps[placement.heap].shared) {
            if (is_kept(resource))
                say(report, Kind::placement, id, kNone, kNone,
                    "{} is kept beyond the execution, but heap {} is shared", report.resource(id),
                    placement.heap);
        } else if (tenant[placement.heap] != kNone) {
            say(report, Kind::placement, id, kNone, kNone,
                "{} and {} share heap {} of one resource", report.resource(tenant[placement.heap]),
                report.resource(id), placement.heap);
        } else {
            tenant[placement.heap] = id;
        }
    }
    for (ResourceId id = 0; id < resources; ++id) {
        const ResourceDecl& resource = declaration.resources[id];
        if (intervals[id].first != kNone && !placed[id] && resource.lifetime != Lifetime::external)
            say(report, Kind::placement, id, kNone, plan.steps[intervals[id].first].pass,
                "{} uses {}, which has no memory",
                report.pass(plan.steps[intervals[id].first].pass), report.resource(id));
    }
    std::uint64_t bytes = 0;
    for (const Heap& heap : plan.heaps) bytes += heap.bytes;
    if (bytes != plan.bytes_peak)
        say(report, Kind::placement, kNone, kNone, kNone,
            "the heaps have {} bytes, but bytes_peak says {}", bytes, plan.bytes_peak);
}

} // namespace ockham::verifier
