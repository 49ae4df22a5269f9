// SPDX-License-Identifier: Apache-2.0
// Ranges and majorants of a volume's cells by brute force, in double precision. For tests: they are
// compared with the passes that make them, and stand in for these in tests of other passes.
#pragma once

#include "framework/scene/transfer_function.hpp"
#include "framework/scene/volume.hpp"
#include "shaders/shared/volume.h"

#include <algorithm>
#include <limits>
#include <vector>

namespace ockham::reference {

/// Least and greatest data value of each cell, x fastest; a cell's lookups touch one more voxel
/// on each side.
inline std::vector<ValueRange> cell_ranges(const Volume& volume) {
    const glm::ivec3 dims(volume.dims), cells = (dims + RANGE_CELL - 1) / RANGE_CELL;
    std::vector<ValueRange> ranges;
    for (int z = 0; z < cells.z; ++z)
        for (int y = 0; y < cells.y; ++y)
            for (int x = 0; x < cells.x; ++x) {
                const glm::ivec3 first =
                    glm::max(glm::ivec3(x, y, z) * RANGE_CELL - 1, glm::ivec3(0));
                const glm::ivec3 last = glm::min((glm::ivec3(x, y, z) + 1) * RANGE_CELL, dims - 1);
                ValueRange range{std::numeric_limits<double>::infinity(),
                    -std::numeric_limits<double>::infinity()};
                for (int k = first.z; k <= last.z; ++k)
                    for (int j = first.y; j <= last.y; ++j)
                        for (int i = first.x; i <= last.x; ++i) {
                            const double value = volume.at({i, j, k});
                            range.lowest = std::min(range.lowest, value);
                            range.highest = std::max(range.highest, value);
                        }
                ranges.push_back(range);
            }
    return ranges;
}

/// The greatest opacity that the table, linear between entries, takes over the range: at its ends
/// or at an entry inside.
inline double greatest_opacity(const TransferTable& table, const ValueRange& range) {
    const double last = static_cast<double>(table.entries.size() - 1);
    const auto place = [&](double value) {
        return std::clamp((value - table.first) / (table.last - table.first) * last, 0.0, last);
    };
    const auto at = [&](double x) {
        const std::size_t entry = std::min(static_cast<std::size_t>(x), table.entries.size() - 2);
        const double fraction = x - static_cast<double>(entry);
        return (1 - fraction) * static_cast<double>(table.entries[entry].w) +
               fraction * static_cast<double>(table.entries[entry + 1].w);
    };
    double greatest = std::max(at(place(range.lowest)), at(place(range.highest)));
    for (std::size_t i = 0; i < table.entries.size(); ++i) {
        const auto x = static_cast<double>(i);
        if (place(range.lowest) <= x && x <= place(range.highest))
            greatest = std::max(greatest, static_cast<double>(table.entries[i].w));
    }
    return greatest;
}

} // namespace ockham::reference
