// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/graph.hpp"

#include "framework/core/error.hpp"
#include "framework/graph/describe.hpp"

#include <algorithm>

namespace ockham {

namespace {

Use fixed_use(Access access) { return {.access = access, .stage = Stage::fixed}; }

Use attachment(Access access, LoadOp load) {
    return {.access = access, .stage = Stage::fixed, .load = load};
}

ResourceDecl declare(
    std::string name, BufferDesc desc, Lifetime lifetime, std::source_location where) {
    ResourceDecl resource;
    resource.name = std::move(name);
    resource.lifetime = lifetime;
    resource.buffer = desc;
    resource.where = where;
    return resource;
}

ResourceDecl declare(
    std::string name, ImageDesc desc, Lifetime lifetime, std::source_location where) {
    ResourceDecl resource;
    resource.name = std::move(name);
    resource.kind = ResourceKind::image;
    resource.lifetime = lifetime;
    resource.image = desc;
    resource.where = where;
    return resource;
}

/// What a call said; begins all that it mixes, so that calls of one kind never look like another.
enum class Said : std::uint8_t {
    resource,
    pass,
    use,
    queue,
    side_effect,
    exported,
    condition,
    guard,
    misuse,
};

void mix(Fingerprint& fingerprint, Said said, std::uint32_t id, std::uint64_t value) {
    fingerprint.mix(static_cast<std::uint64_t>(said) << 32 | id);
    fingerprint.mix(value);
}

void mix(Fingerprint& fingerprint, const AccessState& state) {
    fingerprint.mix(state.stages);
    fingerprint.mix(state.access);
    fingerprint.mix(
        std::uint64_t{static_cast<std::uint32_t>(state.layout)} << 32 | state.queue_family);
}

void mix(Fingerprint& fingerprint, const ResourceDecl& resource) {
    mix(fingerprint, Said::resource, static_cast<std::uint32_t>(resource.kind),
        static_cast<std::uint64_t>(resource.lifetime));
    fingerprint.mix(resource.name);
    if (resource.kind == ResourceKind::buffer) {
        fingerprint.mix(resource.buffer.bytes);
    } else {
        const ImageDesc& image = resource.image;
        fingerprint.mix(static_cast<std::uint64_t>(image.format));
        fingerprint.mix(std::uint64_t{image.width} << 32 | image.height);
        fingerprint.mix(std::uint64_t{image.depth} << 32 | image.layers);
        fingerprint.mix(std::uint64_t{image.mips});
    }
    if (resource.lifetime == Lifetime::external) {
        mix(fingerprint, resource.entry);
        mix(fingerprint, resource.exit);
    }
    if (resource.history_depth)
        fingerprint.mix(std::uint64_t{resource.history_depth} << 32 | resource.history_age);
}

void mix(Fingerprint& fingerprint, const Use& use, std::string_view binding, const Part& part) {
    mix(fingerprint, Said::use, use.resource,
        std::uint64_t{use.part != kNone} << 32 | static_cast<std::uint64_t>(use.access) << 24 |
            static_cast<std::uint64_t>(use.stage) << 16 |
            static_cast<std::uint64_t>(use.load) << 8 | static_cast<std::uint64_t>(use.filter));
    fingerprint.mix(binding);
    if (use.part == kNone) return;
    fingerprint.mix(part.offset);
    fingerprint.mix(part.bytes);
    fingerprint.mix(std::uint64_t{part.first_mip} << 32 | part.mips);
    fingerprint.mix(std::uint64_t{part.first_layer} << 32 | part.layers);
}

} // namespace

PassBuilder& PassBuilder::sample(
    std::string_view binding, ImagePart image, Stage stage, Filter filter) {
    graph_->use(
        pass_, image, {.access = Access::sampled, .stage = stage, .filter = filter}, binding);
    return *this;
}

PassBuilder& PassBuilder::read(std::string_view binding, BufferPart buffer, Stage stage) {
    graph_->use(pass_, buffer, {.access = Access::storage_read, .stage = stage}, binding);
    return *this;
}

PassBuilder& PassBuilder::read(std::string_view binding, ImagePart image, Stage stage) {
    graph_->use(pass_, image, {.access = Access::storage_read, .stage = stage}, binding);
    return *this;
}

PassBuilder& PassBuilder::uniform(std::string_view binding, BufferPart buffer, Stage stage) {
    graph_->use(pass_, buffer, {.access = Access::uniform, .stage = stage}, binding);
    return *this;
}

PassBuilder& PassBuilder::indirect(BufferPart arguments) {
    graph_->use(pass_, arguments, fixed_use(Access::indirect));
    return *this;
}

PassBuilder& PassBuilder::vertices(BufferPart buffer) {
    graph_->use(pass_, buffer, fixed_use(Access::vertex));
    return *this;
}

PassBuilder& PassBuilder::indices(BufferPart buffer) {
    graph_->use(pass_, buffer, fixed_use(Access::index));
    return *this;
}

PassBuilder& PassBuilder::copy_from(BufferPart buffer) {
    graph_->use(pass_, buffer, fixed_use(Access::transfer_read));
    return *this;
}

PassBuilder& PassBuilder::copy_from(ImagePart image) {
    graph_->use(pass_, image, fixed_use(Access::transfer_read));
    return *this;
}

BufferHandle PassBuilder::write(std::string_view binding, BufferPart buffer, Stage stage) {
    return graph_->use(pass_, buffer, {.access = Access::storage_write, .stage = stage}, binding);
}

ImageHandle PassBuilder::write(std::string_view binding, ImagePart image, Stage stage) {
    return graph_->use(pass_, image, {.access = Access::storage_write, .stage = stage}, binding);
}

BufferHandle PassBuilder::read_write(std::string_view binding, BufferPart buffer, Stage stage) {
    return graph_->use(
        pass_, buffer, {.access = Access::storage_read_write, .stage = stage}, binding);
}

ImageHandle PassBuilder::read_write(std::string_view binding, ImagePart image, Stage stage) {
    return graph_->use(
        pass_, image, {.access = Access::storage_read_write, .stage = stage}, binding);
}

BufferHandle PassBuilder::copy_to(BufferPart buffer) {
    return graph_->use(pass_, buffer, fixed_use(Access::transfer_write));
}

ImageHandle PassBuilder::copy_to(ImagePart image) {
    return graph_->use(pass_, image, fixed_use(Access::transfer_write));
}

ImageHandle PassBuilder::color(ImagePart image, LoadOp load, const std::array<float, 4>& clear) {
    return graph_->use(pass_, image, attachment(Access::color_attachment, load), {}, clear);
}

ImageHandle PassBuilder::color(ImagePart image, LoadOp load) { return color(image, load, {}); }

ImageHandle PassBuilder::depth(ImagePart image, float clear_value) {
    return graph_->use(pass_, image, attachment(Access::depth_attachment, LoadOp::clear), {},
        {clear_value, 0, 0, 0});
}

ImageHandle PassBuilder::stencil(ImagePart image, std::uint8_t clear_value) {
    return depth(image, clear_value);
}

PassBuilder& PassBuilder::prefer(QueueWish queue) {
    graph_->declaration_.passes[pass_].queue = queue;
    mix(graph_->fingerprint_, Said::queue, pass_, static_cast<std::uint64_t>(queue));
    return *this;
}

PassBuilder& PassBuilder::side_effect(std::string why) {
    mix(graph_->fingerprint_, Said::side_effect, pass_, why.empty() ? 0 : 1);
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

GuardScope::GuardScope(Graph& graph, Guard guard) : graph_(graph), outer_(graph.guard_) {
    std::vector<Guard>& guards = graph.declaration_.guards;
    guard.parent = outer_;
    auto found = std::find(guards.begin(), guards.end(), guard);
    if (found == guards.end()) {
        found = guards.insert(found, guard);
        mix(graph.fingerprint_, Said::guard, guard.condition,
            std::uint64_t{guard.parent} << 1 | std::uint64_t{guard.wanted});
    }
    graph.guard_ = static_cast<GuardId>(found - guards.begin());
}

GuardScope::~GuardScope() { graph_.guard_ = outer_; }

Graph::Graph(std::string name) { declaration_.name = std::move(name); }

BufferHandle Graph::create_buffer(std::string name, BufferDesc desc, std::source_location where) {
    return {add_resource(declare(std::move(name), desc, Lifetime::transient, where))};
}

ImageHandle Graph::create_image(std::string name, ImageDesc desc, std::source_location where) {
    return {add_resource(declare(std::move(name), desc, Lifetime::transient, where))};
}

BufferHandle Graph::create_persistent_buffer(
    std::string name, BufferDesc desc, std::source_location where) {
    return {add_resource(declare(std::move(name), desc, Lifetime::persistent, where))};
}

ImageHandle Graph::create_persistent_image(
    std::string name, ImageDesc desc, std::source_location where) {
    return {add_resource(declare(std::move(name), desc, Lifetime::persistent, where))};
}

History<BufferHandle> Graph::create_history_buffer(
    std::string name, BufferDesc desc, std::uint32_t depth, std::source_location where) {
    return add_history<BufferHandle>(
        declare(std::move(name), desc, Lifetime::persistent, where), depth);
}

History<ImageHandle> Graph::create_history_image(
    std::string name, ImageDesc desc, std::uint32_t depth, std::source_location where) {
    return add_history<ImageHandle>(
        declare(std::move(name), desc, Lifetime::persistent, where), depth);
}

BufferHandle Graph::import_buffer(std::string name, BufferDesc desc, AccessState entry,
    AccessState exit, std::source_location where) {
    ResourceDecl resource = declare(std::move(name), desc, Lifetime::external, where);
    resource.entry = entry;
    resource.exit = exit;
    return {add_resource(std::move(resource))};
}

ImageHandle Graph::import_image(std::string name, ImageDesc desc, AccessState entry,
    AccessState exit, std::source_location where) {
    ResourceDecl resource = declare(std::move(name), desc, Lifetime::external, where);
    resource.entry = entry;
    resource.exit = exit;
    return {add_resource(std::move(resource))};
}

Condition Graph::add_condition(std::string name, std::source_location where) {
    mix(fingerprint_, Said::condition, 0, 0);
    fingerprint_.mix(name);
    declaration_.conditions.push_back({std::move(name), where});
    return {static_cast<ConditionId>(declaration_.conditions.size() - 1)};
}

GuardScope Graph::when(Condition condition) { return {*this, {condition.id, true, kNone}}; }
GuardScope Graph::unless(Condition condition) { return {*this, {condition.id, false, kNone}}; }

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
    mix(fingerprint_, Said::pass, guard_, static_cast<std::uint64_t>(kind));
    fingerprint_.mix(name);
    PassDecl pass;
    pass.name = std::move(name);
    pass.kind = kind;
    pass.guard = guard_;
    pass.first_use = static_cast<std::uint32_t>(declaration_.uses.size());
    pass.where = where;
    declaration_.passes.push_back(std::move(pass));
    recorders_.emplace_back();
    return static_cast<PassId>(declaration_.passes.size() - 1);
}

ResourceId Graph::add_resource(ResourceDecl resource) {
    mix(fingerprint_, resource);
    declaration_.resources.push_back(std::move(resource));
    versions_.push_back(0);
    return static_cast<ResourceId>(versions_.size() - 1);
}

template <class HandleType>
History<HandleType> Graph::add_history(ResourceDecl resource, std::uint32_t depth) {
    if (depth == 0)
        misuse("bad-size", fmt::format("{} is a history of depth 0; ask for at least 1, or make it "
                                       "persistent",
                               describe(resource)));
    resource.history_depth = depth;
    History<HandleType> history{{add_resource(resource)}, {}};
    for (std::uint32_t age = 1; age <= depth; ++age) {
        ResourceDecl previous = resource;
        previous.name += fmt::format("@-{}", age);
        previous.history_age = age;
        history.previous.push_back({add_resource(std::move(previous))});
    }
    return history;
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

void Graph::refuse_second_writer(PassId pass, ResourceId resource, std::uint32_t version) {
    const auto first =
        std::find_if(declaration_.uses.begin(), declaration_.uses.end(), [&](const Use& use) {
            return use.resource == resource && use.version == version &&
                   use.version_written != kNone;
        });
    const auto writer = std::find_if(
        declaration_.passes.begin(), declaration_.passes.end(), [&](const PassDecl& decl) {
            return declaration_.uses.begin() + decl.first_use + decl.use_count > first;
        });
    misuse("two-writers",
        fmt::format("{} and {} both write version {} of {}; let the second write the handle that "
                    "the first returned",
            describe(*writer), describe(declaration_.passes[pass]), version,
            describe(declaration_.resources[resource])));
}

template <ResourceKind Kind>
Handle<Kind> Graph::use(PassId pass, const PartOf<Kind>& target, Use use, std::string_view binding,
    const ClearValue& clear) {
    const auto [resource, version] = target.handle;
    PassDecl& user = declaration_.passes[pass];
    if (!is_newest(resource, version)) {
        if (writes(use.access) && resource < versions_.size() && version < versions_[resource])
            refuse_second_writer(pass, resource, version);
        else
            refuse_handle(describe(user), resource, version);
        return target.handle;
    }
    if (pass + 1 != declaration_.passes.size()) {
        misuse("closed-pass",
            fmt::format("{} uses {} after {} was added; declare all uses of a pass before the "
                        "next",
                describe(user), describe(declaration_.resources[resource]),
                describe(declaration_.passes.back())));
        return target.handle;
    }
    use.resource = resource;
    use.version = version;
    if (writes(use.access)) use.version_written = ++versions_[resource];
    if (target.part != Part{}) {
        use.part = static_cast<std::uint32_t>(declaration_.parts.size());
        declaration_.parts.push_back(target.part);
    }
    if (!binding.empty()) use.binding = declaration_.bindings.add(binding);
    mix(fingerprint_, use, binding, target.part);
    ++user.use_count;
    declaration_.uses.push_back(use);
    declaration_.clears.push_back(clear);
    return {resource, versions_[resource]};
}

void Graph::add_export(ResourceId resource, std::uint32_t version, std::string why) {
    if (!is_newest(resource, version)) {
        refuse_handle(fmt::format("the export '{}'", why), resource, version);
        return;
    }
    mix(fingerprint_, Said::exported, resource, 0);
    declaration_.resources[resource].exported = true;
    declaration_.resources[resource].export_reason = std::move(why);
}

void Graph::misuse(const char* code, std::string text) {
    mix(fingerprint_, Said::misuse, 0, 0); // no plan of a graph without it fits
    declaration_.misuses.push_back({code, fmt::format("graph '{}': {}", declaration_.name, text)});
}

} // namespace ockham
