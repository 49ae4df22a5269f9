// SPDX-License-Identifier: Apache-2.0
// Runs that are cut off, and runs that go on for long: killed at any moment, on a device that is
// lost, with files that may not grow, with one thread or two; memory stays flat.
// OCKHAM_KILLS and OCKHAM_FRAMES: how often, how long.
#include "framework/app/checkpoint.hpp"
#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "framework/core/rng.hpp"
#include "framework/io/image_file.hpp"
#include "tests/support/program_test.hpp"

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <span>

namespace ockham::test {
namespace {

namespace fs = std::filesystem;

int from_environment(const char* name, int usual) {
    const char* const text = std::getenv(name);
    return text ? std::atoi(text) : usual;
}

/// Values that are not the same to the bit.
std::size_t different_values(const Image& a, const Image& b) {
    if (a.channels() != b.channels() || a.pixels() != b.pixels()) return ~std::size_t{0};
    std::size_t count = 0;
    for (std::size_t c = 0; c < a.channels().size(); ++c) {
        const std::span<const float> x = a.plane(static_cast<int>(c)),
                                     y = b.plane(static_cast<int>(c));
        for (std::size_t i = 0; i < x.size(); ++i)
            count += std::memcmp(&x[i], &y[i], sizeof(float)) != 0;
    }
    return count;
}

const std::string kVolume = "small.json --transfer ct-soft --mode caching --gather off --width 16 "
                            "--height 16 --cache-scale 4 --quiet ";
const std::string kSurfaces = "builtin:fence --width 48 --height 32 --m 2 --quiet ";

class Endurance : public ProgramTest {
protected:
    Endurance() : ProgramTest("endurance") {
        std::string voxels;
        for (int i = 0; i < 16 * 16 * 16; ++i) voxels += static_cast<char>(i * 37 % 251);
        write_text(folder / "small.raw", voxels);
        write_text(folder / "small.json",
            R"({"file": "small.raw", "dims": [16, 16, 16], "type": "uint8", "spacing_mm": [1, 1, 1]})");
    }

    Image volume_picture(const std::string& arguments, const std::string& environment = "") {
        const Result result =
            run(kVolume + arguments + " -o picture.exr", environment, "volume_gi");
        EXPECT_EQ(result.exit_code, 0) << arguments << "\n" << result.text;
        return load_image(folder / "picture.exr");
    }

    /// The program by itself, without a shell, its output dropped.
    pid_t start(const std::string& arguments, const std::string& program) {
        const std::string line = "cd '" + folder.string() + "' && exec '" OCKHAM_BIN "/" + program +
                                 "' " + arguments + " >/dev/null 2>&1";
        const pid_t child = ::fork();
        if (child == 0) {
            ::execl("/bin/sh", "sh", "-c", line.c_str(), nullptr);
            ::_exit(127);
        }
        return child;
    }

    /// Steps in the header of a checkpoint that is whole; 0 where there is none.
    int steps_of(const std::string& name) const {
        if (!fs::exists(folder / name)) return 0;
        const std::string bytes = read_text(folder / name);
        const std::size_t at = bytes.find("\"steps\":", bytes.find('{'));
        return at == std::string::npos ? 0 : std::stoi(bytes.substr(at + 8));
    }
};

TEST_F(Endurance, killed_again_and_again_it_loses_no_bit) {
    const int kills = from_environment("OCKHAM_KILLS", 4);
    Pcg32 random(7);
    int made = 0, last = 0, went_on = 0;
    for (int i = 0; i < kills; ++i) {
        const pid_t child =
            start(kVolume + "--steps 1000000 --checkpoint c --checkpoint-interval 0" +
                      (last > 0 ? " --resume c" : ""),
                "volume_gi");
        // At any moment of the first steps, and so in the middle of writing, or of starting.
        const auto wait = static_cast<useconds_t>(random.uniform(50e3f, 1500e3f));
        int status = 0;
        for (useconds_t waited = 0; waited < wait || steps_of("c") == 0; waited += 10000) {
            ASSERT_EQ(::waitpid(child, &status, WNOHANG), 0) << "it ended by itself";
            ::usleep(10000);
        }
        ::kill(child, SIGKILL);
        ASSERT_EQ(::waitpid(child, &status, 0), child);
        made += WIFSIGNALED(status);
        const int steps = steps_of("c");
        ASSERT_GE(steps, last) << "the older state was lost";
        went_on += steps > last;
        last = steps;
    }
    const std::string to = "--steps " + std::to_string(last + 2);
    const std::size_t lost =
        different_values(volume_picture(to), volume_picture(to + " --resume c"));
    EXPECT_EQ(made, kills);
    EXPECT_GT(went_on, kills / 8); // on a busy machine some end before their first step
    EXPECT_EQ(lost, 0u) << "of " << last << " steps";
    std::printf("reliability: kill {\"kills\": %d, \"steps\": %d, \"values_lost\": %zu}\n", made,
        last, lost);
}

TEST_F(Endurance, a_lost_device_is_replaced_and_the_run_goes_on_from_its_checkpoint) {
    const std::string run_it = "--steps 8 --checkpoint c --checkpoint-interval 0";
    const Image whole = volume_picture("--steps 8");
    std::size_t lost = 0;
    const std::string layer =
        "VK_INSTANCE_LAYERS=VK_LAYER_OCKHAM_fault VK_LAYER_PATH='" OCKHAM_FAULT_LAYER "' ";
    for (const char* fault : {"vkQueueSubmit:20:-4", "vkWaitForFences:19:-4"}) {
        for (const char* old : {"c", "log"}) fs::remove(folder / old);
        const Result result = run(kVolume + run_it + " -o picture.exr",
            layer + "OCKHAM_FAULT=" + fault + " OCKHAM_FAULT_LOG=log", "volume_gi");
        EXPECT_EQ(result.exit_code, 0) << fault << "\n" << result.text;
        EXPECT_NE(read_text(folder / "log").find("hit"), std::string::npos) << fault;
        EXPECT_NE(result.text.find("going on from 'c' on a new device"), std::string::npos)
            << fault << "\n"
            << result.text;
        lost += different_values(whole, load_image(folder / "picture.exr"));
    }
    EXPECT_EQ(lost, 0u);
    // Without a checkpoint there is nothing to go on from.
    EXPECT_EQ(run(kVolume + "--steps 8", layer + "OCKHAM_FAULT=vkQueueSubmit:12:-4", "volume_gi")
                  .exit_code,
        3);
    std::printf("reliability: device_lost {\"losses\": 2, \"values_lost\": %zu}\n", lost);
}

bool is_whole(const fs::path& file) {
    const std::string end = file.extension();
    if (end == ".exr") {
        try {
            load_image(file);
        } catch (const Error&) {
            return false;
        }
        return true;
    }
    const std::string text = read_text(file);
    if (end == ".json") return nlohmann::json::accept(text);
    if (end == ".html") return text.find("</html>") != std::string::npos;
    // A state: a line, the length of its header, the header, and what that lists.
    const std::size_t at = text.find('\n') + 1;
    std::uint64_t length = 0;
    if (at == 0 || text.size() < at + sizeof length) return false;
    std::memcpy(&length, text.data() + at, sizeof length);
    const auto header =
        nlohmann::json::parse(text.substr(at + sizeof length, length), nullptr, false);
    if (header.is_discarded()) return false;
    std::size_t bytes = at + sizeof length + length;
    for (const nlohmann::json& resource : header["resources"])
        bytes += resource["bytes"].get<std::size_t>();
    return bytes == text.size();
}

/// Files may grow to so many KiB. What has its final name is whole.
TEST_F(Endurance, outputs_that_do_not_fit_leave_nothing_cut_off) {
    const std::pair<std::string, std::string> jobs[] = {
        {"adaptive_aa", kSurfaces + "-o out.exr --stats s.json --plan p.json --trace t.json"},
        {"volume_gi",
            kVolume + "--steps 2 -o out.exr --stats s.json --plan p.html --checkpoint c"}};
    int tried = 0, partial = 0;
    for (const auto& [program, arguments] : jobs) {
        const std::set<std::string> before = files();
        const auto sizes = [&] {
            std::map<std::string, std::uintmax_t> result;
            for (const std::string& name : files())
                if (!before.contains(name)) result[name] = fs::file_size(folder / name);
            return result;
        };
        ASSERT_EQ(run(arguments, "", program).exit_code, 0);
        const auto whole = sizes();
        for (const int kib : {0, 1, 2, 4, 8, 16, 32, 64, 1024}) {
            for (const auto& [name, bytes] : whole) fs::remove(folder / name);
            const Result result = run(arguments, "ulimit -f " + std::to_string(kib) + ";", program);
            ++tried;
            EXPECT_TRUE(result.exit_code == 2 || sizes().size() == whole.size()) << result.text;
            for (const auto& [name, bytes] : sizes()) {
                if (is_whole(folder / name)) continue;
                ++partial;
                ADD_FAILURE() << name << " has " << bytes << " bytes at a limit of " << kib
                              << " KiB";
            }
        }
        for (const auto& [name, bytes] : whole) fs::remove(folder / name);
        for (const char* target : {"/dev/full", "/proc/out.exr", "/sys/kernel/out.exr"}) {
            const Result result = run(arguments + " --stats " + target, "", program);
            // Given twice, which is an error of its own; what counts is that nothing is left.
            EXPECT_EQ(result.exit_code, 2) << result.text;
            ++tried;
            partial += static_cast<int>(sizes().size());
        }
        EXPECT_EQ(partial, 0);
    }
    std::printf("reliability: outputs {\"tried\": %d, \"partial\": %d}\n", tried, partial);
}

TEST_F(Endurance, threads_of_the_driver_and_repeats_change_no_bit) {
    std::size_t different = 0, compared = 0;
    for (const std::string mode :
        {"--mode path --steps 3", "--mode caching --gather on --steps 4"}) {
        const std::string job = "small.json --transfer ct-soft --width 16 --height 16 --quiet "
                                "--cache-scale 4 " +
                                mode + " -o picture.exr";
        std::optional<Image> first;
        for (const char* threads : {"1", "1", "2", "0"}) {
            const Result result = run(job, std::string("LP_NUM_THREADS=") + threads, "volume_gi");
            ASSERT_EQ(result.exit_code, 0) << result.text;
            const Image picture = load_image(folder / "picture.exr");
            if (!first) first = picture;
            different += different_values(*first, picture);
            ++compared;
        }
    }
    std::optional<Image> first;
    for (const char* threads : {"1", "1", "2", "0"}) {
        const Result result = run(kSurfaces + "--preset ockham -o picture.exr",
            std::string("LP_NUM_THREADS=") + threads, "adaptive_aa");
        ASSERT_EQ(result.exit_code, 0) << result.text;
        const Image picture = load_image(folder / "picture.exr");
        if (!first) first = picture;
        different += different_values(*first, picture);
        ++compared;
    }
    EXPECT_EQ(different, 0u);
    std::printf("reliability: determinism {\"pictures\": %zu, \"values_different\": %zu}\n",
        compared, different);
}

class Soak : public Endurance, public testing::WithParamInterface<std::string> {
protected:
    /// Resident, in KiB; 0 once the process has ended.
    static double resident_kib(pid_t process) {
        std::ifstream status("/proc/" + std::to_string(process) + "/status");
        for (std::string line; std::getline(status, line);)
            if (line.starts_with("VmRSS:")) return std::stod(line.substr(6));
        return 0;
    }
};

TEST_P(Soak, keeps_memory_flat) {
    const int frames = from_environment("OCKHAM_FRAMES", 300);
    const bool volume = GetParam() == "volume_gi";
    const std::string arguments =
        volume ? kVolume + "--steps " + std::to_string(frames)
               : "builtin:fence --width 24 --height 16 --m 2 --quiet --frames " +
                     std::to_string(frames);
    const pid_t child = start(arguments, GetParam());
    std::vector<double> samples;
    int status = 0;
    while (::waitpid(child, &status, WNOHANG) == 0) {
        if (const double kib = resident_kib(child); kib > 0) samples.push_back(kib);
        ::usleep(5000);
    }
    ASSERT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    ASSERT_GT(samples.size(), 40u);
    // From a third of the time, when all kernels are compiled, to the last sample but those of the
    // end, where all is given back.
    const auto most = [&](std::size_t begin, std::size_t end) {
        return *std::max_element(samples.begin() + static_cast<std::ptrdiff_t>(begin),
            samples.begin() + static_cast<std::ptrdiff_t>(end));
    };
    const std::size_t n = samples.size();
    const double growth = (most(2 * n / 3, n) - most(n / 3, 2 * n / 3)) / 1024;
    EXPECT_LT(growth, 2.0) << "MiB more in the last third of " << frames << " frames";
    std::printf("reliability: soak {\"program\": \"%s\", \"frames\": %d, \"growth_mib\": %.2f, "
                "\"resident_mib\": %.0f}\n",
        GetParam().c_str(), frames, growth, samples[n / 2] / 1024);
}

INSTANTIATE_TEST_SUITE_P(, Soak, testing::Values("adaptive_aa", "volume_gi"),
    [](const auto& program) { return program.param; });

} // namespace
} // namespace ockham::test
