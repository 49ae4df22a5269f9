// SPDX-License-Identifier: Apache-2.0
#include "passes/schedule/tile_list.hpp"

#include "framework/runtime/commands.hpp"
#include "shaders/schedule/tile_list.h"

#include <bit>

namespace ockham {
namespace {

std::uint32_t tiles_over(std::uint32_t pixels) { return (pixels + BUCKET_TILE - 1) / BUCKET_TILE; }
std::uint32_t padded_bits(std::uint32_t pixels) {
    return static_cast<std::uint32_t>(std::bit_width(tiles_over(pixels) - 1));
}

} // namespace

TileList add_tile_list(
    Graph& graph, ImageHandle sample_count, std::uint32_t width, std::uint32_t height) {
    const shader::TileListPush push{
        .size = {width, height}, .tile_bits = {padded_bits(width), padded_bits(height)}};
    const std::uint32_t padded_tiles = 1u << (push.tile_bits.x + push.tile_bits.y);
    const std::uint64_t words = sizeof(std::uint32_t);
    const std::uint64_t tiles = std::uint64_t{tiles_over(width)} * tiles_over(height);

    BufferHandle work = graph.create_buffer("tile_work", {padded_tiles * words});
    TileList out{.list = graph.create_buffer("tile_list", {(1 + tiles) * words}),
        .arguments = graph.create_buffer("tile_arguments", {sizeof(shader::DispatchArguments)})};

    PassBuilder count = graph.add_compute_pass("tile_work");
    count.because("tiles whose pixels all have one sample need no second look");
    count.read("sample_count", sample_count);
    work = count.write("tile_work", work);
    count.record([push, padded_tiles](Commands& commands) {
        commands.dispatch_over(
            {.shader = "schedule/tile_work.comp", .specialization = {}, .push = as_push(push)},
            {padded_tiles, 1, 1});
    });

    PassBuilder list = graph.add_compute_pass("tile_list");
    list.because("the device itself decides how many tiles are worked through");
    list.read("tile_work", work);
    out.list = list.write("tile_list", out.list);
    out.arguments = list.write("tile_arguments", out.arguments);
    list.record([push](Commands& commands) {
        commands.dispatch(
            {.shader = "schedule/tile_list.comp", .specialization = {}, .push = as_push(push)},
            {1, 1, 1});
    });
    return out;
}

} // namespace ockham
