// SPDX-License-Identifier: Apache-2.0
// Bloom against the two-dimensional sum that its two passes factor, and its law: light that stays
// inside the picture is neither lost nor made.
#include "framework/core/rng.hpp"
#include "passes/post/bloom.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/pass_bench.hpp"

#include <glm/glm.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

namespace ockham::test {
namespace {

struct Picture {
    std::uint32_t width, height;
    std::vector<glm::vec4> texels;

    glm::dvec3 light(int x, int y) const {
        const int w = static_cast<int>(width), h = static_cast<int>(height);
        const int at = std::clamp(y, 0, h - 1) * w + std::clamp(x, 0, w - 1);
        return glm::dvec3(texels[static_cast<std::size_t>(at)]);
    }
};

Picture random_picture(std::uint32_t width, std::uint32_t height) {
    Picture picture{width, height, {}};
    Pcg32 rng(7);
    for (std::uint32_t i = 0; i < width * height; ++i) {
        const float bright = rng.uniform() < 0.05f ? 100.0f : 1.0f;
        picture.texels.emplace_back(
            bright * rng.uniform(), bright * rng.uniform(), rng.uniform(), rng.uniform());
    }
    return picture;
}

// [reference]
/// The formula, as it is written.
glm::dvec3 expected(const Picture& picture, int x, int y, const BloomParams& params) {
    const int radius = static_cast<int>(std::ceil(4 * params.sigma));
    const double sigma = params.sigma, share = params.share;
    glm::dvec3 sum(0.0);
    double weights = 0;
    for (int j = -radius; j <= radius; ++j) {
        for (int i = -radius; i <= radius; ++i) {
            const double weight = std::exp(-0.5 * (i * i + j * j) / (sigma * sigma));
            sum += weight * picture.light(x + i, y + j);
            weights += weight;
        }
    }
    return (1 - share) * picture.light(x, y) + share * sum / weights;
}
// [/reference]

class BloomTest : public GpuTest {
protected:
    static std::vector<float> bloom(const Picture& picture, const BloomParams& params) {
        PassBench bench(device());
        const ImageHandle radiance = bench.image("radiance", VK_FORMAT_R32G32B32A32_SFLOAT,
            picture.width, picture.height, picture.texels);
        const ImageHandle out = add_bloom(bench.graph, radiance, params);
        bench.graph.export_resource(out, "test");
        bench.execute();
        return interleaved(bench.read(out));
    }
};

// [tests]
TEST_F(BloomTest, IsTheGaussianOfThePicture) {
    const BloomParams params{.share = 0.3f, .sigma = 1.7f};
    for (const auto& [width, height] : {std::pair{1u, 1u}, {7u, 5u}, {64u, 64u}}) {
        const Picture picture = random_picture(width, height);
        const std::vector<float> out = bloom(picture, params);
        for (std::size_t i = 0; i < picture.texels.size(); ++i) {
            const glm::dvec3 truth =
                expected(picture, static_cast<int>(i % width), static_cast<int>(i / width), params);
            for (int c = 0; c < 3; ++c)
                ASSERT_NEAR(out[4 * i + static_cast<std::size_t>(c)], truth[c], 1e-5 * truth[c])
                    << width << " x " << height << ", texel " << i;
            ASSERT_EQ(out[4 * i + 3], picture.texels[i].a) << "alpha passes";
        }
    }
}

TEST_F(BloomTest, KeepsTheLightThatStaysInside) {
    const BloomParams params{.share = 0.5f, .sigma = 3};
    Picture picture = random_picture(64, 64);
    double before = 0, after = 0;
    for (std::uint32_t i = 0; i < 64 * 64; ++i) { // dark 12 pixels = 4 sigma deep at the sides
        const std::uint32_t x = i % 64, y = i / 64;
        if (std::min({x, y, 63 - x, 63 - y}) < 12) picture.texels[i] = glm::vec4(0.0f);
        before += picture.texels[i].r;
    }
    const std::vector<float> out = bloom(picture, params);
    for (std::size_t i = 0; i < out.size(); i += 4) after += out[i];
    EXPECT_NEAR(after, before, 1e-5 * before);
}
// [/tests]

TEST_F(BloomTest, LeavesEvenLightAndScattersNothingForNoShare) {
    const Picture even{9, 9, std::vector<glm::vec4>(81, glm::vec4(3.0f, 0.25f, 40.0f, 1.0f))};
    const std::vector<float> same = bloom(even, {.share = 1, .sigma = 5});
    for (std::size_t i = 0; i < same.size(); ++i) {
        const float value = even.texels[0][static_cast<int>(i % 4)];
        EXPECT_NEAR(same[i], value, 2e-6f * value);
    }
    const Picture picture = random_picture(9, 9);
    const std::vector<float> none = bloom(picture, {.share = 0, .sigma = 5});
    for (std::size_t i = 0; i < none.size(); ++i)
        EXPECT_EQ(none[i], picture.texels[i / 4][static_cast<int>(i % 4)]);
}

} // namespace
} // namespace ockham::test
