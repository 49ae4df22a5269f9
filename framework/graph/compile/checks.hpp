// SPDX-License-Identifier: Apache-2.0
// What validate() checks, one idea per file. Each throws Error(input) for the first mistake it
// finds,
// "[code] graph 'g': ...", and relies on those before it. For framework/graph only.
#pragma once

#include "framework/core/error.hpp"
#include "framework/graph/compile.hpp"
#include "framework/graph/compile/pieces.hpp"

#include <bit>
#include <cstring>
#include <string_view>
#include <utility>

namespace ockham {

/// Indices, enumerators and versions fit together. Holds for whatever Graph declares; a declaration
/// from a file may be anything.
void check_structure(const Declaration& declaration);
/// Names, sizes and formats of resources, names of passes.
void check_resources(const Declaration& declaration, const Capabilities& capabilities);
/// Each pass by itself: accesses, stages, bindings, formats, parts, attachments, queue.
void check_passes(const Declaration& declaration, const Capabilities& capabilities);
/// What passes read has been written, whatever the conditions say.
void check_content(const Declaration& declaration, const Pieces& pieces);

/// A hash of a name: a few instructions for the short ones that names are, not for adversaries.
inline std::size_t hash_of(std::string_view text) {
    constexpr std::uint64_t factor = 0x9e3779b97f4a7c15;
    const auto load = [&](std::size_t at, auto word) {
        std::memcpy(&word, text.data() + at, sizeof(word));
        return std::uint64_t{word};
    };
    const std::size_t size = text.size();
    std::uint64_t hash = size * factor;
    const auto mix = [&](std::uint64_t word) { hash = std::rotl((hash ^ word) * factor, 29); };
    for (std::size_t at = 0; at + 8 <= size; at += 8) mix(load(at, std::uint64_t{}));
    // The rest, by words that may overlap what was mixed already.
    if (size >= 8)
        mix(load(size - 8, std::uint64_t{}));
    else if (size >= 4)
        mix(load(0, std::uint32_t{}) << 32 | load(size - 4, std::uint32_t{}));
    else if (size > 0)
        mix(load(0, std::uint8_t{}) << 16 | load(size / 2, std::uint8_t{}) << 8 |
            load(size - 1, std::uint8_t{}));
    return static_cast<std::size_t>(hash * factor >> 16);
}

template <class... Args>
[[noreturn]] void fail_misuse(const Declaration& declaration, const char* code,
    fmt::format_string<Args...> text, Args&&... args) {
    fail_input("[{}] graph '{}': {}", code, declaration.name,
        fmt::format(text, std::forward<Args>(args)...));
}

} // namespace ockham
