// SPDX-License-Identifier: Apache-2.0
// The compare program as its users run it: results, exit codes, and no file left after an error.
#include "framework/core/file.hpp"
#include "framework/io/image_file.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>

namespace ockham {
namespace {

namespace fs = std::filesystem;

struct Result {
    int exit_code = -1;
    std::string output; // of stdout and stderr
};

class Compare : public testing::Test {
protected:
    Compare()
        : folder_(fs::path(testing::TempDir()) /
                  fmt::format("ockham_compare_{}_{}", ::getpid(),
                      testing::UnitTest::GetInstance()->current_test_info()->name())) {
        fs::create_directories(folder_);
        Image image(16, 8, {"R", "G", "B", "k"});
        for (std::size_t i = 0; i < image.pixels(); ++i) {
            image.plane("R")[i] = static_cast<float>(i) / 127.0f;
            image.plane("k")[i] = static_cast<float>(i % 16 + 1);
        }
        save_image(file("reference.exr"), image);
        image.plane("G")[20] = 4.0f;
        save_image(file("test.exr"), image);
        image.plane("B")[21] = std::numeric_limits<float>::quiet_NaN();
        save_image(file("nan.exr"), image);
        save_image(file("small.exr"), Image(4, 4, {"R", "G", "B"}));
        std::ofstream(file("garbage.exr")) << "no picture";
        before_ = files();
    }
    ~Compare() override { fs::remove_all(folder_); }

    fs::path file(const std::string& leaf) const { return folder_ / leaf; }
    std::size_t files() const {
        return static_cast<std::size_t>(
            std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
    }
    std::size_t files_added() const { return files() - before_; }

    /// Runs the program inside the folder.
    Result run(const std::string& arguments) const {
        const std::string command =
            fmt::format("cd '{}' && '{}' {} 2>&1", folder_.string(), OCKHAM_COMPARE, arguments);
        Result result;
        FILE* pipe = ::popen(command.c_str(), "r");
        if (!pipe) return result;
        for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) {
            result.output += static_cast<char>(c);
        }
        const int status = ::pclose(pipe);
        result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
        return result;
    }

    fs::path folder_;
    std::size_t before_ = 0;
};

TEST_F(Compare, WritesAllItIsAskedFor) {
    const Result result = run("test.exr reference.exr --error-map e.png --flip-map f.png "
                              "--side-by-side s.png --json m.json --heat k=k.png --range 1,16");
    EXPECT_EQ(result.exit_code, 0) << result.output;
    EXPECT_EQ(files_added(), 5u);
    EXPECT_EQ(load_image(file("s.png")).width(), 3 * 16);
    EXPECT_EQ(load_image(file("f.png")).height(), 8);
    const auto json = nlohmann::json::parse(read_text(file("m.json")));
    EXPECT_NEAR(json.at("mse").get<double>(), 1.0 / (3 * 16 * 8), 1e-8);
    EXPECT_TRUE(json.at("hdr").get<bool>());
    EXPECT_GT(json.at("hdr_flip").get<double>(), 0.0);
    EXPECT_EQ(json.at("non_finite").get<int>(), 0);
    // k = 1 is the dark end and k = 16 the light one.
    const Image heat = load_image(file("k.png"));
    EXPECT_LT(heat.at(0, 3, 1), 0.01f);
    EXPECT_GT(heat.at(15, 3, 1), 0.8f);
}

TEST_F(Compare, EqualPicturesHavePsnr999InJson) {
    EXPECT_EQ(run("test.exr test.exr --json m.json").exit_code, 0);
    const auto json = nlohmann::json::parse(read_text(file("m.json")));
    EXPECT_EQ(json.at("psnr").get<double>(), 999.0);
    EXPECT_EQ(json.at("flip").get<double>(), 0.0);
}

TEST_F(Compare, CountsNonFinitePixels) {
    const Result result = run("nan.exr reference.exr --json m.json");
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_NE(result.output.find("1 of 128 pixels of the test picture are NaN or infinite"),
        std::string::npos)
        << result.output;
    const auto json = nlohmann::json::parse(read_text(file("m.json")));
    EXPECT_EQ(json.at("non_finite").get<int>(), 1);
    for (const auto& [key, value] : json.items()) {
        EXPECT_FALSE(value.is_null()) << key << " is not a finite number";
    }
}

TEST_F(Compare, BadInputEndsWithCode2AndNoFile) {
    const std::pair<const char*, const char*> cases[] = {
        {"", "test is required"},
        {"test.exr", "a reference is missing"},
        {"missing.exr reference.exr --json m.json", "cannot open 'missing.exr'"},
        {"garbage.exr reference.exr --json m.json", "cannot read 'garbage.exr' as OpenEXR"},
        {"test.exr small.exr --error-map e.png", "16 x 8 pixels, the reference 4 x 4"},
        {"test.exr nan.exr --json m.json", "1 of 128 pixels of the reference are not finite"},
        {"test.exr reference.jpg --json m.json", "picture files end in .exr or .png"},
        {"test.exr reference.exr --json m.json --error-map e.exr", "only be written as .png"},
        {"test.exr reference.exr --json m.json --error-map no/e.png", "cannot write 'no/e.png'"},
        {"test.exr reference.exr --json /dev/full", "No space left"},
        {"test.exr reference.exr --json .", "it is a folder"},
        {"test.exr reference.exr --json m.json --scale 0", "--scale"},
        {"test.exr --heat z=z.png", "has no channel 'z', only R, G, B, k"},
        {"test.exr --heat k", "expected CHANNEL=FILE.png"},
        {"test.exr --heat k=k.png --range 2,1", "--range"},
        {"test.exr --heat k=k.png --json m.json", "only --heat works without a reference"},
        {"test.exr reference.exr --unknown", "--unknown"},
        {"test.exr reference.exr --json m.json --vmaf --ffmpeg none", "no program 'none'"},
        {"test.exr reference.exr --json m.json --vmaf-model m.pkl", "are for --vmaf"},
        {"test.exr reference.exr --json m.json --onnx none.onnx", "onnx"},
        {"test.exr --heat k=k.png --vmaf", "only --heat works without a reference"},
    };
    for (const auto& [arguments, expected] : cases) {
        const Result result = run(arguments);
        EXPECT_EQ(result.exit_code, 2) << arguments;
        EXPECT_NE(result.output.find(expected), std::string::npos)
            << arguments << "\nsaid: " << result.output;
        EXPECT_EQ(files_added(), 0u) << arguments;
    }
}

} // namespace
} // namespace ockham
