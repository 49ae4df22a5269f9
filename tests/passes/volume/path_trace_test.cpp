// SPDX-License-Identifier: Apache-2.0
// Path tracing against closed forms, tables of radiative transfer and an analog twin, by z-tests
// with fixed seeds; and its promises: furnaces, budgets, seeds, statistics.
#include "framework/core/rng.hpp"
#include "passes/volume/path_trace.hpp"
#include "tests/reference/analog_tracer.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/volume_bench.hpp"
#include "tests/support/z_test.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

namespace ockham::test {
namespace {

constexpr double kPi = std::numbers::pi;

/// A picture of a volume; its pixels are independent.
struct Case {
    Volume volume = float_volume(glm::uvec3(2), [](glm::uvec3) { return 1.0; });
    TransferFunction transfer = linear_transfer();
    VolumeBench::Options options = {};
    PathTraceParams params = {};
    std::uint32_t samples = 64; ///< per pixel, in two halves
    bool global_majorant = false;
};

/// A cube of side 1 and this extinction, as wide as the middle half of a view from (0, 0, 2) with
/// one radian from bottom to top.
Case cube(float sigma, float albedo, float g = 0) {
    Case setup;
    setup.options.view.density_scale = sigma;
    setup.options.view.albedo = albedo;
    setup.options.view.phase_g = g;
    setup.options.width = setup.options.height = 32;
    const double half = std::atan(0.5 * std::tan(0.5));
    setup.options.camera = look_at({0, 0, 2}, {0, 0, 0}, static_cast<float>(2 * half * 180 / kPi));
    setup.samples = 1024;
    return setup;
}

struct Result {
    std::array<Estimate, 3> mean; ///< over all pixels, per channel
    double alpha = 0;
    PathStatistics statistics;
    std::vector<float> sum; ///< R, G, B, A of each pixel
};

class PathTraceTest : public GpuTest {
protected:
    /// Errors come from the differences between the halves of each pixel.
    static Result trace(Case setup) {
        VolumeBench bench(device(), setup.volume, setup.transfer, setup.options);
        if (setup.global_majorant) bench.inputs.majorants = {};
        setup.params.width = setup.options.width;
        setup.params.height = setup.options.height;
        setup.params.samples_per_step = setup.samples / 2;
        const PathTraceConditions conditions{
            bench.graph.add_condition("restart"), bench.graph.add_condition("drain")};
        const PathTrace out = add_path_trace(bench.graph, bench.inputs, setup.params, conditions);
        bench.graph.export_resource(out.radiance, "test");
        bench.on_bind([&](Executor& executor) {
            executor.set(conditions.restart, false); // all is zero before the first execution
            executor.set(conditions.drain, false);
        });
        const auto step = [&] {
            bench.execute();
            bench.executor().set(conditions.drain, true);
            while (!path_statistics(bench.executor().read(out.statistics)).drained())
                bench.execute();
            bench.executor().set(conditions.drain, false);
            return interleaved(bench.read(out.sum));
        };
        const std::vector<float> first = step();
        Result result;
        result.sum = step();
        result.statistics = path_statistics(bench.executor().read(out.statistics));

        const std::size_t pixels = result.sum.size() / 4;
        const double n = setup.samples;
        for (std::size_t c = 0; c < 3; ++c) {
            double sum = 0, variance = 0;
            for (std::size_t i = 0; i < pixels; ++i) {
                const double half = first[i * 4 + c], all = result.sum[i * 4 + c];
                sum += all / n;
                variance += (2 * half - all) * (2 * half - all) / (n * n); // of the pixel's mean
            }
            const auto count = static_cast<double>(pixels);
            result.mean[c] = {sum / count, std::sqrt(variance) / count};
        }
        for (std::size_t i = 0; i < pixels; ++i) result.alpha += result.sum[i * 4 + 3] / n;
        result.alpha /= static_cast<double>(pixels);
        EXPECT_EQ(result.statistics.finished, pixels * setup.samples);
        EXPECT_EQ(result.statistics.truncated, 0u);
        EXPECT_EQ(result.statistics.clamped, 0u);
        return result;
    }

    /// A view straight along an axis, as wide as `width` around the middle of the box.
    static Camera flat_view(glm::vec3 from, float width = 0.01f) {
        Camera camera = look_at(from, glm::vec3(0.0f), 30.0f);
        camera.orthographic_height = width;
        return camera;
    }
};

TEST_F(PathTraceTest, CubeInWhiteLightHasTheValuesOfAnIndependentTracer) {
    struct Row {
        float sigma, albedo, g;
        Estimate truth;
    };
    // Analog Monte Carlo by another program; the last one is a quadrature.
    const Row rows[] = {{4, 1.0f, 0, {1.0, 0}}, {4, 0.8f, 0, {0.5610, 1e-4}},
        {4, 0.5f, 0, {0.2737, 1e-4}}, {4, 0.8f, 0.6f, {0.5414, 1e-4}}, {2, 0.8f, 0, {0.7258, 1e-4}},
        {4, 0.0f, 0, {0.056846, 5e-7}}};
    for (const Row& row : rows) {
        SCOPED_TRACE(fmt::format("sigma {}, albedo {}, g {}", row.sigma, row.albedo, row.g));
        const Estimate mean = trace(cube(row.sigma, row.albedo, row.g)).mean[0];
        EXPECT_LE(mean.error, 0.0005);
        EXPECT_LE(z_of(mean, row.truth), z_limit(std::size(rows)))
            << mean.mean << " +- " << mean.error;
    }
}

} // namespace
} // namespace ockham::test
