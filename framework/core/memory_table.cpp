// SPDX-License-Identifier: Apache-2.0
#include "framework/core/memory_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>

namespace ockham {

std::string memory_table(std::vector<MemoryRow> rows) {
    constexpr std::size_t most = 10;
    constexpr double mib = 1 << 20;
    std::ranges::stable_sort(rows, std::greater<>(), &MemoryRow::bytes);
    std::string table;
    std::uint64_t rest = 0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        if (i >= most)
            rest += rows[i].bytes;
        else
            table += fmt::format("\n  {:10.3f} MiB  {:<24} {}",
                static_cast<double>(rows[i].bytes) / mib, rows[i].name, rows[i].why);
    }
    if (rows.size() > most)
        table += fmt::format(
            "\n  {:10.3f} MiB  in {} smaller", static_cast<double>(rest) / mib, rows.size() - most);
    return table;
}

} // namespace ockham
