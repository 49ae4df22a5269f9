// SPDX-License-Identifier: Apache-2.0
#include "framework/runtime/recorder.hpp"

#include "framework/gpu/device.hpp"
#include "framework/runtime/barriers.hpp"
#include "framework/runtime/commands_impl.hpp"

namespace ockham {

Recorder::Recorder(gpu::Device& device, const Graph& graph, const Plan& plan,
    const Resources& resources, RecordPolicy policy)
    : device_(device), graph_(graph), plan_(plan), resources_(resources), policy_(policy),
      bindings_(device, graph.declaration()), targets_(device, graph.declaration(), resources) {}

void Recorder::record(VkCommandBuffer commands, gpu::DescriptorArena& descriptors,
    const QueueFamily& family, std::uint32_t index, bool skip) {
    const Step& step = plan_.steps[index];
    const gpu::Label label(device_, commands, graph_.declaration().passes[step.pass].name);
    if (policy_.poison) resources_.record_poison(commands, index);
    record_barriers(commands, plan_.barriers_before(step));
    if (!skip) record_pass(commands, descriptors, family, step.pass);
    record_barriers(commands, plan_.releases_after(step));
}

void Recorder::record_exit(VkCommandBuffer commands) const {
    record_barriers(commands, plan_.exit_barriers());
}

void Recorder::record_barriers(VkCommandBuffer commands, std::span<const Barrier> barriers) const {
    BarrierBatch batch({.one_family = policy_.one_family,
        .spell_out = device_.validation() == gpu::Validation::sync});
    for (const Barrier& barrier : barriers) batch.add(barrier, resources_[barrier.resource]);
    batch.record(commands);
}

void Recorder::record_pass(VkCommandBuffer commands, gpu::DescriptorArena& descriptors,
    const QueueFamily& family, PassId pass) {
    const Declaration& declaration = graph_.declaration();
    const bool raster = declaration.passes[pass].kind == PassKind::raster;
    const RasterTarget* const target = raster ? &targets_.of(pass) : nullptr;
    if (target) begin_raster(commands, declaration, *target);
    Recording recording{device_, declaration, resources_, bindings_, descriptors, family};
    CommandsImpl impl(recording, pass, commands, target);
    Commands front(impl);
    const std::function<void(Commands&)>& recorder = graph_.recorder(pass);
    if (recorder) recorder(front);
    if (target) vkCmdEndRenderPass(commands);
}

} // namespace ockham
