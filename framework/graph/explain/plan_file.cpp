// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/explain/plan_file.hpp"

#include "framework/graph/describe.hpp"
#include "framework/graph/explain/json_reader.hpp"

#include <nlohmann/json.hpp>

#include <cmath>
#include <limits>

namespace ockham {

namespace {

using nlohmann::json;

constexpr std::uint32_t kVersion = 1;
constexpr std::uint64_t kMost32 = std::numeric_limits<std::uint32_t>::max();
/// Sums of all the sizes of a file must fit 64 bits.
constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 48;

// The words of each enum, in its order.
constexpr std::array<const char*, 2> kResourceKinds{"buffer", "image"};
constexpr std::array<const char*, 3> kLifetimes{"transient", "persistent", "external"};
constexpr std::array<const char*, 3> kPassKinds{"compute", "raster", "transfer"};
constexpr std::array<const char*, 3> kQueueWishes{"main", "async_compute", "transfer"};
constexpr std::array<const char*, 3> kFilters{"texel", "linear_clamp", "linear_repeat"};
constexpr std::array<const char*, 3> kLoadOps{"discard", "clear", "load"};
constexpr std::array<const char*, 2> kOrders{"declared", "batched"};
const std::vector<const char*> kAccesses = [] {
    std::vector<const char*> names;
    for (int i = 0; i <= static_cast<int>(Access::host_read); ++i)
        names.push_back(name_of(static_cast<Access>(i)));
    return names;
}();
const std::vector<const char*> kStages = [] {
    std::vector<const char*> names;
    for (int i = 0; i <= static_cast<int>(Stage::fixed); ++i)
        names.push_back(name_of(static_cast<Stage>(i)));
    return names;
}();

template <class Enum, class Names>
const char* word(Enum value, const Names& names) {
    return names[static_cast<std::size_t>(value)];
}

/// JSON has neither infinity nor NaN: these are words.
json real(double value) {
    if (std::isfinite(value)) return value;
    return std::isnan(value) ? "nan" : value > 0 ? "inf" : "-inf";
}

json state_json(const AccessState& state) {
    json out{{"stages", state.stages}, {"access", state.access},
        {"layout", static_cast<std::uint32_t>(state.layout)}};
    if (state.queue_family != VK_QUEUE_FAMILY_IGNORED) out["queue_family"] = state.queue_family;
    return out;
}

AccessState load_state(const JsonReader& in) {
    AccessState state;
    state.stages = in["stages"].number();
    state.access = in["access"].number();
    state.layout = static_cast<VkImageLayout>(in["layout"].number(0, kMost32 / 2));
    if (in.has("queue_family"))
        state.queue_family = static_cast<std::uint32_t>(in["queue_family"].number(0, kMost32));
    return state;
}

json resource_json(const ResourceDecl& resource) {
    json out{{"name", resource.name}, {"kind", word(resource.kind, kResourceKinds)},
        {"lifetime", word(resource.lifetime, kLifetimes)}, {"where", place_of(resource.where)}};
    if (resource.kind == ResourceKind::buffer) {
        out["bytes"] = resource.buffer.bytes;
    } else {
        const ImageDesc& image = resource.image;
        out.update({{"format", static_cast<std::uint32_t>(image.format)}, {"width", image.width},
            {"height", image.height}, {"depth", image.depth}, {"layers", image.layers},
            {"mips", image.mips}});
    }
    const MemoryNeed& need = resource.memory;
    if (need.bytes)
        out["memory"] = {
            {"bytes", need.bytes}, {"alignment", need.alignment}, {"type_bits", need.type_bits}};
    if (resource.exported) out["exported"] = resource.export_reason;
    if (resource.lifetime == Lifetime::external) {
        out["entry"] = state_json(resource.entry);
        out["exit"] = state_json(resource.exit);
    }
    if (resource.history_depth)
        out["history"] = {{"depth", resource.history_depth}, {"age", resource.history_age}};
    return out;
}

ResourceDecl load_resource(const JsonReader& in) {
    ResourceDecl resource;
    resource.name = in["name"].text();
    resource.kind = in["kind"].one_of<ResourceKind>(kResourceKinds);
    resource.lifetime = in["lifetime"].one_of<Lifetime>(kLifetimes);
    const auto extent = [&](const char* key, std::uint64_t most) {
        return static_cast<std::uint32_t>(in[key].number(1, most));
    };
    if (resource.kind == ResourceKind::buffer) {
        resource.buffer.bytes = in["bytes"].number(1, kMostBytes);
    } else {
        ImageDesc& image = resource.image;
        image.format = static_cast<VkFormat>(in["format"].number(0, kMost32 / 2));
        image.width = extent("width", 1 << 20);
        image.height = extent("height", 1 << 20);
        image.depth = extent("depth", 1 << 20);
        image.layers = extent("layers", 1 << 16);
        image.mips = extent("mips", 32);
    }
    if (in.has("memory")) {
        const JsonReader need = in["memory"];
        resource.memory = {need["bytes"].number(1, kMostBytes),
            need["alignment"].number(1, std::uint64_t{1} << 32),
            static_cast<std::uint32_t>(need["type_bits"].number(0, kMost32))};
    }
    resource.exported = in.has("exported");
    if (resource.exported) resource.export_reason = in["exported"].text();
    if (resource.lifetime == Lifetime::external) {
        resource.entry = load_state(in["entry"]);
        resource.exit = load_state(in["exit"]);
    }
    if (in.has("history")) {
        const JsonReader history = in["history"];
        resource.history_depth = static_cast<std::uint32_t>(history["depth"].number(1, 1 << 16));
        resource.history_age =
            static_cast<std::uint32_t>(history["age"].number(0, resource.history_depth));
    }
    return resource;
}

/// The ages 0..depth of a history are consecutive, persistent, and equal but for name and age.
void check_history(const JsonReader& in, const std::vector<ResourceDecl>& all, ResourceId id) {
    const ResourceDecl& one = all[id];
    if (one.history_depth == 0) return;
    if (one.lifetime != Lifetime::persistent) in.fail("only persistent resources have a history");
    if (one.history_age < one.history_depth && id + 1 >= all.size())
        in.fail("the history of depth {} ends at age {}", one.history_depth, one.history_age);
    if (one.history_age == 0) return;
    if (id == 0) in.fail("a history begins with age 0, found {}", one.history_age);
    const ResourceDecl& before = all[id - 1];
    if (before.history_depth != one.history_depth || before.history_age + 1 != one.history_age ||
        before.kind != one.kind || before.buffer != one.buffer || before.image != one.image)
        in.fail("age {} of a history follows on age {} of the same size and depth, found '{}'",
            one.history_age, one.history_age - 1, before.name);
}

json part_json(ResourceKind kind, const Part& part) {
    json out = json::object();
    if (kind == ResourceKind::buffer) {
        out["offset"] = part.offset;
        if (part.bytes != kRest) out["bytes"] = part.bytes;
        return out;
    }
    out["first_mip"] = part.first_mip;
    out["first_layer"] = part.first_layer;
    if (part.mips != kRestOfMips) out["mips"] = part.mips;
    if (part.layers != kRestOfMips) out["layers"] = part.layers;
    return out;
}

Part load_part(const JsonReader& in, const ResourceDecl& resource) {
    Part part;
    if (resource.kind == ResourceKind::buffer) {
        part.offset = in["offset"].number(0, resource.buffer.bytes - 1);
        if (in.has("bytes"))
            part.bytes = in["bytes"].number(1, resource.buffer.bytes - part.offset);
        return part;
    }
    const auto range = [&](const char* first_key, const char* count_key, std::uint32_t all,
                           std::uint32_t& first, std::uint32_t& count) {
        first = static_cast<std::uint32_t>(in[first_key].number(0, all - 1));
        if (in.has(count_key))
            count = static_cast<std::uint32_t>(in[count_key].number(1, all - first));
    };
    range("first_mip", "mips", resource.image.mips, part.first_mip, part.mips);
    range("first_layer", "layers", resource.image.layers, part.first_layer, part.layers);
    return part;
}

json use_json(const Declaration& declaration, const Use& use) {
    const ClearValue& clear = declaration.clear_of(use);
    json out{{"resource", use.resource}, {"access", name_of(use.access)},
        {"stage", name_of(use.stage)}, {"version", use.version}};
    if (use.version_written != kNone) out["version_written"] = use.version_written;
    if (use.load != LoadOp::discard) out["load"] = word(use.load, kLoadOps);
    if (use.filter != Filter::texel) out["filter"] = word(use.filter, kFilters);
    if (use.part != kNone)
        out["part"] =
            part_json(declaration.resources[use.resource].kind, declaration.parts[use.part]);
    if (use.binding != kNone) out["binding"] = declaration.binding_of(use);
    if (clear != ClearValue{})
        for (const float value : clear) out["clear"].push_back(real(value));
    return out;
}

/// `newest`: the latest version of each resource so far, which is the only one to use.
void load_use(const JsonReader& in, Declaration& declaration, std::vector<std::uint32_t>& newest) {
    Use use;
    ClearValue clear{};
    use.resource = in["resource"].index(declaration.resources.size());
    use.access = in["access"].one_of<Access>(kAccesses);
    use.stage = in["stage"].one_of<Stage>(kStages);
    if (in.has("load")) use.load = in["load"].one_of<LoadOp>(kLoadOps);
    if (in.has("filter")) use.filter = in["filter"].one_of<Filter>(kFilters);
    std::uint32_t& version = newest[use.resource];
    use.version = static_cast<std::uint32_t>(in["version"].number(version, version));
    if (writes(use.access)) {
        ++version;
        use.version_written =
            static_cast<std::uint32_t>(in["version_written"].number(version, version));
    } else if (in.has("version_written")) {
        in["version_written"].fail("{} writes nothing", name_of(use.access));
    }
    if (in.has("part")) {
        use.part = static_cast<std::uint32_t>(declaration.parts.size());
        declaration.parts.push_back(load_part(in["part"], declaration.resources[use.resource]));
    }
    if (in.has("binding")) use.binding = declaration.bindings.add(in["binding"].text());
    if (in.has("clear")) {
        const std::vector<JsonReader> values = in["clear"].items();
        if (values.size() != 4) in["clear"].fail("found {} numbers, expected 4", values.size());
        for (std::size_t i = 0; i < 4; ++i) clear[i] = static_cast<float>(values[i].real());
    }
    declaration.uses.push_back(use);
    declaration.clears.push_back(clear);
}

json pass_json(const Declaration& declaration, PassId id) {
    const PassDecl& pass = declaration.passes[id];
    json out{{"name", pass.name}, {"kind", word(pass.kind, kPassKinds)},
        {"where", place_of(pass.where)}, {"uses", json::array()}};
    if (pass.queue != QueueWish::main) out["queue"] = word(pass.queue, kQueueWishes);
    if (pass.guard != kNone) out["guard"] = pass.guard;
    if (!pass.reason.empty()) out["reason"] = pass.reason;
    if (!pass.side_effect.empty()) out["side_effect"] = pass.side_effect;
    for (const Use& use : declaration.uses_of(id))
        out["uses"].push_back(use_json(declaration, use));
    return out;
}

void load_pass(const JsonReader& in, Declaration& declaration, std::vector<std::uint32_t>& newest) {
    PassDecl pass;
    pass.name = in["name"].text();
    pass.kind = in["kind"].one_of<PassKind>(kPassKinds);
    if (in.has("queue")) pass.queue = in["queue"].one_of<QueueWish>(kQueueWishes);
    if (in.has("guard")) pass.guard = in["guard"].index(declaration.guards.size());
    if (in.has("reason")) pass.reason = in["reason"].text();
    if (in.has("side_effect")) pass.side_effect = in["side_effect"].text();
    pass.first_use = static_cast<std::uint32_t>(declaration.uses.size());
    for (const JsonReader& use : in["uses"].items()) load_use(use, declaration, newest);
    pass.use_count = static_cast<std::uint32_t>(declaration.uses.size()) - pass.first_use;
    declaration.passes.push_back(std::move(pass));
}

Capabilities load_capabilities(const JsonReader& in) {
    Capabilities out;
    for (const JsonReader& family : in["families"].items())
        out.families.push_back(
            {family["graphics"].yes(), family["compute"].yes(), family["transfer"].yes(),
                static_cast<std::uint32_t>(family["queues"].number(1, 1 << 10))});
    const auto is_main = [](const QueueFamily& one) { return one.graphics && one.compute; };
    if (!out.families.empty() && std::ranges::none_of(out.families, is_main))
        in["families"].fail("none has both graphics and compute");
    out.buffer_image_granularity = in["buffer_image_granularity"].number(1, std::uint64_t{1} << 32);
    out.max_buffer_bytes = in["max_buffer_bytes"].number(1);
    const auto limit = [&](const char* name) {
        return static_cast<std::uint32_t>(in[name].number(1, kMost32));
    };
    out.max_image_extent = limit("max_image_extent");
    out.max_image_layers = limit("max_image_layers");
    out.max_attachment_extent = limit("max_attachment_extent");
    return out;
}

Policy load_policy(const JsonReader& in) {
    Policy out;
    out.order = in["order"].one_of<Order>(kOrders);
    out.batch_memory = in["batch_memory"].real();
    if (!(out.batch_memory >= 0)) in["batch_memory"].fail("expected 0 or more");
    out.async_queues = in["async_queues"].yes();
    out.alias_memory = in["alias_memory"].yes();
    out.memory_budget_bytes = in["memory_budget_bytes"].number();
    return out;
}

Declaration load(const JsonReader& in) {
    in["version"].number(kVersion, kVersion);
    Declaration declaration;
    declaration.name = in["name"].text();
    for (const JsonReader& one : in["conditions"].items())
        declaration.conditions.push_back({one["name"].text(), {}});
    for (const JsonReader& one : in["guards"].items()) {
        Guard guard{one["condition"].index(declaration.conditions.size()), one["wanted"].yes()};
        if (one.has("parent")) // an earlier one, so that no chain is a ring
            guard.parent = one["parent"].index(declaration.guards.size());
        declaration.guards.push_back(guard);
    }
    const std::vector<JsonReader> resources = in["resources"].items();
    for (const JsonReader& one : resources) declaration.resources.push_back(load_resource(one));
    for (ResourceId id = 0; id < resources.size(); ++id)
        check_history(resources[id], declaration.resources, id);
    std::vector<std::uint32_t> newest(declaration.resources.size(), 0);
    for (const JsonReader& one : in["passes"].items()) load_pass(one, declaration, newest);
    for (const JsonReader& one : in["omissions"].items())
        declaration.omissions.push_back(
            {one["name"].text(), one["is_pass"].yes(), one["reason"].text()});
    return declaration;
}

} // namespace

json declaration_json(const Declaration& declaration) {
    json out{{"version", kVersion}, {"name", declaration.name}};
    for (const char* list : {"conditions", "guards", "resources", "passes", "omissions"})
        out[list] = json::array();
    for (const ConditionDecl& one : declaration.conditions)
        out["conditions"].push_back({{"name", one.name}, {"where", place_of(one.where)}});
    for (const Guard& one : declaration.guards) {
        json guard{{"condition", one.condition}, {"wanted", one.wanted}};
        if (one.parent != kNone) guard["parent"] = one.parent;
        out["guards"].push_back(std::move(guard));
    }
    for (const ResourceDecl& one : declaration.resources)
        out["resources"].push_back(resource_json(one));
    for (PassId id = 0; id < declaration.passes.size(); ++id)
        out["passes"].push_back(pass_json(declaration, id));
    for (const Omission& one : declaration.omissions)
        out["omissions"].push_back(
            {{"name", one.name}, {"is_pass", one.is_pass}, {"reason", one.reason}});
    return out;
}

json to_json(const Capabilities& capabilities) {
    json families = json::array();
    for (const QueueFamily& one : capabilities.families)
        families.push_back({{"graphics", one.graphics}, {"compute", one.compute},
            {"transfer", one.transfer}, {"queues", one.queues}});
    return {{"families", families},
        {"buffer_image_granularity", capabilities.buffer_image_granularity},
        {"max_buffer_bytes", capabilities.max_buffer_bytes},
        {"max_image_extent", capabilities.max_image_extent},
        {"max_image_layers", capabilities.max_image_layers},
        {"max_attachment_extent", capabilities.max_attachment_extent}};
}

json to_json(const Policy& policy) {
    return {{"order", word(policy.order, kOrders)}, {"batch_memory", real(policy.batch_memory)},
        {"async_queues", policy.async_queues}, {"alias_memory", policy.alias_memory},
        {"memory_budget_bytes", policy.memory_budget_bytes}};
}

Declaration load_declaration(const json& json) { return load({json, "bad-plan-file"}); }

PlanFile load_plan_file(const json& json) {
    const JsonReader in{json, "bad-plan-file"};
    PlanFile file{load(in["declaration"]), {}, {}};
    if (in.has("capabilities")) file.capabilities = load_capabilities(in["capabilities"]);
    if (in.has("policy")) file.policy = load_policy(in["policy"]);
    return file;
}

} // namespace ockham
