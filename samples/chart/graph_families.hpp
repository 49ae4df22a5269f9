// SPDX-License-Identifier: Apache-2.0
// Families of graphs of any size that planners are compared on: chain2 and random16. Used by the
// benchmark, by charts and by tests; RandomGraph (tests) is the third corpus.
#pragma once

#include "framework/core/rng.hpp"
#include "framework/graph/graph.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace ockham {

/// Each pass reads what the one before wrote; the last output is exported. `passes` >= 1.
inline Graph chain2(std::uint32_t passes) {
    Pcg32 rng(2);
    Graph graph("chain2");
    BufferHandle previous;
    for (std::uint32_t i = 0; i < passes; ++i) {
        const BufferHandle next = graph.create_buffer(
            fmt::format("b{}", i), {1 + static_cast<std::uint64_t>(std::exp2(rng.uniform(8, 24)))});
        auto pass = graph.add_compute_pass(fmt::format("p{}", i));
        if (previous) pass.read("from", previous);
        previous = pass.write("to", next);
    }
    graph.export_resource(previous, "the end of the chain");
    return graph;
}

/// Each pass writes a buffer or image of its own and reads 0 to 16 of those before, both uniform.
/// Passes that none reads have a side effect, so that nothing is culled; the last is exported.
inline Graph random16(std::uint32_t passes, std::uint64_t seed = 1) {
    Pcg32 rng(seed);
    std::vector<std::vector<std::uint32_t>> reads(passes);
    std::vector<bool> is_read(passes, false);
    for (std::uint32_t i = 1; i < passes; ++i) {
        const std::uint32_t count = rng.below(17);
        for (std::uint32_t k = 0; k < count; ++k) reads[i].push_back(rng.below(i));
        std::sort(reads[i].begin(), reads[i].end());
        reads[i].erase(std::unique(reads[i].begin(), reads[i].end()), reads[i].end());
        for (const std::uint32_t read : reads[i]) is_read[read] = true;
    }
    constexpr VkFormat formats[] = {VK_FORMAT_R8_UNORM, VK_FORMAT_R16G16_SFLOAT,
        VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_R32G32B32A32_SFLOAT};
    Graph graph("random16");
    std::vector<BufferHandle> buffers(passes);
    std::vector<ImageHandle> images(passes);
    for (std::uint32_t i = 0; i < passes; ++i) {
        const std::string name = fmt::format("r{}", i);
        if (rng.below(2)) {
            const std::uint32_t width = 1 + rng.below(2048), height = 1 + rng.below(2048);
            images[i] = graph.create_image(name, {formats[rng.below(4)], width, height});
        } else {
            const auto bytes = static_cast<std::uint64_t>(std::exp2(rng.uniform(8, 24)));
            buffers[i] = graph.create_buffer(name, {bytes});
        }
        auto pass = graph.add_compute_pass(fmt::format("p{}", i));
        for (std::size_t k = 0; k < reads[i].size(); ++k) {
            const std::string binding = fmt::format("in{}", k);
            if (const std::uint32_t from = reads[i][k]; buffers[from])
                pass.read(binding, buffers[from]);
            else
                pass.sample(binding, images[from]);
        }
        if (buffers[i])
            buffers[i] = pass.write("out", buffers[i]);
        else
            images[i] = pass.write("out", images[i]);
        if (!is_read[i] && i + 1 != passes) pass.side_effect("nothing reads what it writes");
    }
    if (buffers.back())
        graph.export_resource(buffers.back(), "the last one");
    else
        graph.export_resource(images.back(), "the last one");
    return graph;
}

} // namespace ockham
