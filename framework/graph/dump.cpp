// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/dump.hpp"

#include "framework/graph/compile.hpp"
#include "framework/graph/describe.hpp"
#include "framework/graph/explain.hpp"
#include "framework/graph/words.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <span>
#include <utility>

namespace ockham {

namespace {

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
    std::string text = summary(declaration, plan);

    Table steps;
    steps.add({"step", "pass", "kind", "barrier", "resource", "from", "src stages", "src access",
        "", "dst stages", "dst access", "layout"});
    for (std::size_t i = 0; i < plan.steps.size(); ++i) {
        const PassDecl& pass = declaration.passes[plan.steps[i].pass];
        std::vector<std::string> cells{fmt::format("{}", i), pass.name, name_of(pass.kind)};
        if (plan.steps[i].barrier_count == 0) steps.add(cells);
        for (const Barrier& barrier : plan.barriers_before(plan.steps[i])) {
            add_barrier_row(steps, declaration, barrier, cells);
            cells = {"", "", ""};
        }
    }
    for (const Barrier& barrier : plan.exit_barriers())
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

    const std::string culled = absences(declaration, plan);
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
        json["passes"].push_back({{"name", declaration.passes[i].name},
            {"kind", name_of(declaration.passes[i].kind)}, {"culled", plan.passes[i].culled},
            {"reason", reason_of_pass(declaration, plan, static_cast<PassId>(i))}});

    std::vector<std::uint64_t> bytes(plan.resources.size(), 0);
    for (const Placement& placement : plan.placements) bytes[placement.resource] = placement.bytes;
    for (std::size_t i = 0; i < plan.resources.size(); ++i)
        json["resources"].push_back({{"name", declaration.resources[i].name},
            {"kind", name_of(declaration.resources[i].kind)},
            {"lifetime", name_of(declaration.resources[i].lifetime)}, {"bytes", bytes[i]},
            {"culled", plan.resources[i].culled},
            {"reason", reason_of_resource(declaration, plan, static_cast<ResourceId>(i))}});
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

} // namespace ockham
