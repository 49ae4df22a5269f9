// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/compile/checks.hpp"
#include "framework/graph/describe.hpp"

namespace ockham {

namespace {

template <class... Args>
[[noreturn]] void fail(
    const Declaration& declaration, fmt::format_string<Args...> text, Args&&... args) {
    fail_misuse(declaration, "malformed", text, std::forward<Args>(args)...);
}

void check_resource(const Declaration& declaration, ResourceId id) {
    const ResourceDecl& resource = declaration.resources[id];
    if (resource.kind > ResourceKind::image || resource.lifetime > Lifetime::external)
        fail(declaration, "resource {} is of an unknown kind or lifetime", id);
    const std::uint32_t depth = resource.history_depth, age = resource.history_age;
    if (depth == 0 && age == 0) return;
    const bool fits = age <= depth && age <= id && depth - age < declaration.resources.size() - id;
    if (!fits || resource.lifetime != Lifetime::persistent)
        fail(declaration, "{} is age {} of a history of depth {} that is not there",
            describe(resource), age, depth);
    const ResourceDecl& present = declaration.resources[id - age];
    if (present.history_age != 0 || present.history_depth != depth ||
        present.kind != resource.kind || present.buffer != resource.buffer ||
        present.image != resource.image)
        fail(declaration, "{} differs from {}, whose history it belongs to", describe(resource),
            describe(present));
    if (age != depth && declaration.resources[id + 1].history_age != age + 1)
        fail(declaration, "{} is not followed by the next older age of its history",
            describe(resource));
}

void check_guards(const Declaration& declaration) {
    for (GuardId id = 0; id < declaration.guards.size(); ++id) {
        const Guard& guard = declaration.guards[id];
        if (guard.condition >= declaration.conditions.size())
            fail(declaration, "guard {} asks condition {} of {}", id, guard.condition,
                declaration.conditions.size());
        if (guard.parent != kNone && guard.parent >= id)
            fail(declaration, "guard {} lies inside of guard {}, which comes no earlier", id,
                guard.parent);
    }
}

void check_use(const Declaration& declaration, const PassDecl& pass, const Use& use,
    std::vector<std::uint32_t>& versions, std::uint32_t& next_part) {
    if (use.resource >= declaration.resources.size())
        fail(declaration, "{} uses resource {} of {}", describe(pass), use.resource,
            declaration.resources.size());
    const ResourceDecl& resource = declaration.resources[use.resource];
    if (use.access > Access::host_read || use.stage > Stage::fixed || use.load > LoadOp::load ||
        use.filter > Filter::linear_repeat)
        fail(declaration, "{} uses {} in an unknown way", describe(pass), describe(resource));
    if (use.part != kNone && use.part != next_part++)
        fail(declaration, "{} uses part {} of {}, where part {} is next", describe(pass), use.part,
            declaration.parts.size(), next_part - 1);
    if (use.binding != kNone && use.binding >= declaration.bindings.size())
        fail(declaration, "{} binds {} to name {} of {}", describe(pass), describe(resource),
            use.binding, declaration.bindings.size());
    std::uint32_t& version = versions[use.resource];
    const std::uint32_t made = writes(use.access) ? version + 1 : kNone;
    if (use.version != version || use.version_written != made)
        fail(declaration, "{} sees version {} of {} where the passes before it leave version {}",
            describe(pass), use.version, describe(resource), version);
    if (made != kNone) version = made;
}

} // namespace

void check_structure(const Declaration& declaration) {
    for (ResourceId id = 0; id < declaration.resources.size(); ++id)
        check_resource(declaration, id);
    check_guards(declaration);
    if (declaration.clears.size() != declaration.uses.size())
        fail(declaration, "{} uses have {} clear values", declaration.uses.size(),
            declaration.clears.size());
    std::vector<std::uint32_t> versions(declaration.resources.size(), 0);
    std::uint32_t next_use = 0, next_part = 0;
    for (PassId id = 0; id < declaration.passes.size(); ++id) {
        const PassDecl& pass = declaration.passes[id];
        if (pass.kind > PassKind::transfer || pass.queue > QueueWish::transfer)
            fail(declaration, "pass {} is of an unknown kind or wishes for an unknown queue", id);
        if (pass.guard != kNone && pass.guard >= declaration.guards.size())
            fail(declaration, "{} has guard {} of {}", describe(pass), pass.guard,
                declaration.guards.size());
        if (pass.first_use != next_use || pass.use_count > declaration.uses.size() - next_use)
            fail(declaration, "{} has uses {} to {} of {}", describe(pass), pass.first_use,
                pass.first_use + pass.use_count, declaration.uses.size());
        next_use += pass.use_count;
        for (const Use& use : declaration.uses_of(id))
            check_use(declaration, pass, use, versions, next_part);
    }
    if (next_part != declaration.parts.size())
        fail(declaration, "{} parts belong to no use", declaration.parts.size() - next_part);
    if (next_use != declaration.uses.size())
        fail(declaration, "{} of {} uses belong to no pass", declaration.uses.size() - next_use,
            declaration.uses.size());
}

} // namespace ockham
