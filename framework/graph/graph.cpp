// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/graph.hpp"

#include "framework/core/error.hpp"
#include "framework/graph/describe.hpp"

#include <algorithm>

namespace ockham {

namespace {

Use shader_use(Access access, std::string binding, Stage stage) {
    Use use;
    use.access = access;
    use.stage = stage;
    use.binding = std::move(binding);
    return use;
}

Use fixed_use(Access access) { return shader_use(access, {}, Stage::fixed); }

Use attachment(Access access, LoadOp load, const float (&clear)[4]) {
    Use use = fixed_use(access);
    use.load = load;
    std::copy(std::begin(clear), std::end(clear), std::begin(use.clear));
    return use;
}

constexpr float kNoClear[4] = {0, 0, 0, 0};

} // namespace

PassBuilder& PassBuilder::sample(
    std::string binding, ImageHandle image, Stage stage, Filter filter) {
    Use use = shader_use(Access::sampled, std::move(binding), stage);
    use.filter = filter;
    graph_->use(pass_, image.resource, image.version, std::move(use));
    return *this;
}

PassBuilder& PassBuilder::read(std::string binding, BufferHandle buffer, Stage stage) {
    graph_->use(pass_, buffer.resource, buffer.version,
        shader_use(Access::storage_read, std::move(binding), stage));
    return *this;
}

PassBuilder& PassBuilder::read(std::string binding, ImageHandle image, Stage stage) {
    graph_->use(pass_, image.resource, image.version,
        shader_use(Access::storage_read, std::move(binding), stage));
    return *this;
}

PassBuilder& PassBuilder::uniform(std::string binding, BufferHandle buffer, Stage stage) {
    graph_->use(pass_, buffer.resource, buffer.version,
        shader_use(Access::uniform, std::move(binding), stage));
    return *this;
}

PassBuilder& PassBuilder::indirect(BufferHandle arguments) {
    graph_->use(pass_, arguments.resource, arguments.version, fixed_use(Access::indirect));
    return *this;
}

PassBuilder& PassBuilder::vertices(BufferHandle buffer) {
    graph_->use(pass_, buffer.resource, buffer.version, fixed_use(Access::vertex));
    return *this;
}

PassBuilder& PassBuilder::indices(BufferHandle buffer) {
    graph_->use(pass_, buffer.resource, buffer.version, fixed_use(Access::index));
    return *this;
}

PassBuilder& PassBuilder::copy_from(BufferHandle buffer) {
    graph_->use(pass_, buffer.resource, buffer.version, fixed_use(Access::transfer_read));
    return *this;
}

PassBuilder& PassBuilder::copy_from(ImageHandle image) {
    graph_->use(pass_, image.resource, image.version, fixed_use(Access::transfer_read));
    return *this;
}

BufferHandle PassBuilder::write(std::string binding, BufferHandle buffer, Stage stage) {
    return {buffer.resource, graph_->use(pass_, buffer.resource, buffer.version,
                                 shader_use(Access::storage_write, std::move(binding), stage))};
}

ImageHandle PassBuilder::write(std::string binding, ImageHandle image, Stage stage) {
    return {image.resource, graph_->use(pass_, image.resource, image.version,
                                shader_use(Access::storage_write, std::move(binding), stage))};
}

BufferHandle PassBuilder::read_write(std::string binding, BufferHandle buffer, Stage stage) {
    return {
        buffer.resource, graph_->use(pass_, buffer.resource, buffer.version,
                             shader_use(Access::storage_read_write, std::move(binding), stage))};
}

ImageHandle PassBuilder::read_write(std::string binding, ImageHandle image, Stage stage) {
    return {image.resource, graph_->use(pass_, image.resource, image.version,
                                shader_use(Access::storage_read_write, std::move(binding), stage))};
}

BufferHandle PassBuilder::copy_to(BufferHandle buffer) {
    return {buffer.resource,
        graph_->use(pass_, buffer.resource, buffer.version, fixed_use(Access::transfer_write))};
}

ImageHandle PassBuilder::copy_to(ImageHandle image) {
    return {image.resource,
        graph_->use(pass_, image.resource, image.version, fixed_use(Access::transfer_write))};
}

ImageHandle PassBuilder::color(ImageHandle image, LoadOp load, const float (&clear)[4]) {
    return {image.resource, graph_->use(pass_, image.resource, image.version,
                                attachment(Access::color_attachment, load, clear))};
}

ImageHandle PassBuilder::color(ImageHandle image, LoadOp load) {
    return color(image, load, kNoClear);
}

ImageHandle PassBuilder::depth(ImageHandle image, float clear_value) {
    return {image.resource,
        graph_->use(pass_, image.resource, image.version,
            attachment(Access::depth_attachment, LoadOp::clear, {clear_value, 0, 0, 0}))};
}

PassBuilder& PassBuilder::side_effect(std::string why) {
    graph_->declaration_.passes[pass_].side_effect = std::move(why);
    return *this;
}

PassBuilder& PassBuilder::because(std::string reason) {
    graph_->declaration_.passes[pass_].reason = std::move(reason);
    return *this;
}

PassBuilder& PassBuilder::record(std::function<void(Commands&)> function) {
    graph_->recorders_[pass_] = std::move(function);
    return *this;
}

Graph::Graph(std::string name) { declaration_.name = std::move(name); }

BufferHandle Graph::create_buffer(std::string name, BufferDesc desc, std::source_location where) {
    ResourceDecl resource;
    resource.name = std::move(name);
    resource.buffer = desc;
    resource.where = where;
    return {add_resource(std::move(resource))};
}

ImageHandle Graph::create_image(std::string name, ImageDesc desc, std::source_location where) {
    ResourceDecl resource;
    resource.name = std::move(name);
    resource.kind = ResourceKind::image;
    resource.image = desc;
    resource.where = where;
    return {add_resource(std::move(resource))};
}

BufferHandle Graph::create_persistent_buffer(
    std::string name, BufferDesc desc, std::source_location where) {
    const BufferHandle handle = create_buffer(std::move(name), desc, where);
    declaration_.resources[handle.resource].lifetime = Lifetime::persistent;
    return handle;
}

ImageHandle Graph::create_persistent_image(
    std::string name, ImageDesc desc, std::source_location where) {
    const ImageHandle handle = create_image(std::move(name), desc, where);
    declaration_.resources[handle.resource].lifetime = Lifetime::persistent;
    return handle;
}

BufferHandle Graph::import_buffer(std::string name, BufferDesc desc, AccessState entry,
    AccessState exit, std::source_location where) {
    const BufferHandle handle = create_buffer(std::move(name), desc, where);
    ResourceDecl& resource = declaration_.resources[handle.resource];
    resource.lifetime = Lifetime::external;
    resource.entry = entry;
    resource.exit = exit;
    return handle;
}

ImageHandle Graph::import_image(std::string name, ImageDesc desc, AccessState entry,
    AccessState exit, std::source_location where) {
    const ImageHandle handle = create_image(std::move(name), desc, where);
    ResourceDecl& resource = declaration_.resources[handle.resource];
    resource.lifetime = Lifetime::external;
    resource.entry = entry;
    resource.exit = exit;
    return handle;
}

PassBuilder Graph::add_compute_pass(std::string name, std::source_location where) {
    return {*this, add_pass(std::move(name), PassKind::compute, where)};
}

PassBuilder Graph::add_raster_pass(std::string name, std::source_location where) {
    return {*this, add_pass(std::move(name), PassKind::raster, where)};
}

PassBuilder Graph::add_transfer_pass(std::string name, std::source_location where) {
    return {*this, add_pass(std::move(name), PassKind::transfer, where)};
}

void Graph::export_resource(BufferHandle buffer, std::string why) {
    add_export(buffer.resource, buffer.version, std::move(why));
}

void Graph::export_resource(ImageHandle image, std::string why) {
    add_export(image.resource, image.version, std::move(why));
}

void Graph::omit_pass(std::string name, std::string reason) {
    declaration_.omissions.push_back({std::move(name), true, std::move(reason)});
}

void Graph::omit_resource(std::string name, std::string reason) {
    declaration_.omissions.push_back({std::move(name), false, std::move(reason)});
}

ImageHandle Graph::find_image(std::string_view name) const {
    const ResourceId id = find(name, ResourceKind::image);
    return id == kNone ? ImageHandle{} : ImageHandle{id, versions_[id]};
}

BufferHandle Graph::find_buffer(std::string_view name) const {
    const ResourceId id = find(name, ResourceKind::buffer);
    return id == kNone ? BufferHandle{} : BufferHandle{id, versions_[id]};
}

const ImageDesc& Graph::desc(ImageHandle image) const {
    check(image.resource < declaration_.resources.size(), "desc() of a handle of no image");
    return declaration_.resources[image.resource].image;
}

const BufferDesc& Graph::desc(BufferHandle buffer) const {
    check(buffer.resource < declaration_.resources.size(), "desc() of a handle of no buffer");
    return declaration_.resources[buffer.resource].buffer;
}

PassId Graph::add_pass(std::string name, PassKind kind, std::source_location where) {
    PassDecl pass;
    pass.name = std::move(name);
    pass.kind = kind;
    pass.first_use = static_cast<std::uint32_t>(declaration_.uses.size());
    pass.where = where;
    declaration_.passes.push_back(std::move(pass));
    recorders_.emplace_back();
    return static_cast<PassId>(declaration_.passes.size() - 1);
}

ResourceId Graph::add_resource(ResourceDecl resource) {
    declaration_.resources.push_back(std::move(resource));
    versions_.push_back(0);
    return static_cast<ResourceId>(versions_.size() - 1);
}

ResourceId Graph::find(std::string_view name, ResourceKind kind) const {
    const auto& all = declaration_.resources;
    const auto found = std::find_if(all.begin(), all.end(),
        [&](const ResourceDecl& r) { return r.kind == kind && r.name == name; });
    return found == all.end() ? kNone : static_cast<ResourceId>(found - all.begin());
}

bool Graph::is_newest(ResourceId resource, std::uint32_t version) const {
    return resource < versions_.size() && version == versions_[resource];
}

void Graph::refuse_handle(const std::string& user, ResourceId resource, std::uint32_t version) {
    if (resource >= versions_.size() || version > versions_[resource])
        misuse("invalid-handle",
            fmt::format("{} uses a handle that names nothing in this graph; create or import the "
                        "resource here and pass on the handle that returns",
                user));
    else
        misuse("stale-handle",
            fmt::format("{} uses version {} of {}, whose newest version is {}; use the handle that "
                        "the last write returned",
                user, version, describe(declaration_.resources[resource]), versions_[resource]));
}

std::uint32_t Graph::use(PassId pass, ResourceId resource, std::uint32_t version, Use use) {
    PassDecl& user = declaration_.passes[pass];
    if (!is_newest(resource, version)) {
        refuse_handle(describe(user), resource, version);
        return version;
    }
    if (pass + 1 != declaration_.passes.size()) {
        misuse("closed-pass",
            fmt::format("{} uses {} after {} was added; declare all uses of a pass before the "
                        "next",
                describe(user), describe(declaration_.resources[resource]),
                describe(declaration_.passes.back())));
        return version;
    }
    use.resource = resource;
    use.version = version;
    if (writes(use.access)) use.version_written = ++versions_[resource];
    ++user.use_count;
    declaration_.uses.push_back(std::move(use));
    return versions_[resource];
}

void Graph::add_export(ResourceId resource, std::uint32_t version, std::string why) {
    if (!is_newest(resource, version)) {
        refuse_handle(fmt::format("the export '{}'", why), resource, version);
        return;
    }
    declaration_.resources[resource].exported = true;
    declaration_.resources[resource].export_reason = std::move(why);
}

void Graph::misuse(const char* code, std::string text) {
    declaration_.misuses.push_back({code, fmt::format("graph '{}': {}", declaration_.name, text)});
}

} // namespace ockham
