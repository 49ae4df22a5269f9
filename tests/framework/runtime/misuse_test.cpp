// SPDX-License-Identifier: Apache-2.0
// Every mistake that a pass or a caller can make at execution is one Error that names the pass, the
// shader and the thing, and leaves the device usable.
#include "framework/gpu/buffer.hpp"
#include "framework/gpu/image.hpp"
#include "framework/gpu/transfer.hpp"
#include "framework/runtime/commands.hpp"
#include "framework/runtime/executor.hpp"
#include "tests/framework/runtime/small_passes.hpp"
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
    expect_contains(text, {"[undeclared-binding]", "graph 'misuse'", "pass 'bad' (misuse_test.cpp:",
                              "test/number.comp", "'numbers'", "misspelt"});
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
    expect_contains(text, {"[binding-kind]", "'bad'", "'numbers'", "storage buffer",
                              "storage image", "image 'picture' (misuse_test.cpp:"});
}

TEST_F(MisuseTest, ShaderWritesWhatIsDeclaredRead) {
    const std::string text = run(
        [](Graph& graph, PassBuilder& pass) {
            pass.read("numbers", graph.create_persistent_buffer("numbers", {256}));
        },
        [](Commands& commands) {
            commands.dispatch({.shader = "test/number.comp", .push = as_push(kPush)}, {1, 1, 1});
        });
    expect_contains(text, {"[binding-direction]", "'bad'", "test/number.comp", "may write",
                              "'numbers'", "storage_read"});
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
    expect_contains(text,
        {"[binding-direction]", "'bad'", "test/mark.comp", "may read", "'marks'", "storage_write"});
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
    expect_contains(
        text, {"[binding-format]", "'bad'", "'target'", "R32_SFLOAT", "'half'", "R16_SFLOAT"});
}

TEST_F(MisuseTest, WrongPushSize) {
    const std::uint32_t one = 1;
    expect_contains(dispatch_numbers(as_push(one), {1, 1, 1}),
        {"[push-size]", "'bad'", "test/number.comp", "8 bytes", "got 4"});
    expect_contains(dispatch_numbers({}, {1, 1, 1}), {"'bad'", "8 bytes", "got 0"});
}

TEST_F(MisuseTest, TooManyGroups) {
    expect_contains(dispatch_numbers(as_push(kPush), {1, 65536, 1}),
        {"[too-many-groups]", "'bad'", "test/number.comp", "1 x 65536 x 1", "65535"});
}

TEST_F(MisuseTest, UnknownShaderAndConstant) {
    const std::string text = run(declare_numbers, [](Commands& commands) {
        commands.dispatch({.shader = "test/none.comp"}, {1, 1, 1});
    });
    expect_contains(text, {"[bad-shader]", "'bad'", "test/none.comp", "test/number.comp"});
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
    EXPECT_EQ(run_shader("test/shared_memory.comp", {}), "");
    expect_contains(run_shader("test/shared_memory.comp:too_much", {}),
        {"'bad'", "test/shared_memory.comp:too_much", "49152 bytes", "32768"});
}

TEST_F(MisuseTest, CommandsInTheWrongPass) {
    expect_contains(
        run(declare_numbers,
            [](Commands& commands) { commands.bind({.vertex_shader = "test/triangle.vert"}); }),
        {"[wrong-pass-kind]", "'bad'", "bind()", "raster pass", "compute pass"});
    expect_contains(run(declare_numbers,
                        [](Commands& commands) {
                            commands.fill(BufferHandle{0, 1}, 0);
                        }),
        {"[undeclared-access]", "'bad'", "fill()", "'numbers'", "transfer_write"});
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
    expect_contains(error_of([&] { executor.execute(); }),
        {"[unbound-import]", "imports", "'from_caller'", "bind()"});
    const gpu::Buffer small(
        device(), {.bytes = 4, .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, .name = "small"});
    expect_contains(error_of([&] { executor.bind(imported, small); }),
        {"[import-mismatch]", "'small'", "'from_caller'", "4", "256"});
    const gpu::Buffer copied(
        device(), {.bytes = 256, .usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT, .name = "copied"});
    expect_contains(error_of([&] { executor.bind(imported, copied); }),
        {"[missing-usage]", "'copied'", "'from_caller'", "usage"});
    expect_contains(error_of([&] { (void)executor.read(target); }),
        {"[not-executed]", "'target'", "execute()"});
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
    expect_contains(error_of([&] { (void)executor.read(numbers); }),
        {"[not-kept]", "'numbers'", "not kept", "export"});
}

TEST_F(MisuseTest, ShaderReadsOnlyWhatIsDeclaredWrite) {
    const std::string text = run(
        [](Graph& graph, PassBuilder& pass) {
            (void)pass.write("source", graph.create_buffer("from", {256}));
            (void)pass.write("target", graph.create_buffer("to", {256}));
        },
        [](Commands& commands) {
            commands.dispatch({.shader = "test/add_one.comp"}, {1, 1, 1});
        });
    expect_contains(text, {"[binding-direction]", "'source'", "cannot write", "buffer 'from'"});
}

TEST_F(MisuseTest, WrongStage) {
    Graph graph("stages");
    PassBuilder first = graph.add_compute_pass("first");
    const BufferHandle numbers = first.write("numbers", graph.create_buffer("corners", {256}));
    first.record([](Commands& commands) {
        commands.dispatch({.shader = "test/number.comp", .push = as_push(kPush)}, {1, 1, 1});
    });
    PassBuilder draw = graph.add_raster_pass("draw");
    draw.read("vertices", numbers, Stage::fragment);
    const ImageHandle depth = draw.depth(
        graph.create_image("depth", {.format = VK_FORMAT_D32_SFLOAT, .width = 4, .height = 4}), 0);
    draw.record([](Commands& commands) { commands.bind({.vertex_shader = "test/triangle.vert"}); });
    graph.export_resource(depth, "checked");
    Executor executor(device(), std::move(graph));
    expect_contains(error_of([&] { executor.execute(); }),
        {"[binding-stage]", "'draw'", "'vertices'", "fragment", "'corners'"});
}

TEST_F(MisuseTest, WrongDimension) {
    const auto text = [](const ImageDesc& desc) {
        return run(
            [&](Graph& graph, PassBuilder& pass) {
                (void)pass.write("target", graph.create_image("solid", desc));
            },
            [](Commands& commands) {
                const float offset = 0;
                commands.dispatch(
                    {.shader = "test/gradient.comp", .push = as_push(offset)}, {1, 1, 1});
            });
    };
    const VkFormat format = VK_FORMAT_R32_SFLOAT;
    expect_contains(text({.format = format, .width = 4, .height = 4, .depth = 4}),
        {"[binding-dimension]", "'bad'", "'target'", "'solid'", "3D", "2D"});
    expect_contains(text({.format = format, .width = 4, .height = 4, .layers = 3}),
        {"[binding-dimension]", "'target'", "one layer", "3"});
}

TEST_F(MisuseTest, FilterThatTheFormatLacks) {
    const std::string text = run(
        [](Graph& graph, PassBuilder& pass) {
            pass.sample("source",
                graph.create_persistent_image(
                    "ids", {.format = VK_FORMAT_R32_UINT, .width = 4, .height = 4}),
                Stage::compute, Filter::linear_clamp);
            (void)pass.write("target", graph.create_image("to", {.format = VK_FORMAT_R32_SFLOAT}));
        },
        [](Commands& commands) {
            commands.dispatch({.shader = "test/shift.comp"}, {1, 1, 1});
        });
    expect_contains(text, {"[binding-filter]", "'source'", "'ids'", "R32_UINT", "texel"});
}

TEST_F(MisuseTest, MoreThanTheDeviceBinds) {
    const std::uint64_t limit = device().limits().uniform_bytes;
    const std::string text = run(
        [&](Graph& graph, PassBuilder& pass) {
            pass.read("source", graph.create_persistent_buffer("from", {256}));
            pass.uniform("table", graph.create_persistent_buffer("large", {limit + 256}));
            (void)pass.write("target", graph.create_buffer("to", {256}));
        },
        [](Commands& commands) {
            commands.dispatch({.shader = "test/two_sets.comp"}, {1, 1, 1});
        });
    expect_contains(text, {"[binding-size]", "'table'", "'large'", "range"});
}

TEST_F(MisuseTest, IndirectArgumentsBeyondTheBuffer) {
    auto arguments = std::make_shared<BufferHandle>();
    const std::string text = run(
        [=](Graph& graph, PassBuilder& pass) {
            *arguments = graph.create_persistent_buffer("arguments", {24});
            pass.indirect(*arguments);
            declare_numbers(graph, pass);
        },
        [=](Commands& commands) {
            commands.dispatch_indirect(
                {.shader = "test/number.comp", .push = as_push(kPush)}, *arguments, 16);
        });
    expect_contains(text, {"[bad-offset]", "'bad'", "16", "24"});
}

/// A sum of offset and size would wrap around and pass.
TEST_F(MisuseTest, IndirectArgumentsAtTheLastOffset) {
    auto arguments = std::make_shared<BufferHandle>();
    const std::string text = run(
        [=](Graph& graph, PassBuilder& pass) {
            *arguments = graph.create_persistent_buffer("arguments", {24});
            pass.indirect(*arguments);
            declare_numbers(graph, pass);
        },
        [=](Commands& commands) {
            commands.dispatch_indirect({.shader = "test/number.comp", .push = as_push(kPush)},
                *arguments, ~std::uint64_t{3});
        });
    expect_contains(text, {"[bad-offset]", "'bad'", "18446744073709551612", "24"});
}

TEST_F(MisuseTest, PartsBeyondTheResource) {
    const auto error = [](const std::function<void(Commands&, BufferHandle, ImageHandle)>& record) {
        Graph graph("beyond");
        PassBuilder pass = graph.add_transfer_pass("bad");
        const BufferHandle buffer = pass.copy_to(graph.create_buffer("kilobyte", {1024}));
        const ImageHandle image = pass.copy_to(graph.create_image("picture",
            {.format = VK_FORMAT_R32_SFLOAT, .width = 4, .height = 4, .layers = 2, .mips = 3}));
        pass.side_effect("is tested");
        pass.record([=](Commands& commands) { record(commands, buffer, image); });
        Executor executor(device(), std::move(graph));
        return error_of([&] { executor.execute(); });
    };
    const std::pair<std::uint64_t, std::uint64_t> ranges[] = {
        {2048, kRest}, {1024, kRest}, {0, 0}, {4, ~std::uint64_t{7}}, {~std::uint64_t{3}, 8}};
    for (const auto& [offset, bytes] : ranges) {
        expect_contains(error([&](Commands& commands, BufferHandle buffer, ImageHandle) {
            commands.fill(buffer.range(offset, bytes), 0);
        }),
            {"[undeclared-part]", "'bad'", "fill()", "'kilobyte'"});
    }
    const std::pair<std::uint32_t, std::uint32_t> pieces[] = {
        {5, kRestOfMips}, {3, kRestOfMips}, {0, 0}, {1, ~std::uint32_t{1}}, {~std::uint32_t{0}, 2}};
    for (const auto& [first, count] : pieces) {
        for (const bool mips : {true, false}) {
            expect_contains(error([&](Commands& commands, BufferHandle, ImageHandle image) {
                commands.clear(mips ? image.mips(first, count) : image.layers(first, count), {});
            }),
                {"[undeclared-part]", "'bad'", "clear()", "'picture'"});
        }
    }
    EXPECT_EQ(error([](Commands& commands, BufferHandle buffer, ImageHandle image) {
        commands.fill(buffer.range(512, kRest), 0);
        commands.clear(image.mips(1, kRestOfMips), {});
        commands.clear(image.mip(0).layers(1, kRestOfLayers), {});
    }),
        "");
}

TEST_F(MisuseTest, ClearsOnAQueueThatCannot) {
    const QueueFamily main, compute{.graphics = false};
    const QueueFamily transfer{.graphics = false, .compute = false};
    gpu::Device core({.validation = gpu::Validation::core}); // sync knows no timelines
    const auto clear = [&](VkFormat format, const QueueFamily& beside) {
        Graph graph("queues");
        // Work for the main queue, without which it would do as well.
        graph.export_resource(
            test::add_numbers(graph, "numbers", graph.create_buffer("other", {256}), 0), "checked");
        PassBuilder pass = graph.add_transfer_pass("bad");
        pass.prefer(QueueWish::transfer);
        const ImageHandle image = pass.copy_to(
            graph.create_image("picture", {.format = format, .width = 4, .height = 4}));
        pass.record([=](Commands& commands) { commands.clear(image, {}); });
        graph.export_resource(image, "checked");
        Executor executor(
            core, std::move(graph), Policy{}, {.pretended_families = {QueueFamily{}, beside}});
        return error_of([&] { executor.execute(); });
    };
    expect_contains(clear(VK_FORMAT_R32_SFLOAT, transfer),
        {"[wrong-queue]", "'bad' (misuse_test.cpp:", "clear()", "'picture'", "compute"});
    expect_contains(
        clear(VK_FORMAT_D32_SFLOAT, transfer), {"[wrong-queue]", "'picture'", "graphics"});
    EXPECT_EQ(clear(VK_FORMAT_R32_SFLOAT, compute), "");
    EXPECT_EQ(clear(VK_FORMAT_D32_SFLOAT, main), "");
    EXPECT_EQ(core.validation_messages(), std::vector<std::string>{});
}

TEST_F(MisuseTest, Draws) {
    const auto draw = [](const std::function<void(Commands&, BufferHandle)>& record) {
        Graph graph("draws");
        const BufferHandle indices = graph.create_persistent_buffer("indices", {12});
        PassBuilder pass = graph.add_raster_pass("bad");
        pass.indices(indices);
        const ImageHandle target = pass.color(graph.create_image(
            "target", {.format = VK_FORMAT_R32_SFLOAT, .width = 4, .height = 4}));
        pass.record([=](Commands& commands) { record(commands, indices); });
        graph.export_resource(target, "checked");
        Executor executor(device(), std::move(graph));
        return error_of([&] { executor.execute(); });
    };
    expect_contains(draw([](Commands& commands, BufferHandle) { commands.draw(3); }),
        {"[no-pipeline]", "'bad'", "bind()"});
    const std::string text = draw([](Commands& commands, BufferHandle indices) {
        commands.bind({.vertex_shader = "test/full.vert", .depth_test = false});
        commands.bind_indices(indices);
        commands.draw_indexed(4, 1, 0, 0, 0);
    });
    expect_contains(text, {"[bad-indices]", "'bad'", "0 to 4", "3 are bound"});
    expect_contains(draw([](Commands& commands, BufferHandle indices) {
        commands.bind({.vertex_shader = "test/full.vert", .depth_test = false});
        commands.bind_indices(indices.range(16, kRest));
        commands.draw_indexed(3, 1, 0, 0, 0);
    }),
        {"[undeclared-part]", "'bad'", "bind_indices()", "'indices'"});
}

TEST_F(MisuseTest, Copies) {
    const auto copy = [](const std::function<void(Commands&, Graph&)>& record) {
        Graph graph("copies");
        const ImageDesc desc{.format = VK_FORMAT_R32_SFLOAT, .width = 8, .height = 8};
        const ImageDesc other{.format = VK_FORMAT_R32_SFLOAT, .width = 8, .height = 4};
        PassBuilder pass = graph.add_transfer_pass("bad");
        pass.copy_from(graph.create_persistent_buffer("from", {256}));
        (void)pass.copy_to(graph.create_buffer("to", {128}));
        pass.copy_from(graph.create_persistent_image("picture", desc));
        (void)pass.copy_to(graph.create_image("other", other));
        pass.side_effect("is tested");
        pass.record([&](Commands& commands) { record(commands, graph); });
        Executor executor(device(), graph);
        return error_of([&] { executor.execute(); });
    };
    expect_contains(copy([](Commands& commands, Graph& graph) {
        commands.copy(graph.find_buffer("from"), graph.find_buffer("to"));
    }),
        {"[copy-size]", "'from'", "256", "'to'", "128"});
    expect_contains(copy([](Commands& commands, Graph& graph) {
        commands.copy(graph.find_image("picture"), graph.find_image("other"));
    }),
        {"[copy-shape]", "'picture'", "8 x 8", "'other'", "8 x 4"});
    expect_contains(copy([](Commands& commands, Graph& graph) {
        commands.fill(graph.find_buffer("to").range(2, 8), 1);
    }),
        {"[copy-size]", "'to'", "multiples of 4"});
    expect_contains(copy([](Commands& commands, Graph&) { commands.fill(BufferHandle{}, 1); }),
        {"[invalid-handle]", "'bad'", "fill()"});
}

TEST_F(MisuseTest, BindingAndReadingWhatOneCannot) {
    Graph graph("reads");
    const AccessState sampled = state_of(Access::sampled, Stage::compute);
    const ImageDesc desc{.format = VK_FORMAT_R32_SFLOAT, .width = 4, .height = 4};
    const ImageHandle imported = graph.import_image("imported", desc, sampled);
    const ImageHandle solid = graph.create_persistent_image(
        "solid", {.format = VK_FORMAT_R32_SFLOAT, .width = 4, .height = 4, .depth = 4});
    PassBuilder pass = graph.add_transfer_pass("copy");
    pass.copy_from(imported).copy_from(solid);
    const ImageHandle target = pass.copy_to(graph.create_image("target", desc));
    pass.record([=](Commands& commands) { commands.copy(imported, target); });
    graph.export_resource(target, "checked");
    Executor executor(device(), std::move(graph));
    const gpu::Image image(
        device(), {.format = desc.format,
                      .width = 4,
                      .height = 4,
                      .usage = VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT |
                               VK_IMAGE_USAGE_SAMPLED_BIT,
                      .name = "theirs"});
    const std::vector<float> texels(16, 1.0f);
    gpu::upload(device(), image, 0, 0, std::as_bytes(std::span(texels)));
    expect_contains(error_of([&] { executor.bind(solid, image); }),
        {"[not-imported]", "'solid' (misuse_test.cpp:"});
    expect_contains(error_of([&] { (void)executor.read(solid); }), {"[unreadable]", "'solid'"});
    executor.bind(imported, image);
    executor.execute();
    expect_contains(error_of([&] { executor.execute(); }),
        {"[entry-layout]", "'imported'", "exit state", "bind()"});
}

TEST_F(MisuseTest, APlanThatIsNotRight) {
    Graph graph("planned");
    const BufferHandle marks =
        test::add_mark(graph, "first", graph.create_persistent_buffer("marks", {256}), 1);
    graph.export_resource(test::add_mark(graph, "second", marks, 1), "checked");
    Plan plan = make_plan(device(), graph);
    ASSERT_FALSE(plan.barriers.empty());
    for (Barrier& barrier : plan.barriers) barrier.src_stages = barrier.src_access = 0;
    expect_contains(
        error_of([&] { const Executor executor(device(), std::move(graph), std::move(plan)); }),
        {"[bad-plan]", "'planned'", "'second'", "'marks'"});
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
