// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/dump.hpp"

#include "framework/graph/compile.hpp"
#include "framework/graph/describe.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <span>
#include <utility>

namespace ockham {

namespace {

using Names = std::span<const std::pair<std::uint64_t, const char*>>;

/// "compute+fragment"; bits without a name in hexadecimal.
std::string join_flags(std::uint64_t flags, Names names) {
    std::string text;
    for (const auto& [bits, name] : names) {
        if ((flags & bits) != bits) continue;
        flags &= ~bits;
        if (!text.empty()) text += '+';
        text += name;
    }
    if (flags) text += fmt::format("{}{:#x}", text.empty() ? "" : "+", flags);
    return text.empty() ? "none" : text;
}

std::string stages_text(VkPipelineStageFlags2 stages) {
    static constexpr std::pair<std::uint64_t, const char*> names[] = {
        {VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, "all"},
        {VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT, "indirect"},
        {VK_PIPELINE_STAGE_2_VERTEX_ATTRIBUTE_INPUT_BIT, "vertex_input"},
        {VK_PIPELINE_STAGE_2_INDEX_INPUT_BIT, "index_input"},
        {VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT, "vertex"},
        {VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, "fragment"},
        {VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT,
            "depth_tests"},
        {VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT, "color_output"},
        {VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, "compute"},
        {VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, "transfer"},
        {VK_PIPELINE_STAGE_2_HOST_BIT, "host"},
    };
    return join_flags(stages, names);
}

std::string access_text(VkAccessFlags2 access) {
    static constexpr std::pair<std::uint64_t, const char*> names[] = {
        {VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT, "indirect_read"},
        {VK_ACCESS_2_VERTEX_ATTRIBUTE_READ_BIT, "vertex_read"},
        {VK_ACCESS_2_INDEX_READ_BIT, "index_read"},
        {VK_ACCESS_2_UNIFORM_READ_BIT, "uniform_read"},
        {VK_ACCESS_2_SHADER_SAMPLED_READ_BIT, "sampled_read"},
        {VK_ACCESS_2_SHADER_STORAGE_READ_BIT, "storage_read"},
        {VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT, "storage_write"},
        {VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT, "color_read"},
        {VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT, "color_write"},
        {VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT, "depth_read"},
        {VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT, "depth_write"},
        {VK_ACCESS_2_TRANSFER_READ_BIT, "transfer_read"},
        {VK_ACCESS_2_TRANSFER_WRITE_BIT, "transfer_write"},
        {VK_ACCESS_2_HOST_READ_BIT, "host_read"},
        {VK_ACCESS_2_HOST_WRITE_BIT, "host_write"},
        {VK_ACCESS_2_MEMORY_READ_BIT, "memory_read"},
        {VK_ACCESS_2_MEMORY_WRITE_BIT, "memory_write"},
    };
    return join_flags(access, names);
}

std::string layout_text(VkImageLayout layout) {
    switch (layout) {
    case VK_IMAGE_LAYOUT_UNDEFINED:
        return "undefined";
    case VK_IMAGE_LAYOUT_GENERAL:
        return "general";
    case VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL:
        return "color";
    case VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL:
        return "depth";
    case VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL:
        return "read_only";
    case VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL:
        return "transfer_src";
    case VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL:
        return "transfer_dst";
    case VK_IMAGE_LAYOUT_PRESENT_SRC_KHR:
        return "present";
    default:
        return fmt::format("layout_{}", static_cast<int>(layout));
    }
}

/// "12 B", "1.5 KiB" or "45.3 MiB".
std::string size_text(std::uint64_t bytes) {
    const auto value = static_cast<double>(bytes);
    if (bytes < 1024) return fmt::format("{} B", bytes);
    if (bytes < 1024 * 1024) return fmt::format("{:.1f} KiB", value / 1024);
    return fmt::format("{:.1f} MiB", value / (1024 * 1024));
}

double ratio(const Plan& plan) {
    return plan.bytes_lower_bound == 0
               ? 1.0
               : static_cast<double>(plan.bytes_peak) / static_cast<double>(plan.bytes_lower_bound);
}

const std::string& name_or(const Declaration& declaration, PassId pass, const std::string& none) {
    return pass == kNone ? none : declaration.passes[pass].name;
}
const std::string kBefore = "(before)";
const std::string kAfter = "(after)";

std::string description_text(const ResourceDecl& resource) {
    if (resource.kind == ResourceKind::buffer) return fmt::format("{} B", resource.buffer.bytes);
    const ImageDesc& image = resource.image;
    std::string text = fmt::format("{}x{}", image.width, image.height);
    if (image.depth > 1) text += fmt::format("x{}", image.depth);
    if (image.layers > 1) text += fmt::format(" {} layers", image.layers);
    if (image.mips > 1) text += fmt::format(" {} mips", image.mips);
    return fmt::format("{} {}", text, format_text(image.format));
}

/// Left-aligned columns, as wide as their widest cell; no blanks at the ends of lines.
class Table {
public:
    void add(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }
    std::string text() const {
        std::vector<std::size_t> widths;
        for (const auto& row : rows_) {
            widths.resize(std::max(widths.size(), row.size()));
            for (std::size_t i = 0; i < row.size(); ++i)
                widths[i] = std::max(widths[i], row[i].size());
        }
        std::string text;
        for (const auto& row : rows_) {
            for (std::size_t i = 0; i < row.size(); ++i)
                text += fmt::format("{:<{}}  ", row[i], widths[i]);
            text.erase(text.find_last_not_of(' ') + 1);
            text += '\n';
        }
        return text;
    }

private:
    std::vector<std::vector<std::string>> rows_;
};

bool is_image(const Declaration& declaration, ResourceId id) {
    return declaration.resources[id].kind == ResourceKind::image;
}

void add_barrier_row(Table& table, const Declaration& declaration, const Barrier& barrier,
    std::vector<std::string> cells) {
    cells.insert(
        cells.end(), {name_of(barrier.hazard), declaration.resources[barrier.resource].name,
                         name_or(declaration, barrier.from, kBefore),
                         stages_text(barrier.src_stages), access_text(barrier.src_access), "->",
                         stages_text(barrier.dst_stages), access_text(barrier.dst_access)});
    if (barrier.old_layout != barrier.new_layout)
        cells.push_back(fmt::format(
            "{} -> {}", layout_text(barrier.old_layout), layout_text(barrier.new_layout)));
    else if (is_image(declaration, barrier.resource))
        cells.push_back(layout_text(barrier.new_layout));
    table.add(std::move(cells));
}

std::span<const Barrier> exit_barriers(const Plan& plan) {
    return {plan.barriers.data() + plan.first_exit_barrier, plan.exit_barrier_count};
}
std::span<const Barrier> barriers_of(const Plan& plan, const Step& step) {
    return {plan.barriers.data() + step.first_barrier, step.barrier_count};
}

std::string head_text(const Declaration& declaration, const Plan& plan) {
    return fmt::format("graph '{}': {} of {} passes, {} barriers in {} batches, {} (lower "
                       "bound {}, ratio {:.3f})\n",
        declaration.name, plan.steps.size(), declaration.passes.size(), plan.barriers.size(),
        plan.batches(), size_text(plan.bytes_peak), size_text(plan.bytes_lower_bound), ratio(plan));
}

std::string culled_text(const Declaration& declaration, const Plan& plan) {
    std::string text;
    for (std::size_t i = 0; i < plan.passes.size(); ++i)
        if (plan.passes[i].culled)
            text +=
                fmt::format("pass '{}': {}\n", declaration.passes[i].name, plan.passes[i].reason);
    for (std::size_t i = 0; i < plan.resources.size(); ++i)
        if (plan.resources[i].culled)
            text += fmt::format("{} '{}': {}\n", name_of(declaration.resources[i].kind),
                declaration.resources[i].name, plan.resources[i].reason);
    for (const Omission& omission : declaration.omissions)
        text += fmt::format("{} '{}': omitted: {}\n", omission.is_pass ? "pass" : "resource",
            omission.name, omission.reason);
    return text;
}

/// Why a barrier exists, in a sentence.
std::string sentence(const Declaration& declaration, const Barrier& barrier) {
    const auto quoted = [&](PassId pass, const char* none) {
        return pass == kNone ? none : fmt::format("'{}'", declaration.passes[pass].name);
    };
    const std::string from = quoted(barrier.from, "the previous execution or the caller");
    const std::string to = quoted(barrier.to, "the caller");
    const char* const resource = declaration.resources[barrier.resource].name.c_str();
    switch (barrier.hazard) {
    case Hazard::read_after_write:
        return fmt::format("{} reads '{}' as {} left it", to, resource, from);
    case Hazard::write_after_read:
        return fmt::format("{} may change '{}' only after {} has read it", to, resource, from);
    case Hazard::write_after_write:
        return fmt::format("{} overwrites '{}', which {} wrote", to, resource, from);
    case Hazard::layout:
        return fmt::format("{} wants '{}' in layout {}, {} left it in {}", to, resource,
            layout_text(barrier.new_layout), from, layout_text(barrier.old_layout));
    case Hazard::first_use:
        return fmt::format("{} begins '{}' anew", to, resource);
    case Hazard::alias:
        return fmt::format("{} begins '{}' in memory that {} used last", to, resource, from);
    case Hazard::exit:
        return fmt::format("the caller gets '{}' after {}", resource, from);
    }
    return {};
}

nlohmann::json barrier_json(const Declaration& declaration, const Barrier& barrier) {
    nlohmann::json json{{"resource", declaration.resources[barrier.resource].name},
        {"hazard", name_of(barrier.hazard)}, {"from", name_or(declaration, barrier.from, kBefore)},
        {"to", name_or(declaration, barrier.to, kAfter)},
        {"src_stages", stages_text(barrier.src_stages)},
        {"src_access", access_text(barrier.src_access)},
        {"dst_stages", stages_text(barrier.dst_stages)},
        {"dst_access", access_text(barrier.dst_access)}};
    if (is_image(declaration, barrier.resource)) {
        json["old_layout"] = layout_text(barrier.old_layout);
        json["new_layout"] = layout_text(barrier.new_layout);
    }
    return json;
}

std::string dot_quoted(const std::string& text) {
    std::string quoted = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') quoted += '\\';
        quoted += c;
    }
    return quoted + '"';
}

} // namespace

std::string plan_text(const Declaration& declaration, const Plan& plan) {
    std::string text = head_text(declaration, plan);

    Table steps;
    steps.add({"step", "pass", "kind", "barrier", "resource", "from", "src stages", "src access",
        "", "dst stages", "dst access", "layout"});
    for (std::size_t i = 0; i < plan.steps.size(); ++i) {
        const PassDecl& pass = declaration.passes[plan.steps[i].pass];
        std::vector<std::string> cells{fmt::format("{}", i), pass.name, name_of(pass.kind)};
        if (plan.steps[i].barrier_count == 0) steps.add(cells);
        for (const Barrier& barrier : barriers_of(plan, plan.steps[i])) {
            add_barrier_row(steps, declaration, barrier, cells);
            cells = {"", "", ""};
        }
    }
    for (const Barrier& barrier : exit_barriers(plan))
        add_barrier_row(steps, declaration, barrier, {"", kAfter, ""});
    text += '\n';
    text += steps.text();

    Table resources;
    resources.add({"resource", "kind", "lifetime", "content", "memory", "heap", "offset", "steps"});
    for (const Placement& placement : plan.placements) {
        const ResourceDecl& resource = declaration.resources[placement.resource];
        const bool shared = plan.heaps[placement.heap].shared;
        resources.add({resource.name, name_of(resource.kind), name_of(resource.lifetime),
            description_text(resource), size_text(placement.bytes),
            fmt::format("{}{}", placement.heap, shared ? "" : " (own)"),
            fmt::format("{}", placement.offset),
            fmt::format("{}-{}", placement.first_step, placement.last_step)});
    }
    for (std::size_t i = 0; i < plan.resources.size(); ++i) {
        const ResourceDecl& resource = declaration.resources[i];
        if (resource.lifetime == Lifetime::external && !plan.resources[i].culled)
            resources.add({resource.name, name_of(resource.kind), name_of(resource.lifetime),
                description_text(resource)});
    }
    text += '\n';
    text += resources.text();

    const std::string culled = culled_text(declaration, plan);
    return culled.empty() ? text : fmt::format("{}\n{}", text, culled);
}

std::string plan_dot(const Declaration& declaration, const Plan& plan) {
    std::string text = fmt::format("digraph {} {{\n  rankdir=LR;\n", dot_quoted(declaration.name));
    const auto style = [](bool culled) { return culled ? ", style=dashed" : ""; };
    for (std::size_t i = 0; i < plan.passes.size(); ++i)
        text += fmt::format("  p{} [shape=box, label={}{}];\n", i,
            dot_quoted(declaration.passes[i].name), style(plan.passes[i].culled));
    for (std::size_t i = 0; i < plan.resources.size(); ++i)
        text += fmt::format("  r{} [shape=ellipse, label={}{}];\n", i,
            dot_quoted(declaration.resources[i].name), style(plan.resources[i].culled));
    for (std::size_t i = 0; i < plan.passes.size(); ++i) {
        const PassDecl& pass = declaration.passes[i];
        for (std::uint32_t k = 0; k < pass.use_count; ++k) {
            const Use& use = declaration.uses[pass.first_use + k];
            const char* const dashed = plan.passes[i].culled ? " [style=dashed]" : "";
            if (needs_content(use))
                text += fmt::format("  r{} -> p{}{};\n", use.resource, i, dashed);
            if (writes(use.access))
                text += fmt::format("  p{} -> r{}{};\n", i, use.resource, dashed);
        }
    }
    return text + "}\n";
}

nlohmann::json plan_json(const Declaration& declaration, const Plan& plan) {
    nlohmann::json json{{"passes", nlohmann::json::array()}, {"resources", nlohmann::json::array()},
        {"barriers", nlohmann::json::array()}};
    for (std::size_t i = 0; i < plan.passes.size(); ++i)
        json["passes"].push_back(
            {{"name", declaration.passes[i].name}, {"kind", name_of(declaration.passes[i].kind)},
                {"culled", plan.passes[i].culled}, {"reason", plan.passes[i].reason}});

    std::vector<std::uint64_t> bytes(plan.resources.size(), 0);
    for (const Placement& placement : plan.placements) bytes[placement.resource] = placement.bytes;
    for (std::size_t i = 0; i < plan.resources.size(); ++i)
        json["resources"].push_back({{"name", declaration.resources[i].name},
            {"kind", name_of(declaration.resources[i].kind)},
            {"lifetime", name_of(declaration.resources[i].lifetime)}, {"bytes", bytes[i]},
            {"culled", plan.resources[i].culled}, {"reason", plan.resources[i].reason}});
    for (const Omission& omission : declaration.omissions) {
        nlohmann::json entry{{"name", omission.name}, {"kind", "omitted"}, {"culled", true},
            {"reason", fmt::format("omitted: {}", omission.reason)}};
        if (!omission.is_pass) {
            entry["lifetime"] = "omitted";
            entry["bytes"] = 0;
        }
        json[omission.is_pass ? "passes" : "resources"].push_back(std::move(entry));
    }
    for (const Barrier& barrier : plan.barriers)
        json["barriers"].push_back(barrier_json(declaration, barrier));
    json["memory"] = {{"bytes_peak", plan.bytes_peak},
        {"bytes_lower_bound", plan.bytes_lower_bound}, {"heaps", plan.heaps.size()},
        {"batches", plan.batches()}, {"compile_us", plan.compile_us}};
    return json;
}

std::string explain(const Declaration& declaration, const Plan& plan) {
    std::string text = head_text(declaration, plan) + "\n";
    for (std::size_t i = 0; i < plan.steps.size(); ++i) {
        const PassId pass = plan.steps[i].pass;
        text += fmt::format(
            "step {}: '{}' is {}\n", i, declaration.passes[pass].name, plan.passes[pass].reason);
        for (const Barrier& barrier : barriers_of(plan, plan.steps[i]))
            text += fmt::format(
                "    {}: {}\n", name_of(barrier.hazard), sentence(declaration, barrier));
    }
    for (const Barrier& barrier : exit_barriers(plan))
        text += fmt::format("after: {}\n", sentence(declaration, barrier));
    text += "\n";
    for (const Placement& placement : plan.placements)
        text += fmt::format("{} '{}', {}: {}{}\n",
            name_of(declaration.resources[placement.resource].kind),
            declaration.resources[placement.resource].name, size_text(placement.bytes),
            plan.resources[placement.resource].reason,
            plan.heaps[placement.heap].shared ? "" : "; memory of its own");
    for (std::size_t i = 0; i < plan.resources.size(); ++i)
        if (declaration.resources[i].lifetime == Lifetime::external && !plan.resources[i].culled)
            text += fmt::format("{} '{}', memory of the caller: {}\n",
                name_of(declaration.resources[i].kind), declaration.resources[i].name,
                plan.resources[i].reason);
    const std::string culled = culled_text(declaration, plan);
    return culled.empty() ? text : fmt::format("{}\n{}", text, culled);
}

} // namespace ockham
