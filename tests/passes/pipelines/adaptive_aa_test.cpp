// SPDX-License-Identifier: Apache-2.0
// Identities of whole pictures, bit for bit: methods that must agree do, and the plan holds only
// what the scene and the window need.
#include "framework/core/image.hpp"
#include "framework/graph/explain/budget.hpp"
#include "framework/graph/explain/dump.hpp"
#include "framework/graph/explain/explain.hpp"
#include "framework/scene/builtin.hpp"
#include "passes/pipelines/adaptive_aa.hpp"
#include "passes/post/bloom.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/pass_bench.hpp"
#include "tests/support/shuffle.hpp"
#include "tests/support/surface_scenes.hpp"

#include <bit>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>

namespace ockham::test {
namespace {

using Bits = std::vector<std::uint32_t>;

Bits bits_of(const Image& image) {
    const std::vector<float> values = interleaved(image);
    Bits bits(values.size());
    std::memcpy(bits.data(), values.data(), values.size() * sizeof(float));
    return bits;
}

/// How many texels differ, and the first that does: failures of thousands of numbers are no help.
testing::AssertionResult equal_bits(const Image& a, const Image& b) {
    if (a.width() != b.width() || a.height() != b.height())
        return testing::AssertionFailure() << "sizes differ";
    const Bits x = bits_of(a), y = bits_of(b);
    std::size_t count = 0, first = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        if (x[i] != y[i] && count++ == 0) first = i;
    }
    if (count == 0) return testing::AssertionSuccess();
    const std::size_t pixel = first / a.channels().size();
    return testing::AssertionFailure()
           << count << " of " << x.size() << " numbers differ, first in pixel ("
           << pixel % static_cast<std::size_t>(a.width()) << ", "
           << pixel / static_cast<std::size_t>(a.width()) << "): " << std::bit_cast<float>(x[first])
           << " and " << std::bit_cast<float>(y[first]);
}

class AdaptiveAaTest : public GpuTest {
protected:
    static void SetUpTestSuite() { varied_ = std::make_unique<LitScene>(device(), varied_scene()); }
    static void TearDownTestSuite() { varied_.reset(); } // before the device goes
    static const LitScene& varied() { return *varied_; }
    static const Camera& camera() { return varied().scene().cameras.front(); }

    static AdaptiveAaParams params(
        std::uint32_t width, std::uint32_t height, std::uint32_t m, AaMethod method) {
        AdaptiveAaParams p;
        p.width = width;
        p.height = height;
        p.m = m;
        p.method = method;
        p.export_counts = true;
        return p;
    }
    static Image render(const AdaptiveAaParams& p) {
        AdaptiveAa aa(device(), varied(), camera(), p);
        aa.execute();
        return aa.picture();
    }
    static Image render(
        std::uint32_t width, std::uint32_t height, std::uint32_t m, AaMethod method) {
        return render(params(width, height, m, method));
    }
    static MetricsParams weights(float depth, float normal, float shading) {
        MetricsParams metrics;
        metrics.depth_weight = depth;
        metrics.normal_weight = normal;
        metrics.shading_weight = shading;
        return metrics;
    }
    static std::string explanation(AdaptiveAa& aa) {
        return explain(aa.executor().graph().declaration(), aa.executor().plan());
    }
    static bool runs(AdaptiveAa& aa, std::string_view pass) {
        const Declaration& declaration = aa.executor().graph().declaration();
        for (std::size_t i = 0; i < declaration.passes.size(); ++i) {
            if (declaration.passes[i].name == pass) return !aa.executor().plan().passes[i].culled;
        }
        return false;
    }
    static bool has(AdaptiveAa& aa, std::string_view resource) {
        for (const ResourceDecl& r : aa.executor().graph().declaration().resources) {
            if (r.name == resource) return true;
        }
        return false;
    }

private:
    inline static std::unique_ptr<LitScene> varied_;
};

struct Size {
    std::uint32_t width, height;
};
constexpr Size kSizes[] = {{1, 1}, {7, 5}, {33, 21}};

TEST_F(AdaptiveAaTest, APartIsThatPartOfThePicture) {
    AdaptiveAaParams whole = params(40, 30, 1, AaMethod::none);
    whole.gbuffer = GbufferLayout::visibility;
    const Image all = render(whole);
    AdaptiveAaParams p = params(8, 6, 1, AaMethod::none);
    p.part_of = {40, 30};
    AdaptiveAa part(device(), varied(), camera(), p);
    for (const glm::uvec2 origin : {glm::uvec2(0, 0), glm::uvec2(13, 9), glm::uvec2(32, 24)}) {
        part.set_origin(origin);
        part.execute();
        Image wanted(8, 6, all.channels());
        for (int y = 0; y < 6; ++y)
            for (int x = 0; x < 8; ++x)
                for (int c = 0; c < 4; ++c)
                    wanted.at(x, y, c) =
                        all.at(x + static_cast<int>(origin.x), y + static_cast<int>(origin.y), c);
        EXPECT_TRUE(equal_bits(part.picture(), wanted)) << origin.x << " " << origin.y;
    }
}

TEST_F(AdaptiveAaTest, APartOfManyPixelsHasTheSamplesOfOne) {
    constexpr int kM = 3;
    AdaptiveAaParams p = params(13, 9, kM, AaMethod::ssaa);
    p.gbuffer = GbufferLayout::visibility;
    const Image picture = render(p);
    AdaptiveAaParams q = params(kM, kM, 1, AaMethod::none);
    q.part_of = {13 * kM, 9 * kM};
    AdaptiveAa samples(device(), varied(), camera(), q);
    for (const glm::ivec2 pixel : {glm::ivec2(2, 3), glm::ivec2(6, 5), glm::ivec2(11, 7)}) {
        samples.set_origin(glm::uvec2(kM * pixel));
        samples.execute();
        const Image of_pixel = samples.picture();
        for (int c = 0; c < 4; ++c) {
            float sum = 0;
            for (const float value : of_pixel.plane(c)) sum += value;
            const float mean = sum / (kM * kM);
            EXPECT_NEAR(picture.at(pixel.x, pixel.y, c), mean, 1e-5f * std::max(1.0f, mean));
        }
    }
}

TEST_F(AdaptiveAaTest, SceneShowsWhatTheIdentitiesAreAbout) {
    const AdaptiveAaParams p = params(64, 48, 4, AaMethod::adaptive);
    AdaptiveAa aa(device(), varied(), camera(), p);
    aa.execute();
    const auto counts = aa.sample_counts();
    EXPECT_GT(counts.histogram.front(), 64u * 48 / 10) << "flat pixels";
    EXPECT_GT(counts.histogram.back(), 20u) << "edges";
    std::size_t used = 0;
    for (const std::uint64_t count : counts.histogram) used += count > 0;
    EXPECT_GE(used, 6u) << "many different counts";
    const Image picture = aa.picture();
    float low = 1, high = 0;
    for (const float alpha : picture.plane("A")) {
        low = std::min(low, alpha);
        high = std::max(high, alpha);
    }
    EXPECT_EQ(low, 0.0f) << "sky";
    EXPECT_EQ(high, 1.0f);
}

TEST_F(AdaptiveAaTest, OneSampleWindowIsPlainDeferredByEveryMethod) {
    for (const Size size : kSizes) {
        const Image plain = render(size.width, size.height, 1, AaMethod::none);
        EXPECT_TRUE(equal_bits(plain, render(size.width, size.height, 4, AaMethod::none)));
        for (const AaMethod method : {AaMethod::uniform, AaMethod::ssaa, AaMethod::adaptive}) {
            EXPECT_TRUE(equal_bits(plain, render(size.width, size.height, 1, method)));
        }
    }
}

TEST_F(AdaptiveAaTest, UniformWithAllSamplesIsFullSupersampling) {
    for (const std::uint32_t m : {2u, 3u, 4u, 8u}) {
        for (const Size size : kSizes) {
            SCOPED_TRACE(testing::Message() << size.width << "x" << size.height << ", m = " << m);
            AdaptiveAaParams p = params(size.width, size.height, m, AaMethod::uniform);
            p.k = m * m;
            EXPECT_TRUE(equal_bits(render(p), render(size.width, size.height, m, AaMethod::ssaa)));
        }
    }
}

TEST_F(AdaptiveAaTest, FullSupersamplingIsTheBoxFilterOfALargerPicture) {
    for (const std::uint32_t m : {2u, 3u, 4u, 5u, 7u, 8u}) {
        for (const Size size : kSizes) {
            SCOPED_TRACE(testing::Message() << size.width << "x" << size.height << ", m = " << m);
            const Image large = render(m * size.width, m * size.height, 1, AaMethod::none);
            Image filtered(
                static_cast<int>(size.width), static_cast<int>(size.height), {"R", "G", "B", "A"});
            const int w = static_cast<int>(m);
            for (int y = 0; y < filtered.height(); ++y) {
                for (int x = 0; x < filtered.width(); ++x) {
                    for (int c = 0; c < 4; ++c) {
                        float sum = 0.0f;
                        for (int i = 0; i < w * w; ++i)
                            sum += large.at(x * w + i % w, y * w + i / w, c);
                        filtered.at(x, y, c) = sum / static_cast<float>(w * w);
                    }
                }
            }
            EXPECT_TRUE(equal_bits(render(size.width, size.height, m, AaMethod::ssaa), filtered));
        }
    }
}

TEST_F(AdaptiveAaTest, PixelsWithAllSamplesEqualFullSupersamplingAndWithOneS) {
    for (const std::uint32_t m : {2u, 3u, 4u, 8u}) {
        for (const Dispatch dispatch : {Dispatch::buckets, Dispatch::loop}) {
            const Size size{33, 21};
            SCOPED_TRACE(
                testing::Message() << "m = " << m << ", loop " << (dispatch == Dispatch::loop));
            AdaptiveAaParams p = params(size.width, size.height, m, AaMethod::adaptive);
            p.dispatch = dispatch;
            p.captures = {"first_sample"};
            p.metrics = weights(1e9f, 1e9f, 0.0f); // whatever is not flat and not sky
            AdaptiveAa aa(device(), varied(), camera(), p);
            aa.execute();
            const Image picture = aa.picture(), k = aa.executor().read(aa.outputs().sample_count);
            const Image s = aa.executor().read(aa.outputs().first_sample);
            const Image full = render(size.width, size.height, m, AaMethod::ssaa);
            std::size_t all = 0, one = 0, wrong = 0;
            for (int y = 0; y < picture.height(); ++y) {
                for (int x = 0; x < picture.width(); ++x) {
                    const int count = static_cast<int>(k.at(x, y, 0));
                    ASSERT_TRUE(count == 1 || count == static_cast<int>(m * m)) << count;
                    (count == 1 ? one : all) += 1;
                    const Image& expected = count == 1 ? s : full;
                    for (int c = 0; c < 4; ++c)
                        wrong += picture.at(x, y, c) != expected.at(x, y, c);
                }
            }
            EXPECT_EQ(wrong, 0u);
            EXPECT_GT(all, picture.pixels() / 4);
            EXPECT_GT(one, picture.pixels() / 16) << "sky";
        }
    }
}

TEST_F(AdaptiveAaTest, WithoutWeightsThePictureIsS) {
    for (const std::uint32_t m : {2u, 3u, 4u}) {
        for (const Size size : kSizes) {
            AdaptiveAaParams p = params(size.width, size.height, m, AaMethod::adaptive);
            p.metrics = weights(0, 0, 0);
            p.captures = {"first_sample"};
            AdaptiveAa aa(device(), varied(), camera(), p);
            aa.execute();
            EXPECT_TRUE(equal_bits(aa.picture(), aa.executor().read(aa.outputs().first_sample)));
            EXPECT_EQ(aa.sample_counts().percent, 100.0 / (m * m));
        }
    }
}

TEST_F(AdaptiveAaTest, UniformWithOneSampleIsS) {
    for (const std::uint32_t m : {2u, 3u, 4u}) {
        AdaptiveAaParams p = params(33, 21, m, AaMethod::uniform);
        const Image uniform = render(p);
        p.method = AaMethod::adaptive;
        p.metrics = weights(0, 0, 0);
        EXPECT_TRUE(equal_bits(uniform, render(p))) << "m = " << m;
    }
}

TEST_F(AdaptiveAaTest, LoopAndBucketsMakeTheSamePicture) {
    for (const std::uint32_t m : {2u, 3u, 4u, 8u}) {
        for (const Size size : kSizes) {
            SCOPED_TRACE(testing::Message() << size.width << "x" << size.height << ", m = " << m);
            AdaptiveAaParams p = params(size.width, size.height, m, AaMethod::adaptive);
            const Image buckets = render(p);
            p.dispatch = Dispatch::loop;
            EXPECT_TRUE(equal_bits(buckets, render(p)));
        }
    }
}

TEST_F(AdaptiveAaTest, HalfPlanesAreExactOnceBothHaveASample) {
    // A white half plane before a black wall: coverage by clusters, at every angle.
    constexpr std::uint32_t kWidth = 24, kHeight = 24;
    float prefix_worst = 0;
    std::size_t edges = 0;
    for (int degrees = 0; degrees <= 90; degrees += 10) {
        Scene scene;
        scene.materials = {unlit_material(glm::vec3(0.0f)), unlit_material()};
        add(scene, rectangle({-9, -9, -1}, {99, 0, 0}, {0, 99, 0}, 0));
        const float angle = glm::radians(static_cast<float>(degrees));
        const glm::vec3 across(std::cos(angle), std::sin(angle), 0), up(-across.y, across.x, 0);
        add(scene,
            rectangle(glm::vec3(12.3f, 11.6f, 0) - 60.0f * across, 120.0f * across, 60.0f * up, 1));
        const LitScene lit(device(), scene);
        const Camera camera = pixel_camera(kWidth, kHeight);
        AdaptiveAaParams p = params(kWidth, kHeight, 4, AaMethod::ssaa);
        AdaptiveAa full(device(), lit, camera, p);
        full.execute();
        const Image truth = full.picture();
        p.method = AaMethod::adaptive;
        p.metrics = weights(20, 0, 0); // one unit of depth between them: 2 to 5 samples
        for (const Resolve resolve : {Resolve::prefix, Resolve::stratified}) {
            p.resolve = resolve;
            AdaptiveAa aa(device(), lit, camera, p);
            aa.execute();
            const Image picture = aa.picture(), k = aa.executor().read(aa.outputs().sample_count);
            for (std::size_t i = 0; i < picture.pixels(); ++i) {
                const float error = std::abs(picture.plane("R")[i] - truth.plane("R")[i]);
                const float count = k.plane(0)[i];
                if (count < 2.0f || count > 15.0f) continue;
                if (resolve == Resolve::prefix) {
                    prefix_worst = std::max(prefix_worst, error);
                    continue;
                }
                EXPECT_LT(error, 1e-6f) << degrees << " degrees, k = " << count;
                ++edges;
            }
        }
    }
    EXPECT_GT(edges, 100u);
    EXPECT_GT(prefix_worst, 0.05f) << "what the stratified resolve is for";
}

TEST_F(AdaptiveAaTest, StratifiedIsPrefixWhereOneSurfaceIsSeenAndFullWhereAllAreTaken) {
    AdaptiveAaParams p = params(33, 21, 4, AaMethod::adaptive);
    const Image full = render(33, 21, 4, AaMethod::ssaa);
    p.metric = MetricKind::ockham;
    p.lambda = 0.0f;
    p.resolve = Resolve::stratified;
    EXPECT_TRUE(equal_bits(render(p), full)) << "k = n everywhere";
    p.demodulate = p.filter_highlights = true;
    EXPECT_TRUE(equal_bits(render(p), full)) << "a sample that stands for itself needs no means";
    p.m = 8;
    for (const Size size : kSizes) {
        p.width = size.width;
        p.height = size.height;
        EXPECT_TRUE(equal_bits(render(p), render(size.width, size.height, 8, AaMethod::ssaa)))
            << size.width << " x " << size.height << ", m = 8";
    }

    // Two half-lit walls of one surface each: k varies, labels do not.
    Scene scene;
    Material checker = unlit_material();
    checker.base_color_texture.image = add_image(scene, 4, 4,
        [](int x, int y) { return (x + y) % 2 ? glm::u8vec4(255) : glm::u8vec4(0, 0, 0, 255); });
    scene.materials = {checker};
    add(scene, rectangle({-9, -9, 0}, {99, 0, 0}, {0, 99, 0}, 0, {7, 7}));
    const LitScene lit(device(), scene);
    Image pictures[2];
    for (const Resolve resolve : {Resolve::prefix, Resolve::stratified}) {
        AdaptiveAaParams q = params(33, 21, 4, AaMethod::adaptive);
        q.metrics = weights(0, 0, 12);
        q.resolve = resolve;
        AdaptiveAa aa(device(), lit, pixel_camera(33, 21), q);
        aa.execute();
        pictures[resolve == Resolve::stratified] = aa.picture();
        EXPECT_GT(aa.sample_counts().mean, 1.5);
    }
    EXPECT_TRUE(equal_bits(pictures[0], pictures[1]));
}

TEST_F(AdaptiveAaTest, EveryRunMakesTheSamePicture) {
    const AdaptiveAaParams p = params(64, 48, 3, AaMethod::adaptive);
    AdaptiveAa aa(device(), varied(), camera(), p);
    aa.execute();
    const Image first = aa.picture();
    aa.execute();
    EXPECT_TRUE(equal_bits(first, aa.picture())) << "executed again";
    EXPECT_TRUE(equal_bits(first, render(p))) << "made again";
}

TEST_F(AdaptiveAaTest, AMovedCameraSeesWhatOneThatStoodThereSees) {
    const AdaptiveAaParams p = params(33, 21, 3, AaMethod::adaptive);
    Camera other = camera();
    other.position += glm::vec3(0.2f, 0.1f, 0.0f);
    AdaptiveAa there(device(), varied(), other, p);
    there.execute();
    AdaptiveAa moved(device(), varied(), camera(), p);
    moved.execute();
    moved.set_camera(other);
    moved.execute();
    EXPECT_TRUE(equal_bits(moved.picture(), there.picture()));
    EXPECT_FALSE(equal_bits(moved.picture(), render(p)));
}

TEST_F(AdaptiveAaTest, OnlyMovingCamerasRemember) {
    AdaptiveAaParams p = params(33, 21, 3, AaMethod::adaptive);
    p.metric = MetricKind::ockham;
    AdaptiveAa still(device(), varied(), camera(), p);
    EXPECT_FALSE(runs(still, "variance_history"));
    EXPECT_FALSE(has(still, "variance_history"));
    EXPECT_NE(explanation(still).find("nothing to remember"), std::string::npos);
    still.execute();
    p.history = true;
    AdaptiveAa moving(device(), varied(), camera(), p);
    EXPECT_TRUE(runs(moving, "variance_history"));
    moving.execute();
    EXPECT_TRUE(equal_bits(still.picture(), moving.picture())) << "there was nothing before";
    const double first = moving.sample_counts().percent;
    Camera other = camera();
    other.position += glm::vec3(0.02f, 0.01f, 0.0f);
    moving.set_camera(other);
    moving.execute();
    still.set_camera(other);
    still.execute();
    EXPECT_GE(moving.sample_counts().percent, still.sample_counts().percent);
    EXPECT_LT(moving.sample_counts().percent, 1.5 * first);
    p.metric = MetricKind::paper;
    AdaptiveAa paper(device(), varied(), camera(), p);
    EXPECT_FALSE(has(paper, "frame_before"));
}

TEST_F(AdaptiveAaTest, StallChangesNoBit) {
    AdaptiveAaParams p = params(33, 21, 3, AaMethod::adaptive);
    const Image plain = render(p);
    p.stall = 1000;
    EXPECT_TRUE(equal_bits(plain, render(p)));
}

TEST_F(AdaptiveAaTest, WorkSplitOverSeveralDispatchesGivesTheSamePicture) {
    for (const AaMethod method : {AaMethod::adaptive, AaMethod::ssaa}) {
        for (const Dispatch dispatch : {Dispatch::buckets, Dispatch::loop}) {
            AdaptiveAaParams p = params(7, 5, 8, method);
            p.dispatch = dispatch;
            const Image whole = render(p);
            p.stall = 40000; // 2,500 iterations a sample: at most 19 samples a dispatch
            AdaptiveAa aa(device(), varied(), camera(), p);
            EXPECT_TRUE(runs(aa, "shade.1"));
            aa.execute();
            EXPECT_TRUE(equal_bits(whole, aa.picture()));
            if (method == AaMethod::ssaa) break; // has no dispatch mode
        }
    }
}

TEST_F(AdaptiveAaTest, SkyAloneTakesOneSampleAPixel) {
    Scene sky;
    sky.background = {0.25f, 0.5f, 3.0f};
    const LitScene lit(device(), sky);
    for (const std::uint32_t m : {2u, 3u, 4u, 8u}) {
        const AdaptiveAaParams p = params(33, 21, m, AaMethod::adaptive);
        AdaptiveAa aa(device(), lit, look_at({0, 0, 5}, {0, 0, 0}, 60), p);
        aa.execute();
        const auto counts = aa.sample_counts();
        EXPECT_EQ(counts.percent, 100.0 / (m * m)) << "m = " << m;
        EXPECT_EQ(counts.histogram.front(), 33u * 21);
        const Image picture = aa.picture();
        for (std::size_t i = 0; i < picture.pixels(); ++i) {
            ASSERT_EQ(picture.plane("R")[i], 0.25f);
            ASSERT_EQ(picture.plane("B")[i], 3.0f);
            ASSERT_EQ(picture.plane("A")[i], 0.0f);
        }
    }
}

TEST_F(AdaptiveAaTest, SkyAroundALargeSceneStillTakesOneSample) {
    // The background's view depth grows with the scene; its rounding noise must not cost samples.
    for (const float scale : {1.0f, 100.0f, 10000.0f}) {
        Scene scene;
        scene.materials = {unlit_material()};
        add(scene, rectangle({-scale, -scale, 0}, {scale, 0, 0}, {0, scale, 0}));
        const LitScene lit(device(), scene);
        const AdaptiveAaParams p = params(33, 21, 3, AaMethod::adaptive);
        AdaptiveAa aa(device(), lit, look_at({0, 0, 3 * scale}, {0, 0, 0}, 60), p);
        aa.execute();
        const Image k = aa.executor().read(aa.outputs().sample_count), picture = aa.picture();
        for (int y = 0; y < 8; ++y) // above the rectangle, which fills a lower quarter
            for (int x = 0; x < 33; ++x) ASSERT_EQ(k.at(x, y, 0), 1.0f) << "scale " << scale;
    }
}

TEST_F(AdaptiveAaTest, SilhouetteAgainstTheSkyTakesAllSamples) {
    Scene scene;
    scene.background = glm::vec3(0.5f);
    scene.materials = {unlit_material(glm::vec3(0.5f))}; // same colour: only depth shows the edge
    add(scene, rectangle({-1, -1, 0}, {1.03f, 0, 0}, {0, 2, 0}));
    const LitScene lit(device(), scene);
    const AdaptiveAaParams p = params(32, 32, 4, AaMethod::adaptive);
    AdaptiveAa aa(device(), lit, look_at({0, 0, 5}, {0, 0, 0}, 20), p);
    aa.execute();
    const Image k = aa.executor().read(aa.outputs().sample_count), picture = aa.picture();
    std::size_t edges = 0;
    for (int y = 4; y < 28; ++y) {
        for (int x = 0; x < 32; ++x) {
            const float alpha = picture.at(x, y, 3);
            ASSERT_TRUE(std::isfinite(alpha));
            if (alpha > 0.0f && alpha < 1.0f) {
                EXPECT_EQ(k.at(x, y, 0), 16.0f);
                ++edges;
            }
        }
    }
    EXPECT_GT(edges, 20u);
}

TEST_F(AdaptiveAaTest, DistantCheckerAveragesAsLight) {
    // A black and white floor to the horizon: far rows are half the light, not half the code.
    Scene scene;
    scene.background = glm::vec3(0.5f);
    Material material = unlit_material();
    material.base_color_texture.image = add_image(scene, 2, 2,
        [](int x, int y) { return (x + y) % 2 ? glm::u8vec4(255) : glm::u8vec4(0, 0, 0, 255); });
    scene.materials = {material};
    add(scene, rectangle({-2000, 0, 0}, {4000, 0, 0}, {0, 0, -4000}, 0, {2000, 2000}));
    const LitScene lit(device(), scene);
    for (const AaMethod method : {AaMethod::ssaa, AaMethod::adaptive}) {
        const AdaptiveAaParams p = params(64, 48, 4, method);
        AdaptiveAa aa(device(), lit, look_at({0.3f, 2, 0}, {0.3f, 2, -10}, 50), p);
        aa.execute();
        const Image picture = aa.picture();
        double sum = 0;
        for (int y = 25; y < 27; ++y)
            for (int x = 0; x < 64; ++x) sum += picture.at(x, y, 1);
        const double mean = sum / (2 * 64);
        EXPECT_NEAR(mean, 0.5, 0.01);
        EXPECT_NEAR(255 * srgb_encode(static_cast<float>(mean)), 188, 1) << "127: averaged as code";
    }
}

TEST_F(AdaptiveAaTest, BrokenNormalsAndDegenerateTrianglesLeaveThePictureFinite) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    Scene scene = varied_scene();
    const glm::vec3 odd[] = {glm::vec3(0.0f), glm::vec3(nan), glm::vec3(1e-40f),
        glm::vec3(std::numeric_limits<float>::infinity())};
    for (int i = 0; i < 4; ++i) {
        Primitive p = rectangle(
            {-3.0f + 1.5f * static_cast<float>(i), 0.5f, 0.5f}, {1.2f, 0, 0}, {0, 1.2f, 0}, i % 2);
        p.normals.assign(4, odd[i]);
        add(scene, std::move(p));
    }
    add(scene, triangle({0, 1, 1}, {0, 1, 1}, {1, 1, 1}));
    add(scene, triangle({0, 1, 1}, {0.5f, 1, 1}, {1, 1, 1}));
    const LitScene lit(device(), std::move(scene));
    const AdaptiveAaParams p = params(64, 48, 3, AaMethod::adaptive);
    AdaptiveAa aa(device(), lit, lit.scene().cameras.front(), p);
    aa.execute();
    aa.sample_counts(); // checks that 1 <= k <= n
    for (const float v : interleaved(aa.picture())) ASSERT_TRUE(std::isfinite(v));
}

TEST_F(AdaptiveAaTest, PlanHoldsWhatTheSceneNeedsAndSaysWhyNot) {
    Scene plain;
    plain.materials = {Material{}};
    add(plain, rectangle({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}));
    const LitScene lit(device(), plain);
    const Camera front = look_at({0, 0, 3}, {0, 0, 0}, 60);
    AdaptiveAa aa(device(), lit, front, params(16, 16, 2, AaMethod::adaptive));
    for (const char* absent : {"color_textures", "data_textures", "shadow_map", "gbuffer.extra"}) {
        EXPECT_FALSE(has(aa, absent)) << absent;
        EXPECT_NE(explanation(aa).find(absent), std::string::npos) << absent;
    }
    EXPECT_TRUE(runs(aa, "metrics"));
    EXPECT_TRUE(runs(aa, "bucket_scatter"));

    AdaptiveAa one(device(), lit, front, params(16, 16, 1, AaMethod::adaptive));
    for (const char* absent : {"metrics", "bucket_count", "bucket_scan", "bucket_arguments",
             "bucket_scatter", "shade", "resolve"}) {
        EXPECT_FALSE(runs(one, absent)) << absent;
        EXPECT_NE(explanation(one).find(absent), std::string::npos) << absent;
    }
    AdaptiveAaParams p = params(16, 16, 2, AaMethod::adaptive);
    p.dispatch = Dispatch::loop;
    AdaptiveAa loop(device(), lit, front, p);
    EXPECT_FALSE(runs(loop, "bucket_count"));
    EXPECT_NE(explanation(loop).find("only --dispatch buckets and sort"), std::string::npos);

    AdaptiveAa full(device(), varied(), camera(), params(16, 16, 2, AaMethod::adaptive));
    for (const char* present : {"color_textures", "data_textures", "gbuffer.extra"})
        EXPECT_TRUE(has(full, present)) << present;
}

TEST_F(AdaptiveAaTest, CountsAreCoarsenedOnlyOnRequest) {
    AdaptiveAaParams p = params(40, 24, 3, AaMethod::adaptive);
    p.export_counts = true;
    AdaptiveAa fine(device(), varied(), camera(), p);
    fine.execute();
    EXPECT_FALSE(runs(fine, "coarsen"));
    p.powers_of_two = true;
    AdaptiveAa powers(device(), varied(), camera(), p);
    powers.execute();
    EXPECT_TRUE(runs(powers, "coarsen"));
    const auto counts = powers.sample_counts();
    for (const std::uint32_t k : {3u, 5u, 6u, 7u}) EXPECT_EQ(counts.histogram[k - 1], 0u) << k;
    EXPECT_GT(counts.histogram[8], 0u) << "n stays";
    p.powers_of_two = false;
    p.count_block = 8;
    AdaptiveAa blocks(device(), varied(), camera(), p);
    blocks.execute();
    EXPECT_EQ(blocks.sample_counts().histogram[0] % 64, 0u);
    for (AdaptiveAa* coarse : {&powers, &blocks})
        EXPECT_GT(coarse->sample_counts().percent, fine.sample_counts().percent);
}

TEST_F(AdaptiveAaTest, BloomFollowsThePictureWhereItIsAskedFor) {
    AdaptiveAaParams p = params(40, 24, 2, AaMethod::adaptive);
    AdaptiveAa sharp(device(), varied(), camera(), p);
    sharp.execute();
    EXPECT_FALSE(runs(sharp, "bloom"));
    EXPECT_NE(explanation(sharp).find("no --bloom"), std::string::npos);

    p.bloom = 0.5f;
    AdaptiveAa scattered(device(), varied(), camera(), p);
    scattered.execute();
    PassBench bench(device());
    const ImageHandle bloom = add_bloom(bench.graph,
        bench.image("picture", VK_FORMAT_R32G32B32A32_SFLOAT, 40, 24, interleaved(sharp.picture())),
        {.share = 0.5f, .sigma = p.bloom_width / 100 * 24});
    bench.graph.export_resource(bloom, "test");
    bench.execute();
    EXPECT_TRUE(equal_bits(scattered.picture(), bench.read(bloom)));
}

TEST_F(AdaptiveAaTest, EveryBackEndSharesSamplesOutAlike) {
    AdaptiveAaParams p = params(40, 24, 3, AaMethod::adaptive);
    p.metric = MetricKind::ockham;
    p.resolve = Resolve::stratified;
    p.dispatch = Dispatch::loop;
    const Image plain = render(p);
    p.demodulate = p.filter_highlights = true;
    const Image loop = render(p);
    EXPECT_FALSE(equal_bits(loop, plain)) << "colours and lobes of whole surfaces";
    for (const Dispatch dispatch : kDispatches) {
        if (dispatch == Dispatch::stencil && !device().exports_stencil()) continue;
        p.dispatch = dispatch;
        EXPECT_TRUE(equal_bits(render(p), loop)) << name_of(dispatch);
    }
}

TEST_F(AdaptiveAaTest, MeansOfSurfacesExistWhereSamplesTakeThem) {
    Scene plain;
    plain.materials = {Material{}};
    add(plain, rectangle({-9, -9, 0}, {99, 0, 0}, {0, 99, 0}));
    plain.ambient = glm::vec3(1.0f);
    const LitScene ambient(device(), plain);
    plain.lights.emplace_back();
    const LitScene rough(device(), plain);
    plain.materials[0].roughness = 0.5f;
    const LitScene untextured(device(), plain);
    AdaptiveAaParams p = params(8, 8, 2, AaMethod::adaptive);
    const auto why_not = [&](const LitScene& lit) {
        AdaptiveAa aa(device(), lit, camera(), p);
        if (runs(aa, "surface_means")) return std::string("runs");
        const std::string text = explanation(aa), from = "'surface_means'";
        const std::size_t at = text.find(from);
        return at == std::string::npos ? text : text.substr(at, text.find('\n', at) - at);
    };
    p.demodulate = p.filter_highlights = true;
    EXPECT_NE(why_not(varied()).find("knows no surfaces"), std::string::npos) << why_not(varied());
    p.resolve = Resolve::stratified;
    EXPECT_EQ(why_not(varied()), "runs");
    EXPECT_EQ(why_not(untextured), "runs");
    EXPECT_NE(why_not(ambient).find("no highlights"), std::string::npos) << why_not(ambient);
    EXPECT_NE(why_not(rough).find("no material is smoother"), std::string::npos) << why_not(rough);
    p.filter_highlights = false;
    EXPECT_EQ(why_not(varied()), "runs");
    EXPECT_NE(why_not(untextured).find("no material has a colour image"), std::string::npos);
    p.demodulate = false;
    EXPECT_NE(why_not(varied()).find("no --demodulate"), std::string::npos);
}

TEST_F(AdaptiveAaTest, EveryBackEndRunsOnlyItsOwnPasses) {
    AdaptiveAaParams p = params(40, 24, 2, AaMethod::adaptive);
    p.dispatch = Dispatch::loop;
    const Image loop = render(p);
    for (const Dispatch dispatch :
        {Dispatch::buckets, Dispatch::repack, Dispatch::stencil, Dispatch::depth, Dispatch::sort}) {
        p.dispatch = dispatch;
        if (dispatch == Dispatch::stencil && !device().exports_stencil()) {
            const std::string text =
                error_of([&] { AdaptiveAa aa(device(), varied(), camera(), p); });
            EXPECT_NE(text.find("VK_EXT_shader_stencil_export"), std::string::npos) << text;
            continue;
        }
        AdaptiveAa aa(device(), varied(), camera(), p);
        aa.execute();
        EXPECT_TRUE(equal_bits(aa.picture(), loop)) << name_of(dispatch);
        EXPECT_EQ(runs(aa, "tile_list"), dispatch == Dispatch::repack);
        EXPECT_EQ(runs(aa, "bucket_scatter"),
            dispatch == Dispatch::buckets || dispatch == Dispatch::sort);
    }
}

/// What the plan takes today: a change that adds barriers or bytes must say so here.
TEST_F(AdaptiveAaTest, PlanKeepsItsBudget) {
    AdaptiveAa aa(device(), varied(), camera(), params(64, 48, 4, AaMethod::adaptive));
    EXPECT_EQ(over_budget(aa.executor().graph().declaration(), aa.executor().plan(),
                  {.passes = 9, .barriers = 21, .batches = 9, .submissions = 1, .bytes = 2 << 20}),
        "");
}

TEST_F(AdaptiveAaTest, VeryWidePictureOfOneRow) {
    const std::uint32_t width = device().limits().attachment_extent / 2 - 1;
    const AdaptiveAaParams p = params(width, 1, 2, AaMethod::adaptive);
    AdaptiveAa aa(device(), varied(), camera(), p);
    aa.execute();
    const auto counts = aa.sample_counts();
    std::uint64_t pixels = 0;
    for (const std::uint64_t count : counts.histogram) pixels += count;
    EXPECT_EQ(pixels, width);
    for (const float v : interleaved(aa.picture())) ASSERT_TRUE(std::isfinite(v));
}

TEST_F(AdaptiveAaTest, ImpossibleParametersAreRefusedInWords) {
    const auto text = [&](AdaptiveAaParams p) {
        return error_of([&] { AdaptiveAa aa(device(), varied(), camera(), p); });
    };
    const auto expect_names = [](const std::string& found,
                                  std::initializer_list<const char*> words) {
        EXPECT_FALSE(found.empty());
        for (const char* word : words)
            EXPECT_NE(found.find(word), std::string::npos) << "'" << word << "' in: " << found;
    };
    expect_names(text(params(0, 0, 4, AaMethod::adaptive)), {"0 x 0"});
    expect_names(text(params(8, 16385, 1, AaMethod::none)), {"8 x 16385", "16384"});
    expect_names(text(params(8, 8, 0, AaMethod::adaptive)), {"m = 0", "1 to 8"});
    expect_names(text(params(8, 8, 9, AaMethod::ssaa)), {"m = 9", "1 to 8"});
    expect_names(text(params(8, 8, 5, AaMethod::adaptive)), {"m = 5", "1, 2, 3, 4 or 8"});
    AdaptiveAaParams uniform = params(8, 8, 2, AaMethod::uniform);
    uniform.k = 5;
    expect_names(text(uniform), {"k = 5", "1 to 4"});
    uniform.k = 0;
    expect_names(text(uniform), {"k = 0", "1 to 4"});
    const std::uint32_t limit = device().limits().attachment_extent;
    const std::uint32_t wide = std::min(limit, 16384u);
    AdaptiveAaParams packed = params(wide, 1, 2, AaMethod::adaptive);
    packed.gbuffer = GbufferLayout::packed; // which no screen tiles are drawn with
    expect_names(text(packed), {std::to_string(wide).c_str(), std::to_string(2 * wide).c_str(),
                                   std::to_string(limit).c_str()});
    AdaptiveAaParams stalled = params(8, 8, 2, AaMethod::adaptive);
    stalled.stall = 16 * 50000;
    expect_names(text(stalled), {"iterations", "50000", "stall"});
    AdaptiveAaParams captured = params(8, 8, 2, AaMethod::adaptive);
    captured.captures = {"nonsense"};
    expect_names(text(captured), {"nonsense"});
}

TEST_F(AdaptiveAaTest, AovsShowWhatTheFirstSampleSaw) {
    AdaptiveAaParams p = params(33, 21, 2, AaMethod::adaptive);
    const Image plain = render(p);
    p.aov = true;
    AdaptiveAa aa(device(), varied(), camera(), p);
    aa.execute();
    EXPECT_TRUE(equal_bits(plain, aa.picture())) << "looking changes nothing";
    for (const ImageHandle image : {aa.outputs().aov_surface, aa.outputs().aov_material,
             aa.outputs().winner, aa.outputs().sample_count, aa.outputs().first_sample}) {
        ASSERT_TRUE(bool(image));
        EXPECT_EQ(aa.executor().read(image).width(), 33);
    }
}

TEST_F(AdaptiveAaTest, TheOrderOfDeclarationChangesNoBit) {
    const AdaptiveAaParams budget = [] {
        AdaptiveAaParams p = params(33, 21, 4, AaMethod::adaptive);
        p.metric = MetricKind::ockham;
        p.resolve = Resolve::stratified;
        p.budget = 30;
        return p;
    }();
    std::size_t other = 0;
    for (AdaptiveAaParams p : {params(33, 21, 4, AaMethod::adaptive), budget}) {
        p.aov = true;
        AdaptiveAa declared(device(), varied(), camera(), p);
        declared.execute();
        for (unsigned seed = 1; seed <= 3; ++seed) {
            const Shuffle shuffle(seed);
            AdaptiveAa aa(device(), varied(), camera(), p);
            aa.execute();
            aa.execute();
            other += order_of(aa.executor()) != order_of(declared.executor());
            EXPECT_TRUE(equal_bits(aa.picture(), declared.picture())) << "seed " << seed;
            EXPECT_TRUE(equal_bits(aa.executor().read(aa.outputs().sample_count),
                declared.executor().read(declared.outputs().sample_count)));
        }
    }
    EXPECT_GE(other, 3u) << "shuffled in vain";
    std::printf("reliability: order {\"pictures\": 6, \"other_orders\": %zu}\n", other);
}

} // namespace
} // namespace ockham::test
