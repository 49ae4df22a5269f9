// SPDX-License-Identifier: Apache-2.0
// Several executors on one device, each used by its own thread at the same time, sharing imports.
#include "framework/gpu/buffer.hpp"
#include "framework/gpu/image.hpp"
#include "framework/gpu/transfer.hpp"
#include "framework/runtime/executor.hpp"
#include "tests/framework/runtime/small_passes.hpp"
#include "tests/support/gpu_fixture.hpp"

#include <fmt/format.h>

#include <atomic>
#include <thread>

namespace ockham {
namespace {

using test::add_mark;
using test::add_numbers;
using test::add_one;
using test::read_as;

class ThreadsTest : public test::GpuTest {};

constexpr ImageDesc kDesc{.format = VK_FORMAT_R32_SFLOAT, .width = 16, .height = 16};

/// Declares, plans, creates, executes and reads three graphs; returns how many results were wrong.
int run(gpu::Device& device, const gpu::Image& texture, std::uint32_t thread) {
    int wrong = 0;
    for (std::uint32_t round = 0; round < 3; ++round) {
        const std::uint32_t offset = 100 * thread + round;
        Graph graph(fmt::format("thread {}, round {}", thread, round));
        BufferHandle buffer =
            add_numbers(graph, "numbers", graph.create_buffer("b0", {4096}), offset);
        for (int i = 1; i < 4; ++i) {
            const std::string name = fmt::format("b{}", i);
            buffer = add_one(graph, "to_" + name, buffer, graph.create_buffer(name, {4096}));
        }
        const BufferHandle marks =
            add_mark(graph, "mark", graph.create_persistent_buffer("marks", {256}), thread + 1);
        const AccessState sampled = state_of(Access::sampled, Stage::compute);
        const ImageHandle imported = graph.import_image("texture", kDesc, sampled, sampled);
        PassBuilder pass = graph.add_compute_pass("shift");
        pass.sample("source", imported);
        const ImageHandle picture = pass.write("target", graph.create_image("picture", kDesc));
        pass.record([](Commands& commands) {
            commands.dispatch({.shader = "test/shift.comp"}, {2, 2, 1});
        });
        graph.export_resource(buffer, "checked");
        graph.export_resource(marks, "checked");
        graph.export_resource(picture, "checked");
        Executor executor(device, std::move(graph), Policy{}, {.slots = 2});
        executor.bind(imported, texture);
        for (std::uint32_t execution = 1; execution <= 4; ++execution) {
            executor.submit();
            if (execution % 2) continue;
            const auto values = read_as<std::uint32_t>(executor, buffer);
            for (std::uint32_t i = 0; i < 1024; ++i) wrong += values[i] != i + offset + 3;
            wrong += read_as<std::uint32_t>(executor, marks)[63] != execution * (thread + 1);
            const Image image = executor.read(picture);
            for (const float value : image.plane(0)) wrong += value != 9.0f;
        }
    }
    return wrong;
}

TEST_F(ThreadsTest, FourThreadsOnOneDevice) {
    for (const gpu::Validation validation : {gpu::Validation::off, gpu::Validation::core}) {
        gpu::Device device({.validation = validation});
        {
            const gpu::Image texture(
                device, {.format = kDesc.format,
                            .width = kDesc.width,
                            .height = kDesc.height,
                            .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                            .name = "texture"});
            const std::vector<float> texels(256, 4.0f);
            gpu::upload(device, texture, 0, 0, std::as_bytes(std::span(texels)));
            std::atomic<int> wrong = 0;
            std::vector<std::thread> threads;
            for (std::uint32_t i = 0; i < 4; ++i) {
                threads.emplace_back([&, i] { wrong += run(device, texture, i); });
            }
            for (std::thread& thread : threads) thread.join();
            EXPECT_EQ(wrong, 0) << name_of(validation);
        }
        EXPECT_EQ(device.validation_messages(), std::vector<std::string>{});
        EXPECT_EQ(device.allocator().bytes_used(), 0u);
    }
}

} // namespace
} // namespace ockham
