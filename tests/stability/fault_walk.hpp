// SPDX-License-Identifier: Apache-2.0
// Walks over the calls of a program: lets one after another fail, and judges what the program makes
// of it. tests/support/fault_layer.cpp does the failing.
#pragma once

#include "tests/support/program_test.hpp"

#include <fstream>
#include <map>

namespace ockham::test {

/// A small job: a program and its arguments, in which SMALL stands for a volume of 8^3 voxels.
struct FaultJob {
    std::string program, arguments;
};
inline void PrintTo(const FaultJob& job, std::ostream* out) { *out << job.program; }

class FaultWalk : public ProgramTest {
protected:
    using Sizes = std::map<std::string, std::uintmax_t>; ///< of files, by name

    FaultWalk() : ProgramTest("faults"), input_(folder.string() + ".in") {
        std::filesystem::create_directories(input_);
        std::ofstream(input_ / "small.raw") << std::string(512, '\x80');
        std::ofstream(input_ / "small.json")
            << R"({"file": "small.raw", "dims": [8, 8, 8], "type": "uint8", "spacing_mm": [1, 1, 1]})";
    }
    ~FaultWalk() override { std::filesystem::remove_all(input_); }

    /// `fault`: as OCKHAM_FAULT; empty: none. Longer than a minute counts as hanging.
    Result run_job(const FaultJob& job, const std::string& fault) {
        for (const std::string& name : files()) std::filesystem::remove(folder / name);
        std::string arguments = job.arguments;
        if (const std::size_t at = arguments.find("SMALL"); at != std::string::npos)
            arguments.replace(at, 5, input_ / "small.json");
        return run(arguments,
            "OCKHAM_FAULT_LOG=log VK_INSTANCE_LAYERS=VK_LAYER_OCKHAM_fault "
            "VK_LAYER_PATH='" OCKHAM_FAULT_LAYER "' " +
                (fault.empty() ? "" : "OCKHAM_FAULT=" + fault + " ") + "timeout 60",
            job.program);
    }

    /// Calls by entry point, and "hit" where the fault was met.
    std::map<std::string, unsigned> log() {
        std::map<std::string, unsigned> calls;
        std::ifstream file(folder / "log");
        for (std::string line; std::getline(file, line);) {
            const std::size_t space = line.find(' ');
            calls[line.substr(0, space)] =
                space == std::string::npos
                    ? 1u
                    : static_cast<unsigned>(std::stoul(line.substr(space + 1)));
        }
        return calls;
    }

    /// Vulkan's results that an entry point may return.
    static std::vector<int> results_of(const std::string& call) {
        std::vector<int> results = {-1, -2}; // out of host, of device memory
        for (const char* waits : {"vkQueueSubmit", "vkQueueSubmit2", "vkWaitForFences",
                 "vkWaitSemaphores", "vkDeviceWaitIdle", "vkGetQueryPoolResults"})
            if (call == waits) results.push_back(-4); // device lost
        if (call == "vkCreateInstance" || call == "vkCreateDevice") results.push_back(-3);
        if (call == "vkMapMemory") results.push_back(-5);
        return results;
    }

    /// Lets each call fail that `chosen` (n-th of so many) names. Nothing may crash or hang. Either
    /// the program ends with exit code 3, one error and no file that is cut off, or it does
    /// without the call and all its files are there. Returns how many faults were met.
    template <class Chosen>
    unsigned walk(const FaultJob& job, const Chosen& chosen) {
        const Result whole = run_job(job, "");
        EXPECT_EQ(whole.exit_code, 0) << whole.text;
        const std::map<std::string, unsigned> calls = log();
        EXPECT_GT(calls.size(), 20u) << "the layer is not between";
        const Sizes whole_files = sizes();
        unsigned faults = 0;
        for (const auto& [call, count] : calls) {
            for (unsigned n = 1; n <= count; ++n) {
                if (!chosen(n, count)) continue;
                for (const int result : results_of(call)) {
                    judge(job, call + ":" + std::to_string(n) + ":" + std::to_string(result),
                        whole_files);
                    ++faults;
                }
            }
        }
        std::printf("reliability: faults {\"program\": \"%s\", \"faults\": %u, \"crashes\": %u, "
                    "\"hangs\": %u, \"partial_files\": %u}\n",
            job.program.c_str(), faults, crashes_, hangs_, partial_files_);
        return faults;
    }

private:
    unsigned crashes_ = 0, hangs_ = 0, partial_files_ = 0;
    std::filesystem::path input_; ///< beside the folder, whose files are judged

    Sizes sizes() const {
        Sizes sizes;
        for (const std::string& name : files())
            if (name != "log") sizes[name] = std::filesystem::file_size(folder / name);
        return sizes;
    }

    void judge(const FaultJob& job, const std::string& fault, const Sizes& whole) {
        const Result result = run_job(job, fault);
        const std::string where = job.program + ", " + fault + ": " + result.text;
        EXPECT_TRUE(log().contains("hit")) << where;
        std::size_t errors = 0;
        for (std::size_t at = 0; (at = result.text.find("error: ", at)) != std::string::npos; ++at)
            ++errors;
        if (result.exit_code == 0) {
            EXPECT_EQ(sizes().size(), whole.size()) << where;
            EXPECT_EQ(errors, 0u) << where;
        } else {
            EXPECT_EQ(result.exit_code, 3) << where; // 124: hung; 128: a signal
            hangs_ += result.exit_code == 124;
            crashes_ += result.exit_code >= 125;
            EXPECT_EQ(errors, 1u) << where;
            // A state names times, so that its length changes by some digits.
            for (const auto& [name, bytes] : sizes()) {
                const bool is_whole = whole.contains(name) && bytes + 64 >= whole.at(name);
                EXPECT_TRUE(is_whole) << name << ": " << where;
                partial_files_ += !is_whole;
            }
        }
    }
};

/// One of each kind: a bare graph, a raster pipeline with read-backs, a graph that keeps state.
inline const FaultJob kFaultJobs[] = {
    {"hello_graph", ""},
    {"adaptive_aa",
        "builtin:plane --width 24 --height 16 --m 2 -o out.exr --stats out.json --quiet"},
    {"volume_gi",
        "SMALL --transfer ct-soft --mode caching --gather off --steps 2 --width 16 --height 16 "
        "--cache-scale 4 -o out.exr --stats out.json --checkpoint out.state --quiet"},
};

} // namespace ockham::test
