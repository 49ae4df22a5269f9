// SPDX-License-Identifier: Apache-2.0
#include "framework/core/memory_table.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace ockham {
namespace {

TEST(MemoryTable, LargestFirstAndTheRestInOneLine) {
    EXPECT_EQ(memory_table({}), "");
    std::vector<MemoryRow> rows{{1 << 20, "b", "kept"}, {3 << 20, "a", "used"}};
    EXPECT_EQ(memory_table(rows), "\n       3.000 MiB  a                        used"
                                  "\n       1.000 MiB  b                        kept");
    for (int i = 0; i < 10; ++i) rows.push_back({1 << 19, "small", "used"});
    const std::string table = memory_table(rows);
    EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 11);
    EXPECT_TRUE(table.ends_with("\n       1.000 MiB  in 2 smaller")) << table;
}

} // namespace
} // namespace ockham
