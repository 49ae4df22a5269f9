// SPDX-License-Identifier: Apache-2.0
// Messages for people, on stderr, so that stdout stays free for results. Levels can be silenced;
// warnings are also counted, so that a program can say how many it printed.
#pragma once

#include <fmt/format.h>

#include <functional>
#include <string>
#include <string_view>

namespace ockham::log {

enum class Level { debug, info, warning, error };

/// Messages below `level` are dropped. Default: info.
void set_level(Level level);
/// Receives every message that is not dropped, in place of stderr; empty restores stderr.
/// May be called from any thread that logs.
void set_sink(std::function<void(Level, std::string_view)> sink);

void write(Level level, std::string_view text);

template <class... Args>
void debug(fmt::format_string<Args...> text, Args&&... args) {
    write(Level::debug, fmt::format(text, std::forward<Args>(args)...));
}
template <class... Args>
void info(fmt::format_string<Args...> text, Args&&... args) {
    write(Level::info, fmt::format(text, std::forward<Args>(args)...));
}
template <class... Args>
void warning(fmt::format_string<Args...> text, Args&&... args) {
    write(Level::warning, fmt::format(text, std::forward<Args>(args)...));
}
template <class... Args>
void error(fmt::format_string<Args...> text, Args&&... args) {
    write(Level::error, fmt::format(text, std::forward<Args>(args)...));
}

} // namespace ockham::log
