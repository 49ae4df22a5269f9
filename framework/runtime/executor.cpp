// SPDX-License-Identifier: Apache-2.0
#include "framework/runtime/executor.hpp"

#include "framework/core/error.hpp"
#include "framework/gpu/buffer.hpp"
#include "framework/gpu/descriptors.hpp"
#include "framework/gpu/image.hpp"
#include "framework/gpu/memory.hpp"
#include "framework/gpu/pipeline.hpp"
#include "framework/gpu/timestamps.hpp"
#include "framework/gpu/transfer.hpp"
#include "framework/graph/explain.hpp"
#include "framework/runtime/commands_impl.hpp"

#include <algorithm>
#include <optional>
#include <set>

namespace ockham {

namespace {

/// Whole words, so that fills cover all of it.
gpu::BufferInfo buffer_info(const ResourceDecl& resource, VkBufferUsageFlags usage) {
    return {.bytes = (resource.buffer.bytes + 3) / 4 * 4, .usage = usage, .name = resource.name};
}

gpu::ImageInfo image_info(const ResourceDecl& resource, VkImageUsageFlags usage) {
    const ImageDesc& desc = resource.image;
    return {.format = desc.format,
        .width = desc.width,
        .height = desc.height,
        .depth = desc.depth,
        .layers = desc.layers,
        .mips = desc.mips,
        .usage = usage,
        .name = resource.name,
        .aliased = resource.lifetime == Lifetime::transient && !resource.exported};
}

Capabilities capabilities_of(const gpu::Device& device) {
    const gpu::Limits& limits = device.limits();
    return {.buffer_image_granularity = limits.buffer_image_granularity,
        .max_buffer_bytes = limits.buffer_bytes,
        .max_image_extent = limits.image_extent};
}

/// A barrier's dependency on one resource, of whole buffers and images.
class BarrierBatch {
public:
    void add(const Barrier& barrier, const Resource& resource) {
        if (barrier.hazard == Hazard::alias) {
            // The memory was written through another resource, which a barrier on this one does
            // not cover.
            memory_.push_back({.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
                .srcStageMask = barrier.src_stages,
                .srcAccessMask = barrier.src_access,
                .dstStageMask = barrier.dst_stages,
                .dstAccessMask = barrier.dst_access});
        }
        if (resource.buffer) {
            buffers_.push_back({.sType = VK_STRUCTURE_TYPE_BUFFER_MEMORY_BARRIER_2,
                .srcStageMask = barrier.src_stages,
                .srcAccessMask = barrier.src_access,
                .dstStageMask = barrier.dst_stages,
                .dstAccessMask = barrier.dst_access,
                .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                .buffer = resource.buffer->handle(),
                .size = VK_WHOLE_SIZE});
        } else {
            const gpu::ImageInfo& info = resource.image->info();
            images_.push_back({.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
                .srcStageMask = barrier.src_stages,
                .srcAccessMask = barrier.src_access,
                .dstStageMask = barrier.dst_stages,
                .dstAccessMask = barrier.dst_access,
                .oldLayout = barrier.old_layout,
                .newLayout = barrier.new_layout,
                .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                .image = resource.image->handle(),
                .subresourceRange = {.aspectMask = resource.image->aspect(),
                    .levelCount = info.mips,
                    .layerCount = info.layers}});
        }
    }

    void record(VkCommandBuffer commands) const {
        if (buffers_.empty() && images_.empty()) return;
        const VkDependencyInfo info{.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
            .memoryBarrierCount = static_cast<std::uint32_t>(memory_.size()),
            .pMemoryBarriers = memory_.data(),
            .bufferMemoryBarrierCount = static_cast<std::uint32_t>(buffers_.size()),
            .pBufferMemoryBarriers = buffers_.data(),
            .imageMemoryBarrierCount = static_cast<std::uint32_t>(images_.size()),
            .pImageMemoryBarriers = images_.data()};
        vkCmdPipelineBarrier2(commands, &info);
    }

private:
    std::vector<VkMemoryBarrier2> memory_;
    std::vector<VkBufferMemoryBarrier2> buffers_;
    std::vector<VkImageMemoryBarrier2> images_;
};

/// Command buffers of one execution, from one pool that is reset before the next.
class CommandBuffers {
public:
    explicit CommandBuffers(gpu::Device& device) : device_(device) {
        const VkCommandPoolCreateInfo info{.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
            .queueFamilyIndex = device.queue_family()};
        gpu::expect(vkCreateCommandPool(device.handle(), &info, nullptr, &pool_),
            "creating a command pool");
    }
    ~CommandBuffers() { vkDestroyCommandPool(device_.handle(), pool_, nullptr); }
    CommandBuffers(const CommandBuffers&) = delete;
    CommandBuffers& operator=(const CommandBuffers&) = delete;

    void reset() {
        gpu::expect(vkResetCommandPool(device_.handle(), pool_, 0), "resetting a command pool");
        begun_ = 0;
        open_ = VK_NULL_HANDLE; // left open by an error while recording
    }
    /// Ends the present buffer, if any, and begins another.
    VkCommandBuffer begin() {
        end();
        if (begun_ == buffers_.size()) {
            const VkCommandBufferAllocateInfo info{
                .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                .commandPool = pool_,
                .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                .commandBufferCount = 1};
            VkCommandBuffer buffer = VK_NULL_HANDLE;
            gpu::expect(vkAllocateCommandBuffers(device_.handle(), &info, &buffer),
                "allocating a command buffer");
            buffers_.push_back(buffer);
        }
        open_ = buffers_[begun_++];
        const VkCommandBufferBeginInfo info{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
            .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
        gpu::expect(vkBeginCommandBuffer(open_, &info), "beginning a command buffer");
        return open_;
    }
    std::size_t begun() const { return begun_; } ///< since reset()
    /// Ends the present buffer and gives all since reset().
    std::span<const VkCommandBuffer> finish() {
        end();
        return {buffers_.data(), begun_};
    }

private:
    void end() {
        if (open_) gpu::expect(vkEndCommandBuffer(open_), "ending a command buffer");
        open_ = VK_NULL_HANDLE;
    }

    gpu::Device& device_;
    VkCommandPool pool_ = VK_NULL_HANDLE;
    std::vector<VkCommandBuffer> buffers_;
    std::size_t begun_ = 0;
    VkCommandBuffer open_ = VK_NULL_HANDLE;
};

} // namespace

Plan make_plan(const gpu::Device& device, Graph& graph, const Policy& policy) {
    const Capabilities capabilities = capabilities_of(device);
    // Memory needs follow from usage bits, and these from what is culled: plan once without needs.
    Policy without_budget = policy;
    without_budget.memory_budget_bytes = 0;
    const Plan draft = compile(graph.declaration(), capabilities, without_budget);
    for (const Placement& placement : draft.placements) {
        ResourceDecl& resource = graph.declaration().resources[placement.resource];
        const std::uint32_t usage = draft.usages[placement.resource];
        const VkMemoryRequirements need =
            resource.kind == ResourceKind::buffer
                ? gpu::memory_requirements(device, buffer_info(resource, usage))
                : gpu::memory_requirements(device, image_info(resource, usage));
        resource.memory = {need.size, need.alignment, need.memoryTypeBits};
    }
    return compile(graph.declaration(), capabilities, policy);
}

class Executor::Impl {
public:
    Impl(gpu::Device& device, Graph graph, Plan plan)
        : device_(device), graph_(std::move(graph)), plan_(std::move(plan)), descriptors_(device),
          commands_(device) {
        const Declaration& declaration = graph_.declaration();
        resources_.resize(declaration.resources.size());
        externals_.resize(declaration.resources.size());
        targets_.resize(declaration.passes.size());
        for (const Use& use : declaration.uses) {
            if (writes(use.access)) resources_[use.resource].written = true;
        }
        create_resources();
        clear_persistent();
        if (!plan_.steps.empty()) {
            timestamps_.emplace(device, static_cast<std::uint32_t>(plan_.steps.size()) + 1);
        }
    }

    ~Impl() {
        for (RasterTarget& target : targets_) destroy(target);
    }

    void bind(ResourceId id, const gpu::Buffer& buffer) {
        const ResourceDecl& resource = external(id, ResourceKind::buffer);
        if (buffer.bytes() < resource.buffer.bytes) {
            fail_input("buffer '{}' with {} bytes cannot stand for '{}' with {}", buffer.name(),
                buffer.bytes(), resource.name, resource.buffer.bytes);
        }
        expect_usage(id, buffer.usage(), buffer.name());
        resources_[id].buffer = &buffer;
    }

    void bind(ResourceId id, const gpu::Image& image) {
        const ResourceDecl& resource = external(id, ResourceKind::image);
        const gpu::ImageInfo& found = image.info();
        const ImageDesc& wanted = resource.image;
        if (found.format != wanted.format || found.width != wanted.width ||
            found.height != wanted.height || found.depth != wanted.depth ||
            found.layers != wanted.layers || found.mips != wanted.mips) {
            fail_input(
                "image '{}' ({}, {} x {} x {}, {} layers, {} mips) cannot stand for '{}' ({}, "
                "{} x {} x {}, {} layers, {} mips)",
                image.name(), gpu::name_of(found.format), found.width, found.height, found.depth,
                found.layers, found.mips, resource.name, gpu::name_of(wanted.format), wanted.width,
                wanted.height, wanted.depth, wanted.layers, wanted.mips);
        }
        expect_usage(id, found.usage, image.name());
        resources_[id].image = &image;
        externals_[id].layout = resource.entry.layout;
        for (std::size_t pass = 0; pass < targets_.size(); ++pass) {
            for (const Use& use : uses_of(static_cast<PassId>(pass))) {
                if (use.resource == id) destroy(targets_[pass]);
            }
        }
    }

    void execute() {
        expect_externals();
        commands_.reset();
        descriptors_.reset();
        times_.clear();
        if (plan_.steps.empty()) return;
        // The validation layer misses write-after-write inside one command buffer, and
        // write-after-read between two. So it sees both: the whole frame in one buffer that is
        // never submitted, then one buffer per pass.
        const bool validate = device_.validation() == gpu::Validation::sync;
        if (validate) record_frame(false, false);
        const std::size_t unsubmitted = commands_.begun();
        record_frame(true, validate);
        device_.submit(commands_.finish().subspan(unsubmitted), graph_.name());
        executed_ = true;
        for (ResourceId id = 0; id < externals_.size(); ++id) {
            externals_[id].layout = plan_.final_states[id].layout;
        }
        read_times();
    }

    std::vector<std::byte> read(BufferHandle handle) {
        const ResourceDecl& resource = readable(handle.resource, ResourceKind::buffer);
        return gpu::download(
            device_, *resources_[handle.resource].buffer, 0, resource.buffer.bytes);
    }

    Image read(ImageHandle handle) {
        const ResourceDecl& resource = readable(handle.resource, ResourceKind::image);
        const gpu::FormatInfo* format = gpu::find_format(resource.image.format);
        if (!format || resource.image.depth > 1) {
            fail_input("image '{}' of format {} and depth {} cannot be read as a picture",
                resource.name, gpu::name_of(resource.image.format), resource.image.depth);
        }
        const std::vector<float> values =
            gpu::decode_texels(*format, gpu::download(device_, *resources_[handle.resource].image,
                                            plan_.final_states[handle.resource].layout));
        const std::vector<std::string> names{"R", "G", "B", "A"};
        Image image(static_cast<int>(resource.image.width), static_cast<int>(resource.image.height),
            {names.begin(), names.begin() + format->channels});
        for (std::uint32_t channel = 0; channel < format->channels; ++channel) {
            const std::span<float> plane = image.plane(static_cast<int>(channel));
            for (std::size_t i = 0; i < plane.size(); ++i) {
                plane[i] = values[i * format->channels + channel];
            }
        }
        return image;
    }

    const std::vector<PassTime>& times() const { return times_; }
    const Graph& graph() const { return graph_; }
    const Plan& plan() const { return plan_; }
    std::size_t pipeline_count() const { return pipelines_.size(); }

private:
    /// Layout in which a bound image is now.
    struct External {
        VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;
    };

    std::span<const Use> uses_of(PassId pass) const {
        const PassDecl& decl = graph_.declaration().passes[pass];
        return {graph_.declaration().uses.data() + decl.first_use, decl.use_count};
    }

    void create_resources() {
        const Declaration& declaration = graph_.declaration();
        std::vector<std::uint64_t> alignments(plan_.heaps.size(), 1);
        std::vector<const char*> names(plan_.heaps.size(), "transient resources");
        for (const Placement& placement : plan_.placements) {
            const ResourceDecl& resource = declaration.resources[placement.resource];
            alignments[placement.heap] =
                std::max(alignments[placement.heap], resource.memory.alignment);
            if (!plan_.heaps[placement.heap].shared) names[placement.heap] = resource.name.c_str();
        }
        for (std::size_t i = 0; i < plan_.heaps.size(); ++i) {
            heaps_.push_back(device_.allocator().allocate(
                {plan_.heaps[i].bytes, alignments[i], plan_.heaps[i].type_bits},
                gpu::MemoryUse::device, names[i]));
        }
        buffers_.reserve(plan_.placements.size());
        images_.reserve(plan_.placements.size());
        for (const Placement& placement : plan_.placements) {
            const ResourceDecl& resource = declaration.resources[placement.resource];
            const std::uint32_t usage = plan_.usages[placement.resource];
            const gpu::Memory& heap = heaps_[placement.heap];
            if (resource.kind == ResourceKind::buffer) {
                resources_[placement.resource].buffer = &buffers_.emplace_back(
                    device_, buffer_info(resource, usage), heap, placement.offset);
            } else {
                resources_[placement.resource].image = &images_.emplace_back(
                    device_, image_info(resource, usage), heap, placement.offset);
            }
        }
    }

    /// Zeroes persistent resources and puts them into the state that every execution leaves them
    /// in.
    void clear_persistent() {
        std::vector<ResourceId> fresh;
        for (const Placement& placement : plan_.placements) {
            const ResourceDecl& resource = graph_.declaration().resources[placement.resource];
            if (resource.lifetime == Lifetime::persistent) fresh.push_back(placement.resource);
        }
        if (fresh.empty()) return;
        device_.run("clearing persistent resources", [&](VkCommandBuffer commands) {
            const auto barrier_all = [&](bool before) {
                BarrierBatch batch;
                for (const ResourceId id : fresh) {
                    Barrier barrier;
                    barrier.resource = id;
                    const VkImageLayout layout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
                    barrier.dst_stages = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT;
                    barrier.dst_access = VK_ACCESS_2_TRANSFER_WRITE_BIT;
                    barrier.new_layout = layout;
                    if (!before) {
                        const AccessState& final_state = plan_.final_states[id];
                        barrier.src_stages = barrier.dst_stages;
                        barrier.src_access = barrier.dst_access;
                        barrier.old_layout = layout;
                        barrier.dst_stages = final_state.stages;
                        barrier.dst_access = final_state.access;
                        barrier.new_layout = final_state.layout;
                    }
                    batch.add(barrier, resources_[id]);
                }
                batch.record(commands);
            };
            barrier_all(true);
            for (const ResourceId id : fresh) clear(commands, resources_[id]);
            barrier_all(false);
        });
    }

    static void clear(VkCommandBuffer commands, const Resource& resource) {
        if (resource.buffer) {
            vkCmdFillBuffer(commands, resource.buffer->handle(), 0, VK_WHOLE_SIZE, 0);
        } else {
            gpu::clear(commands, *resource.image, {0, 0, 0, 0});
        }
    }

    const ResourceDecl& external(ResourceId id, ResourceKind kind) const {
        const Declaration& declaration = graph_.declaration();
        check(id < declaration.resources.size() && declaration.resources[id].kind == kind,
            "bind() of a handle that is not of this graph");
        const ResourceDecl& resource = declaration.resources[id];
        if (resource.lifetime != Lifetime::external) {
            fail_input("'{}' of graph '{}' is not imported, so nothing can be bound to it",
                resource.name, graph_.name());
        }
        return resource;
    }

    void expect_usage(ResourceId id, std::uint32_t found, const std::string& name) const {
        const std::uint32_t missing = plan_.usages[id] & ~found;
        if (missing == 0) return;
        fail_input("'{}' cannot stand for '{}': it lacks usage bits {:#x} (has {:#x})", name,
            graph_.declaration().resources[id].name, missing, found);
    }

    void expect_externals() const {
        for (ResourceId id = 0; id < resources_.size(); ++id) {
            const ResourceDecl& resource = graph_.declaration().resources[id];
            if (resource.lifetime != Lifetime::external || plan_.resources[id].culled) continue;
            const bool bound = resources_[id].buffer || resources_[id].image;
            if (!bound) {
                fail_input(
                    "graph '{}' imports '{}', but nothing is bound to it; call bind() before "
                    "execute()",
                    graph_.name(), resource.name);
            }
            const VkImageLayout entry = resource.entry.layout;
            if (resources_[id].image && entry != VK_IMAGE_LAYOUT_UNDEFINED &&
                externals_[id].layout != entry) {
                fail_input(
                    "image '{}' enters graph '{}' in layout {} but was left in {}; import it "
                    "with an exit state, or bind() it again once it is back",
                    resource.name, graph_.name(), static_cast<int>(entry),
                    static_cast<int>(externals_[id].layout));
            }
        }
    }

    const ResourceDecl& readable(ResourceId id, ResourceKind kind) const {
        const Declaration& declaration = graph_.declaration();
        check(id < declaration.resources.size() && declaration.resources[id].kind == kind,
            "read() of a handle that is not of this graph");
        const ResourceDecl& resource = declaration.resources[id];
        if (plan_.resources[id].culled) {
            fail_input("'{}' of graph '{}' cannot be read: it is culled, {}", resource.name,
                graph_.name(), reason_of_resource(declaration, plan_, id));
        }
        if (resource.lifetime == Lifetime::transient && !resource.exported) {
            fail_input("'{}' of graph '{}' cannot be read: its memory is not kept; export it",
                resource.name, graph_.name());
        }
        const bool persistent = resource.lifetime == Lifetime::persistent;
        if (!executed_ && !persistent) {
            fail_input(
                "'{}' of graph '{}' cannot be read before execute()", resource.name, graph_.name());
        }
        return resource;
    }

    void record_barriers(VkCommandBuffer commands, std::uint32_t first, std::uint32_t count) const {
        BarrierBatch batch;
        for (std::uint32_t i = first; i < first + count; ++i) {
            batch.add(plan_.barriers[i], resources_[plan_.barriers[i].resource]);
        }
        batch.record(commands);
    }

    /// Records all steps; `split`: each in a command buffer of its own.
    void record_frame(bool timed, bool split) {
        VkCommandBuffer commands = commands_.begin();
        if (timed) {
            timestamps_->reset(commands);
            timestamps_->write(commands, 0);
        }
        for (std::uint32_t i = 0; i < plan_.steps.size(); ++i) {
            if (split && i > 0) commands = commands_.begin();
            record(commands, plan_.steps[i]);
            if (timed) timestamps_->write(commands, i + 1);
        }
        if (split && plan_.exit_barrier_count > 0) commands = commands_.begin();
        record_barriers(commands, plan_.first_exit_barrier, plan_.exit_barrier_count);
    }

    void record(VkCommandBuffer commands, const Step& step) {
        const PassDecl& pass = graph_.declaration().passes[step.pass];
        const gpu::Label label(device_, commands, pass.name);
        record_barriers(commands, step.first_barrier, step.barrier_count);
        const std::function<void(Commands&)>& recorder = graph_.recorder(step.pass);
        Recording recording{device_, graph_.declaration(), resources_, descriptors_, pipelines_};
        if (pass.kind != PassKind::raster) {
            CommandsImpl impl(recording, step.pass, commands, nullptr);
            Commands front(impl);
            if (recorder) recorder(front);
            return;
        }
        const RasterTarget& target = raster_target(step.pass);
        begin_raster(commands, target);
        CommandsImpl impl(recording, step.pass, commands, &target);
        Commands front(impl);
        if (recorder) recorder(front);
        vkCmdEndRenderPass(commands);
    }

    static void begin_raster(VkCommandBuffer commands, const RasterTarget& target) {
        const VkRenderPassBeginInfo begin{.sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO,
            .renderPass = target.render_pass,
            .framebuffer = target.framebuffer,
            .renderArea = {.extent = target.extent},
            .clearValueCount = static_cast<std::uint32_t>(target.clears.size()),
            .pClearValues = target.clears.data()};
        vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
        const VkViewport viewport{0, 0, static_cast<float>(target.extent.width),
            static_cast<float>(target.extent.height), 0, 1};
        const VkRect2D scissor{.extent = target.extent};
        vkCmdSetViewport(commands, 0, 1, &viewport);
        vkCmdSetScissor(commands, 0, 1, &scissor);
        vkCmdSetCullMode(commands, VK_CULL_MODE_NONE);
        vkCmdSetFrontFace(commands, VK_FRONT_FACE_COUNTER_CLOCKWISE);
    }

    /// Made when first needed, and again after an attachment was bound anew.
    const RasterTarget& raster_target(PassId pass) {
        RasterTarget& target = targets_[pass];
        if (target.framebuffer) return target;
        const std::string& name = graph_.declaration().passes[pass].name;
        std::vector<VkImageView> views;
        const Use* depth = nullptr;
        const auto add = [&](const Use& use) {
            const gpu::Image& image = *resources_[use.resource].image;
            const bool is_depth = use.access == Access::depth_attachment;
            const VkExtent2D extent{image.info().width, image.info().height};
            if (!views.empty() &&
                (extent.width != target.extent.width || extent.height != target.extent.height)) {
                fail_input("pass '{}': attachment '{}' is {} x {}, the others are {} x {}", name,
                    image.name(), extent.width, extent.height, target.extent.width,
                    target.extent.height);
            }
            target.extent = extent;
            const VkAttachmentLoadOp load = use.load == LoadOp::clear ? VK_ATTACHMENT_LOAD_OP_CLEAR
                                            : use.load == LoadOp::load
                                                ? VK_ATTACHMENT_LOAD_OP_LOAD
                                                : VK_ATTACHMENT_LOAD_OP_DONT_CARE;
            target.attachments.push_back({image.info().format, load, is_depth});
            target.clears.push_back(
                gpu::clear_value(image.info().format, graph_.declaration().detail_of(use).clear));
            views.push_back(image.view(VK_IMAGE_VIEW_TYPE_2D, false));
        };
        for (const Use& use : uses_of(pass)) {
            if (use.access == Access::color_attachment) add(use);
            if (use.access == Access::depth_attachment) depth = &use;
        }
        if (depth) add(*depth);
        if (views.empty()) fail_input("pass '{}' is a raster pass without attachments", name);
        target.render_pass = device_.pipelines().render_pass(target.attachments);
        const VkFramebufferCreateInfo info{.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO,
            .renderPass = target.render_pass,
            .attachmentCount = static_cast<std::uint32_t>(views.size()),
            .pAttachments = views.data(),
            .width = target.extent.width,
            .height = target.extent.height,
            .layers = 1};
        gpu::expect(vkCreateFramebuffer(device_.handle(), &info, nullptr, &target.framebuffer),
            fmt::format("creating the framebuffer of pass '{}'", name));
        gpu::set_name(device_, VK_OBJECT_TYPE_FRAMEBUFFER, target.framebuffer, name);
        return target;
    }

    void destroy(RasterTarget& target) {
        vkDestroyFramebuffer(device_.handle(), target.framebuffer, nullptr);
        target = {};
    }

    void read_times() {
        const std::vector<double> nanoseconds = timestamps_->read();
        for (std::size_t i = 0; i < plan_.steps.size(); ++i) {
            times_.push_back({graph_.declaration().passes[plan_.steps[i].pass].name,
                (nanoseconds[i + 1] - nanoseconds[i]) * 1e-6});
        }
    }

    gpu::Device& device_;
    Graph graph_;
    Plan plan_;
    std::vector<gpu::Memory> heaps_;
    std::vector<gpu::Buffer> buffers_;
    std::vector<gpu::Image> images_;
    std::vector<Resource> resources_;   ///< by ResourceId
    std::vector<External> externals_;   ///< by ResourceId
    std::vector<RasterTarget> targets_; ///< by PassId
    gpu::DescriptorArena descriptors_;
    CommandBuffers commands_;
    std::optional<gpu::Timestamps> timestamps_;
    std::set<const gpu::Pipeline*> pipelines_;
    std::vector<PassTime> times_;
    bool executed_ = false;
};

Executor::Executor(gpu::Device& device, Graph graph, const Policy& policy) {
    Plan plan = make_plan(device, graph, policy);
    impl_ = std::make_unique<Impl>(device, std::move(graph), std::move(plan));
}

Executor::Executor(gpu::Device& device, Graph graph, Plan plan)
    : impl_(std::make_unique<Impl>(device, std::move(graph), std::move(plan))) {}

Executor::~Executor() = default;
Executor::Executor(Executor&&) noexcept = default;
Executor& Executor::operator=(Executor&&) noexcept = default;

void Executor::bind(BufferHandle handle, const gpu::Buffer& buffer) {
    impl_->bind(handle.resource, buffer);
}
void Executor::bind(ImageHandle handle, const gpu::Image& image) {
    impl_->bind(handle.resource, image);
}
void Executor::execute() { impl_->execute(); }
const std::vector<PassTime>& Executor::times() const { return impl_->times(); }
std::vector<std::byte> Executor::read(BufferHandle buffer) { return impl_->read(buffer); }
Image Executor::read(ImageHandle image) { return impl_->read(image); }
const Graph& Executor::graph() const { return impl_->graph(); }
const Plan& Executor::plan() const { return impl_->plan(); }
std::size_t Executor::pipeline_count() const { return impl_->pipeline_count(); }

} // namespace ockham
