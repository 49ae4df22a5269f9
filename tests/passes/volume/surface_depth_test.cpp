// SPDX-License-Identifier: Apache-2.0
// Depth of the first isosurface by its three searches: the exact one against a brute-force twin,
// the paper's stochastic one against the laws that it obeys, misses and bias included.
#include "passes/volume/surface_depth.hpp"
#include "tests/reference/trilinear_surface.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/volume_bench.hpp"
#include "tests/support/z_test.hpp"

#include <cmath>
#include <functional>

namespace ockham::test {
namespace {

constexpr std::uint32_t kVoxels = 512; // along the view

/// A cube whose field depends on how deep the view from above has come, 0 to 1.
Volume layered(const std::function<double(double)>& value) {
    Volume volume = float_volume(
        {2, 2, kVoxels}, [&](glm::uvec3 v) { return value(1 - (v.z + 0.5) / kVoxels); });
    volume.spacing_mm = {kVoxels / 2.0, kVoxels / 2.0, 1};
    return volume;
}
/// Solid from depth `a` on, for the isovalue a.
Volume ramp() {
    return layered([](double depth) { return depth; });
}
/// For the isovalue 1/2: solid over `count` voxels from the one at `first` on, and behind `solid`.
Volume shell(std::uint32_t first, std::uint32_t count, double solid = 2) {
    return layered([=](double depth) {
        const auto layer = static_cast<std::uint32_t>(depth * kVoxels);
        return (layer >= first && layer < first + count) || depth > solid ? 1.0 : 0.0;
    });
}

Camera from_above() {
    Camera camera = look_at({0, 0, 2}, {0, 0, 0}, 30, UpAxis::z);
    camera.orthographic_height = 0.9f;
    return camera;
}

struct Pixel {
    double depth = 0;
    int surface = -1; // -1: none
    bool operator==(const Pixel&) const = default;
};

class SurfaceDepthTest : public GpuTest {
protected:
    /// The pass on one volume, ready to be executed.
    struct Bench {
        Bench(const Volume& volume, const std::vector<double>& isovalues, SurfaceDepthParams params,
            const Camera& camera = from_above(), VolumeView view = {})
            : field{glm::ivec3(volume.dims), std::vector<float>(volume.voxel_count())},
              place(place_of(volume)) {
            std::memcpy(field.voxels.data(), volume.voxels.data(), volume.voxels.size());
            for (const double value : isovalues) view.surfaces.push_back({.value = value});
            bench.emplace(device(), volume, linear_transfer(),
                VolumeBench::Options{.view = view,
                    .width = params.width,
                    .height = params.height,
                    .camera = camera});
            restart = bench->graph.add_condition("restart");
            out = add_surface_depth(bench->graph, bench->inputs, params, restart);
            bench->graph.export_resource(out.depth, "test");
        }
        void execute(bool from_the_start = false) {
            bench->execute();
            bench->executor().set(restart, from_the_start); // the next one
        }
        std::vector<Pixel> read() {
            const Image image = bench->read(out.depth);
            std::vector<Pixel> pixels;
            for (std::size_t i = 0; i < image.plane(0).size(); ++i) {
                pixels.push_back({double{image.plane(0)[i]}, int(image.plane(1)[i]) - 1});
            }
            return pixels;
        }
        std::vector<Pixel> run(int executions = 1) {
            for (int i = 0; i < executions; ++i) execute();
            return read();
        }

        reference::TrilinearField field;
        VolumePlace place;
        std::optional<VolumeBench> bench;
        Condition restart;
        SurfaceDepth out;
    };
    static SurfaceDepthParams params(SurfaceSearch search, std::uint32_t side,
        std::uint32_t candidates = 1, std::uint32_t steps = 512) {
        return {side, side, search, candidates, steps};
    }
    static double share_missed(const std::vector<Pixel>& pixels) {
        std::size_t missed = 0;
        for (const Pixel& pixel : pixels) missed += pixel.surface < 0 ? 1u : 0u;
        return static_cast<double>(missed) / static_cast<double>(pixels.size());
    }
    static Estimate excess(const std::vector<Pixel>& pixels, double a) {
        double sum = 0, square = 0;
        for (const Pixel& pixel : pixels) {
            sum += pixel.depth - a;
            square += (pixel.depth - a) * (pixel.depth - a);
        }
        const auto n = static_cast<double>(pixels.size());
        const double mean = sum / n;
        return {mean, std::sqrt((square / n - mean * mean) / n)};
    }
    static double binomial_error(double p, std::size_t n) {
        return std::sqrt(p * (1 - p) / static_cast<double>(n));
    }
};

// E[G_N] - a of a solid [a, 1], from 400,000 simulations each, as printed to five digits.
struct Bias {
    double a;
    std::vector<double> after; // N = 8, 16, 32, ...
};
const std::vector<Bias> kBias = {{.1, {.03229, .01020, .00401, .00178, .00084, .00040, .00020}},
    {.25, {.06011, .02287, .00960, .00436, .00207, .00101, .00050}},
    {.5, {.09253, .04118, .01841, .00856, .00411, .00201, .00099, .00049, .00025}},
    {.75, {.10036, .05435, .02636, .01259, .00610, .00300, .00148}},
    {.9, {.06800, .04873, .02883, .01472, .00725, .00358, .00178}}};

TEST_F(SurfaceDepthTest, StochasticBiasFollowsTheTable) {
    const double limit = z_limit(37);
    for (const Bias& row : kBias) {
        Bench bench(ramp(), {row.a}, params(SurfaceSearch::stochastic, 64, 8));
        int executions = 0;
        for (std::size_t i = 0; i < row.after.size(); ++i) {
            const int n = 8 << i;
            for (; executions < n / 8; ++executions) bench.execute();
            const std::vector<Pixel> pixels = bench.read();
            const Estimate measured = excess(pixels, row.a);
            const double simulated = measured.error * std::sqrt(64 * 64 / 4e5);
            const Estimate truth{row.after[i], std::hypot(simulated, 0.29e-5)};
            EXPECT_LT(z_of(measured, truth), limit)
                << "a = " << row.a << ", N = " << n << ": " << measured.mean;
        }
    }
}

TEST_F(SurfaceDepthTest, StochasticStepsFollowTheirLaws) {
    // With e = G - a: a candidate is taken with chance e / (a + e), and then e' = U e.
    const double a = 0.3;
    Bench bench(ramp(), {a}, params(SurfaceSearch::stochastic, 96));
    std::vector<Pixel> before(96 * 96, Pixel{1, -1});
    double taken = 0, expected = 0, variance = 0, u_sum = 0, u2_sum = 0;
    for (int step = 0; step < 12; ++step) {
        const std::vector<Pixel> after = bench.run();
        for (std::size_t i = 0; i < after.size(); ++i) {
            const double e = before[i].depth - a, chance = e / before[i].depth;
            expected += chance;
            variance += chance * (1 - chance);
            EXPECT_LE(after[i].depth, before[i].depth);
            EXPECT_GE(after[i].depth, a - 1e-5) << "a candidate in front of the solid";
            if (after[i].depth == before[i].depth) continue;
            const double u = (after[i].depth - a) / e;
            taken += 1;
            u_sum += u;
            u2_sum += u * u;
        }
        before = after;
    }
    const double limit = z_limit(3);
    EXPECT_LT(std::abs(taken - expected) / std::sqrt(variance), limit);
    EXPECT_LT(std::abs(u_sum - taken / 2) / std::sqrt(taken / 12), limit);
    EXPECT_LT(std::abs(u2_sum - taken / 3) / std::sqrt(taken * (1.0 / 5 - 1.0 / 9)), limit);
}

TEST_F(SurfaceDepthTest, StochasticTailsLieBetweenTheirBounds) {
    const double a = 0.5;
    const int n = 256;
    Bench bench(ramp(), {a}, params(SurfaceSearch::stochastic, 128, n));
    const std::vector<Pixel> pixels = bench.run();
    const double limit = z_limit(8);
    for (const double x : {0.5 * a / n, a / n, 2 * a / n, 3 * a / n}) {
        double beyond = 0;
        for (const Pixel& pixel : pixels) beyond += pixel.depth - a > x;
        const double share = beyond / static_cast<double>(pixels.size());
        const double low = std::pow(1 - x / a, n), high = std::pow(1 - x, n);
        EXPECT_GT(share, low - limit * binomial_error(low, pixels.size())) << x;
        EXPECT_LT(share, high + limit * binomial_error(high, pixels.size())) << x;
    }
}

TEST_F(SurfaceDepthTest, StochasticMissesThinShellsAsOftenAsItMust) {
    struct Case {
        std::uint32_t voxels;
        double isovalue; // 0.5: as thick as the voxels; 0.75: half as thick
        std::uint32_t n;
    };
    const std::vector<Case> cases = {{8, .5, 45}, {8, .5, 293}, {8, .5, 439}, {2, .5, 178},
        {2, .5, 1177}, {1, .5, 64}, {1, .5, 256}, {1, .5, 1024}, {1, .75, 710}};
    const double limit = z_limit(cases.size());
    for (const Case& it : cases) {
        const double thickness = it.voxels * (it.isovalue == 0.75 ? 0.5 : 1.0) / kVoxels;
        Bench bench(
            shell(200, it.voxels), {it.isovalue}, params(SurfaceSearch::stochastic, 64, it.n));
        const std::vector<Pixel> pixels = bench.run();
        const double miss = std::pow(1 - thickness, it.n);
        EXPECT_LT(z_of({share_missed(pixels), binomial_error(miss, pixels.size())}, miss), limit)
            << "1/" << 1 / thickness << " thick, N = " << it.n << ": " << share_missed(pixels);
    }
}

TEST_F(SurfaceDepthTest, StochasticTakesTheSolidForTheShellBeforeIt) {
    struct Case {
        double a, b;
        double simulated, error; // P(the shell is missed), N = 256, 1/256 thick
    };
    for (const Case& it : {Case{.2, .5, .1411, 6e-4}, Case{.4, .7, .244, 8e-4}}) {
        const auto first = static_cast<std::uint32_t>(it.a * kVoxels);
        Bench bench(shell(first, 2, it.b), {0.5}, params(SurfaceSearch::stochastic, 128, 256));
        const std::vector<Pixel> pixels = bench.run();
        double missed = 0;
        for (const Pixel& pixel : pixels) missed += pixel.depth > it.a + 3.0 / kVoxels;
        const double share = missed / static_cast<double>(pixels.size()), t = 1.0 / 256;
        EXPECT_EQ(share_missed(pixels), 0) << "something is always found: the wrong surface";
        const double error = binomial_error(it.simulated, pixels.size());
        EXPECT_LT(z_of({share, error}, {it.simulated, it.error}), z_limit(2)) << share;
        EXPECT_GT(share, std::pow(1 - t / it.b, 256) - 3 * error);
        EXPECT_LT(share, std::pow(1 - t, 256) + 3 * error);
    }
}

TEST_F(SurfaceDepthTest, ExactFindsAtOnceWhatIsThere) {
    for (const std::uint32_t voxels : {8u, 2u, 1u}) {
        for (const double isovalue : {0.5, 0.75, 0.999}) {
            Bench bench(shell(200, voxels, 0.6), {isovalue}, params(SurfaceSearch::exact, 64));
            const double depth = (200 - 0.5 + isovalue) / kVoxels;
            for (const Pixel& pixel : bench.run()) {
                ASSERT_EQ(pixel.surface, 0);
                ASSERT_NEAR(pixel.depth * kVoxels, depth * kVoxels, 1e-3);
            }
        }
    }
    for (const Bias& row : kBias) {
        Bench bench(ramp(), {row.a}, params(SurfaceSearch::exact, 16));
        for (const Pixel& pixel : bench.run()) {
            ASSERT_EQ(pixel.surface, 0);
            ASSERT_NEAR(pixel.depth * kVoxels, row.a * kVoxels, 1e-3);
        }
    }
}

TEST_F(SurfaceDepthTest, MarchMissesWhatLiesBetweenItsSteps) {
    // Steps are as long as the shell, twice and four times as long.
    for (const std::uint32_t steps : {512u, 256u, 128u}) {
        Bench bench(shell(200, 1), {0.5}, params(SurfaceSearch::march, 128, 1, steps));
        const std::vector<Pixel> pixels = bench.run();
        const double miss = 1 - steps / double{kVoxels};
        const double error = std::max(binomial_error(miss, pixels.size()), 1e-9);
        // A filter with weights of 8 bits sees the shell up to 1/256 of a voxel thinner or thicker.
        const double slack = 2.0 / 256 * steps / kVoxels;
        EXPECT_LT(std::abs(share_missed(pixels) - miss), z_limit(3) * error + slack) << steps;
        for (const Pixel& pixel : pixels)
            if (pixel.surface == 0) {
                ASSERT_NEAR(pixel.depth * kVoxels, 200, 0.01);
            }
    }
    Bench bench(ramp(), {0.37}, params(SurfaceSearch::march, 32, 1, 16));
    for (const Pixel& pixel : bench.run()) ASSERT_NEAR(pixel.depth * kVoxels, 0.37 * kVoxels, 1e-3);
}

TEST_F(SurfaceDepthTest, SolidAtTheStartIsHitThere) {
    const Camera inside = look_at({0, 0, 0.1f}, {0.01f, 0.02f, -1}, 60, UpAxis::z);
    for (const SurfaceSearch search :
        {SurfaceSearch::stochastic, SurfaceSearch::march, SurfaceSearch::exact}) {
        VolumeView cropped, clipped;
        cropped.crop_max.z = 0.5f;
        clipped.clip_planes = {{0, 0.1f, -1, 0}};
        Bench crop(ramp(), {0.4, 0.2}, params(search, 8), from_above(), cropped);
        Bench clip(ramp(), {0.2, 0.4}, params(search, 8), from_above(), clipped);
        Bench camera(ramp(), {0.3}, params(search, 8), inside);
        for (const Pixel& pixel : crop.run()) EXPECT_EQ(pixel, (Pixel{0, 0})) << "the innermost";
        for (const Pixel& pixel : clip.run()) {
            EXPECT_EQ(pixel.depth, 0);
            EXPECT_EQ(pixel.surface, 1) << "at depths of 0.4 to 0.6";
        }
        for (const Pixel& pixel : camera.run()) EXPECT_EQ(pixel, (Pixel{0, 0}));
    }
}

TEST_F(SurfaceDepthTest, RaysBesideTheBoxMeetNothing) {
    const Camera away = look_at({0, 0, 2}, {0, 0, 3}, 60, UpAxis::z);
    for (const SurfaceSearch search :
        {SurfaceSearch::stochastic, SurfaceSearch::march, SurfaceSearch::exact}) {
        Bench bench(ramp(), {0.3}, params(search, 7), away);
        for (const Pixel& pixel : bench.run()) EXPECT_EQ(pixel, (Pixel{1, -1}));
    }
}

TEST_F(SurfaceDepthTest, StochasticStateLastsUntilTheRestart) {
    Bench bench(ramp(), {0.3}, params(SurfaceSearch::stochastic, 16));
    bench.execute(false);
    const std::vector<Pixel> first = bench.read();
    bench.execute(false);
    bench.execute(true);
    const std::vector<Pixel> third = bench.read();
    EXPECT_NE(first, third);
    for (std::size_t i = 0; i < first.size(); ++i) EXPECT_LE(third[i].depth, first[i].depth);
    bench.execute(false);
    EXPECT_EQ(bench.read(), first) << "the same seed, from the start again";
    // Candidates in one execution or in several make no difference.
    Bench three(ramp(), {0.3}, params(SurfaceSearch::stochastic, 16, 3));
    EXPECT_EQ(three.run(), third);
}

TEST_F(SurfaceDepthTest, ViewsOfNestedSurfacesAgreeWithTheTwin) {
    const Volume cloud = float_volume({24, 20, 28}, [](glm::uvec3 v) {
        const glm::dvec3 p = (glm::dvec3(v) + 0.5) / glm::dvec3(24, 20, 28) - 0.5;
        return std::exp(-8 * glm::dot(p, p)) +
               0.2 * std::sin(25 * p.x) * std::sin(31 * p.y + 2 * p.z);
    });
    Camera flat = look_at({1.5f, -2, 1.2f}, {0, 0, 0}, 30, UpAxis::z);
    flat.orthographic_height = 1.4f;
    const Camera cameras[] = {look_at({1.5f, -2, 1.2f}, {0, 0, 0}, 35, UpAxis::z), flat,
        look_at({0.35f, 0.3f, 0.4f}, {0, 0, 0}, 80, UpAxis::z)};
    for (const Camera& camera : cameras) {
        for (const glm::uvec2 size : {glm::uvec2(1), glm::uvec2(7, 5), glm::uvec2(64)}) {
            SurfaceDepthParams exact{.width = size.x, .height = size.y};
            Bench bench(cloud, {0.8, 0.45}, exact, camera);
            const std::vector<Pixel> pixels = bench.run();
            exact.search = SurfaceSearch::march;
            const std::vector<Pixel> marched = Bench(cloud, {0.8, 0.45}, exact, camera).run();
            const shader::VolumeFrame& frame = bench.bench->frame;
            const std::vector<double> values{
                double{frame.surfaces[0].value}, double{frame.surfaces[1].value}};
            const glm::dmat3 inverse = glm::inverse(bench.place.edges);
            for (std::size_t i = 0; i < pixels.size(); ++i) {
                const auto column = static_cast<double>(i % size.x);
                const auto row = static_cast<double>(i / size.x);
                const glm::dvec2 p(2 * (column + 0.5) / size.x - 1, 1 - 2 * (row + 0.5) / size.y);
                const glm::dvec3 aside = p.x * glm::dvec3(frame.right) + p.y * glm::dvec3(frame.up);
                const bool ortho = frame.orthographic != 0;
                const glm::dvec3 o =
                    inverse * (glm::dvec3(frame.position) + (ortho ? aside : glm::dvec3(0)) -
                                  bench.place.corner);
                const glm::dvec3 forward(frame.forward);
                const glm::dvec3 d =
                    inverse * glm::normalize(forward + (ortho ? glm::dvec3(0) : aside));
                const glm::dvec3 a = -o / d, b = (1.0 - o) / d;
                const glm::dvec3 enter = glm::min(a, b), leave = glm::max(a, b);
                const double near = std::max({0.0, enter.x, enter.y, enter.z});
                const double far = std::min({leave.x, leave.y, leave.z});
                if (std::abs(near - far) < 1e-5) continue; // which, rounding decides
                Pixel expected{1, -1};
                reference::Crossing truth;
                if (near < far) {
                    truth = reference::first_crossing(bench.field, values, o, d, near, far, true);
                    if (truth.found)
                        expected = {(truth.t - near) / (far - near), static_cast<int>(truth.value)};
                }
                if (truth.margin < 1e-5) continue;
                ASSERT_EQ(pixels[i].surface, expected.surface) << "pixel " << i;
                const double voxels = 28 * (far - near);
                ASSERT_NEAR(pixels[i].depth * voxels, expected.depth * voxels, 1e-3) << i;
                if (marched[i].surface < 0) continue;
                ASSERT_GE(expected.surface, 0) << "a march finds nothing that is not there";
                ASSERT_GE(marched[i].depth * voxels, expected.depth * voxels - 0.01);
            }
        }
    }
}

} // namespace
} // namespace ockham::test
