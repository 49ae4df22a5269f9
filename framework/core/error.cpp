// SPDX-License-Identifier: Apache-2.0
#include "framework/core/error.hpp"

#include <cstdio>
#include <cstdlib>

namespace ockham {

void abort_check(const std::source_location& where, const std::string& text) {
    fmt::print(stderr, "{}:{}: check failed in {}: {}\n", where.file_name(), where.line(),
        where.function_name(), text);
    std::abort();
}

} // namespace ockham
