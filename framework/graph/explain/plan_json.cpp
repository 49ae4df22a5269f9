// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/describe.hpp"
#include "framework/graph/explain/dump.hpp"
#include "framework/graph/explain/explain.hpp"
#include "framework/graph/explain/plan_file.hpp"
#include "framework/graph/explain/timeline.hpp"
#include "framework/graph/explain/words.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>

namespace ockham {

namespace {

using nlohmann::json;

/// Builds one plan's JSON; the indices in it are those of the lists in it.
class Writer {
public:
    Writer(const Declaration& declaration, const Plan& plan)
        : declaration_(declaration), plan_(plan), direct_(direct_dependencies(declaration, plan)),
          step_of_(plan.passes.size(), kNone) {
        for (std::uint32_t i = 0; i < plan.steps.size(); ++i) step_of_[plan.steps[i].pass] = i;
    }

    json write() const {
        const Peak peak = memory_peak(plan_);
        json out{{"passes", passes()}, {"resources", resources()}, {"barriers", barriers()},
            {"queues", json::array()}, {"submissions", submissions()}, {"waits", waits()},
            {"heaps", json::array()}};
        for (const PlanQueue& queue : plan_.queues)
            out["queues"].push_back({{"family", queue.family}, {"index", queue.index}});
        for (const Heap& heap : plan_.heaps)
            out["heaps"].push_back(
                {{"bytes", heap.bytes}, {"shared", heap.shared}, {"type_bits", heap.type_bits}});
        out["memory"] = {{"bytes_peak", plan_.bytes_peak},
            {"bytes_lower_bound", plan_.bytes_lower_bound}, {"heaps", plan_.heaps.size()},
            {"batches", plan_.batches()}, {"compile_us", plan_.compile_us},
            {"peak_step", peak.step}, {"peak_live_bytes", peak.bytes}};
        return out;
    }

private:
    json passes() const {
        const std::vector<std::uint32_t> queues = queue_of_steps(plan_);
        json out = json::array();
        for (PassId id = 0; id < plan_.passes.size(); ++id) {
            const PassDecl& pass = declaration_.passes[id];
            json entry{{"name", pass.name}, {"kind", name_of(pass.kind)},
                {"culled", plan_.passes[id].culled},
                {"reason", reason_of_pass(declaration_, plan_, id)}};
            if (pass.guard != kNone) entry["guard"] = guard_text(declaration_, pass.guard);
            if (step_of_[id] != kNone) {
                entry["step"] = step_of_[id];
                entry["queue"] = queues[step_of_[id]];
                entry["after"] = after(id);
            }
            out.push_back(std::move(entry));
        }
        add_omissions(out, true);
        return out;
    }

    /// The passes that this one directly waits for: [{pass, reason}].
    json after(PassId id) const {
        json out = json::array();
        for (const std::span<const Dependency> pair : dependencies_of(direct_, id))
            out.push_back(
                {{"pass", pair.front().before}, {"reason", reason_of_order(declaration_, pair)}});
        return out;
    }

    json resources() const {
        json out = json::array();
        for (ResourceId id = 0; id < plan_.resources.size(); ++id) {
            const ResourceDecl& resource = declaration_.resources[id];
            out.push_back({{"name", resource.name}, {"kind", name_of(resource.kind)},
                {"lifetime", name_of(resource.lifetime)}, {"bytes", 0},
                {"content", content_text(resource)}, {"culled", plan_.resources[id].culled},
                {"reason", reason_of_resource(declaration_, plan_, id)}});
            if (plan_.concurrent[id]) out.back()["concurrent"] = true;
        }
        for (const Placement& one : plan_.placements)
            out[one.resource].update(
                {{"bytes", one.bytes}, {"heap", one.heap}, {"offset", one.offset},
                    {"first_step", one.first_step}, {"last_step", one.last_step}});
        add_omissions(out, false);
        return out;
    }

    void add_omissions(json& out, bool passes) const {
        for (const Omission& omission : declaration_.omissions) {
            if (omission.is_pass != passes) continue;
            json entry{{"name", omission.name}, {"kind", "omitted"}, {"culled", true},
                {"reason", fmt::format("omitted: {}", omission.reason)}};
            if (!passes) entry.update({{"lifetime", "omitted"}, {"bytes", 0}});
            out.push_back(std::move(entry));
        }
    }

    json barrier(const Barrier& barrier) const {
        const auto name = [&](PassId pass, const char* none) {
            return pass == kNone ? std::string(none) : declaration_.passes[pass].name;
        };
        const ResourceDecl& resource = declaration_.resources[barrier.resource];
        json out{{"resource", resource.name}, {"hazard", name_of(barrier.hazard)},
            {"from", name(barrier.from, "(before)")}, {"to", name(barrier.to, "(after)")},
            {"src_stages", stages_text(barrier.src_stages)},
            {"src_access", access_text(barrier.src_access)},
            {"dst_stages", stages_text(barrier.dst_stages)},
            {"dst_access", access_text(barrier.dst_access)},
            {"reason", reason_of_barrier(declaration_, plan_, barrier)}};
        if (resource.kind == ResourceKind::image) {
            out["old_layout"] = layout_text(barrier.old_layout);
            out["new_layout"] = layout_text(barrier.new_layout);
        }
        const std::string part = part_text(resource, barrier.part);
        if (!part.empty()) out["part"] = part;
        if (barrier.src_family != barrier.dst_family) {
            out["src_family"] = barrier.src_family;
            out["dst_family"] = barrier.dst_family;
        }
        return out;
    }

    /// In the order of the plan; `step` is what they stand before, or after where they release.
    json barriers() const {
        json out = json::array();
        for (const Barrier& one : plan_.barriers) out.push_back(barrier(one));
        for (std::uint32_t i = 0; i < plan_.steps.size(); ++i) {
            const Step& step = plan_.steps[i];
            for (std::uint32_t k = 0; k < step.barrier_count; ++k)
                out[step.first_barrier + k]["step"] = i;
            for (std::uint32_t k = 0; k < step.release_count; ++k)
                out[step.first_release + k]["step"] = i;
        }
        return out;
    }

    json submissions() const {
        json out = json::array();
        for (const Submission& one : plan_.submissions)
            out.push_back({{"queue", one.queue}, {"first_step", one.first_step},
                {"step_count", one.step_count}, {"first_wait", one.first_wait},
                {"wait_count", one.wait_count}});
        return out;
    }

    json waits() const {
        json out = json::array();
        for (const Submission& submission : plan_.submissions)
            for (std::uint32_t i = 0; i < submission.wait_count; ++i) {
                const Wait& wait = plan_.waits[submission.first_wait + i];
                out[submission.first_wait + i] = {{"queue", wait.queue}, {"value", wait.value},
                    {"submission", submission_of(plan_, wait.queue, wait.value)},
                    {"stages", stages_text(wait.stages)},
                    {"reason",
                        "waits " + reason_of_wait(declaration_, plan_, direct_, submission, wait)}};
            }
        return out;
    }

    const Declaration& declaration_;
    const Plan& plan_;
    std::vector<Dependency> direct_;
    std::vector<std::uint32_t> step_of_;
};

} // namespace

json plan_json(const Declaration& declaration, const Plan& plan, const Capabilities& capabilities,
    const Policy& policy) {
    json out = Writer(declaration, plan).write();
    out["declaration"] = declaration_json(declaration);
    out["capabilities"] = to_json(capabilities);
    out["policy"] = to_json(policy);
    return out;
}

} // namespace ockham
