// SPDX-License-Identifier: Apache-2.0
// Every mistake that a pass or a caller can make at execution is one Error that names the pass, the
// shader and the thing, and leaves the device usable.
#include "framework/gpu/buffer.hpp"
#include "framework/gpu/image.hpp"
#include "framework/runtime/commands.hpp"
#include "framework/runtime/executor.hpp"
#include "tests/support/gpu_fixture.hpp"

#include <functional>

namespace ockham {
namespace {

using test::error_of;

void expect_contains(const std::string& text, std::initializer_list<const char*> parts) {
    for (const char* part : parts) {
        EXPECT_NE(text.find(part), std::string::npos) << "'" << part << "' is not in: " << text;
    }
}

class MisuseTest : public test::GpuTest {
protected:
    using Declare = std::function<void(Graph&, PassBuilder&)>;

    /// The error of executing one compute pass 'bad' that `declare` fills and that does `record`.
    static std::string run(const Declare& declare, std::function<void(Commands&)> record) {
        Graph graph("misuse");
        PassBuilder pass = graph.add_compute_pass("bad");
        declare(graph, pass);
        pass.side_effect("is tested");
        pass.record(std::move(record));
        Executor executor(device(), std::move(graph));
        return error_of([&] { executor.execute(); });
    }

    static void declare_numbers(Graph& graph, PassBuilder& pass) {
        (void)pass.write("numbers", graph.create_buffer("numbers", {256}));
    }
    static std::string dispatch_numbers(
        std::span<const std::byte> push, glm::uvec3 groups, Specialization specialization = {}) {
        return run(declare_numbers, [=](Commands& commands) {
            commands.dispatch(
                {.shader = "test/number.comp", .specialization = specialization, .push = push},
                groups);
        });
    }
};

constexpr std::uint32_t kPush[] = {64, 0};

TEST_F(MisuseTest, MissingBinding) {
    const std::string text = run(
        [](Graph& graph, PassBuilder& pass) {
            (void)pass.write("misspelt", graph.create_buffer("numbers", {256}));
        },
        [](Commands& commands) {
            commands.dispatch({.shader = "test/number.comp", .push = as_push(kPush)}, {1, 1, 1});
        });
    expect_contains(text, {"'bad'", "test/number.comp", "'numbers'", "misspelt"});
}

TEST_F(MisuseTest, WrongKind) {
    const std::string text = run(
        [](Graph& graph, PassBuilder& pass) {
            (void)pass.write("numbers",
                graph.create_image("picture", {.format = VK_FORMAT_R32_SFLOAT, .width = 4}));
        },
        [](Commands& commands) {
            commands.dispatch({.shader = "test/number.comp", .push = as_push(kPush)}, {1, 1, 1});
        });
    expect_contains(text, {"'bad'", "'numbers'", "storage buffer", "storage image", "'picture'"});
}

TEST_F(MisuseTest, ShaderWritesWhatIsDeclaredRead) {
    const std::string text = run(
        [](Graph& graph, PassBuilder& pass) {
            pass.read("numbers", graph.create_persistent_buffer("numbers", {256}));
        },
        [](Commands& commands) {
            commands.dispatch({.shader = "test/number.comp", .push = as_push(kPush)}, {1, 1, 1});
        });
    expect_contains(text, {"'bad'", "test/number.comp", "may write", "'numbers'", "storage_read"});
}

TEST_F(MisuseTest, ShaderReadsWhatIsDeclaredWrite) {
    const std::string text = run(
        [](Graph& graph, PassBuilder& pass) {
            (void)pass.write("marks", graph.create_buffer("marks", {256}));
        },
        [](Commands& commands) {
            const std::uint32_t value = 1;
            commands.dispatch({.shader = "test/mark.comp", .push = as_push(value)}, {1, 1, 1});
        });
    expect_contains(text, {"'bad'", "test/mark.comp", "may read", "'marks'", "storage_write"});
}

TEST_F(MisuseTest, WrongFormat) {
    const std::string text = run(
        [](Graph& graph, PassBuilder& pass) {
            (void)pass.write(
                "target", graph.create_image("half", {.format = VK_FORMAT_R16_SFLOAT, .width = 4}));
        },
        [](Commands& commands) {
            const float offset = 0;
            commands.dispatch({.shader = "test/gradient.comp", .push = as_push(offset)}, {1, 1, 1});
        });
    expect_contains(text, {"'bad'", "'target'", "R32_SFLOAT", "'half'", "R16_SFLOAT"});
}

TEST_F(MisuseTest, WrongPushSize) {
    const std::uint32_t one = 1;
    expect_contains(dispatch_numbers(as_push(one), {1, 1, 1}),
        {"'bad'", "test/number.comp", "8 bytes", "got 4"});
    expect_contains(dispatch_numbers({}, {1, 1, 1}), {"'bad'", "8 bytes", "got 0"});
}

TEST_F(MisuseTest, TooManyGroups) {
    expect_contains(dispatch_numbers(as_push(kPush), {1, 65536, 1}),
        {"'bad'", "test/number.comp", "1 x 65536 x 1", "65535"});
}

TEST_F(MisuseTest, UnknownShaderAndConstant) {
    const std::string text = run(declare_numbers, [](Commands& commands) {
        commands.dispatch({.shader = "test/none.comp"}, {1, 1, 1});
    });
    expect_contains(text, {"'bad'", "test/none.comp", "test/number.comp"});
    expect_contains(dispatch_numbers(as_push(kPush), {1, 1, 1}, {{7, 1}}),
        {"'bad'", "test/number.comp", "constant 7"});
}

TEST_F(MisuseTest, BeyondThePortableBudget) {
    const auto run_shader = [](const char* shader, Specialization specialization) {
        return run(declare_numbers, [=](Commands& commands) {
            commands.dispatch({.shader = shader, .specialization = specialization}, {1, 1, 1});
        });
    };
    expect_contains(run_shader("test/large_group.comp", {{1, 33}}),
        {"'bad'", "test/large_group.comp", "33 x 8 x 1 = 264", "256"});
    EXPECT_EQ(run_shader("test/large_group.comp", {{1, 8}}), "");
    expect_contains(run_shader("test/many_constants.comp", {}),
        {"'bad'", "test/many_constants.comp", "144 bytes", "128"});
}

TEST_F(MisuseTest, CommandsInTheWrongPass) {
    expect_contains(
        run(declare_numbers,
            [](Commands& commands) { commands.bind({.vertex_shader = "test/triangle.vert"}); }),
        {"'bad'", "bind()", "raster pass", "compute pass"});
    expect_contains(run(declare_numbers,
                        [](Commands& commands) {
                            commands.fill(BufferHandle{0, 1}, 0);
                        }),
        {"'bad'", "fill()", "'numbers'", "transfer_write"});
}

TEST_F(MisuseTest, NothingBoundToAnImport) {
    Graph graph("imports");
    const BufferHandle imported =
        graph.import_buffer("from_caller", {256}, state_of(Access::storage_read, Stage::compute));
    PassBuilder pass = graph.add_compute_pass("bad");
    pass.read("source", imported);
    const BufferHandle target = pass.write("target", graph.create_buffer("target", {256}));
    pass.record([](Commands& commands) {
        commands.dispatch({.shader = "test/add_one.comp"}, {1, 1, 1});
    });
    graph.export_resource(target, "checked");
    Executor executor(device(), std::move(graph));
    expect_contains(error_of([&] { executor.execute(); }), {"imports", "'from_caller'", "bind()"});
    const gpu::Buffer small(
        device(), {.bytes = 4, .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, .name = "small"});
    expect_contains(error_of([&] { executor.bind(imported, small); }),
        {"'small'", "'from_caller'", "4", "256"});
    const gpu::Buffer copied(
        device(), {.bytes = 256, .usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT, .name = "copied"});
    expect_contains(
        error_of([&] { executor.bind(imported, copied); }), {"'copied'", "'from_caller'", "usage"});
    expect_contains(error_of([&] { (void)executor.read(target); }), {"'target'", "execute()"});
}

TEST_F(MisuseTest, ReadingWhatIsNotKept) {
    Graph graph("transient");
    PassBuilder first = graph.add_compute_pass("first");
    const BufferHandle numbers = first.write("numbers", graph.create_buffer("numbers", {256}));
    first.record([](Commands& commands) {
        commands.dispatch({.shader = "test/number.comp", .push = as_push(kPush)}, {1, 1, 1});
    });
    PassBuilder second = graph.add_compute_pass("second");
    second.read("source", numbers);
    const BufferHandle target = second.write("target", graph.create_buffer("target", {256}));
    second.record([](Commands& commands) {
        commands.dispatch({.shader = "test/add_one.comp"}, {1, 1, 1});
    });
    graph.export_resource(target, "checked");
    Executor executor(device(), std::move(graph));
    executor.execute();
    expect_contains(
        error_of([&] { (void)executor.read(numbers); }), {"'numbers'", "not kept", "export"});
}

TEST_F(MisuseTest, AnExecutorSurvivesAMistake) {
    Graph graph("recovers");
    PassBuilder pass = graph.add_compute_pass("fails_once");
    const BufferHandle numbers = pass.write("numbers", graph.create_buffer("numbers", {256}));
    auto right = std::make_shared<bool>(false);
    pass.record([right](Commands& commands) {
        commands.dispatch({.shader = "test/number.comp",
                              .push = *right ? as_push(kPush) : std::span<const std::byte>()},
            {1, 1, 1});
    });
    graph.export_resource(numbers, "checked");
    Executor executor(device(), std::move(graph));
    EXPECT_NE(error_of([&] { executor.execute(); }), "");
    *right = true;
    EXPECT_EQ(error_of([&] { executor.execute(); }), "");
    EXPECT_EQ(test::read_as<std::uint32_t>(executor, numbers)[63], 63u);
}

} // namespace
} // namespace ockham
