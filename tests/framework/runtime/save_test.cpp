// SPDX-License-Identifier: Apache-2.0
// Persistent content saved from one executor and restored into another: it goes on as the first
// would have, bit for bit.
#include "framework/runtime/executor.hpp"
#include "tests/framework/runtime/small_passes.hpp"
#include "tests/support/gpu_fixture.hpp"

#include <utility>

namespace ockham {
namespace {

using test::add_mark;
using test::error_of;
using test::read_as;

class SaveTest : public test::GpuTest {};

struct Frame {
    Graph graph{"frame"};
    BufferHandle marks;
    History<ImageHandle> history;
};

/// A persistent sum and a Fibonacci sequence in images of 7 x 5 texels.
Frame frame(std::uint64_t bytes = 256, const char* name = "marks") {
    Frame f;
    f.marks = add_mark(f.graph, "mark", f.graph.create_persistent_buffer(name, {bytes}), 3);
    f.history = f.graph.create_history_image(
        "x", {.format = VK_FORMAT_R32_UINT, .width = 7, .height = 5}, 2);
    PassBuilder recur = f.graph.add_compute_pass("recur");
    recur.sample("newest", f.history.previous[0]);
    recur.sample("oldest", f.history.previous[1]);
    f.history.now = recur.write("target", f.history.now);
    recur.record([](Commands& commands) {
        const std::uint32_t value = 1;
        commands.dispatch({.shader = "test/recur_image.comp", .push = as_push(value)}, {1, 1, 1});
    });
    f.graph.export_resource(f.marks, "checked");
    f.graph.export_resource(f.history.now, "checked");
    return f;
}

TEST_F(SaveTest, ARestoredExecutorGoesOnAsTheOldOne) {
    Frame whole = frame(), half = frame(), rest = frame();
    Executor unbroken(device(), std::move(whole.graph));
    for (int i = 0; i < 7; ++i) unbroken.execute();

    std::vector<SavedResource> saved;
    {
        Executor executor(device(), std::move(half.graph));
        for (int i = 0; i < 4; ++i) executor.execute();
        saved = executor.save();
    }
    ASSERT_EQ(saved.size(), 4u); // marks, three ages of x
    EXPECT_EQ(saved.front().name, "marks");
    EXPECT_EQ(saved.back().bytes.size(), 7u * 5 * 4);

    Executor executor(device(), std::move(rest.graph));
    executor.execute(); // what it did before is forgotten
    executor.restore(saved);
    EXPECT_EQ(executor.read(rest.history.now).at(6, 4, 0), 7.0f); // 1 2 4 7
    for (int i = 0; i < 3; ++i) executor.execute();
    EXPECT_EQ(read_as<std::uint32_t>(executor, rest.marks),
        read_as<std::uint32_t>(unbroken, whole.marks));
    EXPECT_EQ(
        executor.read(rest.history.now).at(6, 4, 0), unbroken.read(whole.history.now).at(6, 4, 0));
    EXPECT_EQ(executor.read(rest.history.now).at(0, 0, 0), 33.0f); // 12 20 33
}

TEST_F(SaveTest, SavedContentOfAnotherGraphIsRefused) {
    Frame f = frame();
    Executor executor(device(), std::move(f.graph));
    executor.execute();
    std::vector<SavedResource> saved = executor.save();
    const auto refusal = [&](Frame other) {
        Executor into(device(), std::move(other.graph));
        return error_of([&] { into.restore(saved); });
    };
    const std::string size = refusal(frame(512));
    EXPECT_NE(size.find("content-mismatch"), std::string::npos) << size;
    EXPECT_NE(size.find("512"), std::string::npos) << size;
    const std::string name = refusal(frame(256, "signs"));
    EXPECT_NE(name.find("'marks' was saved"), std::string::npos) << name;
    saved.pop_back();
    EXPECT_NE(refusal(frame()).find("but 3 were saved"), std::string::npos);
}

} // namespace
} // namespace ockham
