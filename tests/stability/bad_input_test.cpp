// SPDX-License-Identifier: Apache-2.0
// Damaged files of every kind that programs read: each is refused with an Error or read, soon and
// in little memory. OCKHAM_INPUTS: how many files of each kind beside the systematic ones.
#include "tests/support/input_kinds.hpp"
#include "tests/support/mutate.hpp"
#include "tests/support/trials.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>

namespace ockham::test {
namespace {

namespace fs = std::filesystem;

std::size_t random_files() {
    const char* const count = std::getenv("OCKHAM_INPUTS");
    return count ? std::strtoul(count, nullptr, 10) : 60;
}

std::uint64_t seed() {
    const char* const given = std::getenv("OCKHAM_SEED");
    return given ? std::strtoull(given, nullptr, 10) : 1;
}

class BadInput : public testing::TestWithParam<InputKind> {
protected:
    BadInput()
        : folder_(fs::temp_directory_path() / fmt::format("ockham_bad_input.{}", ::getpid())) {
        fs::create_directories(folder_);
        GetParam().write_beside(folder_);
    }
    ~BadInput() override { fs::remove_all(folder_); }
    fs::path file() const { return folder_ / GetParam().file; }

    /// The error, or nothing.
    std::string refusal() const {
        log::set_sink([](log::Level, std::string_view) {});
        std::string text;
        try {
            GetParam().load(file());
        } catch (const Error& error) {
            text = error.what();
        }
        log::set_sink({});
        return text;
    }

    /// Cuts, and every wrong value of JSON; of these a quarter in short runs.
    std::vector<std::string> systematic() const {
        std::vector<std::string> files;
        for (const std::string& good : GetParam().good) {
            const std::size_t step = 1 + good.size() / 64;
            for (std::size_t size = 0; size < good.size(); size += step)
                files.push_back(good.substr(0, size));
            if (good.starts_with('{')) {
                std::vector<std::string> all = Mutator::all_of_json(good);
                for (std::size_t i = 0; i < all.size(); i += random_files() < 1000 ? 4 : 1)
                    files.push_back(std::move(all[i]));
            }
        }
        return files;
    }

    std::string random(std::size_t i) const {
        const InputKind& kind = GetParam();
        Mutator mutator(seed() * 1000003 + i);
        const std::string bad = mutator.change(kind.good[i % kind.good.size()]);
        return kind.repair && i % 2 == 0 ? kind.repair(bad) : bad;
    }

private:
    fs::path folder_;
};

TEST_P(BadInput, is_refused_or_read_in_time_and_memory) {
    const std::vector<std::string> first = systematic();
    const auto make = [&](std::size_t i) {
        return i < first.size() ? first[i] : random(i - first.size());
    };
    const std::size_t count = first.size() + random_files();
    const TrialCounts counts = Trials::run(file(), count, make, GetParam().load);
    for (const auto& [what, files] :
        {std::pair{"crashes", counts.crashes}, std::pair{"hangs", counts.hangs}}) {
        for (const std::size_t i : files) {
            const fs::path kept =
                fs::temp_directory_path() / fmt::format("{}_{}", i, GetParam().file);
            std::ofstream(kept, std::ios::binary) << make(i);
            ADD_FAILURE() << GetParam().name << ": file " << i << " " << what << "; kept as "
                          << kept;
        }
    }
    EXPECT_LT(counts.slowest_seconds, 2.0);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    EXPECT_LT(counts.peak_mib, 512.0);
#endif
    EXPECT_GT(counts.refused, counts.tried / 20) << "changes that change nothing";
    std::printf("reliability: input {\"kind\": \"%s\", \"tried\": %zu, \"read\": %zu, \"refused\": "
                "%zu, \"crashes\": %zu, \"hangs\": %zu, \"slowest_s\": %.3f, \"peak_mib\": %.0f}\n",
        GetParam().name.c_str(), counts.tried, counts.loaded, counts.refused, counts.crashes.size(),
        counts.hangs.size(), counts.slowest_seconds, counts.peak_mib);
}

TEST_P(BadInput, good_files_are_read) {
    for (const std::string& good : GetParam().good) {
        const bool is_packed = GetParam().name == "nifti_gz";
        std::ofstream(file(), std::ios::binary) << (is_packed ? GetParam().repair(good) : good);
        EXPECT_EQ(refusal(), "");
    }
}

/// A pipe waits for its writer, a device never ends, a folder is no file.
TEST_P(BadInput, what_is_no_file_is_refused_at_once) {
    fs::remove(file());
    ASSERT_EQ(::mkfifo(file().c_str(), 0600), 0);
    EXPECT_NE(refusal(), "") << "a pipe";
    for (const char* target : {"/dev/zero", "/dev/full", "/proc/self/mem", "nothing", "."}) {
        fs::remove(file());
        fs::create_symlink(target, file());
        EXPECT_NE(refusal(), "") << target;
    }
    fs::remove(file());
    fs::create_directory(file());
    EXPECT_NE(refusal(), "") << "a folder";
}

/// One byte over and over, and nesting without end.
TEST_P(BadInput, monotonous_files_are_refused) {
    for (const char c : {'\0', '[', '{', '(', '9', ' ', '\n', '\xFF'}) {
        if (GetParam().name == "gltf_buffer") continue; // is data, whatever it holds
        std::ofstream(file(), std::ios::binary) << std::string(std::size_t{1} << 18, c);
        EXPECT_NE(refusal(), "") << static_cast<int>(c);
    }
}

INSTANTIATE_TEST_SUITE_P(
    , BadInput, testing::ValuesIn(input_kinds()), [](const auto& kind) { return kind.param.name; });

} // namespace
} // namespace ockham::test
