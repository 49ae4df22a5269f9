// SPDX-License-Identifier: Apache-2.0
// Path traced pictures of small volumes with the errors of their means, for tests of expectations.
#pragma once

#include "passes/volume/cache.hpp"
#include "passes/volume/path_trace.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/volume_bench.hpp"
#include "tests/support/z_test.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

namespace ockham::test {

/// A picture of a volume; its pixels are independent.
struct Case {
    Volume volume = float_volume(glm::uvec3(2), [](glm::uvec3) { return 1.0; });
    TransferFunction transfer = linear_transfer();
    VolumeBench::Options options = {};
    PathTraceParams params = {};
    std::uint32_t samples = 64; ///< per pixel, in two halves
    bool global_majorant = false;
    std::optional<CacheParams> cache = {}; ///< refined first; mode gather
    std::uint32_t cache_executions = 0;    ///< of that; 0: until every cell reaches the target
};

/// A cube of side 1 and this extinction, as wide as the middle half of a view from (0, 0, 2) with
/// one radian from bottom to top.
inline Case cube(float sigma, float albedo, float g = 0) {
    Case setup;
    setup.options.view.density_scale = sigma;
    setup.options.view.albedo = albedo;
    setup.options.view.phase_g = g;
    setup.options.width = setup.options.height = 32;
    const double half = std::atan(0.5 * std::tan(0.5));
    setup.options.camera =
        look_at({0, 0, 2}, {0, 0, 0}, static_cast<float>(2 * half * 180 / std::numbers::pi));
    setup.samples = 1024;
    return setup;
}

struct Result {
    std::array<Estimate, 3> mean; ///< over all pixels, per channel
    double alpha = 0;
    PathStatistics statistics;
    std::vector<float> sum; ///< R, G, B, A of each pixel
};

/// Counts and promises are checked with each picture.
class PathTest : public GpuTest {
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
        Cache cache;
        if (setup.cache) cache = add_cache(bench.graph, bench.inputs, *setup.cache);
        const PathTrace out = add_path_trace(
            bench.graph, bench.inputs, setup.params, conditions, {cache.index, cache.cells});
        bench.graph.export_resource(out.radiance, "test");
        bench.on_bind([&](Executor& executor) {
            executor.set(conditions.restart, false); // all is zero before the first execution
            executor.set(conditions.drain, setup.cache.has_value());
        });
        if (setup.cache) refine(bench, cache, setup.cache_executions);
        if (setup.cache) bench.executor().set(conditions.drain, false);
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

    /// A cube() seen through a cache of `cells` cells along each side.
    static Estimate gathered(Case it, std::uint32_t cells, float target_error) {
        it.volume = float_volume(glm::uvec3(cells), [](glm::uvec3) { return 1.0; });
        it.params.mode = PathMode::gather;
        it.cache = CacheParams{.scale = 1,
            .format = CacheFormat::fp32,
            .directional = it.options.view.phase_g != 0,
            .target_error = target_error,
            .paths = 64,
            .capacity = cells * cells * cells};
        return trace(it).mean[0];
    }

    static void refine(VolumeBench& bench, const Cache& cache, std::uint32_t executions) {
        for (std::uint32_t i = 0; i < (executions > 0 ? executions : 10000); ++i) {
            bench.execute();
            set_cache_change(bench.executor(), cache, CacheChange::none);
            if (bench.read<shader::CacheControl>(cache.control)[0].suspended != 0) return;
        }
        EXPECT_GT(executions, 0u) << "the cache does not reach its target";
    }

    /// A view straight along an axis, as wide as `width` around the middle of the box.
    static Camera flat_view(glm::vec3 from, float width = 0.01f) {
        Camera camera = look_at(from, glm::vec3(0.0f), 30.0f);
        camera.orthographic_height = width;
        return camera;
    }
};

/// z-tests of one family: each must hold.
class Family {
public:
    explicit Family(std::size_t comparisons) : limit_(z_limit(comparisons)) {}
    void expect(const Estimate& found, const Estimate& truth, const std::string& what) const {
        EXPECT_LE(z_of(found, truth), limit_)
            << what << ": " << found.mean << " +- " << found.error << ", expected " << truth.mean
            << " +- " << truth.error;
    }
    void expect(const Estimate& found, double truth, const std::string& what) const {
        expect(found, Estimate{truth, 0}, what);
    }

private:
    double limit_;
};

} // namespace ockham::test
