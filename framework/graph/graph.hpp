// SPDX-License-Identifier: Apache-2.0
// The public API of the render graph: declare resources and passes with typed, versioned handles.
// Declares only: compile() plans, runtime's Executor executes. Integrators start here.
#pragma once

#include "framework/graph/declaration.hpp"
#include "framework/graph/fingerprint.hpp"

#include <functional>
#include <source_location>
#include <string>
#include <string_view>
#include <vector>

namespace ockham {

class Commands; // framework/runtime/commands.hpp: what a pass may record
class Graph;

template <ResourceKind Kind>
struct PartOf;

/// One version of a resource's content. Writing returns the next version; using an old one is a
/// misuse. Copy freely. A default-constructed handle names nothing.
template <ResourceKind Kind>
struct Handle {
    ResourceId resource = kNone;
    std::uint32_t version = 0;
    explicit operator bool() const { return resource != kNone; }

    /// Parts to read or write where all of it would be more than the pass touches.
    PartOf<Kind> range(std::uint64_t offset, std::uint64_t bytes) const
        requires(Kind == ResourceKind::buffer);
    PartOf<Kind> mip(std::uint32_t index) const requires(Kind == ResourceKind::image);
    PartOf<Kind> mips(std::uint32_t first, std::uint32_t count) const
        requires(Kind == ResourceKind::image);
    PartOf<Kind> layer(std::uint32_t index) const requires(Kind == ResourceKind::image);
    PartOf<Kind> layers(std::uint32_t first, std::uint32_t count) const
        requires(Kind == ResourceKind::image);
};
using BufferHandle = Handle<ResourceKind::buffer>;
using ImageHandle = Handle<ResourceKind::image>;

/// A handle and which part of it: mips x layers of an image, bytes of a buffer. Writing a part
/// gives a new version of the whole, whose other parts keep their content.
template <ResourceKind Kind>
struct PartOf {
    Handle<Kind> handle;
    Part part;
    PartOf(Handle<Kind> whole, Part of = {}) : handle(whole), part(of) {}

    PartOf mip(std::uint32_t index) const requires(Kind == ResourceKind::image) {
        return mips(index, 1);
    }
    PartOf mips(std::uint32_t first, std::uint32_t count) const
        requires(Kind == ResourceKind::image);
    PartOf layer(std::uint32_t index) const requires(Kind == ResourceKind::image) {
        return layers(index, 1);
    }
    PartOf layers(std::uint32_t first, std::uint32_t count) const
        requires(Kind == ResourceKind::image);
};
using BufferPart = PartOf<ResourceKind::buffer>;
using ImagePart = PartOf<ResourceKind::image>;

/// The content of this execution and of those before: previous[0] is one execution old. Zero where
/// there was none yet.
template <class HandleType>
struct History {
    HandleType now;
    std::vector<HandleType> previous;
};

/// A yes or no that Executor::set gives before an execution.
struct Condition {
    ConditionId id = kNone;
};

/// Declares one pass; returned by Graph::add_*_pass and valid until the next pass is added.
/// `binding` is the name of the buffer block, image or sampler in the pass's shaders.
class PassBuilder {
public:
    /// Reads. The content must have been written before, by a pass or from outside.
    PassBuilder& sample(std::string_view binding, ImagePart image, Stage stage = Stage::compute,
        Filter filter = Filter::texel);
    PassBuilder& read(std::string_view binding, BufferPart buffer, Stage stage = Stage::compute);
    PassBuilder& read(std::string_view binding, ImagePart image, Stage stage = Stage::compute);
    PassBuilder& uniform(std::string_view binding, BufferPart buffer, Stage stage = Stage::compute);
    PassBuilder& indirect(BufferPart arguments);
    PassBuilder& vertices(BufferPart buffer);
    PassBuilder& indices(BufferPart buffer);
    PassBuilder& copy_from(BufferPart buffer);
    PassBuilder& copy_from(ImagePart image);

    /// Writes everything anew: earlier content is lost, and its producers may be culled.
    [[nodiscard]] BufferHandle write(std::string_view binding, BufferPart, Stage = Stage::compute);
    [[nodiscard]] ImageHandle write(std::string_view binding, ImagePart, Stage = Stage::compute);
    /// Changes part of the content or accumulates onto it.
    [[nodiscard]] BufferHandle read_write(
        std::string_view binding, BufferPart, Stage = Stage::compute);
    [[nodiscard]] ImageHandle read_write(
        std::string_view binding, ImagePart, Stage = Stage::compute);
    /// Destination of a copy, fill or clear. What it does not cover keeps its content.
    [[nodiscard]] BufferHandle copy_to(BufferPart buffer);
    [[nodiscard]] ImageHandle copy_to(ImagePart image);
    /// Attachments of a raster pass, in the order of their shader locations: one mip of one layer
    /// each. `discard` leaves texels that no triangle covers undefined.
    [[nodiscard]] ImageHandle color(
        ImagePart image, LoadOp load, const std::array<float, 4>& clear);
    [[nodiscard]] ImageHandle color(ImagePart image, LoadOp load = LoadOp::discard);
    [[nodiscard]] ImageHandle depth(ImagePart image, float clear_value);
    /// In place of depth: S8_UINT.
    [[nodiscard]] ImageHandle stencil(ImagePart image, std::uint8_t clear_value);

    /// Wishes to run beside the main queue.
    PassBuilder& prefer(QueueWish queue);
    /// Keeps the pass whatever its outputs are worth; says why.
    PassBuilder& side_effect(std::string why);
    /// Why the scene needs this pass; shown by explain.
    PassBuilder& because(std::string reason);
    /// What to record. Called at each execution (twice under sync validation), so it must only
    /// record.
    PassBuilder& record(std::function<void(Commands&)> function);

private:
    friend class Graph;
    PassBuilder(Graph& graph, PassId pass) : graph_(&graph), pass_(pass) {}
    Graph* graph_;
    PassId pass_;
};

/// While it lives, passes added to the graph run only where the condition holds, on top of the
/// guards around it.
class [[nodiscard]] GuardScope {
public:
    ~GuardScope();
    GuardScope(const GuardScope&) = delete;
    GuardScope& operator=(const GuardScope&) = delete;

private:
    friend class Graph;
    GuardScope(Graph& graph, Guard guard);
    Graph& graph_;
    GuardId outer_;
};

class Graph {
public:
    explicit Graph(std::string name);

    /// Transient resources: no memory of their own, no content before the first write.
    BufferHandle create_buffer(std::string name, BufferDesc desc,
        std::source_location where = std::source_location::current());
    ImageHandle create_image(std::string name, ImageDesc desc,
        std::source_location where = std::source_location::current());
    /// Persistent resources: zero before the first execution, then what the last one left.
    BufferHandle create_persistent_buffer(std::string name, BufferDesc desc,
        std::source_location where = std::source_location::current());
    ImageHandle create_persistent_image(std::string name, ImageDesc desc,
        std::source_location where = std::source_location::current());
    /// As many persistent resources as `depth` + 1, which change places after each execution.
    History<BufferHandle> create_history_buffer(std::string name, BufferDesc desc,
        std::uint32_t depth, std::source_location where = std::source_location::current());
    History<ImageHandle> create_history_image(std::string name, ImageDesc desc, std::uint32_t depth,
        std::source_location where = std::source_location::current());
    /// Resources of the caller, bound by Executor::bind before each execution that changes them.
    /// `entry`: how it was last used before; `exit`: how to leave it (default: as last used here).
    BufferHandle import_buffer(std::string name, BufferDesc desc, AccessState entry,
        AccessState exit = {}, std::source_location where = std::source_location::current());
    ImageHandle import_image(std::string name, ImageDesc desc, AccessState entry,
        AccessState exit = {}, std::source_location where = std::source_location::current());

    /// What is known when declaring needs no condition: leave the pass out, and say so by
    /// omit_pass().
    Condition add_condition(
        std::string name, std::source_location where = std::source_location::current());
    GuardScope when(Condition condition);
    GuardScope unless(Condition condition);

    PassBuilder add_compute_pass(
        std::string name, std::source_location where = std::source_location::current());
    PassBuilder add_raster_pass(
        std::string name, std::source_location where = std::source_location::current());
    PassBuilder add_transfer_pass(
        std::string name, std::source_location where = std::source_location::current());

    /// The content is wanted after the execution, and why. Keeps producers alive.
    void export_resource(BufferHandle buffer, std::string why);
    void export_resource(ImageHandle image, std::string why);
    /// Says why a pass or resource that one might expect is absent.
    void omit_pass(std::string name, std::string reason);
    void omit_resource(std::string name, std::string reason);

    /// The resource of that name, as its newest version; an empty handle if there is none.
    ImageHandle find_image(std::string_view name) const;
    BufferHandle find_buffer(std::string_view name) const;
    const ImageDesc& desc(ImageHandle image) const;
    const BufferDesc& desc(BufferHandle buffer) const;
    const std::string& name() const { return declaration_.name; }

    const Declaration& declaration() const { return declaration_; }
    Declaration& declaration() { return declaration_; } ///< for the runtime: fills memory needs
    /// Of all that decides the plan: declarations with equal ones have equal plans. Kept up while
    /// declaring, so asking costs nothing.
    const Fingerprint& fingerprint() const { return fingerprint_; }
    const std::function<void(Commands&)>& recorder(PassId pass) const { return recorders_[pass]; }

private:
    friend class PassBuilder;
    friend class GuardScope;
    PassId add_pass(std::string name, PassKind kind, std::source_location where);
    ResourceId add_resource(ResourceDecl resource);
    template <class HandleType>
    History<HandleType> add_history(ResourceDecl resource, std::uint32_t depth);
    ResourceId find(std::string_view name, ResourceKind kind) const;
    bool is_newest(ResourceId resource, std::uint32_t version) const;
    void refuse_handle(const std::string& user, ResourceId resource, std::uint32_t version);
    void refuse_second_writer(PassId pass, ResourceId resource, std::uint32_t version);
    /// Adds a use; returns the version that it leaves.
    template <ResourceKind Kind>
    Handle<Kind> use(PassId pass, const PartOf<Kind>& target, Use use,
        std::string_view binding = {}, const ClearValue& clear = {});
    void add_export(ResourceId resource, std::uint32_t version, std::string why);
    void misuse(const char* code, std::string text);

    Declaration declaration_;
    Fingerprint fingerprint_;
    GuardId guard_ = kNone;               ///< of passes added now
    std::vector<std::uint32_t> versions_; ///< newest version of each resource
    std::vector<std::function<void(Commands&)>> recorders_;
};

template <ResourceKind Kind>
PartOf<Kind> Handle<Kind>::range(std::uint64_t offset, std::uint64_t bytes) const
    requires(Kind == ResourceKind::buffer) {
    return {*this, {.offset = offset, .bytes = bytes}};
}
template <ResourceKind Kind>
PartOf<Kind> Handle<Kind>::mip(std::uint32_t index) const requires(Kind == ResourceKind::image) {
    return PartOf<Kind>(*this).mips(index, 1);
}
template <ResourceKind Kind>
PartOf<Kind> Handle<Kind>::mips(std::uint32_t first, std::uint32_t count) const
    requires(Kind == ResourceKind::image) {
    return PartOf<Kind>(*this).mips(first, count);
}
template <ResourceKind Kind>
PartOf<Kind> Handle<Kind>::layer(std::uint32_t index) const requires(Kind == ResourceKind::image) {
    return PartOf<Kind>(*this).layers(index, 1);
}
template <ResourceKind Kind>
PartOf<Kind> Handle<Kind>::layers(std::uint32_t first, std::uint32_t count) const
    requires(Kind == ResourceKind::image) {
    return PartOf<Kind>(*this).layers(first, count);
}
template <ResourceKind Kind>
PartOf<Kind> PartOf<Kind>::mips(std::uint32_t first, std::uint32_t count) const
    requires(Kind == ResourceKind::image) {
    PartOf result = *this;
    result.part.first_mip = first;
    result.part.mips = count;
    return result;
}
template <ResourceKind Kind>
PartOf<Kind> PartOf<Kind>::layers(std::uint32_t first, std::uint32_t count) const
    requires(Kind == ResourceKind::image) {
    PartOf result = *this;
    result.part.first_layer = first;
    result.part.layers = count;
    return result;
}

} // namespace ockham
