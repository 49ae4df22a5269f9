// SPDX-License-Identifier: Apache-2.0
// chart as a user runs it: what it writes, refuses, and does a second time.
#include "framework/core/file.hpp"
#include "tests/support/program_test.hpp"

#include <algorithm>

namespace ockham::test {
namespace {

class ChartProgramTest : public ProgramTest {
protected:
    ChartProgramTest() : ProgramTest("chart") {}
    std::size_t lines(const char* file) const {
        const std::string text = read_text(folder / file);
        return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
    }
};

TEST_F(ChartProgramTest, MeasuresOnceThenOnlyDraws) {
    const std::string arguments = "--suite graph --quick --repeats 2 --out d";
    const Result first = run(arguments);
    ASSERT_EQ(first.exit_code, 0) << first.text;
    EXPECT_NE(first.text.find("26 measurements to make, 0 kept"), std::string::npos) << first.text;
    EXPECT_EQ(lines("d/measured.jsonl"), 26u);
    for (const char* name : {"graph_compile", "graph_heap", "graph_batches"}) {
        EXPECT_GT(lines((std::string("d/") + name + ".csv").c_str()), 5u) << name;
        EXPECT_GT(std::filesystem::file_size(folder / "d" / (std::string(name) + ".svg")), 1000u);
    }
    std::filesystem::remove(folder / "d/index.html");
    const Result second = run(arguments);
    EXPECT_NE(second.text.find("0 measurements to make, 26 kept"), std::string::npos)
        << second.text;
    EXPECT_EQ(lines("d/measured.jsonl"), 26u);
    EXPECT_TRUE(std::filesystem::exists(folder / "d/index.html"));
    // One repeat more measures just that.
    EXPECT_NE(run("--suite graph --quick --repeats 3 --out d").text.find("10 measurements to make"),
        std::string::npos);
}

TEST_F(ChartProgramTest, KilledAtAnyMomentItContinues) {
    const std::string arguments = "--suite graph --quick --repeats 2 --out d";
    for (const char* seconds : {"0.05", "0.1", "0.15", "0.2"})
        (void)run(arguments, std::string("timeout -s KILL ") + seconds);
    const Result last = run(arguments);
    EXPECT_EQ(last.exit_code, 0) << last.text;
    EXPECT_EQ(lines("d/measured.jsonl"), 26u) << "each once, whatever was killed when";
}

TEST_F(ChartProgramTest, WithoutGnuplotNumbersAreWrittenAndOneMessageSaysSo) {
    const Result result = run("--suite graph --quick --repeats 1 --out d", "PATH=/nowhere");
    EXPECT_EQ(result.exit_code, 0) << result.text;
    EXPECT_NE(result.text.find("gnuplot is not installed"), std::string::npos) << result.text;
    EXPECT_GT(lines("d/graph_heap.csv"), 5u);
    EXPECT_TRUE(std::filesystem::exists(folder / "d/index.html"));
    EXPECT_FALSE(std::filesystem::exists(folder / "d/graph_heap.svg"));
    const std::string page = read_text(folder / "d/index.html");
    EXPECT_NE(page.find("VMAF: there is no program"), std::string::npos) << "nor is FFmpeg";
}

TEST_F(ChartProgramTest, RefusesWhatItDoesNotKnow) {
    expect_error("", 2, {"--suite", "graph"});
    expect_error("--suite graf --out d", 2, {"--suite", "graf", "graph"});
    expect_error("--suite graph --repeats 0 --out d", 2, {"--repeats"});
    expect_error("--suite aa --scenes builtin:fense --quick --out d", 2, {"fense"});
    expect_error("--suite aa --scenes no/such.glb --quick --out d", 2, {"no/such.glb"});
    expect_error("--suite graph --out /proc/no/such", 2, {"/proc/no/such"});
    expect_error("--suite graph --nonsense 1 --out d", 2, {"--nonsense"});
    expect_error("--suite graph --ffmpeg no/such --out d", 2, {"VMAF", "no/such"});
    expect_error("--suite graph --onnx no/such.onnx --out d", 2, {"no"});
}

TEST_F(ChartProgramTest, AntiAliasingHasEveryCurveOnATinyPicture) {
    // What stands for an FFmpeg scores all pictures alike.
    write_text(folder / "ffmpeg",
        "#!/bin/sh\nif [ \"$2\" = -h ]; then echo ' model  <string>'; exit; fi\n"
        "echo '{\"version\":\"1.2\",\"frames\":[{\"metrics\":{\"vmaf\":61.5}}]}' > log.json\n");
    std::filesystem::permissions(folder / "ffmpeg", std::filesystem::perms::owner_all);
    const Result result = run("--suite aa --scenes builtin:plane --quick --repeats 1 --width 24 "
                              "--height 16 --out d --ffmpeg ./ffmpeg");
    ASSERT_EQ(result.exit_code, 0) << result.text;
    const std::string metrics = read_text(folder / "d/aa_metrics.csv");
    EXPECT_NE(metrics.find("VMAF (its own model, libvmaf 1.2)"), std::string::npos) << metrics;
    EXPECT_NE(metrics.find("one sample,61.5"), std::string::npos) << metrics;
    EXPECT_EQ(lines("d/aa_metrics.csv"), 12u) << "a heading, eleven pictures";
    const std::string samples = read_text(folder / "d/aa_plane_samples.csv");
    for (const char* legend :
        {"adaptive", "paper's metrics", "uniform k", "MSAA", "one a surface", "SRAA", "FXAA",
            "SMAA", "one sample", "TAA at rest", "variance known", "errors known"}) {
        EXPECT_NE(samples.find(std::string("\n") + legend + ","), std::string::npos) << legend;
    }
    EXPECT_EQ(lines("d/aa_plane_table.csv"), 12u) << "a heading, ten methods, the reference";
    const std::string captured = read_text(folder / "d/aa_plane_captured.csv");
    for (const char* scheme : {"buckets", "loop", "repack", "sort"})
        EXPECT_NE(captured.find(std::string("\n") + scheme + ","), std::string::npos) << scheme;
}

TEST_F(ChartProgramTest, AdaptiveAaChoosesByAChartAndSaysWhatItPredictedAndGot) {
    const std::string view = "builtin:fence --width 48 --height 36 ";
    const auto aa = [&](const std::string& flags) { return run(view + flags, "", "adaptive_aa"); };
    ASSERT_EQ(aa("--method ssaa -o all.exr").exit_code, 0);
    const auto obtained = [&](const char* asked) {
        const Result result =
            aa(std::string("--target-psnr ") + asked + " --reference all.exr --stats s.json");
        EXPECT_EQ(result.exit_code, 0) << result.text;
        EXPECT_NE(result.text.find("predicted"), std::string::npos) << result.text;
        const std::size_t at = result.text.find("obtained");
        EXPECT_NE(at, std::string::npos) << result.text;
        EXPECT_NE(read_text(folder / "s.json").find("\"predicted_psnr\""), std::string::npos);
        return std::stod(result.text.substr(at + 8));
    };
    const double low = obtained("36"), high = obtained("46");
    EXPECT_GT(high, low + 3) << "ten decibels more were asked for";
    const Result unreachable = aa("--target-ms 0.001");
    EXPECT_EQ(unreachable.exit_code, 0);
    EXPECT_NE(unreachable.text.find("no lambda of the chart reaches"), std::string::npos);
    for (const char* flags : {"--target-psnr 40 --target-ms 9", "--target-psnr 40 --lambda 1e-4",
             "--target-ms 9 --method uniform", "--target-psnr 40 --m 2", "--chart none.json",
             "--target-psnr 40 --chart none.json"}) {
        const Result result = aa(flags);
        EXPECT_EQ(result.exit_code, 2) << flags << "\n" << result.text;
    }
}

} // namespace
} // namespace ockham::test
