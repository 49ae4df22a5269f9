// SPDX-License-Identifier: Apache-2.0
// The smallest use of the render graph: declare two passes, compile, execute, read back, print.
#include "framework/core/error.hpp"
#include "framework/graph/explain/dump.hpp"
#include "framework/runtime/commands.hpp"
#include "framework/runtime/executor.hpp"

#include <cstdio>
#include <cstring>
#include <numeric>

using namespace ockham;

int main() try {
    constexpr std::uint32_t kWidth = 640, kHeight = 480;

    // Declare. Handles are versions of content: writing returns the next one.
    Graph graph("hello");
    ImageHandle picture = graph.create_image(
        "picture", {.format = VK_FORMAT_R32_SFLOAT, .width = kWidth, .height = kHeight});
    BufferHandle sums = graph.create_buffer("row_sums", {.bytes = kHeight * sizeof(float)});

    PassBuilder draw = graph.add_compute_pass("draw_circle");
    picture = draw.write("picture", picture);
    draw.record([](Commands& commands) {
        commands.dispatch_over({.shader = "samples/hello.comp"}, {kWidth, kHeight, 1});
    });

    PassBuilder sum = graph.add_compute_pass("sum_rows");
    sum.sample("picture", picture);
    sums = sum.write("row_sums", sums);
    sum.record([](Commands& commands) {
        commands.dispatch_over({.shader = "samples/hello_sum.comp"}, {kHeight, 1, 1});
    });
    graph.export_resource(sums, "printed by the program");

    // Compile and execute: order, barriers and memory are the plan's business.
    gpu::Device device;
    Executor executor(device, std::move(graph));
    executor.execute();

    // Read back.
    const std::vector<std::byte> bytes = executor.read(sums);
    std::vector<float> rows(kHeight);
    std::memcpy(rows.data(), bytes.data(), bytes.size());
    const double area = std::accumulate(rows.begin(), rows.end(), 0.0);

    std::printf("%s", plan_text(executor.graph().declaration(), executor.plan()).c_str());
    for (const PassTime& time : executor.times()) {
        std::printf("%-12s %8.3f ms\n", time.pass.c_str(), time.milliseconds);
    }
    std::printf("pi is about %.4f\n", area / (0.4 * 0.4 * kHeight * kHeight));
    return 0;
} catch (const Error& error) {
    std::fprintf(stderr, "error: %s\n", error.what());
    return error.exit_code();
}
