// SPDX-License-Identifier: Apache-2.0
// Sums of samples to pixels: plain means, and S untouched where one sample was enough.
#include "framework/core/rng.hpp"
#include "passes/surface/resolve.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/pass_bench.hpp"

#include <glm/glm.hpp>

#include <algorithm>
#include <limits>

namespace ockham::test {
namespace {

constexpr VkFormat kRadiance = VK_FORMAT_R32G32B32A32_SFLOAT;

class ResolveTest : public GpuTest {
protected:
    static std::vector<glm::vec4> random_radiance(std::size_t count, std::uint64_t seed) {
        Pcg32 rng(seed);
        std::vector<glm::vec4> values(count);
        for (glm::vec4& v : values) {
            const float scale = rng.below(4) ? 1.0f : 1e4f; // highlights are not clamped
            v = scale * glm::vec4(rng.uniform(), rng.uniform(), rng.uniform(), 1.0f);
        }
        return values;
    }
};

TEST_F(ResolveTest, PixelsAreMeansAndSingleSamplesPassUnchanged) {
    for (const auto& [width, height] : {std::pair{1u, 1u}, {7u, 5u}, {64u, 64u}}) {
        const std::size_t pixels = std::size_t{width} * height;
        std::vector<glm::vec4> sum = random_radiance(pixels, 1), s = random_radiance(pixels, 2);
        std::vector<std::uint8_t> count(pixels);
        for (std::size_t i = 0; i < pixels; ++i) {
            count[i] = static_cast<std::uint8_t>(1 + i * 7 % 64);
            // Where k = 1 no sum was written: whatever stands there must not show.
            if (count[i] == 1) sum[i] = glm::vec4(std::numeric_limits<float>::quiet_NaN());
        }
        PassBench bench(device());
        const ImageHandle out =
            add_resolve(bench.graph, bench.image("shaded_sum", kRadiance, width, height, sum),
                bench.image("first_sample", kRadiance, width, height, s),
                bench.image("sample_count", VK_FORMAT_R8_UINT, width, height, count));
        bench.graph.export_resource(out, "test");
        bench.execute();
        const std::vector<float> picture = interleaved(bench.read(out));
        for (std::size_t i = 0; i < pixels; ++i) {
            for (int c = 0; c < 4; ++c) {
                const float expected =
                    count[i] == 1 ? s[i][c] : sum[i][c] / static_cast<float>(count[i]);
                ASSERT_EQ(picture[4 * i + static_cast<std::size_t>(c)], expected)
                    << "pixel " << i << ", k = " << int{count[i]};
            }
        }
    }
}

TEST_F(ResolveTest, UniformCountsDivideEverySum) {
    for (const std::uint32_t k : {1u, 3u, 9u, 25u, 64u}) {
        const std::vector<glm::vec4> sum = random_radiance(35, k);
        PassBench bench(device());
        const ImageHandle out =
            add_resolve_uniform(bench.graph, bench.image("shaded_sum", kRadiance, 7, 5, sum), k);
        bench.graph.export_resource(out, "test");
        bench.execute();
        const std::vector<float> picture = interleaved(bench.read(out));
        for (std::size_t i = 0; i < picture.size(); ++i) {
            ASSERT_EQ(picture[i], sum[i / 4][static_cast<int>(i % 4)] / static_cast<float>(k));
        }
    }
}

} // namespace
} // namespace ockham::test
