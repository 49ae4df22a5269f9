// SPDX-License-Identifier: Apache-2.0
// The code of docs/graph.md that needs no device, run: each region is a block of that page, and
// what follows it says that it does what the page says.
#include "framework/core/error.hpp"
// [includes]
#include "framework/graph/compile.hpp"
#include "framework/graph/explain/dump.hpp"
#include "framework/graph/explain/explain.hpp"
#include "framework/graph/graph.hpp"
#include "framework/runtime/commands.hpp"
// [/includes]

#include "framework/graph/explain/budget.hpp"
#include "framework/graph/verify.hpp"

#include <gtest/gtest.h>

namespace ockham {
namespace {

const ImageDesc kPicture{.format = VK_FORMAT_R16G16B16A16_SFLOAT, .width = 64, .height = 48};

TEST(GraphGuide, FirstGraph) {
    // [first]
    ockham::Graph graph("blur");
    auto input = graph.create_persistent_image("input", {VK_FORMAT_R16G16B16A16_SFLOAT, 1024, 768});
    auto output = graph.create_image("output", {VK_FORMAT_R16G16B16A16_SFLOAT, 1024, 768});

    auto pass = graph.add_compute_pass("blur");
    pass.sample("source", input).because("the user asked for softness");
    output = pass.write("target", output); // the next version; the old handle is stale now
    pass.record([](ockham::Commands& commands) {
        commands.dispatch_over({.shader = "blur.comp"}, {1024, 768, 1});
    });

    graph.export_resource(output, "the picture");
    const ockham::Plan plan = ockham::compile(graph.declaration());
    fmt::print("{}", ockham::explain(graph.declaration(), plan));
    // [/first]
    EXPECT_EQ(plan.steps.size(), 1u);
    EXPECT_EQ(reason_of_pass(graph.declaration(), plan, 0),
        "kept: exported 'output' needs it (the picture); the user asked for softness");
}

// [function]
struct BlurParams {
    float radius_pixels = 2;
};

ImageHandle add_blur(Graph& graph, ImageHandle source, const BlurParams& params) {
    ImageHandle target = graph.create_image("blurred", graph.desc(source));
    PassBuilder pass = graph.add_compute_pass("blur");
    pass.sample("source", source, Stage::compute, Filter::linear_clamp);
    target = pass.write("target", target);
    const glm::uvec3 pixels{graph.desc(source).width, graph.desc(source).height, 1};
    pass.record([params, pixels](Commands& commands) {
        commands.dispatch_over({.shader = "blur.comp", .push = as_push(params)}, pixels);
    });
    return target;
}
// [/function]

TEST(GraphGuide, PassesAreFunctions) {
    Graph graph("g");
    const ImageHandle source = graph.create_persistent_image("source", kPicture);
    graph.export_resource(add_blur(graph, source, {}), "the picture");
    EXPECT_EQ(compile(graph.declaration()).steps.size(), 1u);
}

TEST(GraphGuide, Parts) {
    Graph graph("mips");
    // [parts]
    ImageHandle image = graph.create_image(
        "pyramid", {.format = VK_FORMAT_R16_SFLOAT, .width = 256, .height = 256, .mips = 9});
    PassBuilder top = graph.add_compute_pass("top");
    image = top.write("target", image.mip(0));
    for (std::uint32_t mip = 1; mip < 9; ++mip) {
        PassBuilder down = graph.add_compute_pass(fmt::format("down{}", mip));
        down.sample("source", image.mip(mip - 1));
        image = down.write("target", image.mip(mip)); // the other mips keep their content
    }
    // [/parts]
    graph.export_resource(image, "the pyramid");
    const Plan plan = compile(graph.declaration());
    EXPECT_EQ(plan.steps.size(), 9u);
    for (const Barrier& barrier : plan.barriers) EXPECT_LE(barrier.part.mips, 9u);

    // [ranges]
    BufferHandle counters = graph.create_buffer("counters", {.bytes = 1024});
    PassBuilder count = graph.add_compute_pass("count");
    counters = count.write("counters", counters.range(256, 64)); // bytes 256 to 319
    // [/ranges]
    EXPECT_EQ(counters.version, 1u);
}

TEST(GraphGuide, Histories) {
    Graph graph("taa");
    ImageHandle picture = graph.create_persistent_image("picture", kPicture);
    // [history]
    History<ImageHandle> color = graph.create_history_image("color", kPicture, 2);
    PassBuilder accumulate = graph.add_compute_pass("accumulate");
    accumulate.sample("picture", picture);
    accumulate.sample("one_ago", color.previous[0]).sample("two_ago", color.previous[1]);
    color.now = accumulate.write("color", color.now);
    // [/history]
    graph.export_resource(color.now, "the picture");
    const Plan plan = compile(graph.declaration());
    EXPECT_EQ(plan.heaps.size(), 4u);
}

TEST(GraphGuide, Conditions) {
    Graph graph("fog");
    ImageHandle picture = graph.create_persistent_image("picture", kPicture);
    // [condition]
    const Condition foggy = graph.add_condition("foggy");
    {
        const GuardScope guard = graph.when(foggy); // all passes added in this block
        PassBuilder fog = graph.add_compute_pass("fog");
        picture = fog.read_write("picture", picture);
    }
    // [/condition]
    const Plan plan = compile(graph.declaration());
    EXPECT_EQ(plan.steps.size(), 1u);
    EXPECT_NE(graph.declaration().passes[0].guard, kNone);
}

TEST(GraphGuide, Absence) {
    Graph graph("g");
    const bool has_textures = false;
    ImageHandle picture = graph.create_persistent_image("picture", kPicture);
    // [omit]
    if (has_textures) {
        picture = add_blur(graph, picture, {});
    } else {
        graph.omit_pass("blur", "the scene has no textures");
    }
    // [/omit]
    const std::string text = absences(graph.declaration(), compile(graph.declaration()));
    EXPECT_NE(text.find("pass 'blur': omitted: the scene has no textures"), std::string::npos);
}

TEST(GraphGuide, Imports) {
    Graph graph("g");
    // [import]
    const AccessState drawn{VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
        VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
    const AccessState shown{
        VK_PIPELINE_STAGE_2_BOTTOM_OF_PIPE_BIT, 0, VK_IMAGE_LAYOUT_PRESENT_SRC_KHR};
    const ImageHandle target = graph.import_image("swapchain", kPicture, drawn, shown);
    // [/import]
    auto pass = graph.add_compute_pass("p");
    (void)pass.read_write("target", target);
    const Plan plan = compile(graph.declaration());
    ASSERT_EQ(plan.exit_barrier_count, 1u);
    EXPECT_EQ(plan.exit_barriers()[0].new_layout, VK_IMAGE_LAYOUT_PRESENT_SRC_KHR);
}

TEST(GraphGuide, Queues) {
    Graph graph("g");
    const BufferHandle particles = graph.create_persistent_buffer("particles", {4096});
    // [queue]
    PassBuilder simulate = graph.add_compute_pass("simulate");
    simulate.prefer(QueueWish::async_compute);
    const BufferHandle moved = simulate.read_write("particles", particles);
    // [/queue]
    EXPECT_EQ(moved.version, 1u);
    EXPECT_EQ(compile(graph.declaration()).queues.size(), 1u);
}

TEST(GraphGuide, Policies) {
    Graph graph("g");
    // [policy]
    Policy policy;
    policy.order = Order::batched; // independent passes come together ...
    policy.batch_memory = 0.1;     // ... for at most 10 % more live bytes
    policy.memory_budget_bytes = std::uint64_t{256} << 20;
    const Plan plan = compile(graph.declaration(), {}, policy);
    // [/policy]
    EXPECT_TRUE(plan.steps.empty());
}

TEST(GraphGuide, Budgets) {
    Graph graph("g");
    const ImageHandle source = graph.create_persistent_image("source", kPicture);
    graph.export_resource(add_blur(graph, source, {}), "the picture");
    const Plan plan = compile(graph.declaration());
    // [budget]
    const Budget budget{.passes = 1, .barriers = 2, .bytes = std::uint64_t{1} << 20};
    EXPECT_EQ(over_budget(graph.declaration(), plan, budget), "");
    // [/budget]
    EXPECT_NE(over_budget(graph.declaration(), plan, {.passes = 0}), "");
}

TEST(GraphGuide, Verifier) {
    Graph graph("g");
    const ImageHandle source = graph.create_persistent_image("source", kPicture);
    graph.export_resource(add_blur(graph, source, {}), "the picture");
    // [verify]
    const Capabilities capabilities; // of the device; the defaults suit planning without one
    Plan plan = compile(graph.declaration(), capabilities);
    for (const Violation& violation : verify(graph.declaration(), plan, capabilities))
        fmt::print("{}\n", violation.text);
    // [/verify]
    EXPECT_TRUE(verify(graph.declaration(), plan, capabilities).empty());
    ASSERT_FALSE(plan.barriers.empty());
    plan.barriers[0].dst_stages = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT; // of another stage
    EXPECT_FALSE(verify(graph.declaration(), plan, capabilities).empty());
}

} // namespace
} // namespace ockham
