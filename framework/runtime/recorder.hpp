// SPDX-License-Identifier: Apache-2.0
// Records the steps of a plan into command buffers: barriers, the pass's own commands, releases.
// Decides nothing; which step goes where, and timing, are the executor's business.
#pragma once

#include "framework/graph/compile.hpp"
#include "framework/graph/graph.hpp"
#include "framework/graph/plan.hpp"
#include "framework/runtime/bindings.hpp"
#include "framework/runtime/raster_target.hpp"
#include "framework/runtime/resources.hpp"

#include <span>
#include <vector>

namespace ockham {

namespace gpu {
class DescriptorArena;
} // namespace gpu

/// What to leave out or to add; see ExecutorOptions.
struct RecordPolicy {
    bool poison = false;
    bool one_family = false;
};

class Recorder {
public:
    /// All must outlive this object.
    Recorder(gpu::Device& device, const Graph& graph, const Plan& plan, const Resources& resources,
        RecordPolicy policy);

    /// One step, on a queue of `family`: `skip` leaves out the pass and keeps its barriers.
    void record(VkCommandBuffer commands, gpu::DescriptorArena& descriptors,
        const QueueFamily& family, std::uint32_t step, bool skip);
    /// The barriers after the last step.
    void record_exit(VkCommandBuffer commands) const;

    /// See RasterTargets::forget.
    std::vector<VkFramebuffer> forget_targets(ResourceId id) { return targets_.forget(id); }
    std::size_t pipeline_count() const { return bindings_.pipeline_count(); }

private:
    void record_barriers(VkCommandBuffer commands, std::span<const Barrier> barriers) const;
    void record_pass(VkCommandBuffer commands, gpu::DescriptorArena& descriptors,
        const QueueFamily& family, PassId pass);

    gpu::Device& device_;
    const Graph& graph_;
    const Plan& plan_;
    const Resources& resources_;
    RecordPolicy policy_;
    Bindings bindings_;
    RasterTargets targets_;
};

} // namespace ockham
