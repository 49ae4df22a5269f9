// SPDX-License-Identifier: Apache-2.0
#include "passes/pipelines/screen_tiles.hpp"

#include "framework/core/error.hpp"

#include <algorithm>

namespace ockham {
namespace {

struct Span {
    std::uint32_t origin, first, last;
};

/// One axis.
std::vector<Span> cut(
    std::uint32_t length, std::uint32_t extent, std::uint32_t apron, std::uint32_t block) {
    check(extent <= length && (length - extent) % block == 0 && apron % block == 0,
        "tiles end where blocks and the picture end");
    std::vector<Span> spans;
    std::uint32_t origin = 0, first = 0;
    while (origin + extent < length) {
        const std::uint32_t last = origin + (extent - apron) / block * block;
        check(last > first, "a tile gives at least one block");
        spans.push_back({origin, first, last});
        first = last;
        origin = std::min(last - apron, length - extent);
    }
    spans.push_back({origin, first, length});
    return spans;
}

} // namespace

std::uint32_t tile_extent(
    std::uint32_t length, std::uint32_t most, std::uint32_t apron, std::uint32_t block) {
    if (length <= most) return length;
    const std::uint32_t extent = length - (length - most + block - 1) / block * block;
    const bool wraps = extent > length;
    return wraps || extent < 2 * apron + block ? 0 : extent;
}

std::vector<TilePlacement> place_tiles(
    glm::uvec2 picture, glm::uvec2 extent, std::uint32_t apron, std::uint32_t block) {
    std::vector<TilePlacement> tiles;
    const std::vector<Span> columns = cut(picture.x, extent.x, apron, block);
    for (const Span& y : cut(picture.y, extent.y, apron, block)) {
        for (const Span& x : columns)
            tiles.push_back({{x.origin, y.origin}, {x.first, y.first}, {x.last, y.last}});
    }
    return tiles;
}

void paste_tile(Image& whole, const Image& tile, const TilePlacement& placement, glm::uvec2 picture,
    std::uint32_t scale) {
    if (whole.pixels() == 0) {
        whole = Image(static_cast<int>(scale * picture.x), static_cast<int>(scale * picture.y),
            tile.channels());
    }
    const auto width = static_cast<std::ptrdiff_t>(scale * (placement.last.x - placement.first.x));
    const glm::uvec2 from = scale * (placement.first - placement.origin);
    const glm::uvec2 to = scale * placement.first;
    const std::uint32_t rows = scale * (placement.last.y - placement.first.y);
    for (int c = 0; c < static_cast<int>(tile.channels().size()); ++c) {
        const auto source = tile.plane(c);
        const auto target = whole.plane(c);
        for (std::uint32_t y = 0; y < rows; ++y) {
            const auto row =
                source.begin() + from.x + static_cast<std::ptrdiff_t>(from.y + y) * tile.width();
            std::copy(row, row + width,
                target.begin() + to.x + static_cast<std::ptrdiff_t>(to.y + y) * whole.width());
        }
    }
}

} // namespace ockham
