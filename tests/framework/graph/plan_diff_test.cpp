// SPDX-License-Identifier: Apache-2.0
#include "framework/core/error.hpp"
#include "framework/graph/explain/plan_diff.hpp"
#include "tests/framework/graph/plan_lines.hpp"
#include "tests/framework/graph/random_graph.hpp"
#include "tests/framework/graph/two_queues.hpp"

#include <gtest/gtest.h>

namespace ockham {
namespace {

using nlohmann::json;

TEST(PlanDiff, NothingBetweenEqualPlans) {
    RandomGraph random(11);
    const Declaration& declaration = random.graph().declaration();
    const json plan = plan_json(declaration, compile(declaration));
    EXPECT_EQ(plan_diff_text(plan_diff(plan, plan)), "no difference\n");
}

TEST(PlanDiff, NamesWhatChanged) {
    const auto [graph, plan] = two_queues();
    const json before = plan_json(graph.declaration(), plan);
    json after = before;
    after["passes"][2]["culled"] = true; // shade
    after["passes"][2]["reason"] = "culled: nothing reads 'z'";
    after["passes"][2].erase("step");
    after["passes"][1]["queue"] = 0;
    after["passes"].push_back({{"name", "blur"}, {"kind", "compute"}, {"culled", false},
        {"reason", "kept: side effect (softness)"}, {"step", 9}});
    after["resources"][0]["bytes"] = 32768;
    after["resources"][1]["culled"] = true; // z
    after["resources"].push_back({{"name", "soft"}, {"bytes", 1048576}, {"culled", false},
        {"reason", "kept: used by 'blur'"}});
    after["barriers"].erase(4); // first use of z
    after["barriers"].push_back(after["barriers"][5]);
    after["memory"]["bytes_peak"] = 49152 + 1048576;
    after["memory"]["batches"] = 3;
    const json diff = plan_diff(before, after);
    EXPECT_EQ(diff["numbers"]["bytes_peak"], json::parse(R"({"before": 49152, "after": 1097728})"));
    EXPECT_EQ(plan_diff_text(diff), R"(-1 batches, +1.0 MiB

new pass 'blur': kept: side effect (softness)
now culled: pass 'shade': culled: nothing reads 'z'
moved: pass 'light': from queue 1 to 0
new resource 'soft', 1.0 MiB: kept: used by 'blur'
gone resource 'z', 16.0 KiB
resized: 'color' from 16.0 KiB to 32.0 KiB (+16.0 KiB)
new barrier: read_after_write of 'lit' from 'light' to 'compose': compute/storage_write -> compute/storage_read+storage_write, general -> general ('compose' reads 'lit' as 'light' left it)
gone barrier: first_use of 'z' from '(before)' to 'shade': none/none -> depth_tests/depth_read+depth_write, undefined -> depth ('shade' begins 'z' anew)
)");
}

TEST(PlanDiff, OrderCounts) {
    const auto [graph, plan] = two_queues();
    const json before = plan_json(graph.declaration(), plan);
    json after = before;
    std::swap(after["passes"][1]["step"], after["passes"][2]["step"]);
    EXPECT_EQ(
        plan_diff_text(plan_diff(before, after)), "same numbers\n\npasses run in another order\n");
}

/// Plans of the first release have neither submissions, queues, steps nor reasons of barriers.
TEST(PlanDiff, ReadsOldPlans) {
    const json old = json::parse(R"({
        "passes": [{"name": "p", "kind": "compute", "culled": false, "reason": "kept"}],
        "resources": [], "barriers": [],
        "memory": {"batches": 0, "bytes_peak": 0, "bytes_lower_bound": 0}})");
    EXPECT_EQ(plan_diff_text(plan_diff(old, old)), "no difference\n");
}

TEST(PlanDiff, RefusesWhatIsNoPlan) {
    try {
        plan_diff(json::parse(R"({"passes": [{"name": "p", "culled": 1}]})"), json::object());
        FAIL() << "accepted";
    } catch (const Error& error) {
        EXPECT_STREQ(
            error.what(), "[bad-plan-file] /passes/0/culled: found number, expected true or false");
    }
}

} // namespace
} // namespace ockham
