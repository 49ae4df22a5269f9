// SPDX-License-Identifier: Apache-2.0
// What is made of times: medians, and traces that viewers understand. Needs no device.
#include "framework/app/report.hpp"
#include "framework/core/error.hpp"
#include "tests/framework/graph/two_queues.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace ockham {
namespace {

using nlohmann::ordered_json;

/// Two frames of two_queues(); 'shade' is skipped in the first.
FrameTimes two_frames() {
    FrameTimes times;
    times.add({{"draw", 2}, {"light", 5}, {"shade", 0.5, true}, {"compose", 1}});
    times.add({{"draw", 4}, {"light", 5}, {"shade", 3}, {"compose", 2}});
    return times;
}

TEST(FrameTimes, MediansLeaveOutSkippedFrames) {
    EXPECT_EQ(two_frames().medians(), (std::vector<double>{3, 5, 3, 1.5}));
    FrameTimes never;
    never.add({{"p", 0.1, true}});
    EXPECT_TRUE(std::isnan(never.medians()[0]));
    EXPECT_TRUE(FrameTimes().medians().empty());
}

TEST(Trace, LanesPassesAndArrows) {
    const auto [graph, plan] = two_queues();
    const ordered_json trace = two_frames().to_trace(graph.declaration(), plan);
    EXPECT_EQ(trace["displayTimeUnit"], "ms");
    std::vector<ordered_json> lanes, passes, arrows;
    for (const ordered_json& event : trace["traceEvents"]) {
        const std::string phase = event["ph"];
        ASSERT_TRUE(phase == "M" || phase == "X" || phase == "s" || phase == "f") << event;
        (phase == "M" ? lanes : phase == "X" ? passes : arrows).push_back(event);
    }
    ASSERT_EQ(lanes.size(), 3u);
    EXPECT_EQ(lanes[0]["args"]["name"], "two queues");
    EXPECT_EQ(lanes[1]["args"]["name"], "the main queue (family 0)");
    EXPECT_EQ(lanes[2]["args"]["name"], "queue 1 (family 1)");

    ASSERT_EQ(passes.size(), 8u); // us: draw 0-2000, light and shade from there, compose at 7000
    const double starts[] = {0, 2000, 2000, 7000, 8000, 12000, 12000, 17000};
    const int queues[] = {0, 1, 0, 0};
    for (std::size_t i = 0; i < 8; ++i) {
        EXPECT_DOUBLE_EQ(passes[i]["ts"].get<double>(), starts[i]) << i;
        EXPECT_EQ(passes[i]["tid"], queues[i % 4]) << i;
        EXPECT_EQ(passes[i]["args"]["frame"], i / 4);
        EXPECT_EQ(passes[i]["args"].contains("skipped"), i == 2);
    }
    EXPECT_EQ(passes[2]["name"], "shade (skipped)");
    EXPECT_EQ(passes[3]["dur"], 1000.0);
    EXPECT_EQ(passes[3]["cat"], "compute");
    EXPECT_EQ(passes[3]["args"]["reason"], "kept: exported 'lit' needs it (the picture)");
    EXPECT_EQ(passes[3]["args"]["barriers"],
        ordered_json::parse(R"js(["'compose' reads 'z' as 'shade' left it",
                                  "'compose' reads 'lit' as 'light' left it"])js"));

    ASSERT_EQ(arrows.size(), 8u); // two waits in each frame
    for (std::size_t i = 0; i < 8; i += 2) {
        EXPECT_EQ(arrows[i]["ph"], "s");
        EXPECT_EQ(arrows[i + 1]["ph"], "f");
        EXPECT_EQ(arrows[i]["id"], arrows[i + 1]["id"]);
        EXPECT_LE(arrows[i]["ts"].get<double>(), arrows[i + 1]["ts"].get<double>());
        EXPECT_NE(arrows[i]["tid"], arrows[i + 1]["tid"]);
    }
}

TEST(PlanPath, NamesTheFormats) {
    for (const char* good : {"a.txt", "a.json", "a.dot", "a.html"})
        EXPECT_NO_THROW(check_plan_path(good)) << good;
    try {
        check_plan_path("plan.svg");
        FAIL() << "accepted";
    } catch (const Error& error) {
        EXPECT_STREQ(error.what(),
            "--plan: found 'plan.svg', expected a file ending in .txt, .json, .dot, .html");
    }
}

} // namespace
} // namespace ockham
