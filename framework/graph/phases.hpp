// SPDX-License-Identifier: Apache-2.0
// The phases of compile(), in the order in which it runs them; each reads the declaration and the
// plan so far and fills in its part of the plan. For compile.cpp only.
#pragma once

#include "framework/graph/compile.hpp"
#include "framework/graph/pieces.hpp"

namespace ockham {

/// Throws Error(input) for the first mistake in the declaration; returns the pieces that the others
/// work on.
Pieces validate(const Declaration& declaration, const Capabilities& capabilities);

/// Fills Plan::steps (without barriers), passes and resources.
void cull(const Declaration& declaration, const Pieces& pieces, Plan& plan);

/// Fills Plan::placements, in order of first_step, heaps and bytes_*.
/// Throws Error(device) where the budget of the policy does not suffice.
void place(const Declaration& declaration, const Capabilities& capabilities, const Policy& policy,
    Plan& plan);

/// Fills Plan::barriers, those of the steps and of the exit, final_states and usages.
void synchronize(const Declaration& declaration, const Pieces& pieces, Plan& plan);

} // namespace ockham
