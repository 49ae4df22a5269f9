// SPDX-License-Identifier: Apache-2.0
// The public API of the render graph: declare resources and passes with typed, versioned handles.
// Declares only: compile() plans, runtime's Executor executes. Integrators start here.
#pragma once

#include "framework/graph/declaration.hpp"

#include <functional>
#include <source_location>
#include <string>
#include <string_view>
#include <vector>

namespace ockham {

class Commands; // framework/runtime/commands.hpp: what a pass may record
class Graph;

/// One version of a resource's content. Writing returns the next version; using an old one is a
/// misuse. Copy freely. A default-constructed handle names nothing.
template <ResourceKind Kind>
struct Handle {
    ResourceId resource = kNone;
    std::uint32_t version = 0;
    explicit operator bool() const { return resource != kNone; }
};
using BufferHandle = Handle<ResourceKind::buffer>;
using ImageHandle = Handle<ResourceKind::image>;

/// Declares one pass; returned by Graph::add_*_pass and valid until the next pass is added.
/// `binding` is the name of the buffer block, image or sampler in the pass's shaders.
class PassBuilder {
public:
    /// Reads. The content must have been written before, by a pass or from outside.
    PassBuilder& sample(std::string binding, ImageHandle image, Stage stage = Stage::compute,
        Filter filter = Filter::texel);
    PassBuilder& read(std::string binding, BufferHandle buffer, Stage stage = Stage::compute);
    PassBuilder& read(std::string binding, ImageHandle image, Stage stage = Stage::compute);
    PassBuilder& uniform(std::string binding, BufferHandle buffer, Stage stage = Stage::compute);
    PassBuilder& indirect(BufferHandle arguments);
    PassBuilder& vertices(BufferHandle buffer);
    PassBuilder& indices(BufferHandle buffer);
    PassBuilder& copy_from(BufferHandle buffer);
    PassBuilder& copy_from(ImageHandle image);

    /// Writes everything anew: earlier content is lost, and its producers may be culled.
    [[nodiscard]] BufferHandle write(std::string binding, BufferHandle, Stage = Stage::compute);
    [[nodiscard]] ImageHandle write(std::string binding, ImageHandle, Stage = Stage::compute);
    /// Changes part of the content or accumulates onto it.
    [[nodiscard]] BufferHandle read_write(
        std::string binding, BufferHandle, Stage = Stage::compute);
    [[nodiscard]] ImageHandle read_write(std::string binding, ImageHandle, Stage = Stage::compute);
    /// Destination of a copy, fill or clear. What it does not cover keeps its content.
    [[nodiscard]] BufferHandle copy_to(BufferHandle buffer);
    [[nodiscard]] ImageHandle copy_to(ImageHandle image);
    /// Attachments of a raster pass, in the order of their shader locations. `discard` leaves
    /// texels that no triangle covers undefined.
    [[nodiscard]] ImageHandle color(ImageHandle image, LoadOp load, const float (&clear)[4]);
    [[nodiscard]] ImageHandle color(ImageHandle image, LoadOp load = LoadOp::discard);
    [[nodiscard]] ImageHandle depth(ImageHandle image, float clear_value);

    /// Keeps the pass whatever its outputs are worth; says why.
    PassBuilder& side_effect(std::string why);
    /// Why the scene needs this pass; shown by explain.
    PassBuilder& because(std::string reason);
    /// What to record. Called at each execution (twice under sync validation), so it must only record.
    PassBuilder& record(std::function<void(Commands&)> function);

private:
    friend class Graph;
    PassBuilder(Graph& graph, PassId pass) : graph_(&graph), pass_(pass) {}
    Graph* graph_;
    PassId pass_;
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
    /// Resources of the caller, bound by Executor::bind before each execution that changes them.
    /// `entry`: how it was last used before; `exit`: how to leave it (default: as last used here).
    BufferHandle import_buffer(std::string name, BufferDesc desc, AccessState entry,
        AccessState exit = {}, std::source_location where = std::source_location::current());
    ImageHandle import_image(std::string name, ImageDesc desc, AccessState entry,
        AccessState exit = {}, std::source_location where = std::source_location::current());

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
    const std::function<void(Commands&)>& recorder(PassId pass) const { return recorders_[pass]; }

private:
    friend class PassBuilder;
    PassId add_pass(std::string name, PassKind kind, std::source_location where);
    ResourceId add_resource(ResourceDecl resource);
    ResourceId find(std::string_view name, ResourceKind kind) const;
    bool is_newest(ResourceId resource, std::uint32_t version) const;
    void refuse_handle(const std::string& user, ResourceId resource, std::uint32_t version);
    std::uint32_t use(PassId pass, ResourceId resource, std::uint32_t version, Use use);
    void add_export(ResourceId resource, std::uint32_t version, std::string why);
    void misuse(const char* code, std::string text);

    Declaration declaration_;
    std::vector<std::uint32_t> versions_; ///< newest version of each resource
    std::vector<std::function<void(Commands&)>> recorders_;
};

} // namespace ockham
