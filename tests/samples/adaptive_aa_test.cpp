// SPDX-License-Identifier: Apache-2.0
// adaptive_aa as a user runs it: outputs, statistics, and one clear error with its exit code for
// everything that can be wrong, leaving no file behind.
#include "framework/core/file.hpp"
#include "framework/io/image_file.hpp"
#include "tests/support/program_test.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <csignal>

namespace ockham {
namespace {

namespace fs = std::filesystem;
using test::Result;

class AdaptiveAaProgram : public test::ProgramTest {
protected:
    AdaptiveAaProgram() : ProgramTest("adaptive_aa") {}
};

TEST_F(AdaptiveAaProgram, writes_picture_statistics_plan_and_captures) {
    const std::string size = " --width 33 --height 21 --m 2 --quiet --validation core ";
    ASSERT_EQ(run("builtin:wires" + size + "--method ssaa -o reference.exr").exit_code, 0);
    const Result result =
        run("builtin:wires" + size +
            "-o out.exr --aov --stats s.json --plan p.json --trace t.json --frames 2 "
            "--capture sample_count=k.png --reference reference.exr");
    ASSERT_EQ(result.exit_code, 0) << result.text;

    const Image picture = load_image(folder / "out.exr");
    EXPECT_EQ(picture.width(), 33);
    EXPECT_EQ(picture.height(), 21);
    for (const char* channel : {"R", "G", "B", "A", "k", "winner", "S.R", "S.G", "S.B", "depth",
             "normal.X", "normal.Y", "normal.Z", "material"}) {
        EXPECT_TRUE(picture.find(channel).has_value()) << channel;
    }
    EXPECT_EQ(picture.metadata.count("ockham.command"), 1u);

    const nlohmann::json stats = nlohmann::json::parse(read_text(folder / "s.json"));
    for (const char* key : {"device", "driver", "command", "commit", "width", "height", "frames",
             "gpu_ms", "total_gpu_ms", "shading_gpu_ms", "wall_ms", "plan", "samples", "image"}) {
        EXPECT_TRUE(stats.contains(key)) << key;
    }
    EXPECT_EQ(stats["frames"], 2);
    std::uint64_t pixels = 0, samples = 0;
    for (std::size_t k = 1; k <= 4; ++k) {
        pixels += stats["samples"]["histogram"][k - 1].get<std::uint64_t>();
        samples += k * stats["samples"]["histogram"][k - 1].get<std::uint64_t>();
    }
    EXPECT_EQ(pixels, 33u * 21u);
    EXPECT_DOUBLE_EQ(
        stats["samples"]["percent"].get<double>(), 100.0 * double(samples) / (4.0 * 33 * 21));
    EXPECT_GT(stats["image"]["psnr"].get<double>(), 20.0);
    double sum = 0;
    for (const auto& [pass, time] : stats["gpu_ms"].items()) {
        EXPECT_GT(time["median"].get<double>(), 0.0) << pass;
        sum += time["max"].get<double>();
    }
    EXPECT_LE(stats["total_gpu_ms"].get<double>(), sum);

    const nlohmann::json trace = nlohmann::json::parse(read_text(folder / "t.json"));
    const auto& events = trace["traceEvents"];
    const auto passes = std::count_if(
        events.begin(), events.end(), [](const auto& event) { return event["ph"] == "X"; });
    EXPECT_EQ(static_cast<std::size_t>(passes), 2 * stats["gpu_ms"].size());

    const nlohmann::json plan = nlohmann::json::parse(read_text(folder / "p.json"));
    for (const char* list : {"passes", "resources", "barriers"})
        EXPECT_FALSE(plan[list].empty()) << list;
    for (const auto& pass : plan["passes"]) EXPECT_FALSE(pass["reason"].get<std::string>().empty());
}

TEST_F(AdaptiveAaProgram, flags_and_scenes_come_in_any_order) {
    const Result result =
        run("--m 2 builtin:wires --width 8 builtin:sky --height 6 --quiet -o a.exr");
    EXPECT_EQ(result.exit_code, 0) << result.text;
    EXPECT_EQ(load_image(folder / "a.exr").width(), 8);
}

TEST_F(AdaptiveAaProgram, reports_999_for_equal_pictures) {
    const std::string common = "builtin:sky --width 8 --height 8 --quiet ";
    ASSERT_EQ(run(common + "-o a.exr").exit_code, 0);
    ASSERT_EQ(run(common + "--reference a.exr --stats s.json --frames 1").exit_code, 0);
    EXPECT_EQ(nlohmann::json::parse(read_text(folder / "s.json"))["image"]["psnr"], 999.0);
}

TEST_F(AdaptiveAaProgram, run_files_repeat_a_run) {
    ASSERT_EQ(run("builtin:wires --width 20 --height 12 --m 3 --method uniform --k 5 --dump-config "
                  "c.json")
                  .exit_code,
        0);
    ASSERT_EQ(run("--config c.json --quiet -o a.exr").exit_code, 0);
    ASSERT_EQ(
        run("builtin:wires --width 20 --height 12 --m 3 --method uniform --k 5 --quiet -o b.exr")
            .exit_code,
        0);
    const Image a = load_image(folder / "a.exr"), b = load_image(folder / "b.exr");
    ASSERT_EQ(a.pixels(), 240u);
    for (int c = 0; c < 4; ++c) {
        EXPECT_TRUE(std::equal(a.plane(c).begin(), a.plane(c).end(), b.plane(c).begin()));
    }
}

TEST_F(AdaptiveAaProgram, moving_cameras_number_their_pictures_and_measure_each) {
    write_text(folder / "path.json", R"({"keys": [{"camera": "0,1.7,4 0,1.7,0 60"},
        {"camera": "0.1,1.7,4 0.1,1.7,0 60"}]})");
    const std::string wires = "builtin:wires --width 33 --height 21 --m 2 --history off --quiet ";
    const std::string moving = wires + "--camera-path path.json --frames 3 ";
    ASSERT_EQ(run(moving + "--method ssaa -o all%d.exr").exit_code, 0);
    const Result result = run(moving + "-o out%d.exr --reference all%d.exr --stats s.json");
    ASSERT_EQ(result.exit_code, 0) << result.text;
    EXPECT_FALSE(fs::exists(folder / "out3.exr"));
    const nlohmann::json sequence = nlohmann::json::parse(read_text(folder / "s.json"))["sequence"];
    ASSERT_EQ(sequence["frames"].size(), 3u);
    EXPECT_GT(sequence["flicker"].get<double>(), 0.0);
    EXPECT_GT(sequence["psnr"].get<double>(), 20.0);
    EXPECT_LT(sequence["percent"].get<double>(), 100.0);
    EXPECT_FALSE(sequence["frames"][0].contains("counts_changed"));
    EXPECT_GT(sequence["frames"][1]["counts_changed"].get<double>(), 0.0);

    // The frames are those of runs of their own; a path without --frames shows its keys.
    ASSERT_EQ(run(moving + "--method ssaa --reference all%d.exr --stats same.json").exit_code, 0);
    EXPECT_EQ(nlohmann::json::parse(read_text(folder / "same.json"))["sequence"]["flicker"], 0.0);
    ASSERT_EQ(run(wires + "--camera '0.1,1.7,4 0.1,1.7,0 60' -o last.exr").exit_code, 0);
    ASSERT_EQ(run(wires + "--camera-path path.json -o key%d.exr").exit_code, 0);
    EXPECT_FALSE(fs::exists(folder / "key2.exr"));
    ASSERT_EQ(run(wires + "--turntable 2 -o turn%d.exr").exit_code, 0);
    const auto same = [&](const char* a, const char* b) {
        const Image x = load_image(folder / a), y = load_image(folder / b);
        return std::equal(x.plane(1).begin(), x.plane(1).end(), y.plane(1).begin());
    };
    EXPECT_TRUE(same("last.exr", "out2.exr"));
    EXPECT_TRUE(same("key1.exr", "out2.exr"));
    EXPECT_TRUE(same("turn0.exr", "out0.exr"));
    EXPECT_FALSE(same("turn0.exr", "turn1.exr"));

    expect_error(moving + "-o one.exr", 2, {"one.exr", "3 pictures"});
    expect_error(moving + "--reference all0.exr", 2, {"all0.exr", "3"});
    expect_error(moving + "--turntable 2 -o t%d.exr", 2, {"--camera-path", "--turntable"});
}

TEST_F(AdaptiveAaProgram, bad_input_is_one_error_with_exit_code_2) {
    write_text(folder / "garbage.gltf", "garbage");
    write_text(folder / "garbage.exr", "garbage");
    write_text(folder / "list.json", "[1]");
    expect_error("missing.gltf -o out.exr", 2, {"missing.gltf", "No such file"});
    expect_error("garbage.gltf -o out.exr", 2, {"garbage.gltf"});
    expect_error("builtin:nothing -o out.exr", 2, {"nothing", "atrium"});
    expect_error("--wrong", 2, {"--wrong", "--help"});
    expect_error("--m 0 -o out.exr", 2, {"--m", "'0'", "1 to 8"});
    expect_error("--m nine", 2, {"--m", "nine"});
    expect_error("--m 2 --m 3", 2, {"--m"});
    expect_error("--width 0 --height 0", 2, {"--width", "'0'"});
    expect_error("builtin:sky --m 2 --method uniform --k 5", 2, {"k = 5", "1 to 4"});
    expect_error("builtin:sky --preset paper --m 5", 2, {"m = 5"});
    expect_error("builtin:sky -o no/such/folder.exr", 2, {"no/such/folder.exr"});
    expect_error("builtin:sky -o out.jpg", 2, {"out.jpg", ".exr"});
    expect_error("builtin:sky --stats no/such/s.json", 2, {"no/such/s.json"});
    expect_error("builtin:sky --plan plan.svg", 2, {"plan.svg", ".dot"});
    expect_error("builtin:sky --capture nothing=x.exr", 2, {"nothing"});
    expect_error("builtin:sky --capture nothing", 2, {"NAME=FILE"});
    expect_error("builtin:sky --aov -o out.png", 2, {"--aov", "out.png"});
    expect_error("builtin:sky --reference garbage.exr", 2, {"garbage.exr"});
    expect_error("builtin:sky -o same.exr --stats same.exr", 2, {"same.exr", "two outputs"});
    expect_error("builtin:sky --rig list.json", 2, {"list.json"});
    expect_error("builtin:sky --config list.json", 2, {"list.json"});
    expect_error("builtin:sky --camera nobody", 2, {"--camera", "nobody"});
    expect_error("builtin:sky --camera '0,0,0 0,0,0 60'", 2, {"--camera"});
    expect_error("builtin:sky --environment blue", 2, {"--environment", "blue"});
    expect_error(
        "builtin:wires --gbuffer packed --width 16000 --height 4 --m 4", 2, {"64000", "16"});
}

/// Puts `to` in place of the first `from` in a file; its line, as compilers name it.
std::string replace_in(const fs::path& file, const std::string& from, const std::string& to) {
    std::string text = read_text(file);
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << file << ": " << from;
    if (at == std::string::npos) return "";
    write_text(file, text.replace(at, from.size(), to));
    const auto line = 1 + std::count(text.begin(), text.begin() + std::ptrdiff_t(at), '\n');
    return file.filename().string() + ":" + std::to_string(line);
}

const std::string kStore = "imageStore(radiance, pixel, mean);"; // of surface/resolve.comp

TEST_F(AdaptiveAaProgram, shader_dir_stands_in_for_built_in_shaders) {
    const std::string common = "builtin:wires --m 2 --width 17 --height 9 --validation core ";
    const auto picture = [&](const std::string& flags) {
        const Result result = run(common + flags + " -o out.exr");
        EXPECT_EQ(result.exit_code, 0) << result.text;
        return std::pair(load_image(folder / "out.exr"), result.text);
    };
    const auto equal = [](const Image& a, const Image& b) {
        for (int c = 0; c < 4; ++c) {
            if (!std::ranges::equal(a.plane(c), b.plane(c))) return false;
        }
        return true;
    };
    const auto [built_in, no_text] = picture("");
    fs::copy(OCKHAM_SHADERS, folder / "glsl", fs::copy_options::recursive);
    const auto [same, same_text] = picture("--shader-dir glsl");
    EXPECT_TRUE(equal(same, built_in));
    EXPECT_EQ(same_text.find("reloaded"), std::string::npos) << same_text;

    const fs::path resolve = folder / "glsl/surface/resolve.comp";
    replace_in(resolve, kStore, "imageStore(radiance, pixel, vec4(0.25, 0.5, 2.0, 1.0));");
    const auto [constant, constant_text] = picture("--shader-dir glsl");
    EXPECT_NE(constant_text.find("reloaded shaders: surface/resolve.comp\n"), std::string::npos)
        << constant_text;
    const float expected[] = {0.25f, 0.5f, 2.0f, 1.0f};
    for (int c = 0; c < 4; ++c) {
        const auto plane = constant.plane(c);
        EXPECT_EQ(std::ranges::count(plane, expected[c]), 17 * 9) << c;
    }

    const std::string line = replace_in(resolve, "imageStore(", "nothing(");
    const auto [broken, broken_text] = picture("--shader-dir glsl");
    EXPECT_TRUE(equal(broken, built_in));
    EXPECT_NE(broken_text.find("\nglsl/surface/" + line + ": 'nothing'"), std::string::npos)
        << broken_text;

    expect_error(common + "--shader-dir missing -o none.exr", 2, {"'missing'", "no such folder"});
    expect_error(common + "--shader-dir out.exr -o none.exr", 2, {"'out.exr'", "no folder"});
}

TEST_F(AdaptiveAaProgram, shader_dir_is_watched_between_frames) {
    fs::copy(OCKHAM_SHADERS, folder / "glsl", fs::copy_options::recursive);
    const fs::path resolve = folder / "glsl/surface/resolve.comp";
    const std::string line = replace_in(resolve, kStore, "nothing;");
    const std::string command = "cd '" + folder.string() +
                                "' && echo $$ && exec '" OCKHAM_BIN
                                "/adaptive_aa' builtin:sky --m 2 --width 8 --height 8 "
                                "--frames 1000000 --shader-dir glsl 2>&1";
    FILE* const pipe = ::popen(command.c_str(), "r");
    ASSERT_NE(pipe, nullptr);
    char buffer[4096];
    ASSERT_NE(std::fgets(buffer, sizeof buffer, pipe), nullptr);
    const pid_t program = std::stoi(buffer);
    std::string text;
    const auto wait_for = [&](const std::string& part) {
        while (text.find(part) == std::string::npos) {
            if (std::fgets(buffer, sizeof buffer, pipe) == nullptr) return false;
            text += buffer;
        }
        return true;
    };
    // Broken at first, mended while it runs: no frame waits for the test, nor the test for a clock.
    EXPECT_TRUE(wait_for(line + ": 'nothing'")) << text;
    replace_in(resolve, "nothing;", kStore);
    EXPECT_TRUE(wait_for("reloaded shaders: surface/resolve.comp")) << text;
    ::kill(program, SIGINT);
    const int status = ::pclose(pipe);
    EXPECT_EQ(WIFEXITED(status) ? WEXITSTATUS(status) : -1, 130) << text;
}

TEST_F(AdaptiveAaProgram, wrong_size_of_reference_is_refused) {
    ASSERT_EQ(run("builtin:sky --width 4 --height 4 --quiet -o small.exr").exit_code, 0);
    expect_error("builtin:sky --width 8 --height 8 --reference small.exr -o out.exr --plan p.json",
        2, {"8 x 8", "4 x 4"});
}

TEST_F(AdaptiveAaProgram, full_disk_is_an_error_and_leaves_nothing) {
    expect_error(
        "builtin:sky --width 64 --height 64 --stats /dev/full --frames 1", 2, {"/dev/full"});
    const std::set<std::string> before = files();
    const Result limited = run("builtin:sky --width 64 --height 64 -o out.exr", "ulimit -f 1;");
    EXPECT_EQ(limited.exit_code, 2) << limited.text;
    EXPECT_EQ(files(), before);
}

TEST_F(AdaptiveAaProgram, missing_device_or_memory_is_exit_code_3) {
    expect_error("builtin:sky -o out.exr", 3, {"Vulkan"},
        "VK_DRIVER_FILES=/nonexistent.json VK_ICD_FILENAMES=/nonexistent.json");
    expect_error("builtin:sky --gpu nothing", 3, {"--gpu 'nothing'"});
    expect_error("builtin:wires --memory-budget 8 -o out.exr", 3, {"budget"});
    // Who holds what, and what the graph needs from which pass to which.
    const std::vector<std::string> table{"raise --memory-budget",
        "\nIn use on the device:\n      64.000 MiB  shadow_map               for the device "
        "alone\n",
        "MiB  vertices  ", "\ngraph 'adaptive_aa' needs ", "the largest:\n",
        "MiB  gbuffer                  kept: used from 'gbuffer' to 'shade'\n",
        "       3.000 MiB  radiance                 kept: used by 'resolve'; exported (the "
        "picture)\n",
        " smaller\n"};
    const std::string picture =
        "builtin:wires --width 512 --height 384 -o out.exr --memory-budget ";
    expect_error(picture + "90 --gbuffer packed", 3, table);
    expect_error(picture + "66 --budget 50", 3, table); // which no screen tiles are drawn with
}

TEST_F(AdaptiveAaProgram, help_version_and_devices) {
    const Result help = run("--help");
    EXPECT_EQ(help.exit_code, 0);
    for (const char* flag : {"--m", "--method", "--stall", "--c-depth", "60 at 4 x 4"}) {
        EXPECT_NE(help.text.find(flag), std::string::npos) << flag;
    }
    EXPECT_EQ(run("--version").text.rfind("Ockham 0.", 0), 0u);
    const Result gpus = run("--list-gpus");
    EXPECT_EQ(gpus.exit_code, 0);
    EXPECT_NE(gpus.text.find("score"), std::string::npos);
}

TEST_F(AdaptiveAaProgram, table_has_a_row_per_method_and_width) {
    const Result result =
        run("builtin:wires --width 32 --height 24 --m-max 2 --stall 16 --repeats 1 --quiet --out t",
            "", "aa_table");
    ASSERT_EQ(result.exit_code, 0) << result.text;
    const std::string csv = read_text(folder / "t.csv");
    EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 5) << csv;
    const std::string table = read_text(folder / "t.md");
    for (const char* row :
        {"| 2x2 | Adaptive, as the paper, buckets |", "| 2x2 | Adaptive, buckets |"})
        EXPECT_NE(table.find(row), std::string::npos) << table;
}

} // namespace
} // namespace ockham
