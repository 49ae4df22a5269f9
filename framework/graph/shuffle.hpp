// SPDX-License-Identifier: Apache-2.0
// Plans as of a graph whose passes were declared in another order: what depends on the order of
// declaration shows. For tests; the runtime's planning calls it where the environment asks.
#pragma once

#include "framework/graph/compile.hpp"

#include <cstdint>

namespace ockham {

/// The passes in a random order that their data allow: each pass comes after all before it that
/// touch a resource which either of the two changes. Resources keep their ids; order[i] gets the id
/// that pass i has in `declaration`.
Declaration shuffled(
    const Declaration& declaration, std::uint64_t seed, std::vector<PassId>& order);

/// compile() of the shuffled declaration, as a plan for the given one: its ids.
Plan compile_shuffled(const Declaration& declaration, const Capabilities& capabilities,
    const Policy& policy, std::uint64_t seed);

} // namespace ockham
