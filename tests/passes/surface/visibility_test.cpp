// SPDX-License-Identifier: Apache-2.0
// The two layouts of the G-buffer against each other and against geometry in double precision:
// what fetch_surface() says must not depend on the layout, but for what packing rounds.
#include "framework/image_error/image_error.hpp"
#include "framework/runtime/commands.hpp"
#include "framework/scene/builtin.hpp"
#include "passes/pipelines/adaptive_aa.hpp"
#include "passes/surface/gbuffer.hpp"
#include "tests/passes/surface/shaders/test/surface_probe.h"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/scene_bench.hpp"
#include "tests/support/surface_scenes.hpp"

#include <cmath>
#include <numeric>

namespace ockham::test {
namespace {

using Probes = std::vector<shader::SurfaceProbe>;

class VisibilityTest : public GpuTest {
protected:
    /// Every sample of a picture, row by row.
    static Probes probe(const Scene& scene, const Camera& camera, std::uint32_t width,
        std::uint32_t height, std::uint32_t m, GbufferLayout layout) {
        std::vector<std::uint32_t> order(m * m);
        std::iota(order.begin(), order.end(), 0u);
        SceneBench bench(device(), scene, camera, width, height, m, order);
        const Gbuffer gbuffer = add_gbuffer(bench.graph, bench.inputs,
            {.width = width, .height = height, .m = m, .layout = layout, .slopes = true},
            device().limits().attachment_extent);
        const std::uint32_t samples = m * m * width * height;
        BufferHandle probes =
            bench.graph.create_buffer("probes", {samples * sizeof(shader::SurfaceProbe)});
        PassBuilder pass = bench.graph.add_compute_pass("probe");
        read_gbuffer(pass, gbuffer);
        pass.uniform("frame", bench.inputs.frame);
        probes = pass.write("probes", probes);
        pass.record([=](Commands& commands) {
            const bool packed = layout == GbufferLayout::packed;
            const std::string mode = !packed ? "" : gbuffer.extra ? "extra,slopes" : "slopes";
            commands.dispatch_over(
                {.shader = gbuffer_variant("test/surface_probe.comp", mode, gbuffer),
                    .specialization = gbuffer_specialization(gbuffer)},
                {m * width, m * height, 1});
        });
        bench.graph.export_resource(probes, "test");
        bench.execute();
        return bench.read<shader::SurfaceProbe>(probes);
    }
};

bool hit(const shader::SurfaceProbe& p) { return p.depth > 0.0f; }

TEST_F(VisibilityTest, BothLayoutsSayTheSameOfEverySurface) {
    // Perspective and parallel: culled and double-sided faces, holes, a mirrored instance, vertex
    // colours, normal maps, two sets of coordinates, bars thinner than a sample.
    const Scene scene = varied_scene();
    for (const bool parallel : {false, true}) {
        Camera camera = scene.cameras.front();
        if (parallel) camera.orthographic_height = 5.0f;
        constexpr std::uint32_t kWidth = 40, kHeight = 30, kM = 3;
        const Probes packed = probe(scene, camera, kWidth, kHeight, kM, GbufferLayout::packed);
        const Probes ids = probe(scene, camera, kWidth, kHeight, kM, GbufferLayout::visibility);
        ASSERT_EQ(packed.size(), ids.size());
        std::size_t hits = 0, materials[4] = {}, tilted = 0, breaks = 0, moved = 0;
        for (std::size_t i = 0; i < ids.size(); ++i) {
            SCOPED_TRACE(testing::Message() << "sample " << i % (kM * kWidth) << ", "
                                            << i / (kM * kWidth) << ", parallel " << parallel);
            const shader::SurfaceProbe &a = packed[i], &b = ids[i];
            // Corners stand up to 1/512 sample apart: at edges a sample may change sides.
            if (hit(a) != hit(b) || (hit(a) && a.material != b.material)) {
                ++moved;
                continue;
            }
            breaks += a.breaks != b.breaks;
            if (!hit(a)) continue;
            ++hits;
            ++materials[a.material];
            EXPECT_NEAR(a.depth / b.depth, 1.0f, 2e-5f);
            // Bumps and colours change within a sample, whose place rasterisers round to a grid.
            EXPECT_LT(glm::length(a.normal - b.normal), 0.02f);
            EXPECT_LT(glm::length(a.color - b.color), 0.01f);
            tilted += glm::length(b.normal - b.plane_normal) > 0.1f;
            EXPECT_LT(glm::length(a.plane_normal - b.plane_normal), 0.02f);
            for (int set = 0; set < 2; ++set) {
                const glm::vec2 step =
                    glm::max(glm::abs(b.gradient_x[set]), glm::abs(b.gradient_y[set]));
                glm::vec2 off = a.uv[set] - b.uv[set];
                off -= glm::round(off);
                EXPECT_LT(glm::length(off), 0.02f * glm::length(step) + 2e-6f);
            }
        }
        EXPECT_LT(moved, ids.size() / 1000);
        EXPECT_GT(hits, ids.size() / 3);
        for (const std::size_t count : materials) EXPECT_GT(count, 50u);
        EXPECT_GT(tilted, 100u) << "normal maps are seen";
        EXPECT_LT(breaks, hits / 100) << "where footprints stop";
    }
}

/// A floor seen at a grazing angle, its texture turned: everything is known in closed form.
struct TiltedPlane {
    glm::dvec3 corner{-4, 0, 3}, across{9, 0.5, 0}, up{-1, 0.25, -60};
    glm::vec2 uv_scale{3, 20};
    Camera camera = look_at({0, 1.2f, 4}, {0.3f, 0, -10}, 55);

    Scene scene() const {
        Scene scene;
        Material material;
        material.base_color_texture.image =
            add_image(scene, 4, 4, [](int, int) { return glm::u8vec4(255); });
        scene.materials = {material};
        add(scene, rectangle(corner, across, up, 0, uv_scale));
        return scene;
    }
    struct Truth {
        double depth; ///< along the camera's axis
        glm::dvec2 uv;
        bool inside;
    };
    /// At any place of the picture, in samples.
    Truth at(glm::dvec2 place, glm::dvec2 extent) const {
        const glm::dvec3 forward(camera.forward), position(camera.position);
        const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(camera.up)));
        const glm::dvec3 top = glm::cross(right, forward);
        const double half = std::tan(0.5 * glm::radians(double(camera.fov_y_degrees)));
        const glm::dvec2 ndc = place / extent * glm::dvec2(2, -2) + glm::dvec2(-1, 1);
        const glm::dvec3 ray =
            forward + ndc.x * half * extent.x / extent.y * right + ndc.y * half * top;
        // position + t ray = corner + a across + b up
        const glm::dvec3 solved = glm::inverse(glm::dmat3(ray, -across, -up)) * (corner - position);
        const double a = solved.y, b = solved.z;
        return {solved.x, glm::dvec2(uv_scale) * glm::dvec2(a, 1 - b),
            solved.x > 0 && a > 0 && a < 1 && b > 0 && b < 1};
    }
};

TEST_F(VisibilityTest, DerivativesAreThoseOfTheProjection) {
    constexpr std::uint32_t kWidth = 24, kHeight = 20, kM = 2;
    const TiltedPlane plane;
    const glm::dvec2 extent(kM * kWidth, kM * kHeight);
    double worst[2] = {}; // visibility, packed: relative error of the larger derivative
    for (const GbufferLayout layout : {GbufferLayout::visibility, GbufferLayout::packed}) {
        const bool packed = layout == GbufferLayout::packed;
        const Probes probes = probe(plane.scene(), plane.camera, kWidth, kHeight, kM, layout);
        std::size_t compared = 0;
        for (std::size_t i = 0; i < probes.size(); ++i) {
            const glm::dvec2 place(static_cast<double>(i % (kM * kWidth)) + 0.5,
                static_cast<double>(i / (kM * kWidth)) + 0.5);
            const TiltedPlane::Truth truth = plane.at(place, extent);
            const double h = 1e-4; // central differences of a smooth function, in double
            const auto slope = [&](glm::dvec2 step) {
                return (plane.at(place + h * step, extent).uv -
                           plane.at(place - h * step, extent).uv) /
                       (2 * h);
            };
            const shader::SurfaceProbe& p = probes[i];
            if (!truth.inside || !hit(p)) continue;
            ++compared;
            const glm::dvec2 x = slope({1, 0}), y = slope({0, 1});
            const double size = std::max(glm::length(x), glm::length(y));
            const double error = std::max(glm::length(glm::dvec2(p.gradient_x[0]) - x),
                                     glm::length(glm::dvec2(p.gradient_y[0]) - y)) /
                                 size;
            worst[packed] = std::max(worst[packed], error);
            if (packed) continue;
            glm::dvec2 off = glm::dvec2(p.uv[0]) - truth.uv;
            off -= glm::round(off);
            EXPECT_LT(glm::length(off), 1e-5 + 1e-4 * size);
        }
        EXPECT_GT(compared, probes.size() / 4);
    }
    EXPECT_LT(worst[0], 1e-4) << "exact but for fp32";
    EXPECT_GT(worst[1], 0.02) << "steps of an eighth of an octave, differences over two samples";
}

TEST_F(VisibilityTest, PlanesPredictTheDepthOfOtherSamples) {
    constexpr std::uint32_t kWidth = 24, kHeight = 20, kM = 2, kStride = kM * kWidth;
    TiltedPlane plane;
    for (const bool parallel : {false, true}) {
        if (parallel) plane.camera.orthographic_height = 6;
        for (const GbufferLayout layout : {GbufferLayout::visibility, GbufferLayout::packed}) {
            const bool packed = layout == GbufferLayout::packed;
            const Probes probes = probe(plane.scene(), plane.camera, kWidth, kHeight, kM, layout);
            const glm::dvec3 normal = glm::normalize(glm::cross(plane.across, plane.up));
            std::size_t compared = 0;
            for (std::size_t i = 0; i + 3 * kStride + 3 < probes.size(); ++i) {
                const shader::SurfaceProbe &p = probes[i], &q = probes[i + 3 * kStride + 3];
                if (i % kStride + 3 >= kStride || !hit(p) || !hit(q)) continue;
                ++compared;
                const double step = 3.0 * (std::abs(p.slope.x) + std::abs(p.slope.y));
                const double predicted = p.depth + 3.0 * p.slope.x + 3.0 * p.slope.y;
                EXPECT_NEAR(
                    predicted / q.depth, 1.0, 3e-6 + (packed ? 0x1p-10 : 1e-5) * step / q.depth)
                    << i << ", packed " << packed << ", parallel " << parallel;
                EXPECT_LT(glm::length(glm::dvec3(p.plane_normal) - normal), packed ? 0.01 : 1e-3);
            }
            EXPECT_GT(compared, probes.size() / 4);
        }
    }
}

TEST_F(VisibilityTest, PicturesOfBothLayoutsAreAlike) {
    // Bars thinner than a sample, leaves and shadows of few pixels: where packing rounds, a sample
    // may change sides.
    const LitScene lit(device(), varied_scene(true));
    AdaptiveAaParams p;
    p.width = 96;
    p.height = 72;
    p.m = 4;
    p.export_counts = true;
    for (const AaMethod method : {AaMethod::ssaa, AaMethod::adaptive}) {
        p.method = method;
        Image picture[2];
        double mean[2] = {};
        for (const bool ids : {false, true}) {
            p.gbuffer = ids ? GbufferLayout::visibility : GbufferLayout::packed;
            AdaptiveAa aa(device(), lit, lit.scene().cameras.front(), p);
            aa.execute();
            picture[ids] = aa.picture();
            mean[ids] = aa.sample_counts().mean;
        }
        EXPECT_GT(image_error(picture[1], picture[0]).psnr, 50.0);
        EXPECT_NEAR(mean[1] / mean[0], 1.0, 0.01);
    }
}

class TilesTest : public VisibilityTest {
protected:
    static Image render(const LitScene& lit, const AdaptiveAaParams& p) {
        AdaptiveAa aa(device(), lit, lit.scene().cameras.front(), p);
        EXPECT_EQ(aa.tile_count() > 1, p.tile.x > 0);
        aa.execute();
        return aa.picture();
    }
    static std::size_t different_pixels(const Image& a, const Image& b) {
        EXPECT_EQ(a.width(), b.width());
        EXPECT_EQ(a.height(), b.height());
        std::size_t count = 0;
        for (std::size_t i = 0; i < a.pixels(); ++i) {
            bool same = true;
            for (int c = 0; c < 4; ++c) same = same && a.plane(c)[i] == b.plane(c)[i];
            count += !same;
        }
        return count;
    }
};

TEST_F(TilesTest, MakeTheSamePictureBitByBit) {
    // Where clipping makes a corner, the rasteriser may round it elsewhere in another tile: one
    // sample in a million.
    std::size_t astray = 0;
    const LitScene lit(device(), builtin_scene("atrium"));
    for (const std::uint32_t m : {1u, 2u, 3u, 4u, 5u, 6u, 7u, 8u}) {
        SCOPED_TRACE(testing::Message() << "m = " << m);
        AdaptiveAaParams p;
        p.width = 45;
        p.height = 31;
        p.m = m;
        p.gbuffer = GbufferLayout::visibility;
        p.metrics = default_metrics(m);
        // The printed orders know no other windows.
        if (m > 4 && m < 8) p.method = AaMethod::ssaa;
        const Image whole = render(lit, p);
        for (const glm::uvec2 tile : {glm::uvec2(17, 31), glm::uvec2(16, 9)}) {
            p.tile = tile;
            const std::size_t count = different_pixels(whole, render(lit, p));
            EXPECT_LE(count, 1u) << tile.x << " x " << tile.y;
            astray += count;
        }
    }
    EXPECT_LE(astray, 2u);
}

TEST_F(TilesTest, TheDefaultMetricSeesAcrossTheirBorders) {
    // Variance is pooled over neighbours who look at theirs: two pixels around.
    const LitScene lit(device(), varied_scene());
    for (const std::uint32_t m : {2u, 3u, 4u, 5u, 6u, 7u, 8u}) {
        SCOPED_TRACE(testing::Message() << "m = " << m);
        AdaptiveAaParams p;
        p.width = 45;
        p.height = 31;
        p.m = m;
        p.gbuffer = GbufferLayout::visibility;
        p.metric = MetricKind::ockham;
        p.resolve = Resolve::stratified;
        p.order_kind = SampleOrder::optimal;
        p.demodulate = p.filter_highlights = true;
        const Image whole = render(lit, p);
        p.tile = {17, 31};
        EXPECT_EQ(different_pixels(whole, render(lit, p)), 0u);
    }
}

TEST_F(TilesTest, KeepBlocksOfCountsTogether) {
    const LitScene lit(device(), varied_scene());
    AdaptiveAaParams p;
    p.width = 45;
    p.height = 31;
    p.m = 2;
    p.count_block = 4;
    p.gbuffer = GbufferLayout::visibility;
    const Image whole = render(lit, p);
    p.tile = {19, 23};
    EXPECT_EQ(different_pixels(whole, render(lit, p)), 0u);
}

TEST_F(TilesTest, ReachBeyondTheDevicesLargestImage) {
    const LitScene lit(device(), varied_scene());
    AdaptiveAaParams p;
    p.width = 8191;
    p.height = 1;
    p.m = 8;
    AdaptiveAa aa(device(), lit, lit.scene().cameras.front(), p);
    EXPECT_EQ(aa.fit().layout, GbufferLayout::visibility);
    EXPECT_GE(aa.tile_count(), 4u);
    EXPECT_NE(aa.fit().reason.find("65528 x 8"), std::string::npos) << aa.fit().reason;
    aa.execute();
    EXPECT_EQ(aa.picture().width(), 8191);
    p.gbuffer = GbufferLayout::packed;
    EXPECT_NE(error_of([&] {
        AdaptiveAa(device(), lit, lit.scene().cameras.front(), p);
    }).find("65528 x 8"),
        std::string::npos);
    p.gbuffer.reset();
    p.captures = {"first_sample"};
    EXPECT_NE(error_of([&] {
        AdaptiveAa(device(), lit, lit.scene().cameras.front(), p);
    }).find("--capture"),
        std::string::npos);
}

TEST_F(TilesTest, BudgetsDecideWhatIsDrawn) {
    const auto fit_within = [&](std::uint64_t mib) {
        // A device of its own: budgets belong to devices.
        gpu::Device limited({.memory_budget_bytes = mib << 20});
        const LitScene scene(limited, varied_scene());
        AdaptiveAaParams p;
        p.width = 256;
        p.height = 192;
        p.m = 4;
        AdaptiveAa aa(limited, scene, scene.scene().cameras.front(), p);
        return std::pair(aa.fit(), aa.tile_count());
    };
    const auto [roomy, one] = fit_within(64);
    EXPECT_EQ(roomy.layout, GbufferLayout::packed);
    EXPECT_EQ(roomy.reason, "");
    const auto [tight, still_one] = fit_within(18);
    EXPECT_EQ(tight.layout, GbufferLayout::visibility);
    EXPECT_EQ(still_one, 1u);
    EXPECT_NE(tight.reason.find("--gbuffer packed"), std::string::npos) << tight.reason;
    EXPECT_NE(tight.reason.find("MiB"), std::string::npos);
    const auto [tiny, several] = fit_within(5);
    EXPECT_EQ(tiny.layout, GbufferLayout::visibility);
    EXPECT_GT(several, 1u);
}

TEST(TileCutsTest, CoverEveryPixelOnce) {
    for (const std::uint32_t block : {1u, 3u, 8u}) {
        for (std::uint32_t length = 1; length < 90; length += 7) {
            for (std::uint32_t most = 3 * block; most < 95; most += 5) {
                const std::uint32_t apron = block, extent = tile_extent(length, most, apron, block);
                if (extent == 0) continue;
                EXPECT_LE(extent, std::max(most, length <= most ? length : most));
                std::uint32_t next = 0;
                for (const TilePlacement& tile :
                    place_tiles({length, 1}, {extent, 1}, apron, block)) {
                    EXPECT_EQ(tile.first.x, next);
                    EXPECT_LE(tile.origin.x + extent, length);
                    EXPECT_EQ(tile.origin.x % block, 0u);
                    EXPECT_TRUE(tile.first.x == 0 || tile.first.x >= tile.origin.x + apron);
                    EXPECT_TRUE(
                        tile.last.x == length || tile.last.x + apron <= tile.origin.x + extent);
                    next = tile.last.x;
                }
                EXPECT_EQ(next, length);
            }
        }
    }
    EXPECT_EQ(tile_extent(100, 2, 1, 1), 0u) << "nothing but apron";
}

} // namespace
} // namespace ockham::test
