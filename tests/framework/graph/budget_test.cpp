// SPDX-License-Identifier: Apache-2.0
#include "framework/core/error.hpp"
#include "framework/graph/explain/budget.hpp"
#include "tests/framework/graph/plan_lines.hpp"
#include "tests/framework/graph/two_queues.hpp"

#include <gtest/gtest.h>

namespace ockham {
namespace {

TEST(Budget, ExactlyWhatThereIsSuffices) {
    const auto [graph, plan] = two_queues();
    EXPECT_EQ(over_budget(graph.declaration(), plan, {}), "");
    EXPECT_EQ(over_budget(graph.declaration(), plan,
                  {.passes = 4, .barriers = 7, .batches = 4, .submissions = 4, .bytes = 49152}),
        "");
}

TEST(Budget, SaysWhatIsTooMuchAndWhatIsLarge) {
    const auto [graph, plan] = two_queues();
    EXPECT_EQ(over_budget(graph.declaration(), plan,
                  {.passes = 3, .barriers = 5, .batches = 0, .submissions = 1, .bytes = 48000}),
        "4 passes, 1 above the budget of 3\n"
        "7 barriers, 2 above the budget of 5\n"
        "4 batches, 4 above the budget of 0\n"
        "4 submissions, 3 above the budget of 1\n"
        "48.0 KiB, 1.1 KiB above the budget of 46.9 KiB; the largest:\n"
        "    16.0 KiB  'color' kept: used from 'draw' to 'light'\n"
        "    16.0 KiB  'z' kept: used from 'shade' to 'compose'\n"
        "    16.0 KiB  'lit' kept: used from 'light' to 'compose'; exported (the picture)\n");
}

TEST(Budget, OfAFileThatLacksTheNumber) {
    try {
        over_budget(nlohmann::json::parse(R"({"passes": []})"), {.passes = 1, .batches = 1});
        FAIL() << "accepted";
    } catch (const Error& error) {
        EXPECT_STREQ(error.what(), "[bad-plan-file] the whole: has no 'memory'");
    }
}

} // namespace
} // namespace ockham
