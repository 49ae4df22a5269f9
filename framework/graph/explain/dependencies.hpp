// SPDX-License-Identifier: Apache-2.0
// Which pass must run after which, and through what: the relations that every plan of a declaration
// keeps. Derived anew when asked; compile() has its own way. For explanations, tests and tools.
#pragma once

#include "framework/graph/plan.hpp"

#include <span>
#include <vector>

namespace ockham {

/// `after` may not begin before `before` has ended, because of this part of this resource.
struct Dependency {
    PassId before = kNone;
    PassId after = kNone;
    ResourceId resource = kNone;
    Part part;                                ///< touched by both; ends resolved
    Hazard hazard = Hazard::read_after_write; ///< or write_after_read, write_after_write
};

/// The dependencies between kept passes that no chain of others implies, by `after` in declared
/// order. A pair of passes appears once for each part through which it depends.
std::vector<Dependency> direct_dependencies(const Declaration& declaration, const Plan& plan);

/// Those of one pass among direct_dependencies(), a span for each pass that it waits for; the
/// latest of these first.
std::vector<std::span<const Dependency>> dependencies_of(
    std::span<const Dependency> direct, PassId after);

} // namespace ockham
