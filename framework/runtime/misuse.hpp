// SPDX-License-Identifier: Apache-2.0
// The runtime's errors: a stable code, graph, pass and resource with the places of their
// declaration. docs/runtime.md lists the codes. For the files of framework/runtime only.
#pragma once

#include "framework/core/error.hpp"
#include "framework/graph/describe.hpp"

#include <string>
#include <utility>

namespace ockham {

/// Throws Error(input): "[code] graph 'g': text".
template <class... Args>
[[noreturn]] void fail_graph(const Declaration& declaration, const char* code,
    fmt::format_string<Args...> text, Args&&... args) {
    fail_input("[{}] graph '{}': {}", code, declaration.name,
        fmt::format(text, std::forward<Args>(args)...));
}

/// Throws Error(input): "[code] graph 'g': pass 'blur' (frame.cpp:41): text".
template <class... Args>
[[noreturn]] void fail_pass(const Declaration& declaration, PassId pass, const char* code,
    fmt::format_string<Args...> text, Args&&... args) {
    fail_graph(declaration, code, "{}: {}", describe(declaration.passes[pass]),
        fmt::format(text, std::forward<Args>(args)...));
}

} // namespace ockham
