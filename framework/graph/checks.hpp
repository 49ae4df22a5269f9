// SPDX-License-Identifier: Apache-2.0
// What validate() checks, one idea per file. Each throws Error(input) for the first mistake it
// finds,
// "[code] graph 'g': ...", and relies on those before it. For framework/graph only.
#pragma once

#include "framework/core/error.hpp"
#include "framework/graph/compile.hpp"
#include "framework/graph/pieces.hpp"

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

template <class... Args>
[[noreturn]] void fail_misuse(const Declaration& declaration, const char* code,
    fmt::format_string<Args...> text, Args&&... args) {
    fail_input("[{}] graph '{}': {}", code, declaration.name,
        fmt::format(text, std::forward<Args>(args)...));
}

} // namespace ockham
