// SPDX-License-Identifier: Apache-2.0
#include "passes/schedule/dispatch.hpp"

#include "framework/core/error.hpp"
#include "shaders/schedule/buckets.h"

#include <algorithm>
#include <array>

namespace ockham {
namespace {

using Histogram = std::array<std::uint64_t, MAX_BUCKETS + 1>; ///< pixels by count

std::uint64_t round_up(std::uint64_t value, std::uint64_t unit) {
    return (value + unit - 1) / unit * unit;
}

/// Calls visit(histogram) for each block of the picture.
template <class Visit>
void for_each_block(std::span<const float> counts, std::uint32_t width, std::uint32_t height,
    std::uint32_t block_width, std::uint32_t block_height, Visit visit) {
    for (std::uint32_t y = 0; y < height; y += block_height) {
        for (std::uint32_t x = 0; x < width; x += block_width) {
            Histogram block{};
            for (std::uint32_t v = y; v < std::min(y + block_height, height); ++v) {
                for (std::uint32_t u = x; u < std::min(x + block_width, width); ++u)
                    ++block[static_cast<std::size_t>(counts[std::size_t{v} * width + u])];
            }
            visit(block);
        }
    }
}

/// Samples beyond the first.
std::uint64_t work(const Histogram& histogram) {
    std::uint64_t sum = 0;
    for (std::uint64_t k = 1; k <= MAX_BUCKETS; ++k) sum += histogram[k] * (k - 1);
    return sum;
}

/// Pixels listed by descending count: each group of lanes works as long as its first.
std::uint64_t sorted_slots(const Histogram& all, std::uint32_t lanes) {
    std::uint64_t slots = 0, open = 0; // lanes of the last group that are still free
    for (std::uint64_t k = MAX_BUCKETS; k > 1; --k) {
        const std::uint64_t pixels = all[k] - std::min(all[k], open);
        if (pixels == 0) {
            open -= all[k];
            continue;
        }
        slots += round_up(pixels, lanes) * (k - 1);
        open = round_up(pixels, lanes) - pixels;
    }
    return slots;
}

} // namespace

const char* name_of(Dispatch dispatch) {
    switch (dispatch) {
    case Dispatch::loop:
        return "loop";
    case Dispatch::buckets:
        return "buckets";
    case Dispatch::repack:
        return "repack";
    case Dispatch::stencil:
        return "stencil";
    case Dispatch::depth:
        return "depth";
    case Dispatch::sort:
        break;
    }
    return "sort";
}

double lane_efficiency(std::span<const float> counts, std::uint32_t width, std::uint32_t height,
    Dispatch dispatch, std::uint32_t lanes) {
    check(counts.size() == std::size_t{width} * height && lanes % 4 == 0, "a map and whole groups");
    std::uint64_t slots = 0; // of lanes, beyond the first samples
    Histogram all{};
    for_each_block(
        counts, width, height, width, height, [&](const Histogram& picture) { all = picture; });
    switch (dispatch) {
    case Dispatch::loop: // groups are rows of a workgroup's 8 x 8 pixels
        for_each_block(counts, width, height, lanes, 1, [&](const Histogram& group) {
            std::uint64_t most = MAX_BUCKETS;
            while (group[most] == 0) --most;
            slots += (most - 1) * lanes;
        });
        break;
    case Dispatch::buckets:
        for (std::uint64_t k = 2; k <= MAX_BUCKETS; ++k) slots += round_up(all[k], lanes) * (k - 1);
        break;
    case Dispatch::sort:
        slots = sorted_slots(all, lanes);
        break;
    case Dispatch::repack:
        for_each_block(counts, width, height, BUCKET_TILE, BUCKET_TILE,
            [&](const Histogram& tile) { slots += round_up(work(tile), lanes); });
        break;
    case Dispatch::stencil: // groups are blocks of quads, drawn once per count that they hold
    case Dispatch::depth:
        for_each_block(counts, width, height, lanes / 2, 2, [&](const Histogram& group) {
            for (std::uint64_t k = 2; k <= MAX_BUCKETS; ++k)
                slots += group[k] > 0 ? (k - 1) * lanes : 0;
        });
        break;
    }
    const std::uint64_t pixels = std::uint64_t{width} * height;
    return static_cast<double>(pixels + work(all)) / static_cast<double>(pixels + slots);
}

} // namespace ockham
