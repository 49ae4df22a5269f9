// SPDX-License-Identifier: Apache-2.0
// The phases of compile(), in the order in which it runs them; each reads the declaration and the
// plan so far and fills in its part of the plan. For compile.cpp only.
#pragma once

#include "framework/graph/compile.hpp"
#include "framework/graph/compile/pieces.hpp"

namespace ockham {

/// Throws Error(input) for the first mistake in the declaration; returns the pieces that the others
/// work on.
Pieces validate(const Declaration& declaration, const Capabilities& capabilities);

/// Fills Plan::steps (without barriers), passes and resources.
void cull(const Declaration& declaration, const Pieces& pieces, Plan& plan);

/// Puts Plan::steps into the order of the policy.
void order(const Declaration& declaration, const Pieces& pieces, const Policy& policy, Plan& plan);

/// Spreads the steps over queues and regroups them by submission. Fills Plan::queues, submissions,
/// waits and concurrent.
void schedule(const Declaration& declaration, const Pieces& pieces,
    const Capabilities& capabilities, const Policy& policy, Plan& plan);

/// Fills Plan::placements, in order of first_step, heaps and bytes_*.
/// Throws Error(device) where the budget of the policy does not suffice.
void place(const Declaration& declaration, const Capabilities& capabilities, const Policy& policy,
    Plan& plan);

/// What a resource takes: as given, else estimated.
inline MemoryNeed memory_need(const ResourceDecl& resource) {
    return resource.memory.bytes ? resource.memory : estimate_memory(resource);
}
/// Whether others may have its memory while it is not used.
inline bool shares_memory(const ResourceDecl& resource) {
    return resource.lifetime == Lifetime::transient && !resource.exported;
}

/// Fills Plan::barriers, those of the steps and of the exit, final_states and usages.
/// With Order::batched, as early as that makes fewer batches.
void synchronize(const Declaration& declaration, const Pieces& pieces,
    const Capabilities& capabilities, const Policy& policy, Plan& plan);

} // namespace ockham
