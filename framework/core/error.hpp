// SPDX-License-Identifier: Apache-2.0
// The two kinds of failure: `check` for mistakes of the programmer (aborts with the place), and
// `Error` for mistakes of a user or the environment (a file, a flag, a device). Everybody throws
// `Error`; only a program's main() turns it into an exit code.
#pragma once

#include <fmt/format.h>

#include <source_location>
#include <stdexcept>
#include <string>
#include <utility>

namespace ockham {

/// What kind of thing failed. A program's exit code follows from it.
enum class ErrorKind {
    input,  ///< bad file, flag, scene, or output that cannot be written: exit code 2
    device, ///< no usable device, device lost, out of memory: exit code 3
};

/// One failure that a user can act on. The text says what failed, on which thing, what was found
/// and what to do, in one line without a final period's worth of noise.
class Error : public std::runtime_error {
public:
    Error(ErrorKind kind, std::string text) : std::runtime_error(std::move(text)), kind_(kind) {}
    ErrorKind kind() const { return kind_; }
    /// Exit code of a program that ends on this error: 2 or 3.
    int exit_code() const { return kind_ == ErrorKind::device ? 3 : 2; }

private:
    ErrorKind kind_;
};

/// Throws an Error of kind `input` with a formatted text.
template <class... Args>
[[noreturn]] void fail_input(fmt::format_string<Args...> text, Args&&... args) {
    throw Error(ErrorKind::input, fmt::format(text, std::forward<Args>(args)...));
}

/// Throws an Error of kind `device` with a formatted text.
template <class... Args>
[[noreturn]] void fail_device(fmt::format_string<Args...> text, Args&&... args) {
    throw Error(ErrorKind::device, fmt::format(text, std::forward<Args>(args)...));
}

/// Prints the place and the text to stderr and aborts.
[[noreturn]] void abort_check(const std::source_location& where, const std::string& text);

/// Aborts unless `condition` holds: for mistakes of the programmer, never for input.
inline void check(bool condition, const char* text,
    const std::source_location where = std::source_location::current()) {
    if (!condition) abort_check(where, text);
}

} // namespace ockham
