// SPDX-License-Identifier: Apache-2.0
// What the cells of the cache cost: pictures through caches of several sizes against paths without
// one and against an independent tracer.
#include "tests/support/path_case.hpp"

#include <fmt/format.h>

#include <cmath>
#include <vector>

namespace ockham::test {
namespace {

class TransportConvergence : public PathTest {};

TEST_F(TransportConvergence, CubesOfFineCellsHaveTheValuesOfAnIndependentTracer) {
    struct Row {
        float albedo, g;
        double truth;
    };
    for (const Row row : {Row{0.8f, 0, 0.5610}, {0.5f, 0, 0.2737}, {0.8f, 0.6f, 0.5414}}) {
        const Estimate mean = gathered(cube(4, row.albedo, row.g), 32, 0.02f);
        EXPECT_LE(std::abs(mean.mean - row.truth), 3 * mean.error + 1e-4)
            << "albedo " << row.albedo << ", g " << row.g << ": " << mean.mean << " +- "
            << mean.error;
        EXPECT_LE(mean.error, 5e-4);
        RecordProperty(fmt::format("albedo_{}_g_{}", row.albedo, row.g),
            fmt::format("{:.5f} +- {:.5f}", mean.mean, mean.error));
    }
}

TEST_F(TransportConvergence, BiasFallsThreefoldWithEveryHalvingOfTheCells) {
    Case it = cube(16, 0.8f);
    it.samples = 4096;
    const Estimate truth = trace(it).mean[0];
    std::vector<double> bias;
    std::string found = fmt::format("{:.5f} +- {:.5f}", truth.mean, truth.error);
    for (const std::uint32_t cells : {8u, 16u, 32u}) {
        it.options.view.seed = cells;
        // As many paths for every cell, and not until they look good: stopping has a bias too.
        it.cache_executions = 8 * (32 / cells) * (32 / cells);
        const Estimate mean = gathered(it, cells, 0);
        found += fmt::format("; {} cells: {:.5f} +- {:.5f}", cells, mean.mean, mean.error);
        bias.push_back(std::abs(mean.mean - truth.mean));
    }
    RecordProperty("found", found);
    EXPECT_GE(bias[0], 3 * bias[1]) << found;
    EXPECT_GE(bias[1], 3 * bias[2]) << found;
}

} // namespace
} // namespace ockham::test
