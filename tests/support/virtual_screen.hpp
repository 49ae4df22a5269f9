// SPDX-License-Identifier: Apache-2.0
// An X server without a screen for tests of windows, for its life. It finds a number of its own.
// OCKHAM_XVFB is the server.
#pragma once

#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <string>

namespace ockham::test {

class VirtualScreen {
public:
    VirtualScreen() {
        int ends[2];
        if (::pipe(ends) != 0) return;
        pid_ = ::fork();
        if (pid_ == 0) {
            ::prctl(PR_SET_PDEATHSIG, SIGTERM); // a test that crashes leaves no server
            const std::string number = std::to_string(ends[1]);
            ::execl(OCKHAM_XVFB, "Xvfb", "-displayfd", number.c_str(), "-screen", "0", "800x600x24",
                "-nolisten", "tcp", nullptr);
            ::_exit(127);
        }
        ::close(ends[1]);
        char c = 0;
        while (::read(ends[0], &c, 1) == 1 && c != '\n') name += c;
        ::close(ends[0]);
        if (!name.empty()) name = ":" + name;
    }
    ~VirtualScreen() {
        ::kill(pid_, SIGTERM);
        ::waitpid(pid_, nullptr, 0);
    }
    VirtualScreen(const VirtualScreen&) = delete;
    VirtualScreen& operator=(const VirtualScreen&) = delete;

    std::string name; ///< of the display; empty: it did not start

private:
    pid_t pid_ = -1;
};

} // namespace ockham::test
