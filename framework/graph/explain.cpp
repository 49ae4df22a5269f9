// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/explain.hpp"

#include "framework/graph/describe.hpp"
#include "framework/graph/words.hpp"

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

} // namespace

std::string reason_of_pass(const Declaration& declaration, const Plan& plan, PassId id) {
    const PassDecl& pass = declaration.passes[id];
    const Verdict& verdict = plan.passes[id];
    return (verdict.culled ? culled_reason(declaration, plan, id)
                           : kept_reason(declaration, pass, verdict)) +
           with("; ", pass.reason, "");
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
    if (resource.lifetime == Lifetime::persistent) text += "; persistent";
    if (resource.lifetime == Lifetime::external) text += "; external";
    if (resource.exported) text += "; exported" + with(" (", resource.export_reason, ")");
    return text;
}

std::string reason_of_barrier(const Declaration& declaration, const Barrier& barrier) {
    const auto quoted = [&](PassId pass, const char* none) {
        return pass == kNone ? none : fmt::format("'{}'", declaration.passes[pass].name);
    };
    const std::string from = quoted(barrier.from, "the previous execution or the caller");
    const std::string to = quoted(barrier.to, "the caller");
    const char* const resource = declaration.resources[barrier.resource].name.c_str();
    switch (barrier.hazard) {
    case Hazard::read_after_write:
        return fmt::format("{} reads '{}' as {} left it", to, resource, from);
    case Hazard::write_after_read:
        return fmt::format("{} may change '{}' only after {} has read it", to, resource, from);
    case Hazard::write_after_write:
        return fmt::format("{} overwrites '{}', which {} wrote", to, resource, from);
    case Hazard::layout:
        return fmt::format("{} wants '{}' in layout {}, {} left it in {}", to, resource,
            layout_text(barrier.new_layout), from, layout_text(barrier.old_layout));
    case Hazard::first_use:
        return fmt::format("{} begins '{}' anew", to, resource);
    case Hazard::alias:
        return fmt::format("{} begins '{}' in memory that {} used last", to, resource, from);
    case Hazard::exit:
        return fmt::format("the caller gets '{}' after {}", resource, from);
    case Hazard::release:
        return fmt::format("{} gives '{}' up to the queue of {}", from, resource, to);
    case Hazard::acquire:
        return fmt::format("{} takes '{}' over from the queue of {}", to, resource, from);
    }
    return {};
}

double memory_ratio(const Plan& plan) {
    return plan.bytes_lower_bound == 0
               ? 1.0
               : static_cast<double>(plan.bytes_peak) / static_cast<double>(plan.bytes_lower_bound);
}

std::string summary(const Declaration& declaration, const Plan& plan) {
    return fmt::format("graph '{}': {} of {} passes, {} barriers in {} batches, {} (lower "
                       "bound {}, ratio {:.3f})\n",
        declaration.name, plan.steps.size(), declaration.passes.size(), plan.barriers.size(),
        plan.batches(), size_text(plan.bytes_peak), size_text(plan.bytes_lower_bound),
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

std::string explain(const Declaration& declaration, const Plan& plan) {
    std::string text = summary(declaration, plan) + "\n";
    for (std::size_t i = 0; i < plan.steps.size(); ++i) {
        const PassId pass = plan.steps[i].pass;
        text += fmt::format("step {}: '{}' is {}\n", i, declaration.passes[pass].name,
            reason_of_pass(declaration, plan, pass));
        for (const Barrier& barrier : plan.barriers_before(plan.steps[i]))
            text += fmt::format(
                "    {}: {}\n", name_of(barrier.hazard), reason_of_barrier(declaration, barrier));
    }
    for (const Barrier& barrier : plan.exit_barriers())
        text += fmt::format("after: {}\n", reason_of_barrier(declaration, barrier));
    text += "\n";
    for (const Placement& placement : plan.placements)
        text += fmt::format("{} '{}', {}: {}{}\n",
            name_of(declaration.resources[placement.resource].kind),
            declaration.resources[placement.resource].name, size_text(placement.bytes),
            reason_of_resource(declaration, plan, placement.resource),
            plan.heaps[placement.heap].shared ? "" : "; memory of its own");
    for (std::size_t i = 0; i < plan.resources.size(); ++i)
        if (declaration.resources[i].lifetime == Lifetime::external && !plan.resources[i].culled)
            text += fmt::format("{} '{}', memory of the caller: {}\n",
                name_of(declaration.resources[i].kind), declaration.resources[i].name,
                reason_of_resource(declaration, plan, static_cast<ResourceId>(i)));
    const std::string culled = absences(declaration, plan);
    return culled.empty() ? text : fmt::format("{}\n{}", text, culled);
}

} // namespace ockham
