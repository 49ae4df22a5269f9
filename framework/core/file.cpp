// SPDX-License-Identifier: Apache-2.0
#include "framework/core/file.hpp"

#include "framework/core/error.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace ockham {
namespace {

namespace fs = std::filesystem;

std::string reason() { return std::strerror(errno); }

/// A file descriptor that closes itself.
class Descriptor {
public:
    Descriptor(const fs::path& path, int flags)
        : fd_(::open(path.c_str(), flags | O_CLOEXEC, 0644)) {}
    ~Descriptor() {
        if (fd_ >= 0) ::close(fd_);
    }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    explicit operator bool() const { return fd_ >= 0; }
    int get() const { return fd_; }
    /// Closes now; false if the system reports a late write error.
    bool close() { return ::close(std::exchange(fd_, -1)) == 0; }

private:
    int fd_;
};

template <class Container>
Container read_whole(const fs::path& path, std::size_t max_bytes) {
    Descriptor file(path, O_RDONLY | O_NONBLOCK); // a pipe would wait for its writer
    if (!file) fail_input("cannot open '{}': {}", path.string(), reason());
    struct stat info {};
    if (::fstat(file.get(), &info) != 0)
        fail_input("cannot read '{}': {}", path.string(), reason());
    if (!S_ISREG(info.st_mode)) {
        fail_input("cannot read '{}': it is {}, expected a file", path.string(),
            S_ISDIR(info.st_mode) ? "a folder" : "not a regular file");
    }
    const auto size = static_cast<std::size_t>(info.st_size);
    if (size > max_bytes) {
        fail_input(
            "cannot read '{}': it has {} bytes, the limit is {}", path.string(), size, max_bytes);
    }
    Container bytes(size, {});
    std::size_t done = 0;
    while (done < size) {
        const ssize_t got = ::read(file.get(), bytes.data() + done, size - done);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) fail_input("cannot read '{}': {}", path.string(), reason());
        if (got == 0)
            fail_input(
                "cannot read '{}': it ended after {} of {} bytes", path.string(), done, size);
        done += static_cast<std::size_t>(got);
    }
    return bytes;
}

fs::path temporary_beside(const fs::path& path) {
    fs::path temporary = path;
    temporary += fmt::format(".{}.tmp", ::getpid());
    return temporary;
}

void sync(const fs::path& temporary, const fs::path& path) {
    Descriptor file(temporary, O_RDONLY);
    if (!file || ::fsync(file.get()) != 0 || !file.close()) {
        fail_input("cannot write '{}': {}", path.string(), reason());
    }
}

} // namespace

std::vector<std::byte> read_file(const fs::path& path, std::size_t max_bytes) {
    return read_whole<std::vector<std::byte>>(path, max_bytes);
}

std::string read_text(const fs::path& path, std::size_t max_bytes) {
    return read_whole<std::string>(path, max_bytes);
}

void write_atomically(const fs::path& path, const std::function<void(const fs::path&)>& write) {
    // A device such as /dev/null cannot be renamed over, and needs no protection.
    std::error_code ignored;
    if (fs::exists(path, ignored) && !fs::is_regular_file(path, ignored)) {
        if (fs::is_directory(path, ignored))
            fail_input("cannot write '{}': it is a folder", path.string());
        return write(path);
    }
    const fs::path temporary = temporary_beside(path);
    try {
        write(temporary);
        sync(temporary, path);
        fs::rename(temporary, path);
    } catch (const fs::filesystem_error& error) {
        fs::remove(temporary, ignored);
        fail_input("cannot write '{}': {}", path.string(), error.code().message());
    } catch (...) {
        fs::remove(temporary, ignored);
        throw;
    }
}

void write_file(const fs::path& path, std::span<const std::byte> bytes) {
    write_atomically(path, [&](const fs::path& target) {
        Descriptor file(target, O_WRONLY | O_CREAT | O_TRUNC);
        if (!file) fail_input("cannot write '{}': {}", path.string(), reason());
        std::size_t done = 0;
        while (done < bytes.size()) {
            const ssize_t put = ::write(file.get(), bytes.data() + done, bytes.size() - done);
            if (put < 0 && errno == EINTR) continue;
            if (put < 0) fail_input("cannot write '{}': {}", path.string(), reason());
            done += static_cast<std::size_t>(put);
        }
        if (!file.close()) fail_input("cannot write '{}': {}", path.string(), reason());
        std::error_code ignored;
        if (!fs::is_regular_file(target, ignored)) return;
        const std::vector<std::byte> back = read_file(target);
        if (!std::ranges::equal(back, bytes)) {
            fail_input("cannot write '{}': what was read back differs from what was written",
                path.string());
        }
    });
}

void write_text(const fs::path& path, std::string_view text) {
    write_file(path, std::as_bytes(std::span(text.data(), text.size())));
}

void check_writable(const fs::path& path) {
    std::error_code ignored;
    if (fs::is_directory(path, ignored))
        fail_input("cannot write '{}': it is a folder", path.string());
    if (fs::exists(path, ignored)) {
        if (::access(path.c_str(), W_OK) != 0)
            fail_input("cannot write '{}': {}", path.string(), reason());
        return;
    }
    const fs::path temporary = temporary_beside(path);
    {
        Descriptor file(temporary, O_WRONLY | O_CREAT | O_TRUNC);
        if (!file) fail_input("cannot write '{}': {}", path.string(), reason());
    }
    fs::remove(temporary, ignored);
}

} // namespace ockham
