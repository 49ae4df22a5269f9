// SPDX-License-Identifier: Apache-2.0
// Poisoned memory: what was not written is seen, and what was written is not touched.
#include "framework/runtime/executor.hpp"
#include "tests/framework/runtime/small_passes.hpp"
#include "tests/support/gpu_fixture.hpp"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstdlib>

namespace ockham {
namespace {

using test::add_gradient;
using test::add_numbers;
using test::add_one;
using test::read_as;

constexpr std::uint32_t kPattern = 0x7fc0dead;

class PoisonTest : public test::GpuTest {};

/// 'half' claims to write all of the buffer, and writes every other number.
std::pair<Graph, BufferHandle> wrong_graph() {
    Graph graph("wrong");
    PassBuilder half = graph.add_compute_pass("half");
    const BufferHandle numbers = half.write("numbers", graph.create_buffer("numbers", {256}));
    half.record([](Commands& commands) {
        commands.dispatch({.shader = "test/even.comp"}, {1, 1, 1});
    });
    const BufferHandle next = add_one(graph, "next", numbers, graph.create_buffer("next", {256}));
    graph.export_resource(next, "checked");
    return {std::move(graph), next};
}

TEST_F(PoisonTest, ShowsWhatWasNotWritten) {
    EXPECT_TRUE(std::isnan(std::bit_cast<float>(kPattern)));
    auto [graph, next] = wrong_graph();
    Executor executor(device(), std::move(graph), Policy{}, {.poison = true});
    for (int execution = 0; execution < 2; ++execution) {
        executor.execute();
        const auto values = read_as<std::uint32_t>(executor, next);
        for (std::uint32_t i = 0; i < 64; ++i) {
            ASSERT_EQ(values[i], (i % 2 == 0 ? i : kPattern) + 1);
        }
    }
}

TEST_F(PoisonTest, ByTheEnvironment) {
    setenv("OCKHAM_POISON", "1", 1);
    auto [graph, next] = wrong_graph();
    Executor executor(device(), std::move(graph));
    unsetenv("OCKHAM_POISON");
    executor.execute();
    EXPECT_EQ(read_as<std::uint32_t>(executor, next)[1], kPattern + 1);
}

TEST_F(PoisonTest, LeavesCorrectGraphsAlone) {
    for (const bool poison : {false, true}) {
        Graph graph("right");
        // Chains of buffers and images that share memory, and one persistent sum.
        BufferHandle buffer = add_numbers(graph, "numbers", graph.create_buffer("b0", {4000}), 3);
        for (int i = 1; i < 5; ++i) {
            const std::string name = fmt::format("b{}", i);
            buffer = add_one(graph, "to_" + name, buffer, graph.create_buffer(name, {4000}));
        }
        graph.export_resource(buffer, "checked");
        constexpr ImageDesc desc{.format = VK_FORMAT_R32_SFLOAT, .width = 33, .height = 17};
        ImageHandle image = add_gradient(graph, "gradient", graph.create_image("i0", desc), 0);
        for (int i = 1; i < 4; ++i) {
            const std::string name = fmt::format("i{}", i);
            PassBuilder pass = graph.add_compute_pass("to_" + name);
            pass.sample("source", image);
            image = pass.write("target", graph.create_image(name, desc));
            pass.record([desc](Commands& commands) {
                commands.dispatch_over({.shader = "test/shift.comp"}, {desc.width, desc.height, 1});
            });
        }
        graph.export_resource(image, "checked");
        const BufferHandle sums =
            test::add_mark(graph, "sum", graph.create_persistent_buffer("sums", {256}), 2);
        graph.export_resource(sums, "checked");
        Executor executor(device(), std::move(graph), Policy{}, {.poison = poison});
        for (std::uint32_t execution = 1; execution <= 3; ++execution) {
            executor.execute();
            const auto values = read_as<std::uint32_t>(executor, buffer);
            for (std::uint32_t i = 0; i < 1000; ++i) ASSERT_EQ(values[i], i + 7);
            const Image picture = executor.read(image);
            for (int y = 0; y < 17; ++y) {
                for (int x = 0; x < 33; ++x) {
                    ASSERT_EQ(picture.at(x, y, 0), 8.0f * static_cast<float>(x + 100 * y) + 7.0f);
                }
            }
            EXPECT_EQ(read_as<std::uint32_t>(executor, sums)[63], 2 * execution);
        }
    }
}

} // namespace
} // namespace ockham
