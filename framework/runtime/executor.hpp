// SPDX-License-Identifier: Apache-2.0
// Executes a graph: compiles it once, owns its resources and pipelines, records the plan, submits,
// and reports GPU times. Retained: executing again plans nothing. One per graph; several may share
// a device.
#pragma once

#include "framework/core/image.hpp"
#include "framework/gpu/device.hpp"
#include "framework/graph/compile.hpp"
#include "framework/graph/graph.hpp"

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
};

/// Compiles for this device: asks it what memory each resource takes (kept in the declaration) and
/// what it allows. Throws the errors of compile().
Plan make_plan(const gpu::Device& device, Graph& graph, const Policy& policy = {});

class Executor {
public:
    /// Compiles and creates everything the plan needs. Throws the errors of compile(), and
    /// Error(device) where memory or a feature is missing. `device` must outlive this object.
    Executor(gpu::Device& device, Graph graph, const Policy& policy = {});
    /// The same with a plan from make_plan() for this graph and device, taken as it is.
    Executor(gpu::Device& device, Graph graph, Plan plan);
    ~Executor();
    Executor(Executor&&) noexcept;
    Executor& operator=(Executor&&) noexcept;

    /// Binds the caller's resource to an imported handle. Must be done once before execute();
    /// binding another one later is fine between executions. It must outlive its last execution,
    /// and have the declared size and format and the usage that the plan asks for: Error(input).
    void bind(BufferHandle handle, const gpu::Buffer& buffer);
    void bind(ImageHandle handle, const gpu::Image& image);

    /// Records, submits and waits for one execution. Recording functions run each time (twice under
    /// Validation::sync), so what they capture may change in between; the plan, pipelines and
    /// memory stay. Throws Error(input) for what is not bound or wrongly recorded, and
    /// Error(device) where the device is lost or full.
    void execute();
    /// GPU times of the passes of the last execution, in order. Under Validation::sync they are
    /// there but mean little.
    const std::vector<PassTime>& times() const;

    /// Content of an exported, persistent or external resource after execute(). Error(input) for
    /// others: their memory is not kept.
    std::vector<std::byte> read(BufferHandle buffer);
    /// Layer 0, mip 0 of a 2D image of a colour or depth format as floats; integer formats give
    /// their values. Channels are named R, G, B, A as many as the format has.
    Image read(ImageHandle image);

    const Graph& graph() const;
    const Plan& plan() const;
    /// Different pipelines that the passes have used so far.
    std::size_t pipeline_count() const;

private:
    class Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace ockham
