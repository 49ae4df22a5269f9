// SPDX-License-Identifier: Apache-2.0
#include "passes/volume/path_trace.hpp"

#include "framework/core/error.hpp"
#include "framework/runtime/commands.hpp"
#include "shaders/volume/path.h"

#include <algorithm>
#include <cstring>
#include <vector>

namespace ockham {
namespace {

const char* name_of(PathMode mode) {
    switch (mode) {
    case PathMode::path:
        return "path";
    case PathMode::noncaching:
        return "noncaching";
    case PathMode::gather:
        return "gather";
    }
    return "";
}

/// Rows whose paths are kept in one buffer.
struct Band {
    std::uint32_t first_row, rows;
    BufferHandle paths;
};

std::vector<Band> make_bands(Graph& graph, const PathTraceParams& params) {
    const std::uint64_t row_bytes = std::uint64_t{params.width} * sizeof(shader::Path);
    const auto most = static_cast<std::uint32_t>(
        std::clamp<std::uint64_t>(params.buffer_bytes / row_bytes, 1, params.height));
    std::vector<Band> bands;
    for (std::uint32_t row = 0; row < params.height; row += most) {
        const std::uint32_t rows = std::min(most, params.height - row);
        const std::string name = bands.empty() ? "paths" : fmt::format("paths.{}", bands.size());
        bands.push_back({row, rows, graph.create_persistent_buffer(name, {row_bytes * rows})});
    }
    return bands;
}

void add_restart(Graph& graph, PathTrace& out, std::vector<Band>& bands) {
    PassBuilder pass = graph.add_transfer_pass("restart_paths");
    pass.because("what the samples were of has changed");
    out.sum = pass.copy_to(out.sum);
    out.square = pass.copy_to(out.square);
    out.progress = pass.copy_to(out.progress);
    out.statistics = pass.copy_to(out.statistics);
    for (Band& band : bands) band.paths = pass.copy_to(band.paths);
    pass.record([out, bands](Commands& commands) {
        commands.clear(out.sum, {});
        commands.clear(out.square, {});
        commands.fill(out.progress, 0);
        commands.fill(out.statistics, 0);
        for (const Band& band : bands) commands.fill(band.paths, 0);
    });
}

/// One dispatch per band, which takes `out.samples` more of each of its pixels, or none.
void add_trace(Graph& graph, const MediumInputs& in, const PathTraceParams& params, bool more,
    const PathCache& cache, PathTrace& out, std::vector<Band>& bands) {
    const std::string shader =
        mesh_variant(medium_variant("volume/path_trace.comp", name_of(params.mode), in), in);
    const Specialization constants = path_specialization(in);
    for (std::size_t i = 0; i < bands.size(); ++i) {
        Band& band = bands[i];
        std::string name = more ? "path_trace" : "path_drain";
        if (i > 0) name += fmt::format(".{}", i);
        PassBuilder pass = graph.add_compute_pass(name);
        pass.because(more ? "more samples for every pixel" : "finishes the paths that have begun");
        read_medium(pass, in);
        read_meshes(pass, in, true);
        read_mesh_tree(pass, in);
        if (params.mode == PathMode::gather)
            pass.read("cache_index", cache.index).read("cache_cells", cache.cells);
        out.sum = pass.read_write("sum", out.sum);
        out.square = pass.read_write("square", out.square);
        out.progress = pass.read_write("progress", out.progress);
        out.statistics = pass.read_write("statistics", out.statistics);
        band.paths = pass.read_write("paths", band.paths);
        shader::PathTracePush push{.first_row = band.first_row,
            .rows = band.rows,
            .samples = 0,
            .iterations = std::min(params.iterations, kPathIterations),
            .jitter = params.jitter ? 1u : 0u,
            .nee = params.nee ? 1u : 0u};
        const auto samples = more ? out.samples : std::shared_ptr<std::uint32_t>();
        pass.record([=, width = params.width](Commands& commands) mutable {
            if (samples) push.samples = *samples;
            commands.dispatch_over(
                {.shader = shader, .specialization = constants, .push = as_push(push)},
                {width, push.rows, 1});
        });
    }
}

ImageHandle add_mean(Graph& graph, const PathTrace& in) {
    const ImageDesc desc = graph.desc(in.sum);
    PassBuilder pass = graph.add_compute_pass("path_mean");
    pass.because("the mean of each pixel's samples");
    pass.read("sum", in.sum).read("progress", in.progress);
    const ImageHandle out = pass.write("radiance", graph.create_image("path_radiance", desc));
    pass.record([desc](Commands& commands) {
        commands.dispatch_over({.shader = "volume/path_mean.comp"}, {desc.width, desc.height, 1});
    });
    return out;
}

} // namespace

PathTrace add_path_trace(Graph& graph, const MediumInputs& in, const PathTraceParams& params,
    const PathTraceConditions& conditions, const PathCache& cache) {
    check(params.width > 0 && params.height > 0, "the picture has pixels");
    check(params.samples_per_step > 0, "a step takes samples");
    check(params.iterations > 0, "an invocation has a budget");
    const std::uint64_t pixels = std::uint64_t{params.width} * params.height;
    PathTrace out;
    out.samples = std::make_shared<std::uint32_t>(params.samples_per_step);
    out.sum = graph.create_persistent_image("path_sum",
        {.format = VK_FORMAT_R32G32B32A32_SFLOAT, .width = params.width, .height = params.height});
    out.square = graph.create_persistent_image("path_square",
        {.format = VK_FORMAT_R32_SFLOAT, .width = params.width, .height = params.height});
    out.progress = graph.create_persistent_buffer("path_progress", {pixels * sizeof(glm::uvec2)});
    out.statistics = graph.create_persistent_buffer(
        "path_statistics", {PATHS_STATISTICS * sizeof(std::uint64_t)});
    std::vector<Band> bands = make_bands(graph, params);
    {
        const GuardScope scope = graph.when(conditions.restart);
        add_restart(graph, out, bands);
    }
    {
        const GuardScope scope = graph.unless(conditions.drain);
        add_trace(graph, in, params, true, cache, out, bands);
    }
    {
        const GuardScope scope = graph.when(conditions.drain);
        add_trace(graph, in, params, false, cache, out, bands);
    }
    out.radiance = add_mean(graph, out);
    return out;
}

PathStatistics path_statistics(std::span<const std::byte> bytes) {
    std::uint64_t sums[PATHS_STATISTICS];
    check(bytes.size() == sizeof(sums), "the statistics of a path trace");
    std::memcpy(sums, bytes.data(), sizeof(sums));
    return {.wanted = sums[PATHS_WANTED],
        .finished = sums[PATHS_FINISHED],
        .steps = sums[PATHS_STEPS],
        .resumed = sums[PATHS_RESUMED],
        .truncated = sums[PATHS_TRUNCATED],
        .clamped = sums[PATHS_CLAMPED]};
}

} // namespace ockham
