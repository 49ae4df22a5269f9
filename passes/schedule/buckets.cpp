// SPDX-License-Identifier: Apache-2.0
#include "passes/schedule/buckets.hpp"

#include "framework/core/error.hpp"
#include "framework/runtime/commands.hpp"
#include "shaders/schedule/buckets.h"

#include <bit>

namespace ockham {
namespace {

std::uint32_t padded_bits(std::uint32_t pixels) {
    const std::uint32_t tiles = (pixels + BUCKET_TILE - 1) / BUCKET_TILE;
    return static_cast<std::uint32_t>(std::bit_width(tiles - 1));
}

} // namespace

Buckets add_buckets(Graph& graph, ImageHandle sample_count, const BucketsParams& params) {
    check(params.bucket_count >= 1 && params.bucket_count <= MAX_BUCKETS, "1 to 64 buckets");
    const shader::BucketPush push{.size = {params.width, params.height},
        .tile_bits = {padded_bits(params.width), padded_bits(params.height)},
        .bucket_count = params.bucket_count};
    const std::uint32_t tiles = 1u << (push.tile_bits.x + push.tile_bits.y);
    const std::uint64_t words = sizeof(std::uint32_t);

    BufferHandle histogram = graph.create_buffer(
        params.prefix + "tile_histogram", {std::uint64_t{params.bucket_count} * tiles * words});
    Buckets out{
        .table = graph.create_buffer(
            params.prefix + "bucket_table", {(params.bucket_count + 1) * sizeof(shader::Bucket)}),
        .arguments = graph.create_buffer(params.prefix + "bucket_arguments",
            {(params.bucket_count + 1) * sizeof(shader::DispatchArguments)}),
        .list = graph.create_buffer(
            params.prefix + "pixel_list", {std::uint64_t{params.width} * params.height * words}),
    };

    PassBuilder count = graph.add_compute_pass(params.prefix + "bucket_count");
    count.because("one dispatch per sample count needs the pixels of each count together");
    count.read("sample_count", sample_count);
    histogram = count.write("tile_histogram", histogram);
    count.record([push, tiles](Commands& commands) {
        commands.dispatch_over(
            {.shader = "schedule/bucket_count.comp", .specialization = {}, .push = as_push(push)},
            {tiles, 1, 1});
    });

    PassBuilder scan = graph.add_compute_pass(params.prefix + "bucket_scan");
    scan.because("where each tile's pixels of a count begin");
    histogram = scan.read_write("tile_histogram", histogram);
    out.table = scan.write("bucket_table", out.table);
    scan.record([push](Commands& commands) {
        commands.dispatch(
            {.shader = "schedule/bucket_scan.comp", .specialization = {}, .push = as_push(push)},
            {push.bucket_count, 1, 1});
    });

    PassBuilder arguments = graph.add_compute_pass(params.prefix + "bucket_arguments");
    arguments.because("the device itself decides how large each dispatch is");
    out.table = arguments.read_write("bucket_table", out.table);
    out.arguments = arguments.write("bucket_arguments", out.arguments);
    arguments.record([push](Commands& commands) {
        commands.dispatch({.shader = "schedule/bucket_arguments.comp",
                              .specialization = {},
                              .push = as_push(push)},
            {1, 1, 1});
    });

    PassBuilder scatter = graph.add_compute_pass(params.prefix + "bucket_scatter");
    scatter.because("lists the pixels of each count, tile by tile");
    scatter.read("sample_count", sample_count).read("bucket_table", out.table);
    histogram = scatter.read_write("tile_histogram", histogram);
    out.list = scatter.write("pixel_list", out.list);
    scatter.record([push, tiles](Commands& commands) {
        commands.dispatch_over(
            {.shader = "schedule/bucket_scatter.comp", .specialization = {}, .push = as_push(push)},
            {tiles, 1, 1});
    });
    return out;
}

} // namespace ockham
