// SPDX-License-Identifier: Apache-2.0
// Histories of depth 1 to 3: x(n) = x(n - 1) + x(n - depth) + n over six executions, in buffers,
// images and attachments, submitted by the executor and by the caller.
#include "framework/runtime/executor.hpp"
#include "tests/framework/runtime/small_passes.hpp"
#include "tests/support/gpu_fixture.hpp"

namespace ockham {
namespace {

using test::read_as;

constexpr std::uint32_t kExecutions = 6;

/// x(0) ... x(kExecutions - 1), and zeros before.
class Recurrence {
public:
    explicit Recurrence(std::uint32_t depth) {
        for (std::uint32_t n = 0; n < kExecutions; ++n) {
            values_.push_back(at(int(n) - 1) + at(int(n) - int(depth)) + n + 1);
        }
    }
    std::uint32_t at(int n) const { return n < 0 ? 0 : values_[static_cast<std::size_t>(n)]; }

private:
    std::vector<std::uint32_t> values_;
};

class HistoryTest : public test::GpuTest, public testing::WithParamInterface<std::uint32_t> {
protected:
    /// Executes six times; after each, `look(n)` compares.
    template <class Look>
    void run(Executor& executor, std::uint32_t& step, bool recorded, Look look) {
        for (std::uint32_t n = 0; n < kExecutions; ++n) {
            step = n + 1;
            if (recorded) {
                device().run(
                    "caller", [&](VkCommandBuffer commands) { executor.record(commands); });
            } else {
                executor.execute();
            }
            look(static_cast<int>(n));
        }
    }
};

TEST_P(HistoryTest, OfABuffer) {
    const std::uint32_t depth = GetParam();
    const Recurrence expected(depth);
    for (const bool recorded : {false, true}) {
        Graph graph("buffer_history");
        History<BufferHandle> history = graph.create_history_buffer("x", {256}, depth);
        auto step = std::make_shared<std::uint32_t>(0);
        PassBuilder pass = graph.add_compute_pass("recur");
        pass.read("newest", history.previous.front());
        pass.read("oldest", history.previous.back());
        history.now = pass.write("target", history.now);
        pass.record([step](Commands& commands) {
            commands.dispatch({.shader = "test/recur.comp", .push = as_push(*step)}, {1, 1, 1});
        });
        graph.export_resource(history.now, "checked");
        Executor executor(device(), std::move(graph));
        run(executor, *step, recorded, [&](int n) {
            EXPECT_EQ(read_as<std::uint32_t>(executor, history.now)[0], expected.at(n));
            for (std::uint32_t age = 1; age <= depth; ++age) {
                const auto values = read_as<std::uint32_t>(executor, history.previous[age - 1]);
                EXPECT_EQ(values[0], expected.at(n - int(age))) << n << ", age " << age;
            }
        });
    }
}

TEST_P(HistoryTest, OfAnImage) {
    const std::uint32_t depth = GetParam();
    const Recurrence expected(depth);
    for (const bool recorded : {false, true}) {
        Graph graph("image_history");
        constexpr ImageDesc desc{.format = VK_FORMAT_R32_UINT, .width = 7, .height = 5};
        History<ImageHandle> history = graph.create_history_image("x", desc, depth);
        auto step = std::make_shared<std::uint32_t>(0);
        PassBuilder pass = graph.add_compute_pass("recur");
        pass.sample("newest", history.previous.front());
        pass.sample("oldest", history.previous.back());
        history.now = pass.write("target", history.now);
        pass.record([step](Commands& commands) {
            commands.dispatch(
                {.shader = "test/recur_image.comp", .push = as_push(*step)}, {1, 1, 1});
        });
        graph.export_resource(history.now, "checked");
        Executor executor(device(), std::move(graph));
        run(executor, *step, recorded, [&](int n) {
            EXPECT_EQ(executor.read(history.now).at(6, 4, 0), float(expected.at(n)));
            for (std::uint32_t age = 1; age <= depth; ++age) {
                EXPECT_EQ(executor.read(history.previous[age - 1]).at(0, 0, 0),
                    float(expected.at(n - int(age))))
                    << n << ", age " << age;
            }
        });
    }
}

TEST_P(HistoryTest, OfAnAttachment) {
    const std::uint32_t depth = GetParam();
    const Recurrence expected(depth);
    for (const bool recorded : {false, true}) {
        Graph graph("attachment_history");
        constexpr ImageDesc desc{.format = VK_FORMAT_R32_UINT, .width = 7, .height = 5};
        History<ImageHandle> history = graph.create_history_image("x", desc, depth);
        auto step = std::make_shared<std::uint32_t>(0);
        PassBuilder pass = graph.add_raster_pass("recur");
        pass.sample("newest", history.previous.front(), Stage::fragment);
        pass.sample("oldest", history.previous.back(), Stage::fragment);
        history.now = pass.color(history.now);
        pass.record([step](Commands& commands) {
            commands.bind({.vertex_shader = "test/full.vert",
                .fragment_shader = "test/recur.frag",
                .depth_test = false,
                .depth_write = false});
            commands.push(as_push(*step));
            commands.draw(3);
        });
        graph.export_resource(history.now, "checked");
        Executor executor(device(), std::move(graph));
        run(executor, *step, recorded, [&](int n) {
            EXPECT_EQ(executor.read(history.now).at(3, 2, 0), float(expected.at(n)));
            EXPECT_EQ(executor.read(history.previous.back()).at(6, 4, 0),
                float(expected.at(n - int(depth))));
        });
    }
}

INSTANTIATE_TEST_SUITE_P(Depths, HistoryTest, testing::Values(1u, 2u, 3u));

/// Several in flight: each finds what the one before wrote, waited for on the device.
TEST_P(HistoryTest, InFlight) {
    const std::uint32_t depth = GetParam();
    const Recurrence expected(depth);
    Graph graph("in_flight");
    History<BufferHandle> history = graph.create_history_buffer("x", {256}, depth);
    auto step = std::make_shared<std::uint32_t>(0);
    PassBuilder pass = graph.add_compute_pass("recur");
    pass.read("newest", history.previous.front());
    pass.read("oldest", history.previous.back());
    history.now = pass.write("target", history.now);
    pass.record([step](Commands& commands) {
        commands.dispatch({.shader = "test/recur.comp", .push = as_push(*step)}, {1, 1, 1});
    });
    graph.export_resource(history.now, "checked");
    Executor executor(device(), std::move(graph), Policy{}, {.slots = 3});
    for (std::uint32_t n = 0; n < kExecutions; ++n) {
        *step = n + 1;
        executor.submit();
    }
    EXPECT_EQ(read_as<std::uint32_t>(executor, history.now)[0], expected.at(kExecutions - 1));
    EXPECT_EQ(read_as<std::uint32_t>(executor, history.previous.back())[0],
        expected.at(int(kExecutions) - 1 - int(depth)));
}

} // namespace
} // namespace ockham
