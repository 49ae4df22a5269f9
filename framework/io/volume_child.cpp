// SPDX-License-Identifier: Apache-2.0
#include "framework/io/volume_child.hpp"

#include "framework/core/error.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

namespace ockham {
namespace {

namespace fs = std::filesystem;

/// Addresses that a reader may take beyond those of this process where there is a limit, and more
/// for each byte of its file.
constexpr std::uint64_t kAddresses = std::uint64_t{256} << 20, kAddressesPerByte = 64;
/// Seconds of a processor that a file may take, and more for each MiB of it.
constexpr rlim_t kSeconds = 20, kSecondsPerMib = 1;

/// What the child hands over: this, then `text_bytes` and `voxel_bytes`.
struct Head {
    glm::uvec3 dims;
    VoxelType type;
    double value_scale, value_offset;
    glm::dvec3 spacing_mm, origin_mm;
    glm::dmat3 direction;
    std::uint64_t text_bytes; ///< notes, each with a 0 behind it; of an Error its text
    std::uint64_t voxel_bytes;
    bool failed;
};
static_assert(std::is_trivially_copyable_v<Head>);

/// A file in memory that both processes see.
class SharedFile {
public:
    SharedFile() : fd_(::memfd_create("ockham volume", MFD_CLOEXEC)) {}
    ~SharedFile() { ::close(fd_); }
    SharedFile(const SharedFile&) = delete;
    SharedFile& operator=(const SharedFile&) = delete;
    explicit operator bool() const { return fd_ >= 0; }

    bool write(std::span<const std::byte> bytes) const {
        while (!bytes.empty()) {
            const ssize_t put = ::write(fd_, bytes.data(), bytes.size());
            if (put < 0 && errno == EINTR) continue;
            if (put <= 0) return false;
            bytes = bytes.subspan(static_cast<std::size_t>(put));
        }
        return true;
    }
    /// From `at` on.
    bool read(std::span<std::byte> bytes, std::uint64_t at) const {
        while (!bytes.empty()) {
            const ssize_t got = ::pread(fd_, bytes.data(), bytes.size(), static_cast<off_t>(at));
            if (got < 0 && errno == EINTR) continue;
            if (got <= 0) return false;
            at += static_cast<std::uint64_t>(got);
            bytes = bytes.subspan(static_cast<std::size_t>(got));
        }
        return true;
    }
    std::uint64_t size() const {
        struct stat info {};
        return ::fstat(fd_, &info) == 0 ? static_cast<std::uint64_t>(info.st_size) : 0;
    }

private:
    int fd_;
};

std::uint64_t bytes_at(const fs::path& path) {
    std::error_code ignored;
    if (!fs::is_directory(path, ignored)) return fs::file_size(path, ignored);
    std::uint64_t sum = 0;
    for (const auto& entry : fs::directory_iterator(path, ignored))
        if (entry.is_regular_file(ignored)) sum += entry.file_size(ignored);
    return sum;
}

bool send(const SharedFile& file, const Head& head, std::string_view text, const Volume& volume) {
    return file.write(std::as_bytes(std::span(&head, 1))) &&
           file.write(std::as_bytes(std::span(text))) && file.write(volume.voxels);
}

void limit_memory(std::uint64_t bytes) {
    std::uint64_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    const rlim_t most = pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE)) + kAddresses +
                        kAddressesPerByte * bytes;
    const rlimit memory{most, most};
    if (pages != 0) ::setrlimit(RLIMIT_AS, &memory);
}

/// The child. Nothing of the parent's may be cleaned up here.
[[noreturn]] void serve(const SharedFile& file, std::uint64_t bytes, Memory memory,
    const std::function<Volume()>& load) {
    const rlim_t seconds = kSeconds + kSecondsPerMib * (bytes >> 20);
    const rlimit time{seconds, seconds}, no_dump{0, 0};
    ::setrlimit(RLIMIT_CPU, &time);
    ::setrlimit(RLIMIT_CORE, &no_dump);
    if (memory == Memory::by_file_size) limit_memory(bytes);
    if (const int null = ::open("/dev/null", O_WRONLY); null >= 0) {
        ::dup2(null, STDOUT_FILENO);
        ::dup2(null, STDERR_FILENO);
    }
    Head head{};
    std::string text;
    Volume volume;
    try {
        volume = load();
        for (const std::string& note : volume.notes) text += note + '\0';
        head = {volume.dims, volume.type, volume.value_scale, volume.value_offset,
            volume.spacing_mm, volume.origin_mm, volume.direction, text.size(),
            volume.voxels.size(), false};
    } catch (const std::exception& error) {
        volume = {};
        text = error.what();
        head.text_bytes = text.size();
        head.failed = true;
    }
    ::_exit(send(file, head, text, volume) ? 0 : 1);
}

Volume receive(const SharedFile& file, const fs::path& path) {
    Head head{};
    const bool has_head = file.read(std::as_writable_bytes(std::span(&head, 1)), 0);
    if (!has_head || head.text_bytes > file.size() || head.voxel_bytes > file.size()) {
        fail_input("cannot load volume '{}': what was read of it is gone", path.string());
    }
    std::string text(head.text_bytes, '\0');
    Volume volume;
    volume.voxels.resize(head.voxel_bytes);
    if (!file.read(std::as_writable_bytes(std::span(text)), sizeof head) ||
        !file.read(volume.voxels, sizeof head + head.text_bytes)) {
        fail_input("cannot load volume '{}': what was read of it is gone", path.string());
    }
    if (head.failed) throw Error(ErrorKind::input, text);
    volume.dims = head.dims;
    volume.type = head.type;
    volume.value_scale = head.value_scale;
    volume.value_offset = head.value_offset;
    volume.spacing_mm = head.spacing_mm;
    volume.origin_mm = head.origin_mm;
    volume.direction = head.direction;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = text.find('\0', at);
        volume.notes.push_back(text.substr(at, end - at));
        at = end + 1;
    }
    return volume;
}

} // namespace

Volume load_in_child(const fs::path& path, Memory memory, const std::function<Volume()>& load) {
    const SharedFile file;
    const std::uint64_t bytes = bytes_at(path);
    const pid_t child = file ? ::fork() : -1;
    if (child == 0) serve(file, bytes, memory, load);
    if (child < 0) {
        fail_input("cannot load volume '{}': no process can be started for its reader: {}",
            path.string(), std::strerror(errno));
    }
    int status = 0;
    while (::waitpid(child, &status, 0) < 0) {
        if (errno != EINTR)
            fail_input("cannot load volume '{}': its reader is gone", path.string());
    }
    if (WIFSIGNALED(status)) {
        const int signal = WTERMSIG(status);
        const bool is_late = signal == SIGXCPU || signal == SIGKILL;
        fail_input("cannot load volume '{}': the library that reads it {} ({}); it is damaged",
            path.string(), is_late ? "took too long" : "stopped", ::strsignal(signal));
    }
    if (WEXITSTATUS(status) != 0) {
        fail_input("cannot load volume '{}': the process that reads it failed; is there memory for "
                   "its voxels twice?",
            path.string());
    }
    return receive(file, path);
}

} // namespace ockham
