// SPDX-License-Identifier: Apache-2.0
// volume_gi as a user runs it: every mode end to end on a small volume, equal bits for equal seeds
// and across interruptions, statistics, and one clear error for everything that can be wrong.
#include "framework/app/checkpoint.hpp"
#include "framework/core/file.hpp"
#include "framework/io/image_file.hpp"
#include "tests/support/program_test.hpp"
#include "tests/support/z_test.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <sstream>

namespace ockham {
namespace {

namespace fs = std::filesystem;
using test::Result;

const char* const kModes[] = {
    "--mode path", "--mode noncaching", "--mode caching", "--mode caching --gather off"};

class VolumeGiProgram : public test::ProgramTest {
protected:
    VolumeGiProgram() : ProgramTest("volume_gi") {
        // A fuzzy ball of 16^3 voxels, 255 in the middle and 0 at the border.
        std::string voxels;
        for (int z = 0; z < 16; ++z)
            for (int y = 0; y < 16; ++y)
                for (int x = 0; x < 16; ++x) {
                    const double r = std::hypot(x - 7.5, y - 7.5, z - 7.5) / 7.5;
                    voxels += static_cast<char>(std::lround(255 * std::clamp(1.2 - r, 0.0, 1.0)));
                }
        write_text(folder / "ball.raw", voxels);
        write_text(folder / "ball.json",
            R"({"file": "ball.raw", "dims": [16, 16, 16], "type": "uint8", "spacing_mm": [1, 1, 1]})");
        write_text(folder / "thin.json",
            R"({"points": [{"value": 0, "opacity": 0}, {"value": 255, "opacity": 1}]})");
    }

    /// A run of the ball that takes no arguments but these, and must succeed.
    std::string render(const std::string& arguments) {
        const Result result = run("ball.json --transfer thin.json --density-scale 8 --width 16 "
                                  "--height 16 --camera '0,-2.6,0 0,0,0 30' --validation core "
                                  "--quiet " +
                                  arguments);
        EXPECT_EQ(result.exit_code, 0) << arguments << "\n" << result.text;
        return result.text;
    }

    Image picture(const std::string& arguments) {
        render(arguments + " -o picture.exr");
        return load_image(folder / "picture.exr");
    }

    nlohmann::json json(const std::string& name) {
        return nlohmann::json::parse(read_text(folder / name));
    }
};

bool equal(const Image& a, const Image& b) {
    if (a.channels() != b.channels() || a.pixels() != b.pixels()) return false;
    for (std::size_t c = 0; c < a.channels().size(); ++c)
        if (!std::ranges::equal(a.plane(static_cast<int>(c)), b.plane(static_cast<int>(c))))
            return false;
    return true;
}

TEST_F(VolumeGiProgram, writes_picture_statistics_plan_and_captures) {
    ASSERT_NE(render("--mode path --steps 8 -o reference.exr --explain").find("path_trace"),
        std::string::npos);
    render("--mode path --steps 4 --seed 2 -o out.exr --stats s.json --plan p.json --trace t.json "
           "--capture path_sum=sum.exr --reference reference.exr");
    const Image out = load_image(folder / "out.exr"), sum = load_image(folder / "sum.exr");
    EXPECT_EQ(out.width(), 16);
    EXPECT_EQ(out.metadata.count("ockham.command"), 1u);
    EXPECT_NEAR(sum.at(8, 8, 0), 4 * out.at(8, 8, 0), 1e-5f);

    const nlohmann::json stats = json("s.json");
    for (const char* key : {"device", "driver", "command", "commit", "width", "height", "frames",
             "gpu_ms", "total_gpu_ms", "wall_ms", "plan", "volume", "image"}) {
        EXPECT_TRUE(stats.contains(key)) << key;
    }
    const nlohmann::json& volume = stats["volume"];
    EXPECT_EQ(volume["mode"], "path");
    EXPECT_EQ(volume["paths"], 16 * 16 * 4);
    EXPECT_GT(volume["steps"].get<int>(), 1000);
    EXPECT_EQ(volume["truncated"], 0);
    EXPECT_EQ(volume["resumed"], 0);
    EXPECT_EQ(volume["cells"], 0);
    EXPECT_EQ(volume["majorant_cells"], 8);
    EXPECT_GT(volume["mean_variance"].get<double>(), 0.0);
    EXPECT_EQ(stats["frames"], 3) << "the first compiles kernels";

    std::set<std::string> passes;
    const nlohmann::json plan = json("p.json");
    for (const nlohmann::json& pass : plan["passes"]) passes.insert(pass["name"]);
    for (const char* pass : {"ranges", "majorants", "path_trace", "path_mean"})
        EXPECT_TRUE(passes.contains(pass)) << pass;
    EXPECT_FALSE(json("t.json")["traceEvents"].empty());
}

TEST_F(VolumeGiProgram, equal_seeds_give_equal_pictures_in_every_mode) {
    for (const std::string mode : kModes) {
        const Image a = picture(mode + " --steps 3 --iso 200 --seed 5");
        EXPECT_TRUE(equal(a, picture(mode + " --steps 3 --iso 200 --seed 5"))) << mode;
        EXPECT_FALSE(equal(a, picture(mode + " --steps 3 --iso 200 --seed 6"))) << mode;
    }
}

TEST_F(VolumeGiProgram, path_and_noncaching_agree_without_surfaces) {
    // Mean and variance of each pixel from its sums; seeds differ, so pixels are independent.
    const int steps = 256;
    struct Sums {
        Image sum, square;
    };
    const auto sums = [&](const std::string& mode) {
        render("--mode " + mode + " --sampler independent --albedo 0.8 --steps " +
               std::to_string(steps) + " --capture path_sum=a.exr --capture path_square=b.exr");
        return Sums{load_image(folder / "a.exr"), load_image(folder / "b.exr")};
    };
    const Sums path = sums("path --seed 1"), noncaching = sums("noncaching --seed 2");
    const auto moments = [&](const Sums& s, std::size_t i) {
        const double mean =
            (0.2126 * s.sum.plane(0)[i] + 0.7152 * s.sum.plane(1)[i] + 0.0722 * s.sum.plane(2)[i]) /
            steps;
        return std::pair(mean, (s.square.plane(0)[i] / steps - mean * mean) / (steps - 1));
    };
    std::vector<double> p; // of Welch's test, by the normal distribution: 256 samples are many
    for (std::size_t i = 0; i < path.sum.pixels(); ++i) {
        const auto [m1, v1] = moments(path, i);
        const auto [m2, v2] = moments(noncaching, i);
        if (v1 + v2 < 1e-6 * m1 * m1) continue; // beside the ball, but for rounding
        p.push_back(std::erfc(std::abs(m1 - m2) / std::sqrt(2 * (v1 + v2))));
    }
    EXPECT_GT(p.size(), 100u);
    EXPECT_LT(test::distance_from_uniform(p), test::kolmogorov_limit(p.size()));
}

TEST_F(VolumeGiProgram, a_white_world_is_white_through_every_mode) {
    for (const std::string mode : kModes) {
        const Image image = picture(mode + " --steps 9 --albedo 1 --environment 1,1,1 "
                                           "--cache-format fp32");
        for (int channel = 0; channel < 3; ++channel)
            for (const float value : image.plane(channel)) ASSERT_NEAR(value, 1.0f, 1e-3f) << mode;
    }
}

TEST_F(VolumeGiProgram, resumed_runs_equal_unbroken_ones) {
    for (const std::string mode : {"--mode path --iso 220", "--mode caching"}) {
        const Image whole = picture(mode + " --steps 8");
        render(mode + " --steps 4 --checkpoint half.check");
        EXPECT_TRUE(equal(whole, picture(mode + " --steps 8 --resume half.check"))) << mode;
    }
}

TEST_F(VolumeGiProgram, a_finished_run_resumed_gives_its_picture_again) {
    for (const std::string mode : {"--mode path", "--mode caching --gather off"}) {
        const Image whole = picture(mode + " --steps 2 --checkpoint done.check");
        EXPECT_TRUE(equal(whole, picture(mode + " --steps 2 --resume done.check"))) << mode;
    }
}

TEST_F(VolumeGiProgram, killed_runs_go_on_from_their_checkpoint) {
    const std::string ball = "ball.json --transfer thin.json --density-scale 8 --width 16 "
                             "--height 16 --camera '0,-2.6,0 0,0,0 30' --quiet --mode caching ";
    const pid_t shell = ::fork();
    if (shell == 0) {
        const std::string text = "cd '" + folder.string() +
                                 "' && exec '" OCKHAM_BIN "/volume_gi' " + ball +
                                 "--steps 1000000 --checkpoint c --checkpoint-interval 0";
        ::execl("/bin/sh", "sh", "-c", text.c_str(), nullptr);
        ::_exit(127);
    }
    // Killed in the middle of whatever it does, once a few checkpoints have replaced each other.
    const auto identity = [&] {
        return fs::exists(folder / "c") ? fs::file_size(folder / "c") : 0;
    };
    while (identity() == 0 && ::waitpid(shell, nullptr, WNOHANG) == 0) ::usleep(20000);
    ::usleep(300000);
    ::kill(shell, SIGKILL);
    int status = 0;
    ASSERT_EQ(::waitpid(shell, &status, 0), shell);
    ASSERT_TRUE(WIFSIGNALED(status));

    const std::string bytes = read_text(folder / "c");
    const std::size_t begin = bytes.find('{');
    const std::size_t at = bytes.find("\"steps\":", begin);
    ASSERT_NE(at, std::string::npos);
    const int steps = std::stoi(bytes.substr(at + 8));
    ASSERT_GE(steps, 1);
    const std::string to = " --mode caching --steps " + std::to_string(steps + 3);
    // Validation and checkpoints decide nothing.
    const Image resumed = picture(to + " --resume c");
    EXPECT_TRUE(equal(picture(to), resumed)) << "killed after " << steps << " steps";
}

TEST_F(VolumeGiProgram, checkpoints_of_other_runs_are_refused) {
    render("--mode path --steps 2 --checkpoint c");
    const std::string same = "ball.json --transfer thin.json --density-scale 8 --width 16 "
                             "--height 16 --camera '0,-2.6,0 0,0,0 30' --mode path --resume ";
    EXPECT_EQ(run(same + "c --steps 3").exit_code, 0);
    expect_error(same + "c --albedo 0.5", 2, {"'c'", "--albedo is 1.0 there and 0.5 here"});
    expect_error(same + "c --seed 7", 2, {"--seed is 1 there and 7 here"});
    std::string bytes = read_text(folder / "c");
    write_text(folder / "cut", bytes.substr(0, bytes.size() - 1));
    expect_error(same + "cut", 2, {"'cut'", "cut off"});
    bytes[bytes.size() - 5] ^= 1;
    write_text(folder / "changed", bytes);
    expect_error(same + "changed", 2, {"'changed'", "not those that were written"});
    expect_error(same + "ball.json", 2, {"'ball.json'", "no checkpoint"});
    expect_error(same + "nothing", 2, {"'nothing'", "No such file"});
    std::string voxels = read_text(folder / "ball.raw");
    voxels[2000] = static_cast<char>(voxels[2000] + 1);
    write_text(folder / "ball.raw", voxels);
    expect_error(same + "c", 2, {"volume is"});
}

TEST_F(VolumeGiProgram, an_interrupt_writes_the_checkpoint) {
    const std::string line = "cd '" + folder.string() +
                             "' && echo $$ && exec '" OCKHAM_BIN
                             "/volume_gi' ball.json --width 16 --height 16 --mode path --steps "
                             "1000000 --checkpoint c --checkpoint-interval 0 --quiet 2>&1";
    FILE* const pipe = ::popen(line.c_str(), "r");
    ASSERT_NE(pipe, nullptr);
    char buffer[4096];
    ASSERT_NE(std::fgets(buffer, sizeof buffer, pipe), nullptr);
    const pid_t program = std::stoi(buffer);
    for (int i = 0; i < 3000 && !fs::exists(folder / "c"); ++i) ::usleep(20000);
    ASSERT_TRUE(fs::exists(folder / "c"));
    fs::remove(folder / "c");
    ::kill(program, SIGINT);
    const int status = ::pclose(pipe);
    EXPECT_EQ(WIFEXITED(status) ? WEXITSTATUS(status) : -1, 130);
    EXPECT_TRUE(fs::exists(folder / "c"));
}

TEST_F(VolumeGiProgram, convergence_is_a_table) {
    render("--mode path --steps 64 --seed 3 -o reference.exr");
    render("--mode path --steps 20 --convergence c.csv --reference reference.exr");
    std::istringstream csv(read_text(folder / "c.csv"));
    std::string line;
    std::getline(csv, line);
    EXPECT_EQ(line, "seconds,steps,paths,psnr,ssim,flip");
    std::vector<double> steps, psnr;
    double before = 0;
    while (std::getline(csv, line)) {
        std::replace(line.begin(), line.end(), ',', ' ');
        std::istringstream row(line);
        double seconds = 0, step = 0, paths = 0, decibel = 0, ssim = 0, flip = 0;
        row >> seconds >> step >> paths >> decibel >> ssim >> flip;
        ASSERT_TRUE(row) << line;
        EXPECT_GT(seconds, before);
        EXPECT_EQ(paths, 256 * step);
        before = seconds;
        steps.push_back(step);
        psnr.push_back(decibel);
    }
    EXPECT_EQ(steps, (std::vector<double>{1, 2, 4, 8, 16, 20}));
    EXPECT_GT(psnr.back(), psnr.front() + 5);

    // A resumed run goes on with the table, whose rows of sums only grow in every mode.
    const std::string caching = "--mode caching --convergence c.csv --reference reference.exr ";
    render(caching + "--steps 4 --checkpoint c");
    render(caching + "--steps 16 --resume c");
    const std::string table = read_text(folder / "c.csv");
    EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 6) << table;
    double paths_before = 0;
    std::istringstream rows(table.substr(table.find('\n') + 1));
    while (std::getline(rows, line)) {
        const double paths = std::stod(line.substr(line.find(',', line.find(',') + 1) + 1));
        EXPECT_GT(paths, paths_before) << table;
        paths_before = paths;
    }
}

TEST_F(VolumeGiProgram, stops_at_its_target_error) {
    render("--mode path --target-error 0.05 --stats s.json");
    const nlohmann::json volume = json("s.json")["volume"];
    const double steps = volume["paths"].get<double>() / 256;
    EXPECT_GE(steps, 4);
    EXPECT_LE(steps, 4096);
    render("--mode path --target-error 0.025 --stats s.json");
    const double more = json("s.json")["volume"]["paths"].get<double>() / 256;
    EXPECT_GT(more, 2.5 * steps) << "errors fall with the root of the samples, or faster by Sobol";
    EXPECT_LT(more, 6 * steps);
}

TEST_F(VolumeGiProgram, chooses_by_a_chart_and_says_what_it_predicted_and_got) {
    render("--mode path --steps 512 --seed 3 -o reference.exr");
    const auto choice = [&](const char* flags) {
        render(std::string(flags) + " --reference reference.exr --stats s.json");
        return json("s.json");
    };
    const nlohmann::json low = choice("--target-psnr 24"), high = choice("--target-psnr 34");
    EXPECT_GT(high["image"]["psnr"].get<double>(), low["image"]["psnr"].get<double>() + 3)
        << "ten decibels more were asked for";
    EXPECT_GT(high["choice"]["steps"], low["choice"]["steps"]);
    EXPECT_NEAR(high["choice"]["predicted_psnr"].get<double>(), 34, 2);
    EXPECT_FALSE(choice("--target-ms 0.0001")["choice"]["reached"].get<bool>());
    for (const char* flags : {"--target-psnr 40 --target-ms 9", "--target-psnr 40 --mode path",
             "--target-ms 9 --steps 4", "--target-ms 9 --gather off", "--chart none.json",
             "--target-ms 9 --turntable 2 -o %d.png", "--target-psnr 40 --chart none.json"})
        expect_error(std::string("ball.json ") + flags, 2, {});
}

TEST_F(VolumeGiProgram, turntables_go_around) {
    for (const std::string mode : {"--mode path", "--mode auto"}) {
        render(mode + " --steps 2 --turntable 4 -o turn%02d.exr");
        ASSERT_TRUE(fs::exists(folder / "turn03.exr"));
        EXPECT_FALSE(fs::exists(folder / "turn04.exr"));
        const Image first = load_image(folder / "turn00.exr");
        EXPECT_FALSE(equal(first, load_image(folder / "turn02.exr"))) << mode;
        if (mode == "--mode path") {
            EXPECT_TRUE(equal(first, picture("--mode path --steps 2")));
        }
    }
    const Result result = run("ball.json --turntable 2 --steps 1 --width 8 --height 8");
    EXPECT_NE(result.text.find("--mode auto: caching"), std::string::npos) << result.text;
    expect_error("ball.json --turntable 2 -o one.png", 2, {"one.png", "2 pictures"});
}

TEST_F(VolumeGiProgram, camera_paths_go_from_key_to_key) {
    write_text(folder / "path.json", R"({"keys": [{"camera": "0,-2.6,0 0,0,0 30"},
        {"camera": "2.6,0,0 0,0,0 30"}, {"camera": "2.6,0,1 0,0,0 40"}]})");
    const std::string common = "ball.json --transfer thin.json --density-scale 8 --width 16 "
                               "--height 16 --mode path --steps 2 --quiet --camera-path path.json ";
    ASSERT_EQ(run(common + "-o key%d.exr").exit_code, 0);
    ASSERT_EQ(run(common + "--frames 5 -o all%d.exr").exit_code, 0);
    ASSERT_TRUE(fs::exists(folder / "key2.exr"));
    EXPECT_FALSE(fs::exists(folder / "key3.exr"));
    for (int key = 0; key < 3; ++key) {
        const auto load = [&](const char* name, int i) {
            return load_image(folder / (name + std::to_string(i) + ".exr"));
        };
        EXPECT_TRUE(equal(load("key", key), load("all", 2 * key))) << key;
    }
    EXPECT_TRUE(equal(load_image(folder / "key0.exr"), picture("--mode path --steps 2")));
}

TEST_F(VolumeGiProgram, isovalues_move_from_picture_to_picture) {
    for (const std::string mode : {"--mode path", "--mode caching --gather off"}) {
        const std::string flags = mode + " --turntable 3 --steps 8 --iso-to 140 --iso ";
        render(flags + "220 -o a%d.exr");
        render(flags + "200 -o b%d.exr");
        const auto load = [&](const char* name) { return load_image(folder / name); };
        EXPECT_FALSE(equal(load("a0.exr"), load("b0.exr"))) << mode;
        EXPECT_FALSE(equal(load("a1.exr"), load("b1.exr"))) << mode;
        EXPECT_TRUE(equal(load("a2.exr"), load("b2.exr"))) << mode;
    }
}

TEST_F(VolumeGiProgram, checkpoints_are_of_content_not_of_names) {
    render("--mode path --steps 2 --checkpoint c");
    const Image whole = picture("--mode path --steps 4");
    fs::copy(folder / "ball.json", folder / "other.json");
    fs::copy(folder / "thin.json", folder / "thinner.json");
    const Result result = run("other.json --transfer thinner.json --density-scale 8 --width 16 "
                              "--height 16 --camera '0,-2.6,0 0,0,0 30' --mode auto "
                              "--target-error 0.001 --steps 4 --resume c -o again.exr --quiet");
    ASSERT_EQ(result.exit_code, 0) << result.text;
    EXPECT_TRUE(equal(whole, load_image(folder / "again.exr")));
}

TEST_F(VolumeGiProgram, run_files_repeat_a_run) {
    const std::string flags = "--mode caching --cache-scale 4 --cache-format rgb9e5 --gather off "
                              "--phase-g 0.5 --crop 0,1,0,0.5,0,1 --steps 2 ";
    const Image direct = picture(flags);
    render(flags + "--dump-config c.json");
    const Result result = run("--config c.json -o again.exr --quiet");
    ASSERT_EQ(result.exit_code, 0) << result.text;
    EXPECT_TRUE(equal(direct, load_image(folder / "again.exr")));
}

TEST_F(VolumeGiProgram, explains_what_it_leaves_out) {
    const std::string path = render("--mode path --steps 1 --explain");
    for (const char* text : {"the transfer function emits nothing", "the environment is one colour",
             "--mode path: every path finds its own light", "free flights are drawn by"}) {
        EXPECT_NE(path.find(text), std::string::npos) << text << "\n" << path;
    }
    const std::string composed = render("--mode caching --gather off --steps 1 --explain");
    EXPECT_NE(composed.find("--gather off"), std::string::npos);
    EXPECT_NE(composed.find("only cells that composition may read hold memory"), std::string::npos);
}

TEST_F(VolumeGiProgram, surface_depth_can_be_captured_in_every_mode) {
    for (const std::string mode : kModes) {
        render(mode + " --iso 200 --steps 1 --capture surface_depth=d.exr");
        const Image depth = load_image(folder / "d.exr");
        EXPECT_EQ(depth.at(8, 8, 1), 1.0f) << mode;
        EXPECT_EQ(depth.at(0, 0, 1), 0.0f) << mode;
    }
}

TEST_F(VolumeGiProgram, bad_input_is_one_error_with_exit_code_2) {
    write_text(folder / "list.json", "[1]");
    write_text(folder / "shine.json", R"({"roughness": 2})");
    write_text(folder / "two.json", R"({"surfaces": [{}, {}]})");
    expect_error("missing.nrrd", 2, {"missing.nrrd"});
    expect_error("builtin:nothing", 2, {"nothing", "cloud"});
    expect_error("ball.json ball.json", 2, {"2 volumes", "expected one"});
    expect_error("ball.json --wrong", 2, {"--wrong", "--help"});
    expect_error("ball.json --mode fast", 2, {"--mode", "'fast'", "noncaching"});
    expect_error("ball.json --cache-scale 3", 2, {"--cache-scale", "'3'", "1, 2, 4"});
    expect_error("ball.json --albedo 2", 2, {"--albedo", "'2'", "0 to 1"});
    expect_error("ball.json --light 1,0,0", 2, {"--light", "'1,0,0'", "dx,dy,dz r,g,b"});
    expect_error("ball.json --light '0,0,0 1,1,1'", 2, {"--light", "no length"});
    expect_error("ball.json --light '0,0,1 1,-1,1'", 2, {"--light", "at least 0"});
    expect_error("ball.json --environment blue", 2, {"--environment", "'blue'"});
    expect_error("ball.json --environment none.exr", 2, {"none.exr"});
    expect_error("ball.json --crop 0,1,0,1", 2, {"--crop", "'0,1,0,1'", "x0,x1"});
    expect_error("ball.json --crop 1,0,0,1,0,1", 2, {"--crop", "lower of two first"});
    expect_error("ball.json --clip-plane 1,2", 2, {"--clip-plane", "'1,2'", "nx,ny,nz,d"});
    expect_error("ball.json --clip-plane 0,0,0,1", 2, {"--clip-plane", "no length"});
    expect_error("ball.json --window 5", 2, {"--window", "'5'", "LEVEL,WIDTH"});
    expect_error("ball.json --window 5,0", 2, {"--window", "above 0"});
    expect_error("ball.json --window 5,1 --transfer smoke", 2, {"--window", "--transfer"});
    expect_error("ball.json --transfer list.json", 2, {"list.json"});
    expect_error("ball.json --transfer nothing", 2, {"nothing"});
    expect_error("ball.json --iso high", 2, {"--iso", "'high'"});
    expect_error("ball.json --iso 1,2,3,4,5", 2, {"--iso", "1 to 4"});
    expect_error("ball.json --iso-material shine.json", 2, {"--iso-material", "no --iso"});
    expect_error(
        "ball.json --iso 9 --iso-material shine.json", 2, {"shine.json", "roughness", "2"});
    expect_error("ball.json --iso 9 --iso-material two.json", 2, {"two.json", "2 materials"});
    expect_error("ball.json --iso 9 --surface-search march", 2, {"surface search", "--gather off"});
    write_text(folder / "path.json", R"({"keys": [{"camera": "front"}]})");
    expect_error("ball.json --camera-path path.json", 2, {"path.json", "keys[0].camera", "front"});
    expect_error("ball.json --frames 3", 2, {"--frames", "--camera-path"});
    expect_error("ball.json --iso 150 --iso-to 1,2 --turntable 2", 2, {"--iso-to", "1,2"});
    expect_error("ball.json --iso 150 --iso-to 100", 2, {"--iso-to", "--turntable"});
    expect_error(
        "ball.json --camera-path path.json --turntable 3", 2, {"--camera-path", "--turntable"});
    expect_error("ball.json --camera nobody", 2, {"--camera", "nobody"});
    expect_error("ball.json -o no/such/folder.exr", 2, {"no/such/folder.exr"});
    expect_error("ball.json --checkpoint no/such/file", 2, {"no/such/file"});
    expect_error("ball.json --convergence c.csv", 2, {"--convergence", "--reference"});
    expect_error("ball.json -o same.exr --checkpoint same.exr", 2, {"same.exr", "two outputs"});
    expect_error("ball.json --capture nothing=x.exr", 2, {"nothing"});
}

TEST_F(VolumeGiProgram, memory_that_ends_is_told_with_a_table) {
    // Who holds what, and what the graph needs from which pass to which.
    expect_error("ball.json --mode path --width 512 --height 384 --steps 1 -o out.exr "
                 "--memory-budget 10",
        3,
        {"'paths' needs 23.2 MiB of GPU memory, but of the budget of 10.0 MiB",
            "raise --memory-budget", "\nIn use on the device:\n       3.000 MiB  path_sum ",
            " for the device alone\n", "\ngraph 'volume_gi' needs 3", " MiB for 1",
            "the largest:\n      23.250 MiB  paths                    kept: used from "
            "'restart_paths' to 'path_drain'; persistent\n",
            "       3.000 MiB  path_radiance            kept: used by 'path_mean'; exported (the "
            "picture)\n",
            " smaller\n"});
}

TEST_F(VolumeGiProgram, says_what_it_inferred) {
    const std::string text = run("ball.json --width 8 --height 8 --steps 1 --iso 300").text;
    for (const char* part :
        {"16 x 16 x 16 uint8", "1 x 1 x 1 mm", "values 0 to 255", "no --transfer: opacity 0 up to",
            "neither --light nor --environment", "--mode auto: path", "--iso 300"}) {
        EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
    }
}

TEST_F(VolumeGiProgram, help_and_version) {
    const Result help = run("--help");
    EXPECT_EQ(help.exit_code, 0);
    for (const char* flag : {"--mode", "--iso", "--transfer", "--checkpoint", "ct-bone", ".nrrd"})
        EXPECT_NE(help.text.find(flag), std::string::npos) << flag;
    EXPECT_EQ(run("--version").text.rfind("Ockham 0.", 0), 0u);
}

} // namespace
} // namespace ockham
