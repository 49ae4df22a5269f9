// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/shuffle.hpp"

#include "framework/core/rng.hpp"

#include <utility>

namespace ockham {

namespace {

/// Whether one changes what the other touches, or both do what the graph does not see.
bool must_keep_order(const Declaration& declaration, PassId a, PassId b) {
    for (const Use& x : declaration.uses_of(a))
        for (const Use& y : declaration.uses_of(b))
            if (x.resource == y.resource && (writes(x.access) || writes(y.access))) return true;
    return !declaration.passes[a].side_effect.empty() && !declaration.passes[b].side_effect.empty();
}

/// All passes, each after those that must stay before it.
std::vector<PassId> random_order(const Declaration& declaration, std::uint64_t seed) {
    const auto count = static_cast<PassId>(declaration.passes.size());
    std::vector<std::vector<PassId>> later(count);
    std::vector<std::uint32_t> waits(count, 0);
    std::vector<PassId> ready, order;
    for (PassId b = 0; b < count; ++b) {
        for (PassId a = 0; a < b; ++a) {
            if (!must_keep_order(declaration, a, b)) continue;
            later[a].push_back(b);
            ++waits[b];
        }
        if (waits[b] == 0) ready.push_back(b);
    }
    Pcg32 rng(seed);
    while (!ready.empty()) {
        std::swap(ready[rng.below(static_cast<std::uint32_t>(ready.size()))], ready.back());
        const PassId next = ready.back();
        ready.pop_back();
        order.push_back(next);
        for (const PassId pass : later[next])
            if (--waits[pass] == 0) ready.push_back(pass);
    }
    return order;
}

} // namespace

Declaration shuffled(
    const Declaration& declaration, std::uint64_t seed, std::vector<PassId>& order) {
    order = random_order(declaration, seed);
    Declaration result = declaration;
    result.passes.clear();
    result.uses.clear();
    result.clears.clear();
    for (const PassId id : order) {
        PassDecl pass = declaration.passes[id];
        pass.first_use = static_cast<std::uint32_t>(result.uses.size());
        result.passes.push_back(std::move(pass));
        for (const Use& use : declaration.uses_of(id)) {
            result.uses.push_back(use);
            result.clears.push_back(declaration.clear_of(use));
        }
    }
    return result;
}

Plan compile_shuffled(const Declaration& declaration, const Capabilities& capabilities,
    const Policy& policy, std::uint64_t seed) {
    // compile() refuses these before it looks at passes.
    if (!declaration.misuses.empty()) return compile(declaration, capabilities, policy);
    std::vector<PassId> order;
    Plan plan = compile(shuffled(declaration, seed, order), capabilities, policy);
    const auto rename = [&](PassId& pass) {
        if (pass != kNone) pass = order[pass];
    };
    for (Step& step : plan.steps) rename(step.pass);
    for (Barrier& barrier : plan.barriers) {
        rename(barrier.from);
        rename(barrier.to);
    }
    for (std::vector<Verdict>* verdicts : {&plan.passes, &plan.resources})
        for (Verdict& verdict : *verdicts) {
            rename(verdict.pass);
            rename(verdict.last_pass);
        }
    std::vector<Verdict> passes(plan.passes.size());
    for (PassId pass = 0; pass < order.size(); ++pass) passes[order[pass]] = plan.passes[pass];
    plan.passes = std::move(passes);
    return plan;
}

} // namespace ockham
