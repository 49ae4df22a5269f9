// SPDX-License-Identifier: Apache-2.0
#include "framework/core/process.hpp"

#include "framework/core/error.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

namespace ockham {
namespace {

namespace fs = std::filesystem;

/// A program to be: its standard streams and its folder.
class Actions {
public:
    Actions(int output, const fs::path& folder) {
        posix_spawn_file_actions_init(&actions_);
        posix_spawn_file_actions_addopen(&actions_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
        posix_spawn_file_actions_adddup2(&actions_, output, STDOUT_FILENO);
        posix_spawn_file_actions_adddup2(&actions_, output, STDERR_FILENO);
        if (!folder.empty()) posix_spawn_file_actions_addchdir_np(&actions_, folder.c_str());
    }
    ~Actions() { posix_spawn_file_actions_destroy(&actions_); }
    Actions(const Actions&) = delete;
    Actions& operator=(const Actions&) = delete;
    const posix_spawn_file_actions_t* get() const { return &actions_; }

private:
    posix_spawn_file_actions_t actions_;
};

/// All until the last writer is gone.
std::string read_all(int pipe) {
    std::string text;
    char part[4096];
    for (ssize_t size = 0;;) {
        size = ::read(pipe, part, sizeof(part));
        if (size > 0) text.append(part, static_cast<std::size_t>(size));
        if (size == 0 || (size < 0 && errno != EINTR)) return text;
    }
}

int wait_for(pid_t child) {
    int status = 0;
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

} // namespace

std::optional<fs::path> find_program(const std::string& name) {
    const auto runs = [](const fs::path& path) {
        std::error_code error;
        return fs::is_regular_file(path, error) && ::access(path.c_str(), X_OK) == 0;
    };
    if (name.find('/') != std::string::npos)
        return runs(name) ? std::optional(fs::absolute(name)) : std::nullopt;
    const char* path = std::getenv("PATH");
    const std::string folders = path == nullptr ? "" : path;
    for (std::size_t begin = 0; !name.empty() && begin < folders.size();) {
        const std::size_t end = std::min(folders.find(':', begin), folders.size());
        const fs::path file = fs::path(folders.substr(begin, end - begin)) / name;
        if (runs(file)) return fs::absolute(file);
        begin = end + 1;
    }
    return std::nullopt;
}

ProcessResult run_process(const std::vector<std::string>& words, const fs::path& folder) {
    check(!words.empty(), "a program");
    const std::optional<fs::path> program = find_program(words.front());
    if (!program) fail_input("cannot start '{}': no such program", words.front());
    std::vector<char*> arguments;
    for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);

    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0)
        fail_input("cannot start '{}': {}", words.front(), std::strerror(errno));
    pid_t child = 0;
    const int failed = [&] {
        const Actions actions(ends[1], folder);
        return ::posix_spawn(
            &child, program->c_str(), actions.get(), nullptr, arguments.data(), environ);
    }();
    ::close(ends[1]);
    ProcessResult result;
    if (failed == 0) result = {.exit_code = 0, .text = read_all(ends[0])};
    ::close(ends[0]);
    if (failed != 0) fail_input("cannot start '{}': {}", words.front(), std::strerror(failed));
    result.exit_code = wait_for(child);
    return result;
}

TemporaryFolder::TemporaryFolder() {
    std::string name = (fs::temp_directory_path() / "ockham.XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr)
        fail_input("cannot make the folder '{}': {}", name, std::strerror(errno));
    path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
    std::error_code error;
    fs::remove_all(path_, error);
}

} // namespace ockham
