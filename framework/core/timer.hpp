// SPDX-License-Identifier: Apache-2.0
// Wall clock for progress lines and statistics. GPU times come from timestamps instead.
#pragma once

#include <chrono>

namespace ockham {

class Timer {
public:
    /// Seconds since construction or the last restart().
    double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
    double milliseconds() const { return 1e3 * seconds(); }
    void restart() { start_ = Clock::now(); }

private:
    using Clock = std::chrono::steady_clock;
    Clock::time_point start_ = Clock::now();
};

} // namespace ockham
