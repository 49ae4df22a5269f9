// SPDX-License-Identifier: Apache-2.0
// Plans for several queues, executed. Where the device has one queue, all of the plan's run on it,
// with its submissions, timelines and waits; results must be those of one queue. Under Validation
// `core`: the layer 1.3.239 sees no dependency in timeline semaphores, and reports hazards between
// submissions that wait for each other.
#include "framework/gpu/buffer.hpp"
#include "framework/gpu/image.hpp"
#include "framework/gpu/transfer.hpp"
#include "framework/graph/verify.hpp"
#include "framework/runtime/executor.hpp"
#include "tests/framework/runtime/small_passes.hpp"
#include "tests/support/gpu_fixture.hpp"

#include <dlfcn.h>

#include <optional>
#include <span>
#include <vector>

namespace {

struct Submitted {
    std::vector<VkSemaphoreSubmitInfo> waits, signals;
};
/// What was submitted with semaphores since the last clear().
std::vector<Submitted> submitted;
/// Which of them fails, counted from 1; 0: none.
std::size_t failing = 0;

} // namespace

/// Stands before the loader's, to see submissions and to refuse one.
VkResult vkQueueSubmit2(
    VkQueue queue, std::uint32_t count, const VkSubmitInfo2* infos, VkFence fence) {
    for (const VkSubmitInfo2& info : std::span(infos, count)) {
        const std::span waits(info.pWaitSemaphoreInfos, info.waitSemaphoreInfoCount);
        const std::span signals(info.pSignalSemaphoreInfos, info.signalSemaphoreInfoCount);
        submitted.push_back({{waits.begin(), waits.end()}, {signals.begin(), signals.end()}});
    }
    if (submitted.size() == failing) return VK_ERROR_OUT_OF_HOST_MEMORY;
    static const auto next =
        reinterpret_cast<PFN_vkQueueSubmit2>(dlsym(RTLD_NEXT, "vkQueueSubmit2"));
    return next(queue, count, infos, fence);
}

namespace ockham {
namespace {

using test::add_gradient;
using test::add_mark;
using test::add_numbers;
using test::add_one;
using test::error_of;
using test::read_as;

constexpr QueueFamily kMain{.queues = 1};
constexpr QueueFamily kCompute{.graphics = false, .queues = 1};
constexpr QueueFamily kTransfer{.graphics = false, .compute = false, .queues = 1};

struct Families {
    const char* name;
    std::vector<QueueFamily> families;
    std::size_t queues;
};

class QueuesTest : public test::GpuTest, public testing::WithParamInterface<Families> {
protected:
    void SetUp() override {
        core_.emplace(gpu::DeviceOptions{.validation = gpu::Validation::core});
    }
    void TearDown() override {
        EXPECT_EQ(core_->validation_messages(), std::vector<std::string>{});
        core_.reset();
        GpuTest::TearDown();
    }
    gpu::Device& core() { return *core_; }

private:
    std::optional<gpu::Device> core_;
};

struct Mixed {
    Graph graph{"mixed"};
    BufferHandle sums, numbers;
    ImageHandle picture;
    History<BufferHandle> history;
};

/// Work on the main queue, beside it, and copies between both; kept and transient resources.
Mixed mixed(const std::shared_ptr<std::uint32_t>& step) {
    Mixed m;
    Graph& graph = m.graph;
    m.sums = graph.create_persistent_buffer("sums", {256});
    m.history = graph.create_history_buffer("x", {256}, 2);

    BufferHandle numbers = add_numbers(graph, "numbers", graph.create_buffer("a", {4096}), 5);
    PassBuilder upload = graph.add_transfer_pass("copy");
    upload.prefer(QueueWish::transfer);
    upload.copy_from(numbers);
    const BufferHandle copied = upload.copy_to(graph.create_buffer("b", {4096}));
    upload.record([=](Commands& commands) { commands.copy(numbers, copied); });

    // Beside: a recurrence, and a sum over executions.
    PassBuilder recur = graph.add_compute_pass("recur");
    recur.prefer(QueueWish::async_compute);
    recur.read("newest", m.history.previous.front());
    recur.read("oldest", m.history.previous.back());
    m.history.now = recur.write("target", m.history.now);
    recur.record([step](Commands& commands) {
        commands.dispatch({.shader = "test/recur.comp", .push = as_push(*step)}, {1, 1, 1});
    });
    PassBuilder beside = graph.add_compute_pass("beside");
    beside.prefer(QueueWish::async_compute);
    beside.read("source", copied);
    const BufferHandle shifted = beside.write("target", graph.create_buffer("c", {4096}));
    beside.record([](Commands& commands) {
        commands.dispatch_over({.shader = "test/add_one.comp"}, {1024, 1, 1});
    });
    m.sums = add_mark(graph, "mark", m.sums, 3);

    constexpr ImageDesc desc{.format = VK_FORMAT_R32_SFLOAT, .width = 33, .height = 17};
    ImageHandle image = add_gradient(graph, "gradient", graph.create_image("i0", desc), 2);
    PassBuilder shift = graph.add_compute_pass("shift");
    shift.prefer(QueueWish::async_compute);
    shift.sample("source", image);
    image = shift.write("target", graph.create_image("i1", desc));
    shift.record([](Commands& commands) {
        commands.dispatch_over({.shader = "test/shift.comp"}, {33, 17, 1});
    });
    PassBuilder again = graph.add_compute_pass("again");
    again.sample("source", image);
    m.picture = again.write("target", graph.create_image("i2", desc));
    again.record([](Commands& commands) {
        commands.dispatch_over({.shader = "test/shift.comp"}, {33, 17, 1});
    });
    m.numbers = add_one(graph, "join", shifted, graph.create_buffer("d", {4096}));
    graph.export_resource(m.numbers, "checked");
    graph.export_resource(m.picture, "checked");
    graph.export_resource(m.sums, "checked");
    graph.export_resource(m.history.now, "checked");
    return m;
}

TEST_P(QueuesTest, ResultsAreThoseOfOneQueue) {
    const Families& families = GetParam();
    for (const std::uint32_t slots : {1u, 3u}) {
        auto step = std::make_shared<std::uint32_t>(0);
        Mixed m = mixed(step);
        Executor executor(core(), std::move(m.graph), Policy{},
            {.slots = slots, .pretended_families = families.families});
        EXPECT_EQ(executor.plan().queues.size(), families.queues);
        Capabilities capabilities = capabilities_of(core());
        capabilities.families = families.families;
        EXPECT_EQ(
            violations_text(verify(executor.graph().declaration(), executor.plan(), capabilities)),
            "");
        std::vector<std::uint32_t> x;
        const auto at = [&](int n) { return n < 0 ? 0 : x[static_cast<std::size_t>(n)]; };
        for (int n = 0; n < 6; ++n) {
            *step = static_cast<std::uint32_t>(n);
            executor.submit();
            x.push_back(at(n - 1) + at(n - 2) + *step);
            if (slots > 1 && n < 5) continue; // all in flight
            const auto numbers = read_as<std::uint32_t>(executor, m.numbers);
            for (std::uint32_t i = 0; i < 1024; ++i) ASSERT_EQ(numbers[i], i + 7);
            const Image picture = executor.read(m.picture);
            for (int row = 0; row < 17; ++row) {
                for (int column = 0; column < 33; ++column) {
                    ASSERT_EQ(picture.at(column, row, 0),
                        4.0f * static_cast<float>(column + 100 * row + 2) + 3.0f);
                }
            }
            EXPECT_EQ(read_as<std::uint32_t>(executor, m.sums)[9], 3u * unsigned(n + 1));
            EXPECT_EQ(read_as<std::uint32_t>(executor, m.history.now)[0], at(n));
            EXPECT_EQ(read_as<std::uint32_t>(executor, m.history.previous[1])[0], at(n - 2));
        }
        executor.wait();
        EXPECT_EQ(executor.times().size(), executor.plan().steps.size());
    }
}

INSTANTIATE_TEST_SUITE_P(Devices, QueuesTest,
    testing::Values(Families{"one_family", {kMain}, 1},
        Families{"one_family_two_queues", {{.queues = 2}}, 2},
        Families{"main_and_compute", {kMain, kCompute}, 2},
        Families{"all_three", {kMain, kCompute, kTransfer}, 3}),
    [](const auto& row) { return row.param.name; });

class SemaphoreTest : public test::GpuTest {
protected:
    static VkSemaphore timeline() {
        const VkSemaphoreTypeCreateInfo type{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO,
            .semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE};
        const VkSemaphoreCreateInfo info{
            .sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, .pNext = &type};
        VkSemaphore semaphore = VK_NULL_HANDLE;
        EXPECT_EQ(vkCreateSemaphore(device().handle(), &info, nullptr, &semaphore), VK_SUCCESS);
        return semaphore;
    }
    static void signal(VkSemaphore semaphore, std::uint64_t value) {
        const VkSemaphoreSignalInfo info{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SIGNAL_INFO,
            .semaphore = semaphore,
            .value = value};
        EXPECT_EQ(vkSignalSemaphore(device().handle(), &info), VK_SUCCESS);
    }
    static VkResult wait(VkSemaphore semaphore, std::uint64_t value, std::uint64_t nanoseconds) {
        const VkSemaphoreWaitInfo info{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO,
            .semaphoreCount = 1,
            .pSemaphores = &semaphore,
            .pValues = &value};
        return vkWaitSemaphores(device().handle(), &info, nanoseconds);
    }
};

TEST_F(SemaphoreTest, ImportsWaitForTheHostAndSignalIt) {
    const gpu::Buffer shared(
        device(), {.bytes = 256,
                      .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                               VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                      .name = "shared",
                      .memory = gpu::MemoryUse::upload});
    const auto values = [&] { return reinterpret_cast<std::uint32_t*>(shared.mapped().data()); };
    std::fill_n(values(), 64, 0u);
    const VkSemaphore ready = timeline(), done = timeline();
    {
        Graph graph("imports");
        const AccessState host{VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_WRITE_BIT};
        const AccessState back{VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT};
        BufferHandle marks = graph.import_buffer("marks", {256}, host, back);
        const BufferHandle imported = marks;
        marks = add_mark(graph, "mark", marks, 5);
        graph.export_resource(marks, "checked");
        Executor executor(device(), std::move(graph), Policy{}, {.slots = 2});
        executor.bind(imported, shared, {.wait = {ready, 1}, .signal = {done, 1}});
        executor.submit();
        EXPECT_EQ(wait(done, 1, 20'000'000), VK_TIMEOUT); // nobody has said `ready`
        std::fill_n(values(), 64, 100u);
        signal(ready, 1);
        EXPECT_EQ(wait(done, 1, UINT64_MAX), VK_SUCCESS);
        EXPECT_EQ(values()[63], 105u);
        executor.wait();
        // The points were those of one execution.
        executor.execute();
        EXPECT_EQ(values()[63], 110u);
        // Bound again with the next values.
        executor.bind(imported, shared, {.wait = {ready, 2}, .signal = {done, 2}});
        // No thread of its own signals beside execute(): then the validation layer (1.3.239) now and
        // then waits 10 s for a value that is there, and reports that.
        executor.submit();
        signal(ready, 2);
        executor.wait();
        // Drivers that emulate timelines may show the fence before the value.
        EXPECT_EQ(wait(done, 2, 10'000'000'000), VK_SUCCESS);
        EXPECT_EQ(values()[0], 115u);
        executor.bind(imported, shared, {.wait = {ready, 2}, .signal = {}});
        const std::string text = error_of([&] { executor.record(VK_NULL_HANDLE); });
        EXPECT_NE(text.find("[semaphore-in-record]"), std::string::npos) << text;
    }
    vkDestroySemaphore(device().handle(), ready, nullptr);
    vkDestroySemaphore(device().handle(), done, nullptr);
}

TEST_F(SemaphoreTest, APlanThatDoesNothingWaitsAndSignals) {
    const gpu::Buffer unused(
        device(), {.bytes = 256, .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, .name = "unused"});
    const VkSemaphore ready = timeline(), done = timeline();
    {
        Graph graph("nothing");
        const BufferHandle imported = graph.import_buffer("unused", {256}, {});
        Executor executor(device(), std::move(graph), Policy{}, {.slots = 2});
        ASSERT_TRUE(executor.plan().steps.empty());
        for (std::uint64_t value = 1; value <= 3; ++value) {
            executor.bind(imported, unused, {.wait = {ready, value}, .signal = {done, value}});
            executor.submit();
            EXPECT_EQ(wait(done, value, 1'000'000), VK_TIMEOUT);
            signal(ready, value);
            EXPECT_EQ(wait(done, value, 10'000'000'000), VK_SUCCESS);
        }
        executor.execute(); // the points were those of one execution
    }
    vkDestroySemaphore(device().handle(), ready, nullptr);
    vkDestroySemaphore(device().handle(), done, nullptr);
}

TEST_F(SemaphoreTest, EachQueueWaitsForAnImportAndAllAreSignalled) {
    const gpu::Buffer shared(device(),
        {.bytes = 256,
            .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
            .name = "shared",
            .memory = gpu::MemoryUse::upload});
    std::fill_n(reinterpret_cast<std::uint32_t*>(shared.mapped().data()), 64, 5u);
    const VkSemaphore ready = timeline(), done = timeline();
    {
        // Nothing orders both readers.
        Graph graph("both_read");
        const BufferHandle imported = graph.import_buffer("shared", {256}, {});
        PassBuilder pass = graph.add_compute_pass("beside");
        pass.prefer(QueueWish::async_compute);
        pass.read("source", imported);
        const BufferHandle beside = pass.write("target", graph.create_buffer("b", {256}));
        pass.record([](Commands& commands) {
            commands.dispatch_over({.shader = "test/add_one.comp"}, {64, 1, 1});
        });
        const BufferHandle main = add_one(graph, "main", imported, graph.create_buffer("a", {256}));
        graph.export_resource(main, "checked");
        graph.export_resource(beside, "checked");
        Executor executor(
            device(), std::move(graph), Policy{}, {.pretended_families = {{.queues = 2}}});
        ASSERT_EQ(executor.plan().queues.size(), 2u);
        for (std::uint64_t value = 1; value <= 2; ++value) {
            submitted.clear();
            executor.bind(imported, shared, {.wait = {ready, value}, .signal = {done, value}});
            executor.submit();
            EXPECT_EQ(wait(done, value, 1'000'000), VK_TIMEOUT);
            signal(ready, value);
            EXPECT_EQ(wait(done, value, 10'000'000'000), VK_SUCCESS);
            ASSERT_EQ(submitted.size(), 2u);
            const auto has = [](const auto& points, const VkSemaphoreSubmitInfo& point) {
                return std::ranges::any_of(points, [&](const VkSemaphoreSubmitInfo& other) {
                    return other.semaphore == point.semaphore && other.value == point.value;
                });
            };
            for (const Submitted& one : submitted) {
                EXPECT_TRUE(has(one.waits, {.semaphore = ready, .value = value}));
            }
            EXPECT_FALSE(has(submitted[0].signals, {.semaphore = done, .value = value}));
            EXPECT_TRUE(has(submitted[1].signals, {.semaphore = done, .value = value}));
            EXPECT_TRUE(has(submitted[1].waits, submitted[0].signals.back()));
        }
        EXPECT_EQ(read_as<std::uint32_t>(executor, main)[63], 6u);
        EXPECT_EQ(read_as<std::uint32_t>(executor, beside)[63], 6u);
    }
    vkDestroySemaphore(device().handle(), ready, nullptr);
    vkDestroySemaphore(device().handle(), done, nullptr);
}

TEST_F(SemaphoreTest, WhatWasSubmittedInPartIsNotExecutedAgain) {
    gpu::Device core({.validation = gpu::Validation::core});
    auto step = std::make_shared<std::uint32_t>(1);
    for (const std::size_t fails : {1, 2}) {
        Mixed m = mixed(step);
        Executor executor(
            core, std::move(m.graph), Policy{}, {.pretended_families = {kMain, kCompute}});
        executor.execute();
        submitted.clear();
        failing = fails;
        std::string text = error_of([&] { executor.execute(); });
        failing = 0;
        EXPECT_NE(text.find("submitting 'mixed'"), std::string::npos) << text;
        if (fails == 1) { // as if nothing had happened
            executor.execute();
            EXPECT_EQ(read_as<std::uint32_t>(executor, m.sums)[9], 6u);
            continue;
        }
        for (int i = 0; i < 4; ++i) {
            text = error_of([&] {
                if (i == 0) executor.execute();
                if (i == 1) executor.record(VK_NULL_HANDLE);
                if (i == 2) (void)executor.read(m.sums);
                if (i == 3) (void)executor.update(mixed(step).graph);
            });
            EXPECT_NE(text.find("make another executor"), std::string::npos) << text;
        }
    }
    EXPECT_EQ(core.validation_messages(), std::vector<std::string>{});
}

TEST_F(SemaphoreTest, PlansOfSeveralQueuesAreNotRecorded) {
    auto step = std::make_shared<std::uint32_t>(0);
    Mixed m = mixed(step);
    gpu::Device core({.validation = gpu::Validation::core});
    Executor executor(
        core, std::move(m.graph), Policy{}, {.pretended_families = {kMain, kCompute}});
    const std::string text = error_of([&] { executor.record(VK_NULL_HANDLE); });
    EXPECT_NE(text.find("[several-queues]"), std::string::npos) << text;
    EXPECT_NE(text.find("async_queues = false"), std::string::npos) << text;
    EXPECT_NE(error_of([&] {
        Mixed other = mixed(step);
        Plan plan = executor.plan();
        Executor real(core, std::move(other.graph), std::move(plan));
    }).find("does not have"),
        std::string::npos);
}

} // namespace
} // namespace ockham
