// SPDX-License-Identifier: Apache-2.0
// Properties that every plan has, on random graphs.
#include "framework/graph/shuffle.hpp"
#include "framework/graph/verify.hpp"
#include "tests/framework/graph/plan_lines.hpp"
#include "tests/framework/graph/random_graph.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace ockham {
namespace {

constexpr std::uint64_t kGraphs = 1000;

TEST(Random, PlansAreSound) {
    std::vector<double> ratios;
    std::size_t steps = 0, barriers = 0, placements = 0;
    for (std::uint64_t seed = 0; seed < kGraphs; ++seed) {
        RandomGraph random(seed);
        const Declaration& declaration = random.graph().declaration();
        const Plan plan = compile(declaration);
        const std::string problems = violations_text(verify(declaration, plan));
        ASSERT_EQ(problems, "") << "seed " << seed << "\n" << plan_text(declaration, plan);
        ASSERT_GE(plan.bytes_peak, plan.bytes_lower_bound) << "seed " << seed;
        if (plan.bytes_lower_bound)
            ratios.push_back(
                static_cast<double>(plan.bytes_peak) / static_cast<double>(plan.bytes_lower_bound));
        steps += plan.steps.size();
        barriers += plan.barriers.size();
        placements += plan.placements.size();
    }
    std::sort(ratios.begin(), ratios.end());
    const auto quantile = [&](double q) {
        return ratios[static_cast<std::size_t>(q * static_cast<double>(ratios.size() - 1))];
    };
    fmt::print("{} graphs, {} steps, {} barriers, {} placed resources; peak / lower bound: median "
               "{:.3f}, 95 % {:.3f}, largest {:.3f}\n",
        kGraphs, steps, barriers, placements, quantile(0.5), quantile(0.95), ratios.back());
    EXPECT_LE(quantile(0.95), 1.10);
    EXPECT_GT(placements, kGraphs); // the graphs are not trivial
}

TEST(Random, PlansWithoutAliasingAreSound) {
    Policy policy;
    policy.alias_memory = false;
    for (std::uint64_t seed = 0; seed < 100; ++seed) {
        RandomGraph random(seed);
        const Declaration& declaration = random.graph().declaration();
        const Plan plan = compile(declaration, {}, policy);
        ASSERT_EQ(violations_text(verify(declaration, plan)), "") << "seed " << seed;
    }
}

/// Culling by its definition: what a pass writes reaches a live reader or the outside.
TEST(Random, CullingKeepsExactlyWhatIsNeeded) {
    for (std::uint64_t seed = 0; seed < kGraphs; ++seed) {
        RandomGraph random(seed);
        const Declaration& declaration = random.graph().declaration();
        const Plan plan = compile(declaration);
        const std::size_t count = declaration.passes.size();
        const auto find = [&](std::size_t pass, ResourceId id) -> const Use* {
            for (std::uint32_t i = 0; i < declaration.passes[pass].use_count; ++i) {
                const Use& use = declaration.uses[declaration.passes[pass].first_use + i];
                if (use.resource == id) return &use;
            }
            return nullptr;
        };
        std::vector<char> live(count, 0);
        for (std::size_t p = count; p-- > 0;) {
            bool needed = !declaration.passes[p].side_effect.empty();
            for (ResourceId id = 0; id < declaration.resources.size() && !needed; ++id) {
                const Use* const write = find(p, id);
                if (!write || !writes(write->access)) continue;
                const ResourceDecl& resource = declaration.resources[id];
                bool reaches_end = true;
                for (std::size_t later = p + 1; later < count && reaches_end; ++later) {
                    const Use* const use = find(later, id);
                    if (!use || !live[later]) continue;
                    if (needs_content(*use)) needed = true;
                    if (needs_content(*use) || replaces_content(*use)) reaches_end = false;
                }
                if (reaches_end && (resource.exported || resource.lifetime != Lifetime::transient))
                    needed = true;
            }
            live[p] = needed;
            ASSERT_EQ(needed, !plan.passes[p].culled)
                << "seed " << seed << ", " << declaration.passes[p].name;
        }
    }
}

TEST(Random, EqualDeclarationsGiveEqualPlans) {
    for (std::uint64_t seed = 0; seed < 100; ++seed) {
        const auto text = [&] {
            RandomGraph random(seed);
            Plan plan = compile(random.graph().declaration());
            plan.compile_us = 0;
            return plan_json(random.graph().declaration(), plan).dump() +
                   plan_text(random.graph().declaration(), plan);
        };
        ASSERT_EQ(text(), text()) << "seed " << seed;
    }
}

TEST(Random, ShuffledDeclarationsMeanTheSame) {
    const auto culled = [](const Plan& plan) {
        std::vector<bool> flags;
        for (const Verdict& pass : plan.passes) flags.push_back(pass.culled);
        return flags;
    };
    std::size_t other = 0;
    for (std::uint64_t seed = 0; seed < 300; ++seed) {
        RandomGraph random(seed);
        const Declaration& declaration = random.graph().declaration();
        std::vector<PassId> order;
        const Declaration after = shuffled(declaration, seed, order);
        ASSERT_EQ(after.uses.size(), declaration.uses.size());
        other += !std::is_sorted(order.begin(), order.end());
        // Every resource goes through its versions in their order.
        std::vector<std::uint32_t> version(after.resources.size(), 0);
        for (const Use& use : after.uses) {
            ASSERT_EQ(use.version, version[use.resource]) << "seed " << seed;
            if (use.version_written != kNone) version[use.resource] = use.version_written;
        }
        const Plan plan = compile_shuffled(declaration, {}, {}, seed);
        ASSERT_EQ(violations_text(verify(declaration, plan)), "") << "seed " << seed;
        EXPECT_EQ(culled(plan), culled(compile(declaration))) << "seed " << seed;
    }
    EXPECT_GT(other, 150u);
}

} // namespace
} // namespace ockham
