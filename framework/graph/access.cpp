// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/access.hpp"

namespace ockham {

const char* name_of(Access access) { return row_of(access).name; }

const char* name_of(Stage stage) {
    constexpr std::array<const char*, 4> names{"compute", "vertex", "fragment", "fixed"};
    return names[static_cast<std::size_t>(stage)];
}

} // namespace ockham
