// SPDX-License-Identifier: Apache-2.0
// Proves that GPU-assisted validation is not blind: a kernel that leaves its buffer is reported,
// and one that stays inside is not.
#include "framework/core/log.hpp"
#include "framework/runtime/commands.hpp"
#include "tests/support/gpu_fixture.hpp"

namespace ockham {
namespace {

/// Messages while a kernel touches element `index` of a buffer of 64.
std::vector<std::string> messages_of_element(std::uint32_t index) {
    gpu::Device device({.validation = gpu::Validation::gpu});
    Graph graph("element");
    PassBuilder pass = graph.add_compute_pass("touch");
    const BufferHandle numbers =
        pass.read_write("numbers", graph.create_persistent_buffer("numbers", {64 * 4}));
    pass.record([index](Commands& commands) {
        commands.dispatch({.shader = "test/beyond.comp", .push = as_push(index)}, {1, 1, 1});
    });
    graph.export_resource(numbers, "checked");
    Executor executor(device, std::move(graph));
    executor.execute();
    return device.validation_log().take();
}

TEST(GpuAssistedTest, AccessBeyondABufferIsReported) {
    EXPECT_TRUE(messages_of_element(63).empty());
    log::set_sink([](log::Level, std::string_view) {}); // the message is expected
    const std::vector<std::string> messages = messages_of_element(64);
    log::set_sink({});
    ASSERT_FALSE(messages.empty());
    EXPECT_NE(messages[0].find("out of bounds"), std::string::npos) << messages[0];
}

} // namespace
} // namespace ockham
