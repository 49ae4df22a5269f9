// SPDX-License-Identifier: Apache-2.0
// How a technique and its steps are chosen by a chart of other volumes: at its entries, between
// them, beyond them, on slower machines and harder views.
#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "framework/core/process.hpp"
#include "samples/chart/volume_choice.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace ockham {
namespace {

constexpr VolumeTechnique kPath = kVolumeTechniques[0], kComposed = kVolumeTechniques[3];

/// Path tracing gains 3 dB whenever its steps double; the composed cache is sooner at 30 dB and
/// ends at 34.
VolumeClass surfaces() {
    return {.name = "surfaces",
        .features = {.surface = true, .sun = true, .optical_depth = 2, .albedo = 0.9},
        .curves = {{kPath, {{1, 10, 20}, {8, 80, 29}, {64, 640, 38}}},
            {kComposed, {{1, 20, 26}, {4, 40, 32}, {16, 100, 34}}}}};
}
VolumeClass smoke(double depth) {
    return {.name = fmt::format("smoke {}", depth),
        .features = {.surface = false, .sun = true, .optical_depth = depth, .albedo = 0.9},
        .curves = {{kPath, {{1, 5, 30}, {8, 40, 39}}}}};
}
VolumeChart chart() { return {.device = "test", .classes = {surfaces(), smoke(0.5), smoke(8)}}; }

TEST(VolumeChoice, TakesTheClassOfTheNearestFeatures) {
    EXPECT_EQ(class_of(chart(), {true, false, 8, 0.2}).name, "surfaces");
    EXPECT_EQ(class_of(chart(), {false, true, 1, 0.9}).name, "smoke 0.5");
    EXPECT_EQ(class_of(chart(), {false, false, 4, 0.9}).name, "smoke 8");
}

TEST(VolumeChoice, TakesWhatIsThereSoonest) {
    const VolumeProbe as_class = probe_of(surfaces());
    EXPECT_NEAR(as_class.gpu_ms, 80, 1e-9);
    EXPECT_NEAR(as_class.psnr, 29, 1e-9);
    const VolumeChoice low = choose_by_psnr(chart(), as_class, 32);
    EXPECT_EQ(low.technique, kComposed);
    EXPECT_EQ(low.steps, 4);
    EXPECT_NEAR(low.gpu_ms, 40, 1e-9);
    EXPECT_NEAR(low.psnr, 32, 1e-9);
    const VolumeChoice high = choose_by_psnr(chart(), as_class, 38);
    EXPECT_EQ(high.technique, kPath) << "the cache never gets there";
    EXPECT_EQ(high.steps, 64);
    EXPECT_TRUE(high.reached);
    const VolumeChoice too_high = choose_by_psnr(chart(), as_class, 50);
    EXPECT_EQ(too_high.technique, kPath) << "the nearest";
    EXPECT_FALSE(too_high.reached);
    const VolumeChoice soon = choose_by_time(chart(), as_class, 40);
    EXPECT_EQ(soon.technique, kComposed);
    EXPECT_EQ(soon.steps, 4);
    EXPECT_EQ(choose_by_time(chart(), as_class, 640).technique, kPath);
    EXPECT_FALSE(choose_by_time(chart(), as_class, 5).reached);
}

TEST(VolumeChoice, FollowsTheProbe) {
    VolumeProbe probe = probe_of(surfaces());
    probe.gpu_ms *= 3; // a slower machine, or more pixels
    probe.psnr -= 4;   // and a view with more noise
    const VolumeChoice same = choose_by_psnr(chart(), probe, 28);
    EXPECT_EQ(same.technique, kComposed);
    EXPECT_EQ(same.steps, 4);
    EXPECT_NEAR(same.psnr, 28, 1e-9);
    EXPECT_NEAR(same.gpu_ms, 120, 1e-9);
    const VolumeChoice timed = choose_by_time(chart(), probe, 3 * 640);
    EXPECT_EQ(timed.steps, 64);
    EXPECT_NEAR(timed.psnr, 34, 1e-9);
}

TEST(VolumeChoice, FeaturesAreThoseOfTheBox) {
    VolumeOptions options;
    options.volume = {"builtin:constant:8"};
    options.window = "0.5,1"; // opacity = value
    options.density_scale = 7;
    options.albedo = 0.5f;
    options.light = "0,0,-1 0,0,0";
    const VolumeSource source = load_volume_source(options);
    const VolumeFeatures features = features_of(source);
    EXPECT_FALSE(features.surface);
    EXPECT_FALSE(features.sun) << "black";
    EXPECT_NEAR(features.optical_depth, 7 * source.volume.sample({0.5, 0.5, 0.5}), 1e-6);
    EXPECT_NEAR(features.albedo, 0.5, 1e-6);
    options.iso = "0.5";
    options.light = "0,0,-1 1,1,1";
    options.crop = "0,0.5,0,1,0,1";
    const VolumeFeatures half = features_of(load_volume_source(options));
    EXPECT_TRUE(half.surface && half.sun);
    EXPECT_NEAR(half.optical_depth, features.optical_depth * (0.5 + 1 + 1) / 3, 1e-6);
}

TEST(VolumeChoice, ChartsAreKeptAndDamagedOnesRefused) {
    const TemporaryFolder folder;
    const std::filesystem::path path = folder.path() / "volume_chart.json";
    write_text(path, to_json(chart()));
    EXPECT_EQ(to_json(load_volume_chart(path)), to_json(chart()));
    const auto refused = [&](const std::string& from, const std::string& to,
                             const std::string& part) {
        std::string text = to_json(chart());
        const std::size_t at = text.find(from);
        ASSERT_NE(at, std::string::npos) << from;
        write_text(path, text.replace(at, from.size(), to));
        try {
            (void)load_volume_chart(path);
            ADD_FAILURE() << to;
        } catch (const Error& error) {
            EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
        }
    };
    refused("{", "", "chart of volumes");
    refused("\"classes\"", "\"classless\"", "classes");
    refused("\"composed cache\"", "\"magic\"", "technique");
    refused("\"steps\": 8.0", "\"steps\": 80.0", "entries");
    refused("\"steps\": 64.0", "\"steps\": 0.5", "steps");
    refused("\"path\"", "\"noncaching\"", "curves");
}

TEST(VolumeChoice, TheBuiltInChartHasTheScenesThatComeWithTheProgram) {
    const VolumeChart builtin = builtin_volume_chart();
    for (const char* name : {"cloud", "thin cloud", "milk", "fingers", "cluster", "shells"}) {
        const auto found = std::find_if(builtin.classes.begin(), builtin.classes.end(),
            [&](const VolumeClass& scenes) { return scenes.name == name; });
        ASSERT_NE(found, builtin.classes.end()) << name;
        EXPECT_EQ(found->curves.size(), std::size(kVolumeTechniques)) << name;
    }
}

} // namespace
} // namespace ockham
