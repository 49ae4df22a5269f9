// SPDX-License-Identifier: Apache-2.0
// The table that ends an error about too little memory: what is large, and why it lives. One form
// for plans of graphs and for what a device holds.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace ockham {

struct MemoryRow {
    std::uint64_t bytes = 0;
    std::string name;
    std::string why; ///< it lives
};

/// "\n      12.000 MiB  name                     why" for each of the ten largest, equal ones in
/// the order given, and one more line for the sum of all others. Empty for no rows.
std::string memory_table(std::vector<MemoryRow> rows);

} // namespace ockham
