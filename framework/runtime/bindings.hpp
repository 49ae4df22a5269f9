// SPDX-License-Identifier: Apache-2.0
// Which declared use each binding of a shader stands for. Found by name and checked against the
// shader's reflection once for each pair of pass and pipeline, then only looked up. For Commands.
#pragma once

#include "framework/gpu/device.hpp"
#include "framework/gpu/pipeline.hpp"
#include "framework/graph/declaration.hpp"

#include <map>
#include <set>
#include <utility>
#include <vector>

namespace ockham {

class Bindings {
public:
    /// Both must outlive this object; the declaration may be replaced by an equal one.
    Bindings(const gpu::Device& device, const Declaration& declaration);

    /// Indices into Declaration::uses, one for each slot of the pipeline's layout. Throws
    /// Error(input) with a code of docs/runtime.md where shader and declaration disagree.
    const std::vector<std::uint32_t>& of(PassId pass, const gpu::Pipeline& pipeline);
    std::size_t pipeline_count() const; ///< different ones so far

private:
    using Slot = gpu::PipelineLayout::Slot;
    std::uint32_t find(PassId pass, const Slot& slot) const;
    void check_kind(PassId pass, const Slot& slot, const Use& use) const;
    void check_direction(PassId pass, const Slot& slot, const Use& use) const;
    void check_stage(
        PassId pass, const gpu::Pipeline& pipeline, const Slot& slot, const Use& use) const;
    void check_buffer(PassId pass, const Slot& slot, const Use& use) const;
    void check_image(PassId pass, const Slot& slot, const Use& use) const;

    const gpu::Device& device_;
    const Declaration& declaration_;
    std::vector<std::uint8_t> written_; ///< by ResourceId: some pass of the graph writes it
    std::map<std::pair<PassId, const gpu::Pipeline*>, std::vector<std::uint32_t>> known_;
};

} // namespace ockham
