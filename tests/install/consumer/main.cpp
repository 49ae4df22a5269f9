// SPDX-License-Identifier: Apache-2.0
// A program outside of Ockham's tree: rasterises a triangle, tints it in a compute pass, and exits
// with 0 if every pixel is right. Names no file of the tree but installed headers.
#include "consumer/tint.h"

#include "framework/core/error.hpp"
#include "framework/gpu/shader.hpp"
#include "framework/runtime/commands.hpp"
#include "framework/runtime/executor.hpp"

#include <cstdio>

using namespace ockham;

namespace {

constexpr int kSize = 64;
constexpr shader::Tint kTint = {.color = {0.25f, 0.5f, 1.0f}, .alpha = 0.75f};

/// Declares the two passes, executes them and returns the picture.
Image draw(gpu::Device& device, const char* tint_shader) {
    Graph graph("consumer");
    const ImageDesc desc = {
        .format = VK_FORMAT_R32G32B32A32_SFLOAT, .width = kSize, .height = kSize};
    ImageHandle drawn = graph.create_image("drawn", desc);
    ImageHandle tinted = graph.create_image("tinted", desc);

    PassBuilder triangle = graph.add_raster_pass("triangle");
    drawn = triangle.color(drawn, LoadOp::clear, {0.0f, 0.0f, 0.0f, 1.0f});
    triangle.record([](Commands& commands) {
        commands.bind({.vertex_shader = "consumer/triangle.vert",
            .fragment_shader = "consumer/triangle.frag",
            .depth_test = false,
            .depth_write = false});
        commands.draw(3);
    });

    PassBuilder tint = graph.add_compute_pass("tint");
    tint.sample("drawn", drawn);
    tinted = tint.write("tinted", tinted);
    tint.record([tint_shader](Commands& commands) {
        commands.dispatch_over({.shader = tint_shader, .push = as_push(kTint)}, {kSize, kSize, 1});
    });
    graph.export_resource(tinted, "checked by the program");

    Executor executor(device, std::move(graph));
    executor.execute();
    return executor.read(tinted);
}

/// Pixels whose colour is not the tint where `lit` and black elsewhere. The diagonal, where
/// triangle and background meet, may be either.
int count_wrong(const Image& picture, bool lit_above_diagonal) {
    int wrong = 0;
    for (int y = 0; y < kSize; ++y) {
        for (int x = 0; x < kSize; ++x) {
            if (x + y == kSize - 1) continue;
            const bool lit = (x + y < kSize - 1) == lit_above_diagonal;
            bool right = picture.at(x, y, 3) == kTint.alpha;
            for (int c = 0; c < 3; ++c) {
                right = right && picture.at(x, y, c) == (lit ? kTint.color[c] : 0.0f);
            }
            if (!right) ++wrong;
        }
    }
    return wrong;
}

} // namespace

int main() try {
    gpu::Device device;
    const int wrong = count_wrong(draw(device, "consumer/tint.comp"), true) +
                      count_wrong(draw(device, "consumer/tint.comp:inverted"), false);
    // Nothing here calls Ockham's passes, yet linking them brings their shaders along.
    const std::size_t words = gpu::find_shader("surface/metrics.comp").size();
    std::printf("%s: %d wrong pixels; surface/metrics.comp has %zu words\n",
        device.info().name.c_str(), wrong, words);
    return wrong == 0 && words > 0 ? 0 : 1;
} catch (const Error& error) {
    std::fprintf(stderr, "consumer: %s\n", error.what());
    return error.exit_code();
}
