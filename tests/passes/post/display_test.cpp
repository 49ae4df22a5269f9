// SPDX-License-Identifier: Apache-2.0
// What a display shows: encoded, clamped, with luma, as the CPU's image metrics see it.
#include "framework/core/image.hpp"
#include "passes/post/display.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/pass_bench.hpp"

#include <glm/glm.hpp>

namespace ockham::test {
namespace {

class DisplayTest : public GpuTest {};

TEST_F(DisplayTest, EncodesClampsAndMeasuresLuma) {
    for (const auto& [width, height] : {std::pair{1u, 1u}, {7u, 5u}, {64u, 64u}}) {
        std::vector<glm::vec4> radiance(std::size_t{width} * height);
        for (std::size_t i = 0; i < radiance.size(); ++i) {
            const float x = static_cast<float>(i) / static_cast<float>(radiance.size());
            radiance[i] = {x * x, 0.002f * x, 8.0f * x - 1.0f, 1.0f}; // below 0 and above 1 too
        }
        PassBench bench(device());
        const ImageHandle out = add_display(bench.graph,
            bench.image("radiance", VK_FORMAT_R32G32B32A32_SFLOAT, width, height, radiance));
        bench.graph.export_resource(out, "test");
        bench.execute();
        const std::vector<float> shown = interleaved(bench.read(out));
        for (std::size_t i = 0; i < radiance.size(); ++i) {
            const float r = srgb_encode(radiance[i].x), g = srgb_encode(radiance[i].y),
                        b = srgb_encode(radiance[i].z);
            constexpr float kHalf = 1.0f / 2048; // spacing of 16-bit floats below 1
            EXPECT_NEAR(shown[4 * i], r, kHalf);
            EXPECT_NEAR(shown[4 * i + 1], g, kHalf);
            EXPECT_NEAR(shown[4 * i + 2], b, kHalf);
            EXPECT_NEAR(shown[4 * i + 3], 0.2126f * r + 0.7152f * g + 0.0722f * b, kHalf);
        }
    }
}

} // namespace
} // namespace ockham::test
