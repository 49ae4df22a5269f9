// SPDX-License-Identifier: Apache-2.0
// The whole picture of a volume while things change: what must begin anew equals a fresh one bit
// for bit, and what need not is kept.
#include "framework/graph/explain/explain.hpp"
#include "passes/pipelines/volume_gi.hpp"
#include "tests/support/ball.hpp"
#include "tests/support/equal_pictures.hpp"
#include "tests/support/gpu_fixture.hpp"
#include "tests/support/shuffle.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>

namespace ockham::test {
namespace {

TransferFunction rising(double opacity) {
    return {{{.value = 0, .opacity = 0}, {.value = 255, .opacity = opacity}}};
}

VolumeView lit() {
    VolumeView view;
    view.light_direction = {0.3f, 1.0f, -0.4f};
    view.light_irradiance = glm::vec3(2.0f);
    view.environment = {0.2f, 0.3f, 0.4f};
    view.density_scale = 10;
    view.albedo = 0.9f;
    return view;
}

Camera front() { return look_at({0, -2.4f, 0.2f}, {0, 0, 0}, 30, UpAxis::z); }
Camera side() { return look_at({2.2f, 0.5f, 0.4f}, {0, 0, 0}, 30, UpAxis::z); }

VolumeGiParams params(VolumeMode mode, bool gather = true) {
    VolumeGiParams p;
    p.width = 16;
    p.height = 12;
    p.mode = mode;
    p.gather = gather;
    return p;
}

class VolumeGiTest : public GpuTest {
protected:
    static VolumeGi make(const VolumeGiParams& p, const VolumeView& view = lit(),
        const Camera& camera = front(), double opacity = 1) {
        return VolumeGi(device(), ball(), rising(opacity), {}, view, camera, p);
    }
    static Image after(VolumeGi& gi, int steps) {
        for (int i = 0; i < steps; ++i) gi.execute();
        gi.finish();
        return gi.picture();
    }
};

const VolumeGiParams kAll[] = {params(VolumeMode::path), params(VolumeMode::noncaching),
    params(VolumeMode::caching), params(VolumeMode::caching, false)};

TEST_F(VolumeGiTest, StepsTogetherGiveTheBitsOfOneAfterTheOther) {
    VolumeView view = lit();
    view.surfaces = {{.value = 190, .opacity = 0.5f}};
    VolumeGiParams p = params(VolumeMode::path);
    VolumeGi single = make(p, view);
    const Image expected = after(single, 8);
    p.iterations = 300; // less than eight samples take: paths go on in later executions
    VolumeGi together = make(p, view);
    for (const std::uint32_t steps : {1u, 5u, 2u}) together.execute(steps);
    EXPECT_EQ(together.steps(), 8u);
    together.finish();
    EXPECT_TRUE(equal(together.picture(), expected));
    EXPECT_GT(together.statistics().resumed, 0u);
    EXPECT_EQ(together.statistics().paths, single.statistics().paths);
    EXPECT_FALSE(make(params(VolumeMode::caching)).steps_together());
}

TEST_F(VolumeGiTest, EveryChangeOfTheViewEqualsAFreshPicture) {
    for (const VolumeGiParams& p : kAll) {
        std::vector<VolumeView> views(6, lit());
        views[0].light_direction = {-1, 0.2f, -0.1f};
        views[1].density_scale = 30;
        views[2].crop_max = {0.5f, 1, 1};
        views[3].phase_g = 0.6f;              // other kernels and cells: another graph
        views[4].surfaces = {{.value = 190}}; // another graph, too
        views[5].surfaces = {{.value = 150, .opacity = 0.5f}};
        VolumeGi gi = make(p);
        after(gi, 3);
        for (std::size_t i = 0; i < views.size(); ++i) {
            gi.set_view(views[i]);
            EXPECT_EQ(gi.steps(), 0u);
            const Image changed = after(gi, 2);
            VolumeGi fresh = make(p, views[i]);
            EXPECT_TRUE(equal(changed, after(fresh, 2)))
                << name_of(p.mode) << (p.gather ? "" : ", composed") << ", view " << i;
            EXPECT_EQ(gi.steps(), 2u);
        }
    }
}

TEST_F(VolumeGiTest, EveryTransferFunctionEqualsAFreshPicture) {
    TransferFunction glowing = rising(1);
    glowing.points[1].emission = glm::dvec3(1, 0.5, 0.1);
    const TransferFunction fog{{{.value = 0, .opacity = 0.3}}}; // homogeneous: no majorant grid
    for (const VolumeGiParams& p : kAll) {
        VolumeGi gi = make(p);
        after(gi, 3);
        for (const TransferFunction& transfer : {rising(0.4), glowing, fog, rising(1)}) {
            gi.set_transfer(transfer);
            const Image changed = after(gi, 2);
            VolumeGi fresh(device(), ball(), transfer, {}, lit(), front(), p);
            EXPECT_TRUE(equal(changed, after(fresh, 2)))
                << name_of(p.mode) << (p.gather ? "" : ", composed");
        }
    }
}

TEST_F(VolumeGiTest, ACameraBeginsThePictureAnewAndKeepsTheCache) {
    for (const VolumeGiParams& p : {kAll[2], kAll[3]}) {
        VolumeGi gi = make(p);
        after(gi, 6);
        const auto cells = [&gi] {
            for (const SavedResource& resource : gi.save())
                if (resource.name == "cache_sums") return resource.bytes;
            return std::vector<std::byte>{};
        };
        const std::vector<std::byte> before = cells();
        ASSERT_FALSE(before.empty());
        const std::uint64_t paths = gi.statistics().paths;
        gi.set_camera(side());
        const Image moved = after(gi, 1);
        EXPECT_NE(cells(), before) << "refined further";
        if (!p.gather) {
            EXPECT_GT(gi.statistics().paths, paths);
        }

        // The same step of the cache from a fresh start, under the other camera all along.
        VolumeGi other = make(p, lit(), side());
        after(other, 7);
        EXPECT_EQ(other.statistics().cells, gi.statistics().cells);
        const auto sums = [](VolumeGi& from) {
            for (const SavedResource& resource : from.save())
                if (resource.name == "cache_cells") return resource.bytes;
            return std::vector<std::byte>{};
        };
        EXPECT_EQ(sums(other), sums(gi)) << "the camera is of no concern to the cache";
        EXPECT_EQ(moved.width(), 16);
    }
    for (const VolumeGiParams& p : kAll) {
        VolumeGi gi = make(p);
        after(gi, 2);
        gi.set_camera(side());
        VolumeGi fresh = make(p, lit(), side());
        const Image moved = after(gi, 2), anew = after(fresh, 2);
        EXPECT_EQ(equal(moved, anew), p.mode != VolumeMode::caching) << name_of(p.mode);
    }
}

TEST_F(VolumeGiTest, AnotherSizeBeginsThePictureAnewAndKeepsTheCache) {
    for (const bool gather : {true, false}) {
        VolumeGiParams large = params(VolumeMode::caching, gather);
        large.width = 24;
        large.height = 18;
        VolumeGi fresh = make(large), changed = make(params(VolumeMode::caching, !gather));
        for (VolumeGi* gi : {&fresh, &changed}) {
            gi->execute();
            gi->execute();
            gi->set_refining(false);
        }
        fresh.set_camera(front());
        changed.set_picture(24, 18, gather);
        EXPECT_EQ(changed.steps(), 0u);
        EXPECT_TRUE(equal(after(changed, 2), after(fresh, 2))) << "gather " << gather;
        const std::uint64_t paths = fresh.statistics().paths - (gather ? 2u * 24 * 18 : 0);
        EXPECT_EQ(changed.statistics().paths - (gather ? 2u * 24 * 18 : 0), paths);

        // A cache at rest still follows what is not the camera.
        VolumeView bright = lit();
        bright.light_irradiance *= 2.0f;
        changed.set_view(bright);
        const Image picture = after(changed, 1);
        VolumeGi other = make(large, bright);
        EXPECT_TRUE(equal(picture, after(other, 1))) << "gather " << gather;
    }
}

TEST_F(VolumeGiTest, MaterialsAndGainsKeepTheCache) {
    VolumeView view = lit();
    view.surfaces = {{.value = 190}};
    VolumeGi gi = make(params(VolumeMode::caching, false), view);
    after(gi, 4);
    const std::uint64_t paths = gi.statistics().paths;
    view.surfaces[0].material.base_color = {0.9f, 0.1f, 0.1f};
    view.surface_gain = 2;
    gi.set_view(view);
    after(gi, 1);
    EXPECT_GT(gi.statistics().paths, paths);
    view.surfaces[0].value = 120;
    gi.set_view(view);
    after(gi, 1);
    EXPECT_LT(gi.statistics().paths, paths);
}

TEST_F(VolumeGiTest, OldValuesOfTheCacheLeaveTheMean) {
    VolumeGi gi = make(params(VolumeMode::caching));
    std::vector<float> samples;
    for (int step = 1; step <= 9; ++step) {
        gi.execute();
        gi.finish();
        const std::vector<SavedResource> saved = gi.save();
        const auto progress = std::ranges::find(saved, "path_progress", &SavedResource::name);
        ASSERT_NE(progress, saved.end());
        std::uint32_t finished = 0;
        std::memcpy(&finished, progress->bytes.data(), sizeof(finished));
        samples.push_back(static_cast<float>(finished));
    }
    ASSERT_FALSE(gi.statistics().cache_converged);
    EXPECT_EQ(samples, (std::vector<float>{1, 1, 1, 2, 1, 2, 3, 4, 1}));
}

TEST_F(VolumeGiTest, AConvergedCacheIsLeftAlone) {
    VolumeGiParams p = params(VolumeMode::caching);
    p.cache_error = 0.5f;
    VolumeGi gi = make(p);
    int steps = 0;
    while (!gi.statistics().cache_converged && steps < 200) {
        gi.execute();
        ++steps;
    }
    ASSERT_LT(steps, 200);
    gi.execute(); // a sum of this cache alone
    gi.execute();
    gi.finish();
    const std::vector<SavedResource> saved = gi.save();
    const auto progress = std::ranges::find(saved, "path_progress", &SavedResource::name);
    std::uint32_t finished = 0;
    std::memcpy(&finished, progress->bytes.data(), sizeof(finished));
    EXPECT_EQ(finished, 2u);
    gi.execute();
    bool traced = false;
    for (const PassTime& time : gi.executor().times())
        traced = traced || (time.pass.starts_with("cache") && !time.skipped);
    EXPECT_FALSE(traced);
    VolumeView view = lit();
    view.light_irradiance = glm::vec3(1.0f);
    gi.set_view(view);
    gi.execute();
    EXPECT_FALSE(gi.statistics().cache_converged && gi.statistics().paths == 0);
    VolumeGi fresh = make(p, view);
    fresh.execute();
    gi.finish();
    fresh.finish();
    EXPECT_TRUE(equal(gi.picture(), fresh.picture()));
}

TEST_F(VolumeGiTest, TheBudgetOfIterationsChangesNothing) {
    for (const VolumeMode mode : {VolumeMode::path, VolumeMode::noncaching}) {
        VolumeGiParams tight = params(mode);
        tight.iterations = 16;
        VolumeView view = lit();
        view.surfaces = {{.value = 200}};
        VolumeGi whole = make(params(mode), view), pieces = make(tight, view);
        EXPECT_TRUE(equal(after(whole, 3), after(pieces, 3)));
        EXPECT_GT(pieces.statistics().resumed, whole.statistics().resumed);
        EXPECT_EQ(pieces.statistics().paths, 3u * 16 * 12);
    }
}

TEST_F(VolumeGiTest, AStochasticDepthSettlesWhileTheCacheDoes) {
    VolumeGiParams exact = params(VolumeMode::caching, false), stochastic = exact;
    stochastic.search = SurfaceSearch::stochastic;
    exact.captures = stochastic.captures = {"surface_depth"};
    VolumeView view = lit();
    view.surfaces = {{.value = 190}};
    VolumeGi a = make(exact, view), b = make(stochastic, view);
    after(a, 20);
    after(b, 20); // restarts of the picture leave what was found: 20 * 64 candidates
    const Image found = b.executor().read(b.captures()[0]);
    const Image truth = a.executor().read(a.captures()[0]);
    std::size_t hits = 0;
    for (std::size_t i = 0; i < truth.pixels(); ++i) {
        if (truth.plane(1)[i] == 0) continue;
        ++hits;
        // One-sided and exponential, of mean a / N: 12 means is chance.
        EXPECT_GE(found.plane(0)[i], truth.plane(0)[i] - 1e-4f);
        EXPECT_LT(found.plane(0)[i], truth.plane(0)[i] + 12.0f / (20 * 64));
    }
    EXPECT_GT(hits, 10u);
}

TEST_F(VolumeGiTest, ASurfaceThatKeepsNoLightOutIsOfNoConcernToTheCache) {
    VolumeGiParams p = params(VolumeMode::caching, false);
    p.iso_occlusion = false;
    VolumeView view = lit();
    view.surfaces = {{.value = 190}};
    VolumeGi gi = make(p, view);
    after(gi, 3);
    const std::uint64_t paths = gi.statistics().paths;
    view.surfaces[0].value = 120;
    gi.set_view(view);
    after(gi, 1);
    EXPECT_GT(gi.statistics().paths, paths);
}

TEST_F(VolumeGiTest, NewIsovaluesLeaveOldLightUntilThereIsNew) {
    VolumeGiParams p = params(VolumeMode::caching, false);
    p.keep_on_iso = true;
    VolumeView view = lit();
    view.surfaces = {{.value = 190}};
    VolumeGi gi = make(p, view);
    after(gi, 5);
    const auto cells = [](VolumeGi& from) {
        const std::vector<SavedResource> saved = from.save();
        return std::ranges::find(saved, "cache_cells", &SavedResource::name)->bytes;
    };
    const std::vector<std::byte> old = cells(gi);
    view.surfaces[0].value = 150;
    gi.set_view(view);
    VolumeGi fresh = make(p, view);
    after(gi, 1);
    after(fresh, 1);
    EXPECT_EQ(cells(gi), old);
    EXPECT_NE(cells(fresh), old);
    // All cells have eight paths after four steps; samples from before then leave the mean.
    EXPECT_TRUE(equal(after(gi, 7), after(fresh, 7)));
}

TEST_F(VolumeGiTest, ModesAreChosenByUse) {
    const Volume volume = ball();
    EXPECT_EQ(choose_mode(volume, 1, 2, 0).mode, VolumeMode::path);
    EXPECT_EQ(choose_mode(volume, 8, 2, 0).mode, VolumeMode::caching);
    EXPECT_EQ(choose_mode(volume, 8, 2, 64 << 20).mode, VolumeMode::caching);
    const ModeChoice tight = choose_mode(volume, 8, 1, 4096);
    EXPECT_EQ(tight.mode, VolumeMode::path);
    EXPECT_NE(tight.why.find("cache"), std::string::npos);
}

TEST_F(VolumeGiTest, ImpossibleParametersAreRefusedInWords) {
    const auto text = [](VolumeGiParams p, VolumeView view = lit()) {
        return error_of([&] { make(p, view); });
    };
    VolumeGiParams p = params(VolumeMode::path);
    p.width = 0;
    EXPECT_NE(text(p).find("0 x 12"), std::string::npos);
    p = params(VolumeMode::path);
    p.search = SurfaceSearch::march;
    EXPECT_NE(text(p).find("--gather off"), std::string::npos);
    p = params(VolumeMode::path);
    p.captures = {"nothing"};
    EXPECT_NE(text(p).find("nothing"), std::string::npos);
    VolumeView view = lit();
    view.albedo = 2;
    EXPECT_NE(text(params(VolumeMode::path), view).find("albedo"), std::string::npos);
    VolumeGi gi = make(params(VolumeMode::path));
    after(gi, 1);
    EXPECT_NE(error_of([&] { gi.set_view(view); }), "");
    EXPECT_EQ(gi.steps(), 1u) << "a refused view changes nothing";
}

TEST_F(VolumeGiTest, TheOrderOfDeclarationChangesNoBit) {
    VolumeView view = lit();
    view.surfaces = {{.value = 190, .opacity = 0.5f}};
    std::size_t other = 0, pictures = 0;
    for (const VolumeGiParams& p :
        {params(VolumeMode::caching), params(VolumeMode::caching, false)}) {
        VolumeGi declared = make(p, view);
        const Image expected = after(declared, 3);
        for (unsigned seed = 1; seed <= 2; ++seed, ++pictures) {
            const Shuffle shuffle(seed);
            VolumeGi gi = make(p, view);
            EXPECT_TRUE(equal(after(gi, 3), expected)) << "seed " << seed;
            other += order_of(gi.executor()) != order_of(declared.executor());
        }
    }
    EXPECT_GE(other, 2u) << "shuffled in vain";
    std::printf("reliability: order {\"pictures\": %zu, \"other_orders\": %zu}\n", pictures, other);
}

} // namespace
} // namespace ockham::test
