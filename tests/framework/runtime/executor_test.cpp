// SPDX-License-Identifier: Apache-2.0
// Graphs executed on a device under synchronisation validation, against results known beforehand.
#include "framework/gpu/buffer.hpp"
#include "framework/gpu/image.hpp"
#include "framework/gpu/memory.hpp"
#include "framework/gpu/pipeline.hpp"
#include "framework/gpu/transfer.hpp"
#include "framework/runtime/commands.hpp"
#include "framework/runtime/executor.hpp"
#include "tests/support/gpu_fixture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <numeric>

namespace ockham {
namespace {

using test::read_as;

struct NumberPush {
    std::uint32_t count;
    std::uint32_t offset;
};

/// numbers[i] = factor i + offset
BufferHandle add_numbers(Graph& graph, const std::string& name, BufferHandle buffer,
    std::uint32_t count, std::uint32_t offset = 0, std::uint32_t factor = 1) {
    PassBuilder pass = graph.add_compute_pass(name);
    buffer = pass.write("numbers", buffer);
    pass.record([=](Commands& commands) {
        const NumberPush push{count, offset};
        commands.dispatch_over(
            {.shader = "test/number.comp", .specialization = {{0, factor}}, .push = as_push(push)},
            {count, 1, 1});
    });
    return buffer;
}

BufferHandle add_one(
    Graph& graph, const std::string& name, BufferHandle source, BufferHandle target) {
    const auto count = static_cast<std::uint32_t>(graph.desc(target).bytes / 4);
    PassBuilder pass = graph.add_compute_pass(name);
    pass.read("source", source);
    target = pass.write("target", target);
    pass.record([=](Commands& commands) {
        commands.dispatch_over({.shader = "test/add_one.comp"}, {count, 1, 1});
    });
    return target;
}

ImageHandle add_gradient(Graph& graph, const std::string& name, ImageHandle target, float offset) {
    const ImageDesc desc = graph.desc(target);
    PassBuilder pass = graph.add_compute_pass(name);
    target = pass.write("target", target);
    pass.record([=](Commands& commands) {
        commands.dispatch_over({.shader = "test/gradient.comp", .push = as_push(offset)},
            {desc.width, desc.height, 1});
    });
    return target;
}

/// target = 2 source + 1
ImageHandle add_shift(
    Graph& graph, const std::string& name, ImageHandle source, ImageHandle target) {
    const ImageDesc desc = graph.desc(target);
    PassBuilder pass = graph.add_compute_pass(name);
    pass.sample("source", source);
    target = pass.write("target", target);
    pass.record([=](Commands& commands) {
        commands.dispatch_over({.shader = "test/shift.comp"}, {desc.width, desc.height, 1});
    });
    return target;
}

class ExecutorTest : public test::GpuTest {};

class ExecutorSizes : public test::GpuTest,
                      public testing::WithParamInterface<std::array<std::uint32_t, 2>> {};

TEST_P(ExecutorSizes, ComputeChainOfImages) {
    const auto [width, height] = GetParam();
    const ImageDesc desc{.format = VK_FORMAT_R32_SFLOAT, .width = width, .height = height};
    Graph graph("chain");
    ImageHandle image = add_gradient(graph, "gradient", graph.create_image("a", desc), 3.0f);
    image = add_shift(graph, "shift", image, graph.create_image("b", desc));
    image = add_shift(graph, "shift_again", image, graph.create_image("c", desc));
    graph.export_resource(image, "checked");
    Executor executor(device(), std::move(graph));
    executor.execute();
    const Image result = executor.read(image);
    ASSERT_EQ(result.width(), static_cast<int>(width));
    ASSERT_EQ(result.height(), static_cast<int>(height));
    for (int y = 0; y < result.height(); ++y) {
        for (int x = 0; x < result.width(); ++x) {
            const auto start = static_cast<float>(x + 100 * y + 3);
            ASSERT_EQ(result.at(x, y, 0), 4.0f * start + 3.0f) << x << ", " << y;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Sizes, ExecutorSizes,
    testing::Values(std::array{1u, 1u}, std::array{7u, 5u}, std::array{64u, 64u}));

TEST_F(ExecutorTest, BufferChainInSharedMemory) {
    constexpr std::uint32_t kCount = 5000;
    const BufferDesc desc{kCount * 4};
    Graph graph("aliased");
    BufferHandle buffer = add_numbers(graph, "numbers", graph.create_buffer("r0", desc), kCount, 7);
    for (int i = 1; i < 6; ++i) {
        const std::string name = fmt::format("r{}", i);
        buffer = add_one(graph, "to_" + name, buffer, graph.create_buffer(name, desc));
    }
    graph.export_resource(buffer, "checked");
    Executor executor(device(), std::move(graph));
    // At most two live at a time, and the exported one is alone.
    EXPECT_LE(executor.plan().bytes_peak, 3 * desc.bytes + 4096);
    for (int execution = 0; execution < 3; ++execution) {
        executor.execute();
        const auto values = read_as<std::uint32_t>(executor, buffer);
        ASSERT_EQ(values.size(), kCount);
        for (std::uint32_t i = 0; i < kCount; ++i) ASSERT_EQ(values[i], i + 12);
    }
}

TEST_F(ExecutorTest, ImagesAndBuffersShareMemory) {
    const ImageDesc desc{.format = VK_FORMAT_R32_SFLOAT, .width = 33, .height = 17};
    Graph graph("mixed");
    ImageHandle image = graph.create_image("i0", desc);
    image = add_gradient(graph, "gradient", image, 0.0f);
    for (int i = 1; i < 5; ++i) {
        const std::string name = fmt::format("i{}", i);
        image = add_shift(graph, "to_" + name, image, graph.create_image(name, desc));
    }
    graph.export_resource(image, "checked");
    BufferHandle buffer = add_numbers(graph, "numbers", graph.create_buffer("b0", {4000}), 1000, 1);
    buffer = add_one(graph, "to_b1", buffer, graph.create_buffer("b1", {4000}));
    buffer = add_one(graph, "to_b2", buffer, graph.create_buffer("b2", {4000}));
    graph.export_resource(buffer, "checked");
    const Policy apart{.alias_memory = false};
    Graph copy = graph;
    Executor shared(device(), std::move(graph));
    Executor separate(device(), std::move(copy), apart);
    EXPECT_LT(shared.plan().bytes_peak, separate.plan().bytes_peak);
    for (Executor* executor : {&shared, &separate}) {
        executor->execute();
        const Image result = executor->read(image);
        for (int y = 0; y < result.height(); ++y) {
            for (int x = 0; x < result.width(); ++x) {
                ASSERT_EQ(result.at(x, y, 0), 16.0f * static_cast<float>(x + 100 * y) + 15.0f);
            }
        }
        const auto values = read_as<std::uint32_t>(*executor, buffer);
        for (std::uint32_t i = 0; i < values.size(); ++i) ASSERT_EQ(values[i], i + 3);
    }
}

using Corner = std::array<float, 4>;

/// Two triangles that halve an 8 x 8 picture, and one in front of the middle of both.
std::vector<Corner> two_triangles() {
    return {{-1, -1, 0.25f, 1}, {1, -1, 0.25f, 1}, {-1, 1, 0.25f, 1}, // upper left
        {1, 1, 0.5f, 1}, {-1, 1, 0.5f, 1}, {1, -1, 0.5f, 1}};         // lower right
}

struct RasterGraph {
    Graph graph{"raster"};
    BufferHandle vertices, counts;
    ImageHandle ids, coverage, depth;
    std::vector<std::array<std::uint32_t, 3>> draws; ///< first vertex, count, id
};

/// Draws, then counts the ids by compute. Depth is cleared to 0, the far plane.
RasterGraph raster_graph(std::uint32_t size, std::uint64_t vertex_bytes,
    std::vector<std::array<std::uint32_t, 3>> draws, Commands::Cull cull = Commands::Cull::none) {
    RasterGraph r;
    Graph& graph = r.graph;
    const AccessState uploaded{
        VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_READ_BIT};
    r.vertices = graph.import_buffer("vertices", {vertex_bytes}, uploaded);
    const auto create = [&](const char* name, VkFormat format) {
        return graph.create_image(name, {.format = format, .width = size, .height = size});
    };
    PassBuilder draw = graph.add_raster_pass("draw");
    draw.read("vertices", r.vertices, Stage::vertex);
    r.ids = draw.color(create("ids", VK_FORMAT_R32_UINT), LoadOp::clear, {9, 0, 0, 0});
    r.coverage = draw.color(create("coverage", VK_FORMAT_R8_UNORM), LoadOp::clear, {0, 0, 0, 0});
    r.depth = draw.depth(create("depth", VK_FORMAT_D32_SFLOAT), 0.0f);
    draw.record([draws, cull](Commands& commands) {
        commands.bind(
            {.vertex_shader = "test/triangle.vert", .fragment_shader = "test/triangle.frag"});
        commands.set_cull(cull);
        for (const auto& [first, count, id] : draws) {
            commands.push(as_push(id));
            commands.draw(count, 1, first);
        }
    });
    PassBuilder clear = graph.add_transfer_pass("clear_counts");
    BufferHandle counts = clear.copy_to(graph.create_buffer("counts", {10 * 4}));
    clear.record([counts](Commands& commands) { commands.fill(counts, 0); });
    PassBuilder count = graph.add_compute_pass("count");
    count.sample("ids", r.ids);
    r.counts = count.read_write("counts", counts);
    count.record([size](Commands& commands) {
        commands.dispatch_over({.shader = "test/histogram.comp"}, {size, size, 1});
    });
    graph.export_resource(r.counts, "checked");
    graph.export_resource(r.coverage, "checked");
    graph.export_resource(r.depth, "checked");
    r.draws = std::move(draws);
    return r;
}

gpu::Buffer upload_vertices(gpu::Device& device, const std::vector<Corner>& corners) {
    const auto bytes = std::as_bytes(std::span(corners));
    gpu::Buffer buffer(
        device, {.bytes = bytes.size(),
                    .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                    .name = "vertices"});
    gpu::upload(device, buffer, bytes);
    return buffer;
}

TEST_F(ExecutorTest, RasterThenCompute) {
    const std::vector<Corner> corners = two_triangles();
    const gpu::Buffer vertices = upload_vertices(device(), corners);
    RasterGraph r = raster_graph(8, vertices.bytes(), {{0, 3, 1}, {3, 3, 2}});
    Executor executor(device(), std::move(r.graph));
    executor.bind(r.vertices, vertices);
    executor.execute();
    const auto counts = read_as<std::uint32_t>(executor, r.counts);
    // The shared diagonal belongs to one triangle by the top-left rule: 28 + 8 = 36, or 28.
    EXPECT_EQ(counts[1] + counts[2], 64u);
    EXPECT_EQ(std::min(counts[1], counts[2]), 28u);
    EXPECT_EQ(counts[9], 0u);
    const Image depth = executor.read(r.depth);
    EXPECT_EQ(depth.at(0, 0, 0), 0.25f);
    EXPECT_EQ(depth.at(7, 7, 0), 0.5f);
    const Image coverage = executor.read(r.coverage);
    const std::span<const float> plane = coverage.plane(0);
    EXPECT_EQ(std::accumulate(plane.begin(), plane.end(), 0.0f), 64.0f);
}

TEST_F(ExecutorTest, ReversedDepthKeepsTheGreater) {
    const auto full = [](float depth) {
        return std::vector<Corner>{{-1, -1, depth, 1}, {3, -1, depth, 1}, {-1, 3, depth, 1}};
    };
    std::vector<Corner> corners = full(0.5f);
    const std::vector<Corner> nearer = two_triangles(); // the first at 0.25 is behind
    corners.insert(corners.end(), nearer.begin(), nearer.begin() + 3);
    for (const Corner& corner : full(0.75f)) corners.push_back({corner[0], corner[1], 0.75f, 1});
    const gpu::Buffer vertices = upload_vertices(device(), corners);
    // 2 lies behind 1 and is not seen; 3 lies before it, but is drawn as half a picture only.
    corners[7] = corners[4];
    corners[8] = corners[5];
    corners[6] = corners[3];
    corners[6][2] = corners[7][2] = corners[8][2] = 0.75f;
    gpu::upload(device(), vertices, std::as_bytes(std::span(corners)));
    RasterGraph r = raster_graph(8, vertices.bytes(), {{0, 3, 1}, {3, 3, 2}, {6, 3, 3}});
    Executor executor(device(), std::move(r.graph));
    executor.bind(r.vertices, vertices);
    executor.execute();
    const auto counts = read_as<std::uint32_t>(executor, r.counts);
    EXPECT_EQ(counts[2], 0u);
    EXPECT_TRUE(counts[3] == 28u || counts[3] == 36u) << counts[3];
    EXPECT_EQ(counts[1], 64u - counts[3]);
}

TEST_F(ExecutorTest, CullingAndEmptyPictures) {
    // Clockwise as seen with y down, so a back face for counter-clockwise fronts.
    const std::vector<Corner> corners{{-1, -1, 0.5f, 1}, {3, -1, 0.5f, 1}, {-1, 3, 0.5f, 1},
        {-1, -1, 0.5f, 1}, {-1, 3, 0.5f, 1}, {3, -1, 0.5f, 1}};
    const gpu::Buffer vertices = upload_vertices(device(), corners);
    std::array<std::uint32_t, 2> covered{};
    for (std::uint32_t winding = 0; winding < 2; ++winding) {
        RasterGraph r =
            raster_graph(5, vertices.bytes(), {{3 * winding, 3, 4}}, Commands::Cull::back);
        Executor executor(device(), std::move(r.graph));
        executor.bind(r.vertices, vertices);
        executor.execute();
        const auto counts = read_as<std::uint32_t>(executor, r.counts);
        covered[winding] = counts[4];
        EXPECT_EQ(counts[4] + counts[9], 25u);
    }
    EXPECT_EQ(covered[0], 0u);
    EXPECT_EQ(covered[1], 25u);
}

/// Draws the number c + 1 over all of the picture for each column c in `drawn`, but only where the
/// depth, or the stencil, that an earlier draw of the pass gave each column is that column's.
/// Returns the ids of one row.
std::vector<float> drawn_where_equal(
    gpu::Device& device, bool by_stencil, const std::vector<std::uint32_t>& drawn) {
    std::vector<Corner> corners;
    for (std::uint32_t c = 0; c < 8; ++c) {
        const float depth = static_cast<float>(c + 1) / 16.0f;
        corners.insert(corners.end(), {{-1, -1, depth, 1}, {3, -1, depth, 1}, {-1, 3, depth, 1}});
    }
    const gpu::Buffer vertices = upload_vertices(device, corners);
    Graph graph("equal");
    const AccessState uploaded{
        VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_READ_BIT};
    const BufferHandle imported = graph.import_buffer("vertices", {vertices.bytes()}, uploaded);
    const auto create = [&](const char* name, VkFormat format) {
        return graph.create_image(name, {.format = format, .width = 8, .height = 5});
    };
    PassBuilder draw = graph.add_raster_pass("draw");
    draw.read("vertices", imported, Stage::vertex);
    const ImageHandle ids = draw.color(create("ids", VK_FORMAT_R32_UINT));
    (void)draw.color(create("coverage", VK_FORMAT_R8_UNORM));
    if (by_stencil) {
        (void)draw.stencil(create("stencil", VK_FORMAT_S8_UINT), 0);
    } else {
        (void)draw.depth(create("depth", VK_FORMAT_D32_SFLOAT), 0.0f);
    }
    draw.record([=](Commands& commands) {
        commands.bind({.vertex_shader = "test/full.vert",
            .fragment_shader = by_stencil ? "test/columns.frag:stencil" : "test/columns.frag",
            .depth_test = !by_stencil,
            .depth_write = !by_stencil,
            .stencil_write = by_stencil});
        commands.draw(3);
        commands.bind({.vertex_shader = "test/triangle.vert",
            .fragment_shader = "test/triangle.frag",
            .depth_test = !by_stencil,
            .depth_write = false,
            .depth_equal = true,
            .stencil_equal = by_stencil});
        for (const std::uint32_t c : drawn) {
            const std::uint32_t id = c + 1;
            commands.set_stencil(static_cast<std::uint8_t>(id));
            commands.push(as_push(id));
            commands.draw(3, 1, 3 * c);
        }
    });
    graph.export_resource(ids, "checked");
    Executor executor(device, std::move(graph));
    executor.bind(imported, vertices);
    executor.execute();
    const Image image = executor.read(ids);
    const std::span<const float> all = image.plane(0);
    for (std::size_t i = 8; i < all.size(); ++i) EXPECT_EQ(all[i], all[i % 8]);
    return {all.begin(), all.begin() + 8};
}

TEST_F(ExecutorTest, EqualTestsPickWhatAnEarlierDrawWrote) {
    const std::vector<float> expected{1, 0, 0, 4, 0, 6, 0, 8};
    EXPECT_EQ(drawn_where_equal(device(), false, {0, 3, 5, 7}), expected);
    if (device().exports_stencil()) {
        EXPECT_EQ(drawn_where_equal(device(), true, {0, 3, 5, 7}), expected);
    }
}

TEST_F(ExecutorTest, DepthOnlyPass) {
    const std::vector<Corner> corners{{-1, -1, 0.125f, 1}, {3, -1, 0.125f, 1}, {-1, 3, 0.125f, 1}};
    const gpu::Buffer vertices = upload_vertices(device(), corners);
    Graph graph("depth_only");
    const AccessState uploaded{
        VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_READ_BIT};
    const BufferHandle imported = graph.import_buffer("vertices", {vertices.bytes()}, uploaded);
    PassBuilder draw = graph.add_raster_pass("draw");
    draw.read("vertices", imported, Stage::vertex);
    ImageHandle depth = draw.depth(
        graph.create_image("depth", {.format = VK_FORMAT_D32_SFLOAT, .width = 7, .height = 5}),
        0.0f);
    draw.record([](Commands& commands) {
        commands.bind({.vertex_shader = "test/triangle.vert"});
        const std::uint32_t id = 0;
        commands.push(as_push(id));
        commands.draw(3);
    });
    const ImageDesc desc{.format = VK_FORMAT_R32_SFLOAT, .width = 7, .height = 5};
    ImageHandle result = add_shift(graph, "read", depth, graph.create_image("result", desc));
    graph.export_resource(result, "checked");
    Executor executor(device(), std::move(graph));
    executor.bind(imported, vertices);
    executor.execute();
    const Image image = executor.read(result);
    for (const float value : image.plane(0)) ASSERT_EQ(value, 1.25f);
}

TEST_F(ExecutorTest, IndirectDispatchOfNoneAndSome) {
    Graph graph("indirect");
    PassBuilder write = graph.add_compute_pass("write_arguments");
    const BufferHandle arguments = write.write("arguments", graph.create_buffer("arguments", {24}));
    write.record([](Commands& commands) {
        const std::uint32_t groups = 2;
        commands.dispatch({.shader = "test/arguments.comp", .push = as_push(groups)}, {1, 1, 1});
    });
    BufferHandle marks = graph.create_buffer("marks", {192 * 4});
    PassBuilder clear = graph.add_transfer_pass("clear");
    marks = clear.copy_to(marks);
    clear.record([marks](Commands& commands) { commands.fill(marks, 5); });
    PassBuilder mark = graph.add_compute_pass("mark");
    mark.indirect(arguments);
    marks = mark.read_write("marks", marks);
    mark.record([arguments](Commands& commands) {
        const std::uint32_t never = 1000, once = 1;
        commands.dispatch_indirect(
            {.shader = "test/mark.comp", .push = as_push(never)}, arguments, 0);
        commands.dispatch_indirect(
            {.shader = "test/mark.comp", .push = as_push(once)}, arguments, 12);
    });
    graph.export_resource(marks, "checked");
    Executor executor(device(), std::move(graph));
    executor.execute();
    const auto values = read_as<std::uint32_t>(executor, marks);
    // Two groups of 64: the last third is untouched.
    for (std::uint32_t i = 0; i < 192; ++i) ASSERT_EQ(values[i], i < 128 ? 6u : 5u) << i;
}

TEST_F(ExecutorTest, PersistentResourcesAccumulate) {
    Graph graph("accumulate");
    BufferHandle sums = graph.create_persistent_buffer("sums", {50 * 4});
    ImageHandle total = graph.create_persistent_image("total", {.format = VK_FORMAT_R32_UINT});
    PassBuilder pass = graph.add_compute_pass("accumulate");
    sums = pass.read_write("sums", sums);
    total = pass.read_write("total", total);
    auto amount = std::make_shared<std::uint32_t>(0);
    pass.record([amount](Commands& commands) {
        commands.dispatch({.shader = "test/accumulate.comp", .push = as_push(*amount)}, {1, 1, 1});
    });
    graph.export_resource(sums, "checked");
    graph.export_resource(total, "checked");
    Executor executor(device(), std::move(graph));
    EXPECT_EQ(read_as<std::uint32_t>(executor, sums), std::vector<std::uint32_t>(50, 0));
    EXPECT_EQ(executor.read(total).at(0, 0, 0), 0.0f);
    for (std::uint32_t i = 1; i <= 5; ++i) {
        *amount = i * i; // what a recorder captures may change
        executor.execute();
    }
    EXPECT_EQ(read_as<std::uint32_t>(executor, sums), std::vector<std::uint32_t>(50, 55));
    EXPECT_EQ(executor.read(total).at(0, 0, 0), 55.0f);
    EXPECT_EQ(executor.pipeline_count(), 1u);
}

TEST_F(ExecutorTest, ImportedImagesAreReadAndWritten) {
    constexpr std::uint32_t kWidth = 5, kHeight = 3;
    const VkImageUsageFlags usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT |
                                    VK_IMAGE_USAGE_TRANSFER_DST_BIT |
                                    VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
    const auto make = [&](const char* name) {
        return gpu::Image(device(), {.format = VK_FORMAT_R32_SFLOAT,
                                        .width = kWidth,
                                        .height = kHeight,
                                        .usage = usage,
                                        .name = name});
    };
    const gpu::Image source = make("caller_source"), other = make("caller_other");
    const gpu::Image target = make("caller_target");
    const std::vector<float> texels(kWidth * kHeight, 4.0f), others(kWidth * kHeight, 5.0f);
    gpu::Uploader uploader(device());
    uploader.add(source, 0, 0, std::as_bytes(std::span(texels)));
    uploader.add(other, 0, 0, std::as_bytes(std::span(others)));
    uploader.finish();

    const ImageDesc desc{.format = VK_FORMAT_R32_SFLOAT, .width = kWidth, .height = kHeight};
    const AccessState sampled = state_of(Access::sampled, Stage::compute);
    Graph graph("imports");
    const ImageHandle in = graph.import_image("source", desc, sampled, sampled);
    ImageHandle out = graph.import_image("target", desc, {}, sampled);
    out = add_shift(graph, "shift", in, out);
    graph.export_resource(out, "checked");
    Executor executor(device(), std::move(graph));
    executor.bind(in, source);
    executor.bind(out, target);
    executor.execute();
    executor.execute();
    Image result = executor.read(out);
    for (const float value : result.plane(0)) ASSERT_EQ(value, 9.0f);
    executor.bind(in, other);
    executor.execute();
    result = executor.read(out);
    for (const float value : result.plane(0)) ASSERT_EQ(value, 11.0f);
}

TEST_F(ExecutorTest, WhatIsBoundAnewIsReadInItsEntryLayout) {
    constexpr std::uint32_t kSize = 4;
    const auto make = [&](const char* name) {
        return gpu::Image(device(),
            {.format = VK_FORMAT_R32_SFLOAT,
                .width = kSize,
                .height = kSize,
                .usage = VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT |
                         VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                .name = name});
    };
    const gpu::Image first = make("first"), second = make("second"), drawn = make("drawn");
    const std::vector<float> ones(kSize * kSize, 1.0f), twos(kSize * kSize, 2.0f);
    gpu::Uploader uploader(device()); // leaves images in SHADER_READ_ONLY_OPTIMAL
    uploader.add(first, 0, 0, std::as_bytes(std::span(ones)));
    uploader.add(second, 0, 0, std::as_bytes(std::span(twos)));
    uploader.finish();

    const ImageDesc desc{.format = VK_FORMAT_R32_SFLOAT, .width = kSize, .height = kSize};
    const AccessState sampled = state_of(Access::sampled, Stage::compute);
    Graph graph("bound_anew");
    const ImageHandle in =
        graph.import_image("in", desc, sampled, state_of(Access::storage_read, Stage::compute));
    ImageHandle out = graph.import_image("out", desc, {}, sampled);
    out = add_shift(graph, "shift", in, out);
    graph.export_resource(out, "checked");
    Executor executor(device(), std::move(graph));
    executor.bind(in, first);
    executor.bind(out, drawn);
    executor.execute();
    EXPECT_EQ(executor.read(in).at(0, 0, 0), 1.0f); // in its exit layout, GENERAL
    executor.bind(in, second);
    EXPECT_EQ(executor.read(in).at(0, 0, 0), 2.0f);
    executor.execute();
    EXPECT_EQ(executor.read(in).at(0, 0, 0), 2.0f);
    EXPECT_EQ(executor.read(out).at(0, 0, 0), 5.0f);
    const gpu::Image fresh = make("fresh");
    executor.bind(out, fresh); // enters without content
    const std::string text = test::error_of([&] { (void)executor.read(out); });
    EXPECT_NE(text.find("[not-executed]"), std::string::npos) << text;
}

struct FormatCase {
    const char* variant;
    VkFormat format;
    std::size_t channels;
    bool integer;
    float tolerance;
};

/// Half a quantum of 8 bits, and a rounding error of float: 0.5 may become 127 / 255 or 128 / 255.
constexpr float kHalf = 0.5f / 255 + 1e-7f;

class ReadBack : public test::GpuTest, public testing::WithParamInterface<FormatCase> {};

TEST_P(ReadBack, Format) {
    const FormatCase& c = GetParam();
    Graph graph("format");
    PassBuilder pass = graph.add_compute_pass("write");
    const ImageHandle target = pass.write(
        "target", graph.create_image("target", {.format = c.format, .width = 5, .height = 3}));
    const std::string shader = fmt::format("test/formats.comp:{}", c.variant);
    pass.record([shader](Commands& commands) {
        commands.dispatch_over({.shader = shader}, {5, 3, 1});
    });
    graph.export_resource(target, "checked");
    Executor executor(device(), std::move(graph));
    executor.execute();
    const Image image = executor.read(target);
    ASSERT_EQ(image.channels().size(), c.channels);
    EXPECT_EQ(image.channels().front(), "R");
    constexpr float kFloats[] = {1.0f, 0.5f, 0.25f, 0.0f};
    constexpr float kIntegers[] = {7, 70, 200, 70000};
    for (int x = 0; x < 5; ++x) {
        for (std::size_t channel = 0; channel < c.channels; ++channel) {
            const float expected =
                c.integer ? kIntegers[channel] + static_cast<float>(x) : kFloats[channel];
            EXPECT_NEAR(image.at(x, 2, static_cast<int>(channel)), expected, c.tolerance);
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Formats, ReadBack,
    testing::Values(FormatCase{"r8", VK_FORMAT_R8_UNORM, 1, false, kHalf},
        FormatCase{"rg8", VK_FORMAT_R8G8_UNORM, 2, false, kHalf},
        FormatCase{"rgba8", VK_FORMAT_R8G8B8A8_UNORM, 4, false, kHalf},
        FormatCase{"r16f", VK_FORMAT_R16_SFLOAT, 1, false, 0},
        FormatCase{"rg16f", VK_FORMAT_R16G16_SFLOAT, 2, false, 0},
        FormatCase{"rgba16f", VK_FORMAT_R16G16B16A16_SFLOAT, 4, false, 0},
        FormatCase{"r32f", VK_FORMAT_R32_SFLOAT, 1, false, 0},
        FormatCase{"rg32f", VK_FORMAT_R32G32_SFLOAT, 2, false, 0},
        FormatCase{"rgba32f", VK_FORMAT_R32G32B32A32_SFLOAT, 4, false, 0},
        FormatCase{"r8ui", VK_FORMAT_R8_UINT, 1, true, 0},
        FormatCase{"r32ui", VK_FORMAT_R32_UINT, 1, true, 0},
        FormatCase{"rgba32ui", VK_FORMAT_R32G32B32A32_UINT, 4, true, 0}),
    [](const auto& row) { return row.param.variant; });

/// target[i] = source[i] + bias, the bias in another descriptor set.
std::vector<std::uint32_t> run_two_sets(gpu::Device& device) {
    Graph graph("sets");
    const BufferHandle source =
        add_numbers(graph, "numbers", graph.create_buffer("source", {400}), 100, 0, 3);
    const BufferHandle table =
        add_numbers(graph, "table", graph.create_buffer("table", {16}), 4, 17);
    PassBuilder pass = graph.add_compute_pass("add");
    pass.read("source", source);
    pass.uniform("table", table);
    const BufferHandle target = pass.write("target", graph.create_buffer("target", {400}));
    pass.record([](Commands& commands) {
        // More than one pool of sets.
        for (int i = 0; i < 600; ++i)
            commands.dispatch({.shader = "test/two_sets.comp"}, {0, 1, 1});
        commands.dispatch_over({.shader = "test/two_sets.comp"}, {100, 1, 1});
    });
    graph.export_resource(target, "checked");
    Executor executor(device, std::move(graph));
    executor.execute();
    executor.execute();
    return read_as<std::uint32_t>(executor, target);
}

TEST_F(ExecutorTest, PushDescriptorsAndSetsAgree) {
    ASSERT_TRUE(device().pushes_descriptors());
    ASSERT_FALSE(device_without_push().pushes_descriptors());
    const std::vector<std::uint32_t> pushed = run_two_sets(device());
    for (std::uint32_t i = 0; i < 100; ++i) ASSERT_EQ(pushed[i], 3 * i + 17);
    EXPECT_EQ(run_two_sets(device_without_push()), pushed);
}

TEST_F(ExecutorTest, EveryValidationModeExecutes) {
    const std::vector<std::uint32_t> expected = run_two_sets(device());
    for (const gpu::Validation validation :
        {gpu::Validation::off, gpu::Validation::core, gpu::Validation::gpu}) {
        gpu::Device local({.validation = validation});
        EXPECT_EQ(run_two_sets(local), expected) << name_of(validation);
        {
            const gpu::Buffer vertices = upload_vertices(local, two_triangles());
            RasterGraph r = raster_graph(8, vertices.bytes(), {{0, 3, 1}, {3, 3, 2}});
            Executor executor(local, std::move(r.graph));
            executor.bind(r.vertices, vertices);
            executor.execute();
            const auto counts = read_as<std::uint32_t>(executor, r.counts);
            EXPECT_EQ(counts[1] + counts[2], 64u) << name_of(validation);
        }
        EXPECT_EQ(local.validation_log().count(), 0u) << name_of(validation);
    }
}

TEST_F(ExecutorTest, TimesGrowWithWork) {
    // Not the fixture's device: synchronisation validation spoils times.
    gpu::Device core({.validation = gpu::Validation::core});
    {
        const ImageDesc large{.format = VK_FORMAT_R32_SFLOAT, .width = 1024, .height = 1024};
        const ImageDesc small{.format = VK_FORMAT_R32_SFLOAT, .width = 8, .height = 8};
        const gpu::Buffer vertices = upload_vertices(core, two_triangles());
        // A raster pass comes first: after one, lavapipe's timestamps lie without a barrier.
        RasterGraph r = raster_graph(512, vertices.bytes(), {{0, 3, 1}, {3, 3, 2}});
        const auto add = [&](const char* name, const ImageDesc& desc) {
            const ImageHandle image = r.graph.create_image(name, desc);
            r.graph.export_resource(add_gradient(r.graph, name, image, 0.0f), "checked");
        };
        add("heavy", large);
        add("light", small);
        Executor executor(core, std::move(r.graph));
        executor.bind(r.vertices, vertices);
        executor.execute(); // compiles the shaders
        // The least of several, because other programs take the processor away.
        std::map<std::string, double> least;
        for (int execution = 0; execution < 8; ++execution) {
            executor.execute();
            ASSERT_EQ(executor.times().size(), executor.plan().steps.size());
            for (const PassTime& time : executor.times()) {
                EXPECT_GT(time.milliseconds, 0.0) << time.pass;
                EXPECT_LT(time.milliseconds, 10000.0) << time.pass;
                double& known = least.try_emplace(time.pass, time.milliseconds).first->second;
                known = std::min(known, time.milliseconds);
            }
        }
        EXPECT_GT(least["heavy"], 5 * least["light"]);
        EXPECT_GT(least["draw"], least["light"]);
    }
    EXPECT_EQ(core.validation_log().count(), 0u);
}

TEST_F(ExecutorTest, TwoGraphsOnOneDevice) {
    std::vector<Executor> executors;
    std::vector<BufferHandle> results;
    const std::uint64_t used_before = device().allocator().bytes_used();
    for (std::uint32_t i = 0; i < 2; ++i) {
        Graph graph(fmt::format("graph{}", i));
        BufferHandle buffer =
            add_numbers(graph, "numbers", graph.create_buffer("numbers", {400}), 100, 10 * i);
        buffer = add_one(graph, "next", buffer, graph.create_buffer("next", {400}));
        graph.export_resource(buffer, "checked");
        results.push_back(buffer);
        executors.emplace_back(device(), std::move(graph));
    }
    const std::size_t pipelines = device().pipelines().count();
    for (int execution = 0; execution < 2; ++execution) {
        for (Executor& executor : executors) executor.execute();
    }
    EXPECT_LE(device().pipelines().count(), pipelines + 2); // shared, not one set per graph
    for (std::uint32_t i = 0; i < 2; ++i) {
        const auto values = read_as<std::uint32_t>(executors[i], results[i]);
        for (std::uint32_t j = 0; j < 100; ++j) ASSERT_EQ(values[j], j + 10 * i + 1);
    }
    executors.clear();
    EXPECT_EQ(device().allocator().bytes_used(), used_before);
}

TEST_F(ExecutorTest, CopiesAndClears) {
    const ImageDesc desc{.format = VK_FORMAT_R16G16_SFLOAT, .width = 9, .height = 4, .mips = 2};
    Graph graph("copies");
    PassBuilder clear = graph.add_transfer_pass("clear");
    const ImageHandle first = clear.copy_to(graph.create_image("first", desc));
    clear.record([first](Commands& commands) { commands.clear(first, {0.5f, 2.0f, 0, 0}); });
    PassBuilder copy = graph.add_transfer_pass("copy");
    copy.copy_from(first);
    const ImageHandle second = copy.copy_to(graph.create_image("second", desc));
    copy.record([first, second](Commands& commands) { commands.copy(first, second); });
    graph.export_resource(second, "checked");
    const BufferHandle numbers =
        add_numbers(graph, "numbers", graph.create_buffer("numbers", {40}), 10, 3);
    PassBuilder copy_buffer = graph.add_transfer_pass("copy_buffer");
    copy_buffer.copy_from(numbers);
    const BufferHandle copied = copy_buffer.copy_to(graph.create_buffer("copied", {40}));
    copy_buffer.record(
        [numbers, copied](Commands& commands) { commands.copy(numbers, copied, 40); });
    graph.export_resource(copied, "checked");
    Executor executor(device(), std::move(graph));
    executor.execute();
    const Image image = executor.read(second);
    for (const float value : image.plane("R")) ASSERT_EQ(value, 0.5f);
    for (const float value : image.plane("G")) ASSERT_EQ(value, 2.0f);
    const auto values = read_as<std::uint32_t>(executor, copied);
    for (std::uint32_t i = 0; i < 10; ++i) ASSERT_EQ(values[i], i + 3);
}

TEST_F(ExecutorTest, AGraphWithNothingToDoExecutes) {
    Graph graph("empty");
    Executor executor(device(), std::move(graph));
    executor.execute();
    EXPECT_TRUE(executor.times().empty());
}

} // namespace
} // namespace ockham
