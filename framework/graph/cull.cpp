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

void append_quoted(std::string& text, const std::string& name) {
    text += '\'';
    text += name;
    text += '\'';
}

void append_reason(
    std::string& text, const char* before, const std::string& reason, const char* after) {
    if (reason.empty()) return;
    text += before;
    text += reason;
    text += after;
}

/// Why a pass lives that writes `resource`.
void append_demand(std::string& text, const Declaration& declaration, const Demand& demand,
    const ResourceDecl& resource) {
    if (demand.by != kNone) {
        append_quoted(text, declaration.passes[demand.by].name);
        text += " reads its ";
        append_quoted(text, resource.name);
    } else if (resource.exported) {
        text += "exported ";
        append_quoted(text, resource.name);
        text += " needs it";
        append_reason(text, " (", resource.export_reason, ")");
    } else if (resource.lifetime == Lifetime::persistent) {
        text += "persistent ";
        append_quoted(text, resource.name);
        text += " carries it to the next execution";
    } else {
        text += "external ";
        append_quoted(text, resource.name);
        text += " hands it to the caller";
    }
}

/// Why a culled pass's write to `resource` is worth nothing.
void append_indifference(std::string& text, const Declaration& declaration, const Demand& demand,
    const ResourceDecl& resource) {
    if (demand.culled_reader != kNone) {
        text += "only ";
        append_quoted(text, declaration.passes[demand.culled_reader].name);
        text += ", culled too, reads ";
        append_quoted(text, resource.name);
    } else if (demand.overwritten_by != kNone) {
        append_quoted(text, declaration.passes[demand.overwritten_by].name);
        text += " replaces ";
        append_quoted(text, resource.name);
        text += " before anything reads it";
    } else {
        text += "nothing reads ";
        append_quoted(text, resource.name);
    }
}

Verdict judge(
    const Declaration& declaration, const PassDecl& pass, const std::vector<Demand>& demands) {
    Verdict verdict;
    const auto uses = uses_of(declaration, pass);
    const auto wanted = std::find_if(uses.begin(), uses.end(),
        [&](const Use& use) { return writes(use.access) && demands[use.resource].needed; });
    std::string& text = verdict.reason;
    if (wanted != uses.end()) {
        text = "kept: ";
        append_demand(
            text, declaration, demands[wanted->resource], declaration.resources[wanted->resource]);
    } else if (!pass.side_effect.empty()) {
        text = "kept: side effect (" + pass.side_effect + ")";
    } else {
        verdict.culled = true;
        text = "culled: ";
        const std::size_t start = text.size();
        for (const Use& use : uses) {
            if (!writes(use.access)) continue;
            if (text.size() != start) text += ", ";
            append_indifference(
                text, declaration, demands[use.resource], declaration.resources[use.resource]);
        }
        if (text.size() == start) text += "it writes nothing";
    }
    append_reason(text, "; ", pass.reason, "");
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

Verdict judge(const Declaration& declaration, const ResourceDecl& resource, Users users) {
    Verdict verdict;
    std::string& text = verdict.reason;
    if (users.first == kNone) {
        verdict.culled = true;
        text = "culled: no live pass uses it";
        return verdict;
    }
    text = "kept: used ";
    text += users.first == users.last ? "by " : "from ";
    append_quoted(text, declaration.passes[users.first].name);
    if (users.first != users.last) {
        text += " to ";
        append_quoted(text, declaration.passes[users.last].name);
    }
    if (resource.lifetime == Lifetime::persistent) text += "; persistent";
    if (resource.lifetime == Lifetime::external) text += "; external";
    if (resource.exported) {
        text += "; exported";
        append_reason(text, " (", resource.export_reason, ")");
    }
    return verdict;
}

} // namespace

void cull(const Declaration& declaration, Plan& plan) {
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
        plan.steps.push_back({id, 0, 0});
        for (const Use& use : uses_of(declaration, declaration.passes[id])) {
            Users& user = users[use.resource];
            if (user.first == kNone) user.first = id;
            user.last = id;
        }
    }
    plan.resources.reserve(users.size());
    for (std::size_t i = 0; i < users.size(); ++i)
        plan.resources.push_back(judge(declaration, declaration.resources[i], users[i]));
}

} // namespace ockham
