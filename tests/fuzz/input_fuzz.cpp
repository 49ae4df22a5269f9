// SPDX-License-Identifier: Apache-2.0
// libFuzzer on what programs read from others. OCKHAM_FUZZ_KIND names the kind (input_kinds.hpp);
// OCKHAM_FUZZ_SEEDS a folder that gets the good files to begin with. Whatever is thrown but Error,
// and what the sanitizers find, ends it with the file kept.
#include "framework/core/error.hpp"
#include "framework/core/log.hpp"
#include "tests/support/input_kinds.hpp"

#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>

using namespace ockham;

namespace {

std::vector<test::InputKind> all_kinds() {
    std::vector<test::InputKind> result = test::input_kinds();
    for (test::InputKind& check : test::volume_check_kinds()) result.push_back(std::move(check));
    return result;
}

const std::vector<test::InputKind> kinds = all_kinds();
const test::InputKind* kind = nullptr;
std::filesystem::path folder;

} // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
    const char* const name = std::getenv("OCKHAM_FUZZ_KIND");
    for (const test::InputKind& known : kinds)
        if (name != nullptr && known.name == name) kind = &known;
    if (kind == nullptr) {
        std::fprintf(stderr, "OCKHAM_FUZZ_KIND: one of");
        for (const test::InputKind& known : kinds) std::fprintf(stderr, " %s", known.name.c_str());
        std::fprintf(stderr, "\n");
        std::exit(2);
    }
    log::set_sink([](log::Level, std::string_view) {});
    if (const char* const seeds = std::getenv("OCKHAM_FUZZ_SEEDS")) {
        std::filesystem::create_directories(seeds);
        for (std::size_t i = 0; i < kind->good.size(); ++i) {
            std::ofstream(
                std::filesystem::path(seeds) / ("seed" + std::to_string(i)), std::ios::binary)
                << kind->good[i];
        }
    }
    // In memory, where that can be had.
    const std::filesystem::path shared = "/dev/shm";
    folder =
        (std::filesystem::is_directory(shared) ? shared : std::filesystem::temp_directory_path()) /
        ("ockham_fuzz." + std::to_string(::getpid()));
    std::filesystem::create_directories(folder);
    kind->write_beside(folder);
    std::atexit([] { std::filesystem::remove_all(folder); });
    return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string bytes(reinterpret_cast<const char*>(data), size);
    const std::filesystem::path file = folder / kind->file;
    std::ofstream(file, std::ios::binary) << (kind->repair ? kind->repair(bytes) : bytes);
    try {
        kind->load(file);
    } catch (const Error&) {
        return 0;
    }
    return 0;
}
