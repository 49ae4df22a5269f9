// SPDX-License-Identifier: Apache-2.0
// What is in the page: its data, all of it once, whatever the names. How it looks is for eyes.
#include "framework/graph/explain/plan_page.hpp"
#include "tests/framework/graph/plan_lines.hpp"
#include "tests/framework/graph/random_graph.hpp"
#include "tests/framework/graph/two_queues.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace ockham {
namespace {

using nlohmann::json;

/// The data of a page, as a browser would find it.
json data_of(const std::string& page) {
    const std::string begin = R"(<script type="application/json" id="plan">)";
    const std::size_t from = page.find(begin) + begin.size();
    return json::parse(page.substr(from, page.find("</script>", from) - from));
}

TEST(PlanPage, HoldsEverythingOnce) {
    RandomGraph random(7, 120);
    random.graph().omit_pass("shadows", "no light casts any");
    const Declaration& declaration = random.graph().declaration();
    const Plan plan = compile(declaration);
    const json data = data_of(plan_html(declaration, plan));
    ASSERT_EQ(data["passes"].size(), declaration.passes.size() + 1);
    for (std::size_t i = 0; i < declaration.passes.size(); ++i) {
        EXPECT_EQ(data["passes"][i]["name"], declaration.passes[i].name);
        EXPECT_EQ(data["passes"][i]["uses"].size(), declaration.passes[i].use_count);
    }
    EXPECT_EQ(data["passes"].back()["reason"], "omitted: no light casts any");
    ASSERT_EQ(data["resources"].size(), declaration.resources.size());
    for (std::size_t i = 0; i < declaration.resources.size(); ++i)
        EXPECT_EQ(data["resources"][i]["name"], declaration.resources[i].name);
    ASSERT_EQ(data["barriers"].size(), plan.barriers.size());
    for (const json& barrier : data["barriers"]) EXPECT_FALSE(barrier["reason"].empty());
    std::set<std::uint32_t> steps;
    for (const json& pass : data["passes"])
        if (pass.contains("step")) steps.insert(pass["step"].get<std::uint32_t>());
    EXPECT_EQ(steps.size(), plan.steps.size());
    EXPECT_EQ(data["times"]["unit"].size(), plan.steps.size());
    EXPECT_TRUE(data["times"]["ms"].empty());
}

TEST(PlanPage, SurvivesAnyName) {
    const std::string worst =
        "</script><!-- <script> \" ' & \\ `${1}` @plan@ \xe2\x80\xa8 \xf0\x9f\x8e\xa8 \xff\n";
    Graph graph(worst);
    BufferHandle buffer = graph.create_buffer("b" + worst, {64});
    auto pass = graph.add_compute_pass("p" + worst);
    buffer = pass.write("x", buffer);
    graph.export_resource(buffer, worst);
    const std::string page = plan_html(graph.declaration(), compile(graph.declaration()));
    std::string shown = worst; // what is not UTF-8 becomes a replacement character
    shown.replace(shown.find('\xff'), 1, "\xef\xbf\xbd");
    const json data = data_of(page);
    EXPECT_EQ(data["name"], shown);
    EXPECT_EQ(data["passes"][0]["name"], "p" + shown);
    EXPECT_EQ(data["resources"][0]["name"], "b" + shown);
    std::size_t scripts = 0;
    for (std::size_t at = 0; (at = page.find("</script", at)) != std::string::npos; ++at) ++scripts;
    EXPECT_EQ(scripts, 2u);
}

TEST(PlanPage, NeedsNothingElse) {
    const auto [graph, plan] = two_queues();
    const std::string page = plan_html(graph.declaration(), plan);
    for (const char* outside : {"http:", "https:", "src=", "<link", "@import", "fetch("})
        EXPECT_EQ(page.find(outside), std::string::npos) << outside;
}

TEST(PlanPage, TimesAndSkippedPasses) {
    const auto [graph, plan] = two_queues();
    const json data =
        data_of(plan_html(graph.declaration(), plan, std::vector<double>{2, 0.5, std::nan(""), 1}));
    EXPECT_EQ(data["times"]["ms"], json::parse("[2.0, 0.5, null, 1.0]"));
    EXPECT_EQ(data["times"]["start"], json::parse("[0.0, 2.0, 2.0, 2.5]"));
    EXPECT_EQ(data["times"]["unit"], json::parse("[0.0, 1.0, 1.0, 2.0]"));
    EXPECT_EQ(data["waits"][1]["reason"],
        "waits for queue 1: 'light' writes 'lit' for 'compose' to read");
    EXPECT_EQ(data["submissions"].size(), 4u);
}

} // namespace
} // namespace ockham
