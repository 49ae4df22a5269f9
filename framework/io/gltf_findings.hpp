// SPDX-License-Identifier: Apache-2.0
// How the glTF loader speaks of a bad file: refuse it, tolerate it with a warning, or just note it.
// Private to io/gltf.
#pragma once

#include "framework/core/error.hpp"
#include "framework/core/log.hpp"

#include <cstddef>
#include <string>
#include <utility>

namespace ockham {

/// What is wrong with one file, in degrees.
class GltfFindings {
public:
    GltfFindings(std::string file, bool strict) : file_(std::move(file)), strict_(strict) {}

    /// Makes a read undefined, or cannot be given a meaning: throws Error(input).
    template <class... Args>
    [[noreturn]] void fatal(fmt::format_string<Args...> text, Args&&... args) const {
        fail_input("cannot load '{}': {}", file_, fmt::format(text, std::forward<Args>(args)...));
    }
    /// Invalid, but harmless: a warning; throws as `fatal` does if strict.
    template <class... Args>
    void tolerate(fmt::format_string<Args...> text, Args&&... args) const {
        const std::string found = fmt::format(text, std::forward<Args>(args)...);
        if (strict_) fail_input("cannot load '{}': {}; --strict refuses this", file_, found);
        log::warning("{}: {}", file_, found);
    }
    /// Invalid, and looked for under --strict only: throws Error(input).
    template <class... Args>
    [[noreturn]] void refuse(fmt::format_string<Args...> text, Args&&... args) const {
        fail_input("cannot load '{}': {}; --strict refuses this", file_,
            fmt::format(text, std::forward<Args>(args)...));
    }
    /// Valid, but not supported or not usual: a warning.
    template <class... Args>
    void note(fmt::format_string<Args...> text, Args&&... args) const {
        log::warning("{}: {}", file_, fmt::format(text, std::forward<Args>(args)...));
    }

private:
    std::string file_;
    bool strict_;
};

/// One line of at most `length` bytes (>= 8), for quoting a file's own text.
inline std::string shortened(std::string text, std::size_t length = 64) {
    for (char& c : text) {
        if (static_cast<unsigned char>(c) < 32) c = ' ';
    }
    if (text.size() <= length) return text;
    std::size_t end = length - 3;
    while (end > 0 && (text[end] & 0xC0) == 0x80) --end; // not within a UTF-8 sequence
    return text.substr(0, end) + "...";
}

} // namespace ockham
