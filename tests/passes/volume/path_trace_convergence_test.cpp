// SPDX-License-Identifier: Apache-2.0
// How fast errors fall with samples, by replicates: pictures of sixteen seeds, whose variance is
// the mean squared error, since the estimate has no bias (path_trace_test.cpp).
#include "tests/support/path_case.hpp"

namespace ockham::test {
namespace {

class PathTraceConvergence : public PathTest {
protected:
    static constexpr std::uint32_t kSeeds = 16;

    /// Root of the mean variance of pixels at a number of samples.
    static double error(std::uint32_t samples, bool sobol) {
        Case it = cube(2, 0.8f);
        it.options.width = it.options.height = 24;
        it.options.sobol = sobol;
        it.samples = samples;
        std::vector<double> sum, squares;
        for (std::uint32_t seed = 1; seed <= kSeeds; ++seed) {
            it.options.view.seed = seed;
            const Result result = trace(it);
            sum.resize(result.sum.size() / 4);
            squares.resize(sum.size());
            for (std::size_t i = 0; i < sum.size(); ++i) {
                const double mean = double{result.sum[i * 4]} / samples;
                sum[i] += mean;
                squares[i] += mean * mean;
            }
        }
        double variance = 0;
        for (std::size_t i = 0; i < sum.size(); ++i)
            variance += (squares[i] - sum[i] * sum[i] / kSeeds) / (kSeeds - 1);
        return std::sqrt(variance / static_cast<double>(sum.size()));
    }

    /// Least squares of log error over log samples.
    static double slope(bool sobol) {
        double n = 0, x1 = 0, y1 = 0, x2 = 0, xy = 0;
        for (const std::uint32_t samples : {16u, 64u, 256u, 1024u}) {
            const double x = std::log(samples), y = std::log(error(samples, sobol));
            n += 1, x1 += x, y1 += y, x2 += x * x, xy += x * y;
        }
        return (n * xy - x1 * y1) / (n * x2 - x1 * x1);
    }
};

TEST_F(PathTraceConvergence, IndependentSamplesConvergeByTheRoot) {
    EXPECT_NEAR(slope(false), -0.5, 0.03);
}

TEST_F(PathTraceConvergence, SobolPointsConvergeNoSlowerAndLieLower) {
    EXPECT_LE(slope(true), -0.5);
    EXPECT_LT(error(64, true), error(64, false));
}

} // namespace
} // namespace ockham::test
