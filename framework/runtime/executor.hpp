// SPDX-License-Identifier: Apache-2.0
// Executes a graph: compiles it once, owns its resources and pipelines, records the plan, submits,
// and reports GPU times. Retained: executing again plans nothing. One per graph; several may share
// a device.
#pragma once

#include "framework/core/image.hpp"
#include "framework/gpu/device.hpp"
#include "framework/graph/compile.hpp"
#include "framework/graph/graph.hpp"

#include <memory>
#include <string>
#include <vector>

namespace ockham {

struct PassTime {
    std::string pass;
    double milliseconds = 0; ///< GPU time between timestamps around the pass, its barriers included
};

class Executor {
public:
    /// Compiles and creates everything the plan needs. Throws the errors of compile(), and
    /// Error(device) where memory or a feature is missing. `device` must outlive this object.
    Executor(gpu::Device& device, Graph graph, const Policy& policy = {});
    ~Executor();
    Executor(Executor&&) noexcept;
    Executor& operator=(Executor&&) noexcept;

    /// Binds the caller's resource to an imported handle. Must be done once before execute();
    /// binding another one later is fine between executions.
    void bind(BufferHandle handle, const gpu::Buffer& buffer);
    void bind(ImageHandle handle, const gpu::Image& image);

    /// Records (anew where something was bound since) and submits one execution, and waits for it.
    void execute();
    /// GPU times of the passes of the last execution, in order.
    const std::vector<PassTime>& times() const;

    /// Content of an exported, persistent or external resource after execute().
    std::vector<std::byte> read(BufferHandle buffer);
    /// Layer 0, mip 0 of a 2D image of a colour or depth format as floats; integer formats give
    /// their values. Channels are named R, G, B, A as many as the format has.
    Image read(ImageHandle image);

    const Graph& graph() const;
    const Plan& plan() const;
    std::size_t pipeline_count() const;

private:
    class Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace ockham
