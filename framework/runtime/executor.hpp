// SPDX-License-Identifier: Apache-2.0
// Executes a graph: compiles it once, owns its resources and pipelines, records the plan, submits,
// and reports GPU times. Retained: executing again plans nothing. One per graph, used by one thread
// at a time; several may share a device, from several threads.
#pragma once

#include "framework/core/image.hpp"
#include "framework/gpu/device.hpp"
#include "framework/runtime/planning.hpp"

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace ockham {

namespace gpu {
class Buffer;
class Image;
} // namespace gpu

struct PassTime {
    std::string pass;
    double milliseconds = 0; ///< GPU time between timestamps around the pass, its barriers included
    bool skipped = false;    ///< a condition left it out; only its barriers took time
};

struct ExecutorOptions {
    /// Measure passes in execute() and submit(). On software devices this serialises them.
    bool times = true;
    /// Fill transient memory with NaNs (0x7fc0dead) before its first use in each execution, so that
    /// reading what was not written shows. Also by the environment: OCKHAM_POISON=1.
    bool poison = false;
    /// Executions that may be in flight at a time, >= 1; submit() waits when there are more. So
    /// many recordings by record() may be pending.
    std::uint32_t slots = 1;
    /// Not empty: plans as for a device with these queue families and runs the plan on the main
    /// queue alone, with its waits and without its changes of owner. For tests on devices that have
    /// one queue.
    std::vector<QueueFamily> pretended_families = {};
    /// Where plans are looked up and kept, by executors of one device; must outlive them. Null:
    /// not.
    PlanCache* plans = nullptr;
    /// In debug builds and under Validation::sync, verify() checks the plan first; a violation is
    /// an Error.
    bool verify = true;
};

/// Semaphores of an import's owner, for the next execution. It waits for `wait` before anything
/// uses the import and signals `signal` once nothing does; null semaphores: neither. Each queue
/// that uses the import waits, so where the plan has several, `wait` must be a timeline semaphore.
struct ImportSync {
    gpu::TimelinePoint wait;
    gpu::TimelinePoint signal;
};

/// Content of a persistent resource on the host: the bytes of a buffer, or the texels of an image
/// without gaps, its mips one after the other, each layer by layer.
struct SavedResource {
    std::string name;
    std::vector<std::byte> bytes;
};

class Executor {
public:
    /// Compiles and creates everything the plan needs. Throws the errors of compile(), and
    /// Error(device) where memory or a feature is missing. `device` must outlive this object.
    Executor(gpu::Device& device, Graph graph, const Policy& policy = {},
        const ExecutorOptions& options = {});
    /// The same with a plan from make_plan() for this graph and device, taken as it is. `policy`:
    /// by which update() plans anew; give the plan's.
    Executor(gpu::Device& device, Graph graph, Plan plan, const ExecutorOptions& options = {},
        const Policy& policy = {});
    /// Waits for what is in flight. What was recorded by record() must be over; so it must before
    /// update() with another graph and read().
    ~Executor();
    Executor(Executor&&) noexcept;
    Executor& operator=(Executor&&) noexcept;

    /// Binds the caller's resource to an imported handle. Must be done once before execute();
    /// binding another one later is fine between executions, and waits for none of them. It must
    /// outlive its last execution, and have the declared size and format and the usage that the
    /// plan asks for: Error(input).
    void bind(BufferHandle handle, const gpu::Buffer& buffer, const ImportSync& sync = {});
    void bind(ImageHandle handle, const gpu::Image& image, const ImportSync& sync = {});
    /// Answers a condition, for the executions from now on; `true` until then.
    void set(Condition condition, bool value);

    /// Records, submits and waits for one execution. Recording functions run each time (twice under
    /// Validation::sync), so what they capture may change in between; the plan, pipelines and
    /// memory stay. Throws Error(input) for what is not bound or wrongly recorded, and
    /// Error(device) where the device is lost or full.
    void execute();
    /// The same in two halves: submit() returns once everything is under way.
    void submit();
    void wait();
    /// Records one execution into the caller's command buffer, which must be recording, outside a
    /// render pass, and be submitted to the main queue before anything else is recorded or
    /// executed. For plans of one queue; Error(input) otherwise. Takes no times.
    void record(VkCommandBuffer commands);
    /// GPU times of the passes of the last execution that was waited for, in order; none where they
    /// were not asked for. Under Validation::sync they are there but mean little.
    const std::vector<PassTime>& times() const;

    /// Takes up a graph that was declared anew. With the same fingerprint only its recording
    /// functions and clear values replace those of the old; bindings and conditions stay. Else it
    /// is planned and created, and persistent resources and histories of equal name and description
    /// keep their content; imports must be bound again. True: the plan is the old one.
    bool update(Graph graph);

    /// Content of an exported, persistent or external resource after an execution, as its handles
    /// meant it there: of a history, `now` is what was written last. Error(input) for others: their
    /// memory is not kept. Waits for what is in flight.
    std::vector<std::byte> read(BufferHandle buffer);
    /// The first mip and layer of the part (all of a handle) of a 2D image of a colour or depth
    /// format as floats; integer formats give their values. Channels are named R, G, B, A as many
    /// as the format has.
    Image read(const ImagePart& image);

    /// What the executions so far leave for the next: every persistent resource and age of a
    /// history that the plan keeps, in order of declaration. Waits for what is in flight.
    std::vector<SavedResource> save();
    /// Puts that into an executor of an equal graph, which then goes on as this one would have.
    /// Error(input) naming the resource where names or sizes differ; then some have been changed.
    void restore(const std::vector<SavedResource>& saved);

    const Graph& graph() const;
    const Plan& plan() const;
    /// Different pipelines that the passes have used so far.
    std::size_t pipeline_count() const;

private:
    class Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace ockham
