// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/explain/dump.hpp"

#include "framework/graph/compile.hpp"
#include "framework/graph/describe.hpp"
#include "framework/graph/explain/explain.hpp"
#include "framework/graph/explain/timeline.hpp"
#include "framework/graph/explain/words.hpp"

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

/// "color", or "color mip 1".
std::string resource_cell(const Declaration& declaration, const Barrier& barrier) {
    const ResourceDecl& resource = declaration.resources[barrier.resource];
    const std::string part = part_text(resource, barrier.part);
    return part.empty() ? resource.name : fmt::format("{} {}", resource.name, part);
}

void add_barrier_row(Table& table, const Declaration& declaration, const Barrier& barrier,
    std::vector<std::string> cells) {
    cells.insert(
        cells.end(), {name_of(barrier.hazard), resource_cell(declaration, barrier),
                         name_or(declaration, barrier.from, kBefore),
                         stages_text(barrier.src_stages), access_text(barrier.src_access), "->",
                         stages_text(barrier.dst_stages), access_text(barrier.dst_access)});
    if (barrier.old_layout != barrier.new_layout)
        cells.push_back(fmt::format(
            "{} -> {}", layout_text(barrier.old_layout), layout_text(barrier.new_layout)));
    else if (is_image(declaration, barrier.resource))
        cells.push_back(layout_text(barrier.new_layout));
    if (barrier.src_family != barrier.dst_family)
        cells.back() += fmt::format(" (family {} -> {})", barrier.src_family, barrier.dst_family);
    table.add(std::move(cells));
}

std::string dot_quoted(const std::string& text) {
    std::string quoted = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') quoted += '\\';
        if (c == '\n')
            quoted += "\\n";
        else
            quoted += c;
    }
    return quoted + '"';
}

} // namespace

namespace {

/// One row for each step and barrier; the queue too where there are several.
Table step_table(const Declaration& declaration, const Plan& plan) {
    const bool several = plan.queues.size() > 1;
    const auto lead = [&](std::string step, std::string pass, std::string kind, std::string queue) {
        std::vector<std::string> cells{std::move(step), std::move(pass), std::move(kind)};
        if (several) cells.push_back(std::move(queue));
        return cells;
    };
    Table table;
    std::vector<std::string> head = lead("step", "pass", "kind", "queue");
    for (const char* title : {"barrier", "resource", "from", "src stages", "src access", "",
             "dst stages", "dst access", "layout"})
        head.push_back(title);
    table.add(std::move(head));
    const std::vector<std::uint32_t> queues = queue_of_steps(plan);
    for (std::size_t i = 0; i < plan.steps.size(); ++i) {
        const Step& step = plan.steps[i];
        const PassDecl& pass = declaration.passes[step.pass];
        std::vector<std::string> cells =
            lead(fmt::format("{}", i), pass.name, name_of(pass.kind), fmt::format("{}", queues[i]));
        if (step.barrier_count + step.release_count == 0) table.add(cells);
        for (const auto& barriers : {plan.barriers_before(step), plan.releases_after(step)})
            for (const Barrier& barrier : barriers) {
                add_barrier_row(table, declaration, barrier, cells);
                cells = lead("", "", "", "");
            }
    }
    for (const Barrier& barrier : plan.exit_barriers())
        add_barrier_row(table, declaration, barrier, lead("", kAfter, "", ""));
    return table;
}

/// One row for each submission, with what it waits for.
Table submission_table(const Plan& plan) {
    Table table;
    table.add({"submission", "queue", "family", "steps", "waits for submissions"});
    for (std::size_t i = 0; i < plan.submissions.size(); ++i) {
        const Submission& one = plan.submissions[i];
        std::string waits;
        for (std::uint32_t k = 0; k < one.wait_count; ++k) {
            const Wait& wait = plan.waits[one.first_wait + k];
            waits +=
                fmt::format("{}{}", k ? ", " : "", submission_of(plan, wait.queue, wait.value));
        }
        table.add({fmt::format("{}", i), fmt::format("{}", one.queue),
            fmt::format("{}", plan.queues[one.queue].family),
            one.step_count
                ? fmt::format("{}-{}", one.first_step, one.first_step + one.step_count - 1)
                : "none",
            waits});
    }
    return table;
}

} // namespace

std::string plan_text(const Declaration& declaration, const Plan& plan) {
    std::string text = summary(declaration, plan);

    text += '\n';
    text += step_table(declaration, plan).text();
    if (plan.submissions.size() > 1) {
        text += '\n';
        text += submission_table(plan).text();
    }

    Table resources;
    resources.add({"resource", "kind", "lifetime", "content", "memory", "heap", "offset", "steps"});
    for (const Placement& placement : plan.placements) {
        const ResourceDecl& resource = declaration.resources[placement.resource];
        const bool shared = plan.heaps[placement.heap].shared;
        resources.add({resource.name, name_of(resource.kind), name_of(resource.lifetime),
            content_text(resource), size_text(placement.bytes),
            fmt::format("{}{}", placement.heap, shared ? "" : " (own)"),
            fmt::format("{}", placement.offset),
            fmt::format("{}-{}", placement.first_step, placement.last_step)});
    }
    for (std::size_t i = 0; i < plan.resources.size(); ++i) {
        const ResourceDecl& resource = declaration.resources[i];
        if (resource.lifetime == Lifetime::external && !plan.resources[i].culled)
            resources.add({resource.name, name_of(resource.kind), name_of(resource.lifetime),
                content_text(resource)});
    }
    text += '\n';
    text += resources.text();

    const std::string culled = absences(declaration, plan);
    return culled.empty() ? text : fmt::format("{}\n{}", text, culled);
}

namespace {

std::vector<std::uint32_t> queue_of_passes(const Plan& plan) {
    const std::vector<std::uint32_t> of_steps = queue_of_steps(plan);
    std::vector<std::uint32_t> queues(plan.passes.size(), 0);
    for (std::size_t i = 0; i < plan.steps.size(); ++i) queues[plan.steps[i].pass] = of_steps[i];
    return queues;
}

/// Name, queue where it is not the main one, and guard, a line each.
std::string pass_label(
    const Declaration& declaration, std::size_t pass, const std::vector<std::uint32_t>& queues) {
    std::string label = declaration.passes[pass].name;
    if (queues[pass] != 0) label += fmt::format("\n{}", queue_text(queues[pass]));
    const std::string guard = guard_text(declaration, declaration.passes[pass].guard);
    return guard.empty() ? label : fmt::format("{}\n{}", label, guard);
}

} // namespace

std::string plan_dot(const Declaration& declaration, const Plan& plan) {
    std::string text = fmt::format("digraph {} {{\n  rankdir=LR;\n", dot_quoted(declaration.name));
    const std::vector<std::uint32_t> queues = queue_of_passes(plan);
    const auto style = [](bool culled) { return culled ? ", style=dashed" : ""; };
    for (std::size_t i = 0; i < plan.passes.size(); ++i)
        text += fmt::format("  p{} [shape=box, label={}{}];\n", i,
            dot_quoted(pass_label(declaration, i, queues)), style(plan.passes[i].culled));
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

} // namespace ockham
