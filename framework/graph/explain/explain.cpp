// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/explain/explain.hpp"

#include "framework/graph/describe.hpp"
#include "framework/graph/explain/timeline.hpp"
#include "framework/graph/explain/words.hpp"

#include <algorithm>
#include <functional>
#include <utility>

namespace ockham {

namespace {

using Cause = Verdict::Cause;

std::string with(const char* before, const std::string& reason, const char* after) {
    return reason.empty() ? reason : before + reason + after;
}

/// Why what a culled pass writes to `id` is worth nothing: what comes of it in later passes.
std::string indifference(
    const Declaration& declaration, const Plan& plan, PassId pass, ResourceId id) {
    const std::string& name = declaration.resources[id].name;
    for (PassId later = pass + 1; later < plan.passes.size(); ++later) {
        const std::string& other = declaration.passes[later].name;
        for (const Use& use : declaration.uses_of(later)) {
            if (use.resource != id) continue;
            if (plan.passes[later].culled && needs_content(use))
                return fmt::format("only '{}', culled too, reads '{}'", other, name);
            if (!plan.passes[later].culled && replaces_content(use))
                return fmt::format("'{}' replaces '{}' before anything reads it", other, name);
        }
    }
    return fmt::format("nothing reads '{}'", name);
}

std::string culled_reason(const Declaration& declaration, const Plan& plan, PassId pass) {
    if (plan.passes[pass].cause == Cause::contradiction)
        return "culled: its conditions contradict each other";
    std::string text;
    for (const Use& use : declaration.uses_of(pass)) {
        if (!writes(use.access)) continue;
        if (!text.empty()) text += ", ";
        text += indifference(declaration, plan, pass, use.resource);
    }
    return "culled: " + (text.empty() ? "it writes nothing" : text);
}

std::string kept_reason(
    const Declaration& declaration, const PassDecl& pass, const Verdict& verdict) {
    if (verdict.cause == Cause::side_effect)
        return fmt::format("kept: side effect ({})", pass.side_effect);
    const ResourceDecl& resource = declaration.resources[verdict.resource];
    switch (verdict.cause) {
    case Cause::read:
        return fmt::format(
            "kept: '{}' reads its '{}'", declaration.passes[verdict.pass].name, resource.name);
    case Cause::exported:
        return fmt::format("kept: exported '{}' needs it{}", resource.name,
            with(" (", resource.export_reason, ")"));
    case Cause::persistent:
        return fmt::format("kept: persistent '{}' carries it to the next execution", resource.name);
    default:
        return fmt::format("kept: external '{}' hands it to the caller", resource.name);
    }
}

/// "queue family 1"
std::string family_text(std::uint32_t family) {
    if (family == VK_QUEUE_FAMILY_IGNORED) return "any queue family";
    if (family == VK_QUEUE_FAMILY_EXTERNAL) return "outside of Vulkan";
    return fmt::format("queue family {}", family);
}

/// Which resources had the memory that the resource of an alias barrier takes over: those that the
/// last pass to use it used, or where that pass is unknown all that had it; ", as 'a' and 'b'".
std::string earlier_tenants(
    const Declaration& declaration, const Plan& plan, const Barrier& barrier) {
    constexpr std::size_t shown = 3;
    const auto own = std::ranges::find(plan.placements, barrier.resource, &Placement::resource);
    if (own == plan.placements.end()) return {};
    std::vector<std::string> names;
    std::size_t more = 0;
    for (const Placement& other : plan.placements) {
        const bool overlaps = other.resource != own->resource && other.heap == own->heap &&
                              other.offset < own->offset + own->bytes &&
                              own->offset < other.offset + other.bytes;
        if (!overlaps) continue;
        const bool used = barrier.from == kNone ||
                          std::ranges::any_of(declaration.uses_of(barrier.from),
                              [&](const Use& use) { return use.resource == other.resource; });
        if (used && names.size() < shown)
            names.push_back(fmt::format("'{}'", declaration.resources[other.resource].name));
        else if (used)
            ++more;
    }
    if (more) names.push_back(more == 1 ? "another" : fmt::format("{} others", more));
    return names.empty() ? "" : ", as " + list_text(names);
}

} // namespace

std::string reason_of_pass(const Declaration& declaration, const Plan& plan, PassId id) {
    const PassDecl& pass = declaration.passes[id];
    const Verdict& verdict = plan.passes[id];
    return (verdict.culled ? culled_reason(declaration, plan, id)
                           : kept_reason(declaration, pass, verdict)) +
           with("; ", guard_text(declaration, pass.guard), "") + with("; ", pass.reason, "");
}

std::string reason_of_resource(const Declaration& declaration, const Plan& plan, ResourceId id) {
    const ResourceDecl& resource = declaration.resources[id];
    const Verdict& verdict = plan.resources[id];
    if (verdict.culled) return "culled: no live pass uses it";
    std::string text = "kept: a step of the history between two that are used";
    if (verdict.cause == Cause::used) {
        const std::string& first = declaration.passes[verdict.pass].name;
        const std::string& last = declaration.passes[verdict.last_pass].name;
        text = verdict.pass == verdict.last_pass
                   ? fmt::format("kept: used by '{}'", first)
                   : fmt::format("kept: used from '{}' to '{}'", first, last);
    }
    if (resource.history_depth)
        text += resource.history_age == 0
                    ? fmt::format("; newest of {} kept contents", resource.history_depth + 1)
                    : fmt::format("; {} execution{} old", resource.history_age,
                          resource.history_age == 1 ? "" : "s");
    else if (resource.lifetime == Lifetime::persistent)
        text += "; persistent";
    if (resource.lifetime == Lifetime::external) text += "; external";
    if (resource.exported) text += "; exported" + with(" (", resource.export_reason, ")");
    return text;
}

std::string reason_of_order(
    const Declaration& declaration, std::span<const Dependency> dependencies) {
    constexpr std::pair<Hazard, const char*> clauses[] = {
        {Hazard::read_after_write, "writes {0} for '{1}' to read"},
        {Hazard::write_after_read, "reads {0} before '{1}' changes {2}"},
        {Hazard::write_after_write, "writes {0} before '{1}' does"}};
    const auto& [before, after, resource, part, hazard] = dependencies.front();
    std::vector<std::string> text;
    for (const auto& [kind, clause] : clauses) {
        std::vector<std::string> parts;
        for (const Dependency& one : dependencies)
            if (one.hazard == kind)
                parts.push_back(part_of_text(declaration.resources[one.resource], one.part));
        if (!parts.empty())
            text.push_back(fmt::format(fmt::runtime(clause), list_text(parts),
                declaration.passes[after].name, parts.size() == 1 ? "it" : "them"));
    }
    return fmt::format("'{}' {}", declaration.passes[before].name, list_text(text));
}

std::string reason_of_barrier(
    const Declaration& declaration, const Plan& plan, const Barrier& barrier) {
    const ResourceDecl& resource = declaration.resources[barrier.resource];
    const auto quoted = [&](PassId pass, const char* none) {
        return pass == kNone ? none : fmt::format("'{}'", declaration.passes[pass].name);
    };
    const std::string from =
        quoted(barrier.from, resource.lifetime == Lifetime::external ? "the caller"
                             : barrier.to == kNone                   ? "this execution"
                                                                     : "the previous execution");
    const std::string to = quoted(barrier.to, "the caller");
    const std::string part = part_of_text(resource, barrier.part);
    switch (barrier.hazard) {
    case Hazard::read_after_write:
        return fmt::format("{} reads {} as {} left it", to, part, from);
    case Hazard::write_after_read:
        return fmt::format("{} may change {} only after {} has read it", to, part, from);
    case Hazard::write_after_write:
        return fmt::format("{} overwrites {}, which {} wrote", to, part, from);
    case Hazard::layout:
        return fmt::format("{} wants {} in layout {}, {} left it in {}", to, part,
            layout_text(barrier.new_layout), from, layout_text(barrier.old_layout));
    case Hazard::first_use:
        return fmt::format("{} begins {} anew", to, part);
    case Hazard::alias:
        return fmt::format("{} begins {} in memory that {} used last{}", to, part, from,
            earlier_tenants(declaration, plan, barrier));
    case Hazard::exit:
        return fmt::format("the caller gets {} after {}", part, from);
    case Hazard::release:
        return fmt::format("{} gives {} up from {} to {}, for {}", from, part,
            family_text(barrier.src_family), family_text(barrier.dst_family), to);
    case Hazard::acquire:
        return fmt::format("{} takes {} over in {} from {}, where {} had it", to, part,
            family_text(barrier.dst_family), family_text(barrier.src_family), from);
    }
    return {};
}

std::string reason_of_wait(const Declaration& declaration, const Plan& plan,
    std::span<const Dependency> direct, const Submission& submission, const Wait& wait) {
    const std::uint32_t awaited = submission_of(plan, wait.queue, wait.value);
    const std::vector<std::uint32_t> queues = queue_of_steps(plan);
    std::vector<std::uint32_t> step_of(plan.passes.size(), kNone);
    for (std::uint32_t i = 0; i < plan.steps.size(); ++i) step_of[plan.steps[i].pass] = i;
    const auto within = [](const Submission& one, std::uint32_t step) {
        return step - one.first_step < one.step_count; // steps before it wrap round
    };
    // The latest that the awaited queue does for a pass of this submission, or else a later one.
    const Dependency* best = nullptr;
    bool best_now = false;
    for (const Dependency& one : direct) {
        const std::uint32_t before = step_of[one.before], after = step_of[one.after];
        if (before == kNone || after == kNone || awaited == kNone) continue;
        const Submission& last = plan.submissions[awaited];
        if (queues[before] != wait.queue || before >= last.first_step + last.step_count ||
            queues[after] != submission.queue || after < submission.first_step)
            continue;
        const bool now = within(submission, after);
        if (best && (best_now > now || (best_now == now && step_of[best->before] >= before)))
            continue;
        best = &one;
        best_now = now;
    }
    if (best)
        return fmt::format(
            "for {}: {}", queue_text(wait.queue), reason_of_order(declaration, {best, 1}));
    if (submission.step_count == 0 || &submission == &plan.submissions.back())
        return fmt::format("for {}, before the execution ends", queue_text(wait.queue));
    return fmt::format(
        "for {}, which used memory that is begun anew here, or owned it", queue_text(wait.queue));
}

std::string queue_text(std::uint32_t queue) {
    return queue == 0 ? "the main queue" : fmt::format("queue {}", queue);
}

std::string summary(const Declaration& declaration, const Plan& plan) {
    const std::string queues = plan.queues.size() <= 1
                                   ? ""
                                   : fmt::format(", {} submissions to {} queues",
                                         plan.submissions.size(), plan.queues.size());
    return fmt::format("graph '{}': {} of {} passes, {} barriers in {} batches{}, {} (lower "
                       "bound {}, ratio {:.3f})\n",
        declaration.name, plan.steps.size(), declaration.passes.size(), plan.barriers.size(),
        plan.batches(), queues, size_text(plan.bytes_peak), size_text(plan.bytes_lower_bound),
        memory_ratio(plan));
}

std::string absences(const Declaration& declaration, const Plan& plan) {
    std::string text;
    for (std::size_t i = 0; i < plan.passes.size(); ++i)
        if (plan.passes[i].culled)
            text += fmt::format("pass '{}': {}\n", declaration.passes[i].name,
                reason_of_pass(declaration, plan, static_cast<PassId>(i)));
    for (std::size_t i = 0; i < plan.resources.size(); ++i)
        if (plan.resources[i].culled)
            text += fmt::format("{} '{}': {}\n", name_of(declaration.resources[i].kind),
                declaration.resources[i].name,
                reason_of_resource(declaration, plan, static_cast<ResourceId>(i)));
    for (const Omission& omission : declaration.omissions)
        text += fmt::format("{} '{}': omitted: {}\n", omission.is_pass ? "pass" : "resource",
            omission.name, omission.reason);
    return text;
}

namespace {

/// Why the step runs where it does, and what it waits for.
std::string step_text(const Declaration& declaration, const Plan& plan,
    std::span<const Dependency> direct, const Step& step) {
    std::string text;
    for (const std::span<const Dependency> pair : dependencies_of(direct, step.pass))
        text += fmt::format("    after: {}\n", reason_of_order(declaration, pair));
    for (const Barrier& barrier : plan.barriers_before(step))
        text += fmt::format(
            "    {}: {}\n", name_of(barrier.hazard), reason_of_barrier(declaration, plan, barrier));
    for (const Barrier& barrier : plan.releases_after(step))
        text += fmt::format("    {} afterwards: {}\n", name_of(barrier.hazard),
            reason_of_barrier(declaration, plan, barrier));
    return text;
}

/// Where several queues run: a line for each submission, with its waits.
std::string submission_text(const Declaration& declaration, const Plan& plan,
    std::span<const Dependency> direct, std::uint32_t index) {
    const Submission& submission = plan.submissions[index];
    std::string text = fmt::format("submission {}, {}:{}\n", index, queue_text(submission.queue),
        submission.step_count == 0 ? " only the last barriers" : "");
    for (std::uint32_t i = 0; i < submission.wait_count; ++i)
        text += fmt::format("    waits {}\n", reason_of_wait(declaration, plan, direct, submission,
                                                  plan.waits[submission.first_wait + i]));
    return text;
}

/// Where the peak of memory is, and why the largest resources do not share.
std::string memory_text(const Declaration& declaration, const Plan& plan) {
    constexpr std::size_t shown = 4;
    const Peak peak = memory_peak(plan);
    if (peak.live.empty()) return {};
    const auto name = [&](ResourceId id) {
        return fmt::format("'{}'", declaration.resources[id].name);
    };
    std::vector<std::string> names;
    for (const ResourceId id : peak.live) {
        if (names.size() == shown) break;
        names.push_back(name(id));
    }
    if (peak.live.size() > shown)
        names.push_back(fmt::format("{} smaller", peak.live.size() - shown));
    std::string text = fmt::format("memory: most lives in step {} ('{}'), {}: {}\n", peak.step,
        declaration.passes[plan.steps[peak.step].pass].name, size_text(peak.bytes),
        list_text(names));
    std::vector<Placement> largest = plan.placements;
    std::ranges::stable_sort(largest, std::greater<>(), &Placement::bytes);
    largest.resize(std::min(largest.size(), shown));
    std::vector<std::string> told; // a resource that shares with none is told once
    for (std::size_t i = 0; i < largest.size(); ++i)
        for (std::size_t k = 0; k < i; ++k) {
            std::string why =
                why_not_shared(declaration, plan, largest[k].resource, largest[i].resource);
            if (std::ranges::find(told, why) != told.end()) continue;
            text += fmt::format("    {}\n", why);
            told.push_back(std::move(why));
        }
    return text;
}

} // namespace

std::string explain(const Declaration& declaration, const Plan& plan) {
    const std::vector<Dependency> direct = direct_dependencies(declaration, plan);
    std::string text = summary(declaration, plan) + "\n";
    for (std::uint32_t k = 0; k < plan.submissions.size(); ++k) {
        const Submission& submission = plan.submissions[k];
        if (plan.submissions.size() > 1) text += submission_text(declaration, plan, direct, k);
        for (std::uint32_t i = 0; i < submission.step_count; ++i) {
            const Step& step = plan.steps[submission.first_step + i];
            text += fmt::format("step {}: '{}' is {}\n", submission.first_step + i,
                declaration.passes[step.pass].name, reason_of_pass(declaration, plan, step.pass));
            text += step_text(declaration, plan, direct, step);
        }
    }
    for (const Barrier& barrier : plan.exit_barriers())
        text += fmt::format("after: {}\n", reason_of_barrier(declaration, plan, barrier));
    text += "\n";
    for (const Placement& placement : plan.placements)
        text += fmt::format("{} '{}', {}: {}{}{}\n",
            name_of(declaration.resources[placement.resource].kind),
            declaration.resources[placement.resource].name, size_text(placement.bytes),
            reason_of_resource(declaration, plan, placement.resource),
            plan.heaps[placement.heap].shared ? "" : "; memory of its own",
            plan.concurrent[placement.resource] ? "; used by several queue families at once" : "");
    for (std::size_t i = 0; i < plan.resources.size(); ++i)
        if (declaration.resources[i].lifetime == Lifetime::external && !plan.resources[i].culled)
            text += fmt::format("{} '{}', memory of the caller: {}\n",
                name_of(declaration.resources[i].kind), declaration.resources[i].name,
                reason_of_resource(declaration, plan, static_cast<ResourceId>(i)));
    const std::string memory = memory_text(declaration, plan);
    if (!memory.empty()) text += "\n" + memory;
    const std::string culled = absences(declaration, plan);
    return culled.empty() ? text : fmt::format("{}\n{}", text, culled);
}

} // namespace ockham
