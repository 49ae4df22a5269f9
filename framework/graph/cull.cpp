// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/phases.hpp"

#include <algorithm>
#include <span>

namespace ockham {

namespace {

std::span<const Use> uses_of(const Declaration& declaration, const PassDecl& pass) {
    return {declaration.uses.data() + pass.first_use, pass.use_count};
}

/// Seen from one point of the program order: what comes of the content of a resource afterwards.
struct Demand {
    bool needed = false;
    PassId by = kNone;             ///< the next pass that reads it; kNone: whoever comes after
    PassId overwritten_by = kNone; ///< the next live pass that replaces it
    PassId culled_reader = kNone;  ///< the next pass that would read it, but is culled
};

/// Why a write to `resource` that somebody needs is needed.
Verdict kept_for(const Demand& demand, ResourceId id, const ResourceDecl& resource) {
    using enum Verdict::Cause;
    const Verdict::Cause cause = demand.by != kNone                        ? read
                                 : resource.exported                       ? exported
                                 : resource.lifetime == Lifetime::external ? external
                                                                           : persistent;
    return {false, cause, demand.by, kNone, id};
}

/// Why a culled pass's write to `resource` is worth nothing.
Verdict culled_for(const Demand& demand, ResourceId id) {
    using enum Verdict::Cause;
    if (demand.culled_reader != kNone) return {true, unread_too, demand.culled_reader, kNone, id};
    if (demand.overwritten_by != kNone)
        return {true, overwritten, demand.overwritten_by, kNone, id};
    return {true, unread, kNone, kNone, id};
}

Verdict judge(
    const Declaration& declaration, const PassDecl& pass, const std::vector<Demand>& demands) {
    Verdict verdict{true, Verdict::Cause::writes_nothing, kNone, kNone, kNone};
    for (const Use& use : uses_of(declaration, pass)) {
        if (!writes(use.access)) continue;
        const Demand& demand = demands[use.resource];
        if (demand.needed)
            return kept_for(demand, use.resource, declaration.resources[use.resource]);
        if (verdict.resource == kNone) verdict = culled_for(demand, use.resource);
    }
    if (!pass.side_effect.empty()) return {false, Verdict::Cause::side_effect, kNone, kNone, kNone};
    return verdict;
}

/// Steps back over a pass: demands after it become demands before it.
void step_back(
    const Declaration& declaration, PassId id, bool culled, std::vector<Demand>& demands) {
    for (const Use& use : uses_of(declaration, declaration.passes[id])) {
        Demand& demand = demands[use.resource];
        if (culled) {
            if (needs_content(use)) demand.culled_reader = id;
        } else if (needs_content(use)) {
            demand = {true, id, kNone, kNone};
        } else if (replaces_content(use)) {
            demand = {false, kNone, id, kNone};
        }
    }
}

struct Users {
    PassId first = kNone, last = kNone;
};

Verdict judge(Users users) {
    if (users.first == kNone) return {true, Verdict::Cause::unused, kNone, kNone, kNone};
    return {false, Verdict::Cause::used, users.first, users.last, kNone};
}

} // namespace

void cull(const Declaration& declaration, const Pieces&, Plan& plan) {
    const std::size_t pass_count = declaration.passes.size();
    std::vector<Demand> demands(declaration.resources.size());
    for (std::size_t i = 0; i < demands.size(); ++i) {
        const ResourceDecl& resource = declaration.resources[i];
        demands[i].needed = resource.exported || resource.lifetime != Lifetime::transient;
    }
    plan.passes.resize(pass_count);
    std::size_t live = 0;
    for (auto id = static_cast<PassId>(pass_count); id-- > 0;) {
        plan.passes[id] = judge(declaration, declaration.passes[id], demands);
        step_back(declaration, id, plan.passes[id].culled, demands);
        live += !plan.passes[id].culled;
    }

    plan.steps.reserve(live);
    std::vector<Users> users(declaration.resources.size());
    for (PassId id = 0; id < pass_count; ++id) {
        if (plan.passes[id].culled) continue;
        plan.steps.push_back({.pass = id});
        for (const Use& use : uses_of(declaration, declaration.passes[id])) {
            Users& user = users[use.resource];
            if (user.first == kNone) user.first = id;
            user.last = id;
        }
    }
    plan.resources.reserve(users.size());
    for (const Users& user : users) plan.resources.push_back(judge(user));
}

} // namespace ockham
