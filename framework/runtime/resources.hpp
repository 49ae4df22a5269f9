// SPDX-License-Identifier: Apache-2.0
// The real buffers and images behind a plan: created in its heaps, bound by the caller, rotated as
// histories, poisoned on request. For the executor only.
#pragma once

#include "framework/gpu/buffer.hpp"
#include "framework/gpu/image.hpp"
#include "framework/graph/graph.hpp"
#include "framework/graph/plan.hpp"

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace ockham {

namespace gpu {
class Device;
} // namespace gpu

/// The real thing behind a declared resource; both null while it is culled or not bound.
struct Resource {
    const gpu::Buffer* buffer = nullptr;
    const gpu::Image* image = nullptr;
    std::uint64_t bytes = 0; ///< of a buffer, as declared
};

/// What a declared resource must be created with for `plan`; the ages of a history change places,
/// so each has what all need. Resources that several queue families of `families` use, and keep,
/// are shared among these.
gpu::BufferInfo buffer_info(const Declaration& declaration, const Plan& plan, ResourceId id,
    const std::vector<std::uint32_t>& families);
gpu::ImageInfo image_info(const Declaration& declaration, const Plan& plan, ResourceId id,
    const std::vector<std::uint32_t>& families);
/// Queue families of the plan's queues, each once.
std::vector<std::uint32_t> families_of(const Plan& plan);

gpu::ImageRange range_of(const Part& part);

class Resources {
public:
    /// Creates what the plan places. Persistent resources are zero and in their final state.
    /// `graph` and `plan` must outlive this object. `one_family`: all queues are of one.
    Resources(gpu::Device& device, const Graph& graph, const Plan& plan, bool one_family);

    const Resource& operator[](ResourceId id) const { return resources_[id]; }

    /// For imports; see Executor::bind.
    void bind(ResourceId id, const gpu::Buffer& buffer);
    void bind(ResourceId id, const gpu::Image& image);
    /// Throws unless all imports are bound and images are in their entry layout.
    void expect_bound() const;
    /// In which the image is now: as the last execution left it, or as it was bound since.
    VkImageLayout layout(ResourceId id) const { return layouts_[id]; }
    /// An execution has been recorded: what comes next finds resources as it left them.
    void finish();
    /// What was written before becomes `by` executions older; 1, or -1 to take that back.
    void rotate(int by);
    /// Copies persistent resources of equal name and description from another graph's. Both
    /// graphs must not be executing.
    void keep_content(const Resources& old);

    /// Persistent resources and ages of histories that exist, in order of declaration.
    std::vector<ResourceId> persistent() const;
    /// Content of one of them on the host, as SavedResource has it. Nothing may be executing.
    std::vector<std::byte> content(ResourceId id) const;
    /// The other way; as many bytes as content() gives.
    void set_content(ResourceId id, std::span<const std::byte> bytes);

    /// Transient memory is filled with NaNs before each first use from now on.
    void enable_poison();
    /// Does so for what `step` uses first; after enable_poison() only.
    void record_poison(VkCommandBuffer commands, std::uint32_t step) const;

private:
    struct Ring {
        ResourceId first = 0;
        std::uint32_t count = 0;
    };
    void create_heaps();
    void create(const Placement& placement, const std::vector<std::uint32_t>& families);
    void clear_persistent();
    const ResourceDecl& external(ResourceId id, ResourceKind kind) const;
    void expect_usage(ResourceId id, std::uint32_t found, const std::string& name) const;
    Barrier state_barrier(ResourceId id, bool into_copy, bool from_nothing, Access copy) const;
    void copy_content(ResourceId id, const gpu::Buffer& staging, Access access) const;
    const Declaration& declaration() const { return graph_.declaration(); }

    gpu::Device& device_;
    const Graph& graph_;
    const Plan& plan_;
    std::vector<gpu::Memory> heaps_;
    std::vector<gpu::Buffer> buffers_;
    std::vector<gpu::Image> images_;
    std::vector<Resource> resources_;                 ///< by ResourceId
    std::vector<VkImageLayout> layouts_;              ///< by ResourceId; see layout()
    std::vector<Ring> rings_;                         ///< histories of which all ages exist
    std::vector<std::optional<gpu::Buffer>> poisons_; ///< by heap: all of it as a buffer
};

} // namespace ockham
