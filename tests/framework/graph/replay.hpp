// SPDX-License-Identifier: Apache-2.0
// Replays two executions of a plan, access by access, under Vulkan's memory model as far as plans
// use it: execution chains per stage, availability, visibility, layouts, memory shared by aliases.
// Shares no code with the compiler. Quadratic; for tests.
#pragma once

#include "framework/graph/plan.hpp"

#include <fmt/format.h>

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace ockham {

/// The first unsynchronised pair, wrong layout or shared byte; nothing if the plan is sound.
class Replay {
public:
    Replay(const Declaration& declaration, const Plan& plan)
        : declaration_(declaration), plan_(plan), ranges_(declaration.resources.size()) {
        for (const Placement& p : plan.placements)
            ranges_[p.resource] = {p.heap, p.offset, p.offset + p.bytes, true};
    }

    std::optional<std::string> run() {
        check_overlap();
        layouts_.resize(declaration_.resources.size());
        for (std::size_t i = 0; i < layouts_.size(); ++i)
            if (declaration_.resources[i].lifetime == Lifetime::persistent)
                layouts_[i] = plan_.final_states[i].layout;
        for (int execution = 0; execution < 2 && !problem_; ++execution) {
            enter();
            for (const Step& step : plan_.steps) {
                batch(step.first_barrier, step.barrier_count);
                const PassDecl& pass = declaration_.passes[step.pass];
                for (std::uint32_t i = 0; i < pass.use_count; ++i)
                    access(pass, declaration_.uses[pass.first_use + i]);
            }
            batch(plan_.first_exit_barrier, plan_.exit_barrier_count);
            leave();
        }
        return problem_;
    }

private:
    struct Range {
        std::uint32_t heap = 0;
        std::uint64_t begin = 0, end = 0;
        bool placed = false;
    };
    /// One access in one stage, or one layout transition, and what is ordered after it so far.
    struct Past {
        ResourceId resource;
        std::string what;
        std::uint64_t stage = 0;
        std::uint64_t write_access = 0;
        bool writes = false;
        bool available = false;
        std::uint64_t chained = 0;               ///< stages that wait for it
        std::array<std::uint64_t, 40> visible{}; ///< per stage bit: accesses that see it
    };

    /// Execution scopes include what is logically earlier (later) in the same pipeline.
    static constexpr std::array<std::uint64_t, 8> kDraw{VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT,
        VK_PIPELINE_STAGE_2_INDEX_INPUT_BIT, VK_PIPELINE_STAGE_2_VERTEX_ATTRIBUTE_INPUT_BIT,
        VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT, VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT,
        VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT,
        VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT};
    static std::uint64_t with_earlier(std::uint64_t stages) {
        bool found = false;
        for (std::size_t i = kDraw.size(); i-- > 0;) {
            found = found || (stages & kDraw[i]);
            if (found) stages |= kDraw[i];
        }
        return stages & VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT ? stages | kDraw[0] : stages;
    }
    static std::uint64_t with_later(std::uint64_t stages) {
        if (stages & kDraw[0]) stages |= VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT;
        bool found = false;
        for (const std::uint64_t stage : kDraw) {
            found = found || (stages & stage);
            if (found) stages |= stage;
        }
        return stages;
    }

    void report(std::string text) {
        if (!problem_) problem_ = std::move(text);
    }

    const std::string& name(ResourceId id) const { return declaration_.resources[id].name; }

    bool share_memory(ResourceId a, ResourceId b) const {
        if (a == b) return true;
        const Range &x = ranges_[a], &y = ranges_[b];
        return x.placed && y.placed && x.heap == y.heap && x.begin < y.end && y.begin < x.end;
    }

    /// Resources used in overlapping intervals of steps must not share bytes; kept ones never.
    void check_overlap() {
        const auto& all = plan_.placements;
        const auto lasts = [&](const Placement& p) {
            const ResourceDecl& resource = declaration_.resources[p.resource];
            return resource.exported || resource.lifetime != Lifetime::transient;
        };
        for (std::size_t i = 0; i < all.size(); ++i) {
            if (all[i].offset + all[i].bytes > plan_.heaps[all[i].heap].bytes)
                report(fmt::format("'{}' ends outside its heap", name(all[i].resource)));
            for (std::size_t k = 0; k < i; ++k) {
                const bool share_step =
                    all[i].first_step <= all[k].last_step && all[k].first_step <= all[i].last_step;
                if (share_memory(all[i].resource, all[k].resource) &&
                    (share_step || lasts(all[i]) || lasts(all[k])))
                    report(fmt::format("'{}' and '{}' share bytes while both live",
                        name(all[i].resource), name(all[k].resource)));
            }
        }
        std::vector<std::uint32_t> first(declaration_.resources.size(), kNone);
        std::vector<std::uint32_t> last(declaration_.resources.size(), kNone);
        for (std::uint32_t step = 0; step < plan_.steps.size(); ++step) {
            const PassDecl& pass = declaration_.passes[plan_.steps[step].pass];
            for (std::uint32_t i = 0; i < pass.use_count; ++i) {
                const ResourceId id = declaration_.uses[pass.first_use + i].resource;
                if (first[id] == kNone) first[id] = step;
                last[id] = step;
            }
        }
        for (const Placement& p : all)
            if (p.first_step != first[p.resource] || p.last_step != last[p.resource])
                report(fmt::format("'{}' has a wrong interval", name(p.resource)));
    }

    void enter() {
        for (ResourceId id = 0; id < declaration_.resources.size(); ++id) {
            const ResourceDecl& resource = declaration_.resources[id];
            if (resource.lifetime != Lifetime::external) continue;
            layouts_[id] = resource.entry.layout;
            add(id, "what the caller did", resource.entry.stages, resource.entry.access,
                is_write(resource.entry.access));
        }
    }

    /// External resources are the caller's again, in the state that was promised; what was done
    /// to them is no concern of the next execution.
    void leave() {
        for (ResourceId id = 0; id < declaration_.resources.size(); ++id) {
            const ResourceDecl& resource = declaration_.resources[id];
            if (resource.lifetime != Lifetime::external || plan_.resources[id].culled) continue;
            if (resource.kind == ResourceKind::image &&
                resource.exit.layout != VK_IMAGE_LAYOUT_UNDEFINED &&
                layouts_[id] != resource.exit.layout)
                report(fmt::format("'{}' is not left in its exit layout", name(id)));
            compare(id, "what the caller does", resource.exit, is_write(resource.exit.access));
        }
        std::erase_if(past_, [&](const Past& past) {
            return declaration_.resources[past.resource].lifetime == Lifetime::external;
        });
    }

    /// A batch acts as one: its barriers do not chain among themselves.
    void batch(std::uint32_t first, std::uint32_t count) {
        std::vector<Past> transitions;
        std::vector<std::uint64_t> chained_before;
        for (const Past& past : past_) chained_before.push_back(past.chained);
        for (std::uint32_t i = first; i < first + count; ++i) {
            const Barrier& barrier = plan_.barriers[i];
            for (std::size_t k = 0; k < past_.size(); ++k)
                apply(barrier, past_[k], past_[k].stage | chained_before[k]);
            if (declaration_.resources[barrier.resource].kind == ResourceKind::image)
                transition(barrier, transitions, chained_before);
        }
        past_.insert(past_.end(), transitions.begin(), transitions.end());
    }

    void apply(const Barrier& barrier, Past& past, std::uint64_t reach) const {
        if ((reach & with_earlier(barrier.src_stages)) == 0) return;
        past.chained |= with_later(barrier.dst_stages);
        if (!past.writes || !share_memory(past.resource, barrier.resource)) return;
        if ((barrier.src_stages & past.stage) && (past.write_access & ~barrier.src_access) == 0)
            past.available = true;
        if (!past.available) return;
        for (std::size_t bit = 0; bit < past.visible.size(); ++bit)
            if (barrier.dst_stages >> bit & 1) past.visible[bit] |= barrier.dst_access;
    }

    void transition(const Barrier& barrier, std::vector<Past>& transitions,
        const std::vector<std::uint64_t>& chained_before) {
        VkImageLayout& layout = layouts_[barrier.resource];
        if (barrier.old_layout != VK_IMAGE_LAYOUT_UNDEFINED && barrier.old_layout != layout)
            report(fmt::format(
                "a barrier on '{}' expects another layout than it has", name(barrier.resource)));
        if (barrier.old_layout == barrier.new_layout) return;
        discarded_[barrier.resource] = barrier.old_layout == VK_IMAGE_LAYOUT_UNDEFINED;
        layout = barrier.new_layout;
        for (std::size_t k = 0; k < past_.size(); ++k) {
            const Past& past = past_[k];
            if (!share_memory(past.resource, barrier.resource)) continue;
            if (((past.stage | chained_before[k]) & with_earlier(barrier.src_stages)) == 0)
                report(fmt::format("a transition of '{}' does not wait for {} of '{}'",
                    name(barrier.resource), past.what, name(past.resource)));
            if (past.writes && !past.available)
                report(fmt::format("a transition of '{}' comes before {} of '{}' is available",
                    name(barrier.resource), past.what, name(past.resource)));
        }
        Past done{barrier.resource, "the transition", 0, 0, true, true,
            with_later(barrier.dst_stages), {}};
        for (std::size_t bit = 0; bit < done.visible.size(); ++bit)
            if (barrier.dst_stages >> bit & 1) done.visible[bit] = barrier.dst_access;
        transitions.push_back(done);
    }

    void access(const PassDecl& pass, const Use& use) {
        const AccessState state = state_of(use.access, use.stage);
        const std::string what = fmt::format("the {} by '{}'", name_of(use.access), pass.name);
        if (declaration_.resources[use.resource].kind == ResourceKind::image) {
            if (layouts_[use.resource] != state.layout)
                report(fmt::format("{} of '{}' finds a wrong layout", what, name(use.resource)));
            if (needs_content(use) && discarded_[use.resource])
                report(fmt::format("{} of '{}' finds its content gone", what, name(use.resource)));
        }
        if (writes(use.access)) discarded_[use.resource] = false;
        compare(use.resource, what, state, writes(use.access));
        add(use.resource, what, state.stages, state.access, writes(use.access));
    }

    /// Compares one access with all before it that conflict with it.
    void compare(ResourceId id, const std::string& what, const AccessState& state, bool is_write) {
        for (const Past& past : past_) {
            if (!share_memory(past.resource, id)) continue;
            if (!past.writes && !is_write) continue;
            for (std::size_t bit = 0; bit < past.visible.size(); ++bit) {
                if ((state.stages >> bit & 1) == 0) continue;
                if ((past.chained >> bit & 1) == 0)
                    report(fmt::format("{} of '{}' does not wait for {} of '{}'", what, name(id),
                        past.what, name(past.resource)));
                else if (past.writes && past.resource == id &&
                         (state.access & ~kWrites & ~past.visible[bit]))
                    report(fmt::format("{} of '{}' does not see {}", what, name(id), past.what));
                else if (past.writes && !past.available)
                    report(fmt::format("{} of '{}' comes before {} of '{}' is available", what,
                        name(id), past.what, name(past.resource)));
            }
        }
    }

    static constexpr std::uint64_t kWrites =
        VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT |
        VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT;
    static bool is_write(std::uint64_t access) { return (access & kWrites) != 0; }

    void add(ResourceId id, const std::string& what, std::uint64_t stages, std::uint64_t access,
        bool writes) {
        for (std::uint64_t bit = 0; bit < 40; ++bit)
            if (stages >> bit & 1)
                past_.push_back(
                    {id, what, std::uint64_t{1} << bit, access & kWrites, writes, false, 0, {}});
    }

    const Declaration& declaration_;
    const Plan& plan_;
    std::vector<Range> ranges_;
    std::vector<VkImageLayout> layouts_;
    std::vector<bool> discarded_ = std::vector<bool>(declaration_.resources.size(), false);
    std::vector<Past> past_;
    std::optional<std::string> problem_;
};

} // namespace ockham
