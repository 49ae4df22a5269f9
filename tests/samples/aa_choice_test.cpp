// SPDX-License-Identifier: Apache-2.0
// How lambda is chosen by a chart of other scenes: at its entries, between them, beyond them.
#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "samples/chart/aa_choice.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>

namespace ockham {
namespace {

/// Two classes: `a` spends 20 % at 1e-5 and `b` 60 %.
AaChart two_classes() {
    return {.m = 4,
        .device = "test",
        .classes = {{"a", {{1e-6, 40, 50, 300}, {1e-5, 20, 45, 200}, {1e-4, 10, 35, 100}}},
            {"b", {{1e-6, 80, 48, 900}, {1e-5, 60, 40, 800}, {1e-4, 30, 30, 500}}}}};
}

TEST(AaChoice, TakesTheClassOfTheNearestShareOfSamples) {
    const AaChart chart = two_classes();
    EXPECT_EQ(class_of(chart, {1e-5, 22, 1}).name, "a");
    EXPECT_EQ(class_of(chart, {1e-5, 50, 1}).name, "b");
    EXPECT_EQ(class_of(chart, {1e-5, 34, 1}).name, "a") << "34/20 < 60/34";
    EXPECT_EQ(class_of(chart, {1e-5, 35.5, 1}).name, "b");
    EXPECT_EQ(class_of(chart, {1e-6, 42, 1}).name, "a") << "at the probe's own lambda";
}

TEST(AaChoice, PricesFollowTheErrorAskedFor) {
    const AaProbe probe{1e-5, 20, 50}; // a machine four times as fast as the chart's
    const AaChoice known = choose_by_psnr(two_classes(), probe, 45);
    EXPECT_NEAR(known.lambda, 1e-5, 1e-12);
    EXPECT_NEAR(known.psnr, 45, 1e-9);
    EXPECT_NEAR(known.total_gpu_ms, 50, 1e-9);
    EXPECT_TRUE(known.reached);
    const AaChoice between = choose_by_psnr(two_classes(), probe, 40);
    EXPECT_NEAR(between.lambda, std::sqrt(1e-5 * 1e-4), 1e-12) << "half way in log lambda";
    EXPECT_NEAR(between.psnr, 40, 1e-9);
    EXPECT_NEAR(between.total_gpu_ms, 37.5, 1e-9);
    const AaChoice too_good = choose_by_psnr(two_classes(), probe, 51);
    EXPECT_NEAR(too_good.lambda, 1e-6, 1e-12);
    EXPECT_FALSE(too_good.reached);
    const AaChoice easy = choose_by_psnr(two_classes(), probe, 20);
    EXPECT_NEAR(easy.lambda, 1e-4, 1e-12) << "the cheapest that was measured";
    EXPECT_TRUE(easy.reached);
}

TEST(AaChoice, PricesFollowTheTimeAskedFor) {
    const AaProbe probe{1e-5, 20, 50};
    const AaChoice between = choose_by_time(two_classes(), probe, 62.5); // 250 ms of the chart's
    EXPECT_NEAR(between.lambda, std::sqrt(1e-6 * 1e-5), 1e-12);
    EXPECT_NEAR(between.total_gpu_ms, 62.5, 1e-9);
    EXPECT_NEAR(between.psnr, 47.5, 1e-9);
    EXPECT_NEAR(choose_by_time(two_classes(), probe, 1000).lambda, 1e-6, 1e-12);
    EXPECT_TRUE(choose_by_time(two_classes(), probe, 1000).reached);
    EXPECT_NEAR(choose_by_time(two_classes(), probe, 10).lambda, 1e-4, 1e-12);
    EXPECT_FALSE(choose_by_time(two_classes(), probe, 10).reached);
}

TEST(AaChoice, NoiseInTimesDoesNotMakeADearerPriceCheaper) {
    AaChart chart = two_classes();
    chart.classes.resize(1);
    chart.classes[0].entries = {
        {1e-6, 40, 50, 200}, {1e-5, 20, 45, 220}, {1e-4, 10, 35, 180}, {1e-3, 8, 30, 100}};
    const AaProbe probe{1e-6, 40, 210};
    // The first two are taken as 210 both.
    EXPECT_NEAR(predict(chart.classes[0], probe, 1e-5).total_gpu_ms, 210, 1e-9);
    EXPECT_NEAR(choose_by_time(chart, probe, 211).lambda, 1e-6, 1e-12);
    double last = 0;
    for (double ms = 300; ms > 80; ms -= 1) {
        const double lambda = choose_by_time(chart, probe, ms).lambda;
        EXPECT_GE(lambda, last) << ms;
        last = lambda;
    }
}

TEST(AaChoice, ChartsAreKeptAndDamagedOnesRefused) {
    const std::filesystem::path path =
        std::filesystem::temp_directory_path() / fmt::format("ockham_aa_chart.{}.json", ::getpid());
    write_text(path, to_json(two_classes()));
    const AaChart read = load_aa_chart(path);
    EXPECT_EQ(to_json(read), to_json(two_classes()));
    const auto refused = [&](const std::string& text, const std::string& part) {
        write_text(path, text);
        try {
            (void)load_aa_chart(path);
            ADD_FAILURE() << text;
        } catch (const Error& error) {
            EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
        }
    };
    refused("{", "chart of anti-aliasing");
    refused(R"({"m": 9, "device": "", "classes": []})", "m");
    refused(R"({"m": 4, "device": "", "classes": []})", "classes");
    refused(R"({"m": 4, "device": "", "classes": [{"name": "x", "entries": []}]})", "entries");
    refused(R"({"m": 4, "device": "", "classes": [{"name": "x", "entries": [
        {"lambda": 0, "samples_percent": 1, "psnr": 1, "total_gpu_ms": 1}]}]})",
        "lambda");
    std::filesystem::remove(path);
}

TEST(AaChoice, TheBuiltInChartHasTheScenesThatComeWithTheProgram) {
    const AaChart chart = builtin_aa_chart();
    EXPECT_EQ(chart.m, 4u);
    for (const char* name : {"atrium", "fence", "wires", "foliage", "sparkle"}) {
        const bool found = std::any_of(chart.classes.begin(), chart.classes.end(),
            [&](const AaClass& scenes) { return scenes.name == name; });
        EXPECT_TRUE(found) << name;
    }
}

} // namespace
} // namespace ockham
