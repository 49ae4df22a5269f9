// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/graph.hpp"
#include "tests/framework/graph/plan_lines.hpp"

#include <gtest/gtest.h>

#include <functional>

namespace ockham {
namespace {

TEST(Graph, WritingReturnsTheNextVersion) {
    Graph graph("g");
    const BufferHandle first = graph.create_buffer("data", {64});
    auto fill = graph.add_transfer_pass("fill");
    const BufferHandle second = fill.copy_to(first);
    auto add = graph.add_compute_pass("add");
    const BufferHandle third = add.read_write("data", second);
    EXPECT_EQ(first.version, 0u);
    EXPECT_EQ(second.version, 1u);
    EXPECT_EQ(third.version, 2u);
    EXPECT_EQ(third.resource, first.resource);
    EXPECT_TRUE(graph.declaration().misuses.empty());
    const Use& use = graph.declaration().uses[1];
    EXPECT_EQ(use.version, 1u);
    EXPECT_EQ(use.version_written, 2u);
}

TEST(Graph, FindReturnsTheNewestVersion) {
    Graph graph("g");
    const ImageHandle color = graph.create_image("color", kColor);
    auto pass = graph.add_compute_pass("pass");
    const ImageHandle written = pass.write("color", color);
    EXPECT_EQ(graph.find_image("color").version, written.version);
    EXPECT_EQ(graph.find_image("color").resource, written.resource);
    EXPECT_FALSE(graph.find_image("colour"));
    EXPECT_FALSE(graph.find_buffer("color")); // an image is not found as a buffer
    EXPECT_EQ(graph.desc(color).width, 64u);
}

TEST(Graph, PassRemembersWhatItWasTold) {
    Graph graph("g");
    graph.add_compute_pass("first");
    auto pass = graph.add_compute_pass("second");
    pass.because("it is nice").side_effect("prints").record([](Commands&) {});
    const PassDecl& decl = graph.declaration().passes[1];
    EXPECT_EQ(decl.reason, "it is nice");
    EXPECT_EQ(decl.side_effect, "prints");
    EXPECT_FALSE(graph.recorder(0));
    EXPECT_TRUE(graph.recorder(1));
}

TEST(Graph, AttachmentsKeepLoadAndClear) {
    Graph graph("g");
    const ImageHandle color = graph.create_image("color", kColor);
    const ImageHandle depth = graph.create_image("depth", kDepth);
    auto pass = graph.add_raster_pass("draw");
    (void)pass.color(color, LoadOp::clear, {1, 2, 3, 4});
    (void)pass.depth(depth, 0.5f);
    const auto& uses = graph.declaration().uses;
    EXPECT_EQ(uses[0].load, LoadOp::clear);
    EXPECT_EQ(graph.declaration().clears[0][3], 4.0f);
    EXPECT_EQ(uses[1].load, LoadOp::clear);
    EXPECT_EQ(graph.declaration().clears[1][0], 0.5f);
    EXPECT_FALSE(needs_content(uses[1]));
    EXPECT_TRUE(replaces_content(uses[1]));
}

TEST(Graph, NothingCompilesToNothing) {
    const Plan plan = compile(Graph("empty").declaration());
    EXPECT_TRUE(plan.steps.empty());
    EXPECT_TRUE(plan.barriers.empty());
    EXPECT_TRUE(plan.heaps.empty());
    EXPECT_EQ(plan.bytes_peak, 0u);
    EXPECT_EQ(plan.bytes_lower_bound, 0u);
    EXPECT_EQ(plan.batches(), 0u);
    EXPECT_EQ(compile(Declaration{}).steps.size(), 0u);
}

TEST(Graph, OnePass) {
    Graph graph("one");
    BufferHandle out = graph.create_buffer("out", {1000});
    auto pass = graph.add_compute_pass("pass");
    out = pass.write("out", out);
    graph.export_resource(out, "the result");
    const Plan plan = compile(graph.declaration());
    ASSERT_EQ(plan.steps.size(), 1u);
    EXPECT_EQ(plan.batches(), 1u);
    EXPECT_EQ(plan.bytes_peak, 1024u);
    EXPECT_EQ(plan.bytes_lower_bound, 1024u);
    // The previous execution wrote it too; nothing else is to be waited for.
    EXPECT_EQ(barrier_lines(graph.declaration(), plan),
        "pass <- (before): out first_use | compute/storage_write -> compute/storage_write\n");
}

/// One call more, or on something else, and the plan may be another.
TEST(Graph, EveryCallGivesAFingerprintOfItsOwn) {
    struct Parts {
        Graph graph{"g"};
        BufferHandle a, b;
        ImageHandle image;
    };
    using Call = std::function<void(Parts&, PassBuilder&)>;
    const auto fingerprint = [](const Call& first, const Call& second) {
        Parts parts;
        Graph& graph = parts.graph;
        parts.a = graph.create_buffer("a", {1024});
        parts.b = graph.create_buffer("b", {1024});
        parts.image = graph.create_persistent_image("image", {VK_FORMAT_R8_UNORM, 8, 8, 1, 2, 2});
        PassBuilder p = graph.add_compute_pass("p");
        parts.a = p.write("a", parts.a);
        first(parts, p);
        PassBuilder q = graph.add_compute_pass("q");
        parts.b = q.write("b", parts.b);
        second(parts, q);
        return graph.fingerprint();
    };
    const std::vector<Call> calls{
        [](Parts&, PassBuilder&) {},
        [](Parts&, PassBuilder& pass) { pass.prefer(QueueWish::async_compute); },
        [](Parts&, PassBuilder& pass) { pass.prefer(QueueWish::transfer); },
        [](Parts&, PassBuilder& pass) { pass.side_effect("x"); },
        [](Parts& parts, PassBuilder&) { parts.graph.export_resource(parts.a, "x"); },
        [](Parts& parts, PassBuilder&) { parts.graph.export_resource(parts.b, "x"); },
        [](Parts& parts, PassBuilder&) { (void)parts.graph.create_buffer("c", {1}); },
        [](Parts& parts, PassBuilder&) { (void)parts.graph.create_buffer("c", {2}); },
        [](Parts& parts, PassBuilder&) { (void)parts.graph.create_persistent_buffer("c", {1}); },
        [](Parts& parts, PassBuilder&) { (void)parts.graph.create_history_buffer("c", {1}, 1); },
        [](Parts& parts, PassBuilder&) { (void)parts.graph.create_history_buffer("c", {1}, 2); },
        [](Parts& parts, PassBuilder&) { (void)parts.graph.import_buffer("c", {1}, {}); },
        [](Parts& parts, PassBuilder&) {
            (void)parts.graph.import_buffer("c", {1}, {.queue_family = 1});
        },
        [](Parts& parts, PassBuilder&) { (void)parts.graph.add_condition("c"); },
        [](Parts& parts, PassBuilder&) {
            const GuardScope guard = parts.graph.when(parts.graph.add_condition("c"));
            (void)parts.graph.add_compute_pass("r");
        },
        [](Parts& parts, PassBuilder&) {
            const GuardScope guard = parts.graph.unless(parts.graph.add_condition("c"));
            (void)parts.graph.add_compute_pass("r");
        },
        [](Parts& parts, PassBuilder&) { (void)parts.graph.add_compute_pass("r"); },
        [](Parts& parts, PassBuilder&) { (void)parts.graph.add_transfer_pass("r"); },
        [](Parts& parts, PassBuilder& pass) { pass.sample("x", parts.image); },
        [](Parts& parts, PassBuilder& pass) { pass.sample("y", parts.image); },
        [](Parts& parts, PassBuilder& pass) { pass.sample("x", parts.image.mip(0)); },
        [](Parts& parts, PassBuilder& pass) { pass.sample("x", parts.image.layer(0)); },
        [](Parts& parts, PassBuilder& pass) {
            pass.sample("x", parts.image, Stage::compute, Filter::linear_clamp);
        },
        [](Parts& parts, PassBuilder& pass) { pass.read("x", parts.image); },
        [](Parts& parts, PassBuilder& pass) { (void)pass.write("x", parts.image); },
        [](Parts&, PassBuilder& pass) { pass.read("x", BufferHandle{}); }, // refused
    };
    std::vector<Fingerprint> found;
    for (const Call& call : calls) {
        found.push_back(fingerprint(call, calls[0]));
        if (&call != &calls[0]) found.push_back(fingerprint(calls[0], call));
        EXPECT_EQ(found.back(),
            &call == &calls[0] ? fingerprint(call, calls[0]) : fingerprint(calls[0], call));
    }
    // Exporting 'b' before its pass writes it is refused, as is the empty handle: both are misuses.
    for (std::size_t i = 0; i < found.size(); ++i)
        for (std::size_t k = 0; k < i; ++k)
            EXPECT_NE(found[i], found[k]) << "calls " << i << " and " << k;
}

} // namespace
} // namespace ockham
