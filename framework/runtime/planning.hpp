// SPDX-License-Identifier: Apache-2.0
// Plans for a real device: what it can do, and what memory each resource takes on it. Called by
// Executor, and by whoever wants the plan before the executor exists.
#pragma once

#include "framework/graph/compile.hpp"
#include "framework/graph/graph.hpp"

namespace ockham {

class PlanCache;

namespace gpu {
class Device;
} // namespace gpu

/// What compile() needs to know about the device.
Capabilities capabilities_of(const gpu::Device& device);

/// Compiles for this device: asks it what memory each resource takes (kept in the declaration) and
/// what it allows. Throws the errors of compile().
Plan make_plan(const gpu::Device& device, Graph& graph, const Policy& policy = {});
/// The same with other capabilities than the device's, for tests of plans with several queues.
/// `cache`, which must be used for this device only, or null: where to look first.
Plan make_plan(const gpu::Device& device, Graph& graph, const Policy& policy,
    const Capabilities& capabilities, PlanCache* cache = nullptr);

} // namespace ockham
