// SPDX-License-Identifier: Apache-2.0
// Proves that the validation set-up is not blind: a plan with one barrier removed must be reported,
// and the whole plan must not. Each pattern is one that some set-up is known to miss.
#include "framework/gpu/buffer.hpp"
#include "framework/gpu/transfer.hpp"
#include "framework/runtime/commands.hpp"
#include "framework/runtime/executor.hpp"
#include "tests/support/gpu_fixture.hpp"

#include <algorithm>
#include <functional>

namespace ockham {
namespace {

class HazardTest : public test::GpuTest {
protected:
    /// Removes the barrier on `resource` before `pass`, which must exist.
    static void remove_barrier(
        const Declaration& declaration, Plan& plan, const char* resource, const char* pass) {
        std::size_t removed = 0;
        for (Barrier& barrier : plan.barriers) {
            if (barrier.to == kNone || declaration.passes[barrier.to].name != pass) continue;
            if (declaration.resources[barrier.resource].name != resource) continue;
            // Waiting for nothing, so that only the layout, if any, still changes.
            barrier.src_stages = barrier.dst_stages = VK_PIPELINE_STAGE_2_NONE;
            barrier.src_access = barrier.dst_access = VK_ACCESS_2_NONE;
            ++removed;
        }
        ASSERT_EQ(removed, 1u);
    }

    /// Executes as planned, expecting silence, then without one barrier, expecting a hazard.
    static void expect_detected(
        const std::function<Graph()>& make, const char* resource, const char* pass,
        const char* hazard, const std::function<void(Executor&)>& bind = [](Executor&) {}) {
        Graph whole = make();
        Plan plan = make_plan(device(), whole);
        Graph broken = whole;
        Plan mutated = plan;
        remove_barrier(broken.declaration(), mutated, resource, pass);
        {
            Executor executor(device(), std::move(whole), std::move(plan));
            bind(executor);
            executor.execute();
            ASSERT_EQ(device().validation_log().count(), 0u);
        }
        {
            Executor executor(device(), std::move(broken), std::move(mutated), {.verify = false});
            bind(executor);
            executor.execute();
        }
        const std::vector<std::string> messages = take_messages();
        const bool found = std::ranges::any_of(messages,
            [&](const std::string& text) { return text.find(hazard) != std::string::npos; });
        EXPECT_TRUE(found) << "no " << hazard << " among " << messages.size() << " messages";
    }
};

BufferHandle add_mark(Graph& graph, const char* name, BufferHandle marks) {
    PassBuilder pass = graph.add_compute_pass(name);
    marks = pass.read_write("marks", marks);
    pass.record([](Commands& commands) {
        const std::uint32_t value = 1;
        commands.dispatch({.shader = "test/mark.comp", .push = as_push(value)}, {1, 1, 1});
    });
    return marks;
}

BufferHandle add_numbers(Graph& graph, const char* name, BufferHandle numbers) {
    PassBuilder pass = graph.add_compute_pass(name);
    numbers = pass.write("numbers", numbers);
    pass.record([](Commands& commands) {
        const std::uint32_t push[] = {64, 0};
        commands.dispatch({.shader = "test/number.comp", .push = as_push(push)}, {1, 1, 1});
    });
    return numbers;
}

BufferHandle add_one(Graph& graph, const char* name, BufferHandle source, BufferHandle target) {
    PassBuilder pass = graph.add_compute_pass(name);
    pass.read("source", source);
    target = pass.write("target", target);
    pass.record([](Commands& commands) {
        commands.dispatch({.shader = "test/add_one.comp"}, {1, 1, 1});
    });
    return target;
}

TEST_F(HazardTest, ComputeWriteThenRead) {
    expect_detected(
        [] {
            Graph graph("read_after_write");
            const BufferHandle numbers =
                add_numbers(graph, "write", graph.create_buffer("numbers", {256}));
            graph.export_resource(
                add_one(graph, "read", numbers, graph.create_buffer("next", {256})), "checked");
            return graph;
        },
        "numbers", "read", "READ_AFTER_WRITE");
}

TEST_F(HazardTest, ComputeReadThenOverwrite) {
    expect_detected(
        [] {
            Graph graph("write_after_read");
            BufferHandle numbers =
                add_numbers(graph, "write", graph.create_persistent_buffer("numbers", {256}));
            graph.export_resource(
                add_one(graph, "read", numbers, graph.create_buffer("next", {256})), "checked");
            graph.export_resource(add_numbers(graph, "overwrite", numbers), "checked");
            return graph;
        },
        "numbers", "overwrite", "WRITE_AFTER_READ");
}

/// Not reported inside one command buffer, nor without the checks at queue submission.
TEST_F(HazardTest, ComputeAccumulateTwice) {
    expect_detected(
        [] {
            Graph graph("write_after_write");
            BufferHandle marks = graph.create_persistent_buffer("marks", {256});
            marks = add_mark(graph, "first", marks);
            graph.export_resource(add_mark(graph, "second", marks), "checked");
            return graph;
        },
        "marks", "second", "AFTER_WRITE");
}

TEST_F(HazardTest, ComputeOverwriteStorage) {
    expect_detected(
        [] {
            Graph graph("overwrite");
            BufferHandle numbers = graph.create_persistent_buffer("numbers", {256});
            PassBuilder fill = graph.add_compute_pass("first");
            numbers = fill.read_write("marks", numbers);
            fill.record([](Commands& commands) {
                const std::uint32_t value = 1;
                commands.dispatch({.shader = "test/mark.comp", .push = as_push(value)}, {1, 1, 1});
            });
            fill.side_effect("is overwritten on purpose");
            graph.export_resource(add_numbers(graph, "second", numbers), "checked");
            return graph;
        },
        "numbers", "second", "WRITE_AFTER_WRITE");
}

TEST_F(HazardTest, ComputeThenIndirectArguments) {
    expect_detected(
        [] {
            Graph graph("indirect");
            PassBuilder write = graph.add_compute_pass("write");
            const BufferHandle arguments =
                write.write("arguments", graph.create_buffer("arguments", {24}));
            write.record([](Commands& commands) {
                const std::uint32_t groups = 1;
                commands.dispatch(
                    {.shader = "test/arguments.comp", .push = as_push(groups)}, {1, 1, 1});
            });
            PassBuilder use = graph.add_compute_pass("use");
            use.indirect(arguments);
            const BufferHandle marks =
                use.read_write("marks", graph.create_persistent_buffer("marks", {256}));
            use.record([arguments](Commands& commands) {
                const std::uint32_t value = 1;
                commands.dispatch_indirect(
                    {.shader = "test/mark.comp", .push = as_push(value)}, arguments, 12);
            });
            graph.export_resource(marks, "checked");
            return graph;
        },
        "arguments", "use", "READ_AFTER_WRITE");
}

/// Not reported where raster passes use dynamic rendering.
TEST_F(HazardTest, RasterThenCompute) {
    const std::vector<float> corners{-1, -1, 0.5f, 1, 3, -1, 0.5f, 1, -1, 3, 0.5f, 1};
    const auto bytes = std::as_bytes(std::span(corners));
    const gpu::Buffer vertices(device(),
        {.bytes = bytes.size(),
            .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
            .name = "vertices"});
    gpu::upload(device(), vertices, bytes);
    BufferHandle imported;
    expect_detected(
        [&] {
            Graph graph("raster");
            const AccessState uploaded{
                VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_READ_BIT};
            imported = graph.import_buffer("vertices", {vertices.bytes()}, uploaded);
            PassBuilder draw = graph.add_raster_pass("draw");
            draw.read("vertices", imported, Stage::vertex);
            const ImageHandle depth =
                draw.depth(graph.create_image(
                               "depth", {.format = VK_FORMAT_D32_SFLOAT, .width = 8, .height = 8}),
                    0.0f);
            draw.record([](Commands& commands) {
                commands.bind({.vertex_shader = "test/triangle.vert"});
                const std::uint32_t id = 0;
                commands.push(as_push(id));
                commands.draw(3);
            });
            PassBuilder read = graph.add_compute_pass("read");
            read.sample("source", depth);
            const ImageHandle target = read.write(
                "target", graph.create_image(
                              "target", {.format = VK_FORMAT_R32_SFLOAT, .width = 8, .height = 8}));
            read.record([](Commands& commands) {
                commands.dispatch({.shader = "test/shift.comp"}, {1, 1, 1});
            });
            graph.export_resource(target, "checked");
            return graph;
        },
        "depth", "read", "AFTER_WRITE",
        [&](Executor& executor) { executor.bind(imported, vertices); });
}

} // namespace
} // namespace ockham
