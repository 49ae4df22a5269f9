// SPDX-License-Identifier: Apache-2.0
// Feeds files to a reader in a process of its own, so that what crashes, hangs or fills the memory
// is counted and the rest goes on.
#pragma once

#include "framework/core/error.hpp"
#include "framework/core/log.hpp"

#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

namespace ockham::test {

struct TrialCounts {
    std::size_t tried = 0, loaded = 0, refused = 0;
    /// Numbers of the files on which the process died, or took longer than the limit.
    std::vector<std::size_t> crashes, hangs;
    double slowest_seconds = 0;
    double peak_mib = 0; ///< resident, of a whole process
};

class Trials {
public:
    /// A file may take so long.
    static constexpr double kLimitSeconds = 10;
    /// The address space that is left to a reader; not where a sanitizer needs it itself.
    static constexpr std::uint64_t kAddressBytes = std::uint64_t{3} << 30;

    /// `make(i)`: the bytes of file i of `count`. `load` reads `file` and throws ockham::Error
    /// where it refuses; anything else that it throws counts as a crash.
    static TrialCounts run(const std::filesystem::path& file, std::size_t count,
        const std::function<std::string(std::size_t)>& make,
        const std::function<void(const std::filesystem::path&)>& load) {
        TrialCounts counts;
        auto* const shared = static_cast<Shared*>(::mmap(
            nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0));
        if (shared == MAP_FAILED) std::abort();
        new (shared) Shared;
        while (shared->next < count) {
            const pid_t child = ::fork();
            if (child == 0) feed(*shared, file, count, make, load);
            watch(*shared, child, counts);
        }
        counts.tried = count;
        counts.loaded = shared->loaded;
        counts.refused = shared->refused;
        counts.slowest_seconds = static_cast<double>(shared->slowest_ns) * 1e-9;
        ::munmap(shared, sizeof(Shared));
        return counts;
    }

private:
    struct Shared {
        std::atomic<std::size_t> next{0}, loaded{0}, refused{0};
        std::atomic<std::int64_t> started_ns{0}; ///< 0: between two files
        std::atomic<std::int64_t> slowest_ns{0};
    };

    static std::int64_t now_ns() {
        return std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
    }

    /// The child. What readers print is not wanted.
    [[noreturn]] static void feed(Shared& shared, const std::filesystem::path& file,
        std::size_t count, const std::function<std::string(std::size_t)>& make,
        const std::function<void(const std::filesystem::path&)>& load) {
        log::set_sink([](log::Level, std::string_view) {});
        if (!std::freopen("/dev/null", "w", stdout)) ::_exit(3);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
        const rlimit limit{kAddressBytes, kAddressBytes};
        ::setrlimit(RLIMIT_AS, &limit);
        if (!std::freopen("/dev/null", "w", stderr)) ::_exit(3);
#endif
        while (shared.next < count) {
            std::filesystem::remove(file); // rewriting a file in place may wait for the disk
            std::ofstream(file, std::ios::binary) << make(shared.next);
            const std::int64_t start = now_ns();
            shared.started_ns = start;
            try {
                load(file);
                ++shared.loaded;
            } catch (const Error&) {
                ++shared.refused;
            }
            shared.started_ns = 0;
            shared.slowest_ns = std::max(shared.slowest_ns.load(), now_ns() - start);
            ++shared.next;
        }
        ::_exit(0);
    }

    static void watch(Shared& shared, pid_t child, TrialCounts& counts) {
        int status = 0;
        rusage usage{};
        bool hung = false;
        while (::wait4(child, &status, WNOHANG, &usage) == 0) {
            const std::int64_t start = shared.started_ns;
            if (start != 0 && static_cast<double>(now_ns() - start) * 1e-9 > kLimitSeconds) {
                hung = true;
                ::kill(child, SIGKILL);
                ::wait4(child, &status, 0, &usage);
                break;
            }
            ::usleep(2000);
        }
        counts.peak_mib = std::max(counts.peak_mib, static_cast<double>(usage.ru_maxrss) / 1024);
        shared.started_ns = 0;
        if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return;
        (hung ? counts.hangs : counts.crashes).push_back(shared.next++);
    }
};

} // namespace ockham::test
