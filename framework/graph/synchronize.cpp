// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/phases.hpp"

#include <algorithm>
#include <span>

namespace ockham {

namespace {

constexpr VkAccessFlags2 kWriteAccess =
    VK_ACCESS_2_SHADER_WRITE_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT |
    VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT |
    VK_ACCESS_2_TRANSFER_WRITE_BIT | VK_ACCESS_2_HOST_WRITE_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;

/// How a resource was left: by a write, or by the reads since the last write or transition.
struct Tail {
    AccessState state;
    PassId pass = kNone; ///< the last that used it
    bool written = false;
    /// The barrier that let the reads in; a read in another stage extends it. kNone after a write.
    std::uint32_t barrier = kNone;
    /// Stages that had used it before this execution; those of this execution prove nothing, for
    /// nobody wrote in between.
    VkPipelineStageFlags2 entry_stages = 0;
};

Tail tail_of(const AccessState& state) {
    return {state, kNone, (state.access & kWriteAccess) != 0, kNone, state.stages};
}

AccessState state_of(const Use& use, const ResourceDecl& resource) {
    AccessState state = state_of(use.access, use.stage);
    if (resource.kind == ResourceKind::buffer) state.layout = VK_IMAGE_LAYOUT_UNDEFINED;
    return state;
}

/// What comes next: an access, or the exit state.
struct Next {
    AccessState state;
    PassId pass = kNone;
    bool written = false;
    bool replaces = false;
    bool needs = false;
};

class Synchronizer {
public:
    Synchronizer(const Declaration& declaration, Plan& plan)
        : declaration_(declaration), plan_(plan), tails_(declaration.resources.size()),
          started_(declaration.resources.size(), 0) {}

    void run() {
        find_tails();
        plan_.final_states.resize(tails_.size());
        for (std::size_t i = 0; i < tails_.size(); ++i) plan_.final_states[i] = tails_[i].state;
        enter();
        for (Step& step : plan_.steps) {
            step.first_barrier = static_cast<std::uint32_t>(plan_.barriers.size());
            for (const Use& use : uses_of(step.pass)) pass_uses(step.pass, use);
            step.barrier_count =
                static_cast<std::uint32_t>(plan_.barriers.size()) - step.first_barrier;
        }
        leave();
    }

private:
    std::span<const Use> uses_of(PassId pass) const {
        const PassDecl& decl = declaration_.passes[pass];
        return {declaration_.uses.data() + decl.first_use, decl.use_count};
    }

    /// How every resource is left at the end of one execution, and usage bits.
    void find_tails() {
        plan_.usages.assign(tails_.size(), 0);
        for (const Step& step : plan_.steps)
            for (const Use& use : uses_of(step.pass)) {
                const ResourceDecl& resource = declaration_.resources[use.resource];
                plan_.usages[use.resource] |= resource.kind == ResourceKind::buffer
                                                  ? buffer_usage(use.access)
                                                  : image_usage(use.access);
                const AccessState next = state_of(use, resource);
                Tail& tail = tails_[use.resource];
                const bool joins =
                    !writes(use.access) && !tail.written && tail.state.layout == next.layout;
                tail.pass = step.pass;
                tail.written = writes(use.access);
                if (joins) {
                    tail.state.stages |= next.stages;
                    tail.state.access |= next.access;
                } else {
                    tail.state = next;
                }
            }
        for (std::size_t i = 0; i < tails_.size(); ++i) {
            const ResourceDecl& resource = declaration_.resources[i];
            const bool image = resource.kind == ResourceKind::image;
            if (tails_[i].pass == kNone) continue;
            if (resource.exported || resource.lifetime == Lifetime::persistent)
                plan_.usages[i] |= image ? VkFlags{VK_IMAGE_USAGE_TRANSFER_SRC_BIT}
                                         : VkFlags{VK_BUFFER_USAGE_TRANSFER_SRC_BIT};
            if (resource.lifetime == Lifetime::persistent)
                plan_.usages[i] |= image ? VkFlags{VK_IMAGE_USAGE_TRANSFER_DST_BIT}
                                         : VkFlags{VK_BUFFER_USAGE_TRANSFER_DST_BIT};
        }
    }

    /// Turns tails into how each resource's first use finds it.
    void enter() {
        std::vector<Tail> entries(tails_.size());
        first_hazards_.assign(tails_.size(), Hazard::first_use);
        find_owners(entries);
        for (std::size_t i = 0; i < tails_.size(); ++i) {
            const ResourceDecl& resource = declaration_.resources[i];
            if (resource.lifetime == Lifetime::external) {
                entries[i] = tail_of(resource.entry);
                if (resource.kind == ResourceKind::buffer)
                    entries[i].state.layout = VK_IMAGE_LAYOUT_UNDEFINED;
            } else if (resource.lifetime == Lifetime::persistent) {
                entries[i] = tails_[i]; // as the previous execution left it
                entries[i].pass = kNone;
                entries[i].entry_stages = entries[i].state.stages;
            } else if (resource.exported) {
                add_owner(entries[i], tails_[i], false); // alone in its memory
            }
        }
        tails_ = std::move(entries);
    }

    /// Joins the last uses of `owner` into what the next owner of its memory waits for.
    static void add_owner(Tail& entry, const Tail& owner, bool this_execution) {
        entry.state.stages |= owner.state.stages;
        if (owner.written) entry.state.access |= owner.state.access & kWriteAccess;
        entry.written |= owner.written;
        if (this_execution && (entry.pass == kNone || entry.pass < owner.pass))
            entry.pass = owner.pass;
    }

    /// For each shared range: whoever last used its bytes, in this or the previous execution.
    void find_owners(std::vector<Tail>& entries) {
        struct Segment {
            std::uint64_t begin, end;
            std::uint32_t placement;
        };
        std::vector<std::vector<Segment>> heaps(plan_.heaps.size());
        std::vector<Segment> kept;
        // The first round leaves the segments as an execution does; the second starts from there.
        for (int round = 0; round < 2; ++round) {
            for (std::uint32_t i = 0; i < plan_.placements.size(); ++i) {
                const Placement& placement = plan_.placements[i];
                if (!plan_.heaps[placement.heap].shared) continue;
                std::vector<Segment>& segments = heaps[placement.heap];
                const std::uint64_t begin = placement.offset, end = begin + placement.bytes;
                const auto first = std::lower_bound(segments.begin(), segments.end(), begin,
                    [](const Segment& s, std::uint64_t offset) { return s.end <= offset; });
                const auto last = std::lower_bound(first, segments.end(), end,
                    [](const Segment& s, std::uint64_t offset) { return s.begin < offset; });
                kept.clear();
                if (first != last && first->begin < begin)
                    kept.push_back({first->begin, begin, first->placement});
                kept.push_back({begin, end, i});
                if (first != last && (last - 1)->end > end)
                    kept.push_back({end, (last - 1)->end, (last - 1)->placement});
                if (round == 1)
                    for (auto segment = first; segment != last; ++segment) {
                        const Placement& owner = plan_.placements[segment->placement];
                        add_owner(entries[placement.resource], tails_[owner.resource],
                            segment->placement < i);
                        if (segment->placement != i)
                            first_hazards_[placement.resource] = Hazard::alias;
                    }
                const auto at = segments.erase(first, last);
                segments.insert(at, kept.begin(), kept.end());
            }
        }
    }

    void pass_uses(PassId pass, const Use& use) {
        const ResourceDecl& resource = declaration_.resources[use.resource];
        advance(use.resource, {state_of(use, resource), pass, writes(use.access),
                                  replaces_content(use), needs_content(use)});
    }

    /// Adds what must be waited for before `next`, and makes it the resource's tail.
    void advance(ResourceId id, const Next& next) {
        Tail& tail = tails_[id];
        const ResourceDecl& resource = declaration_.resources[id];
        const bool first = !started_[id];
        started_[id] = 1;
        const bool layout_changes = tail.state.layout != next.state.layout;
        if (!next.written && !tail.written && !layout_changes) {
            join_reads(id, tail, next);
            return;
        }
        Barrier barrier = barrier_to(id, tail, next);
        if (next.pass == kNone)
            barrier.hazard = Hazard::exit;
        else if (first && resource.lifetime == Lifetime::transient)
            barrier.hazard = first_hazards_[id];
        else if (tail.state.stages == 0 && tail.state.layout == VK_IMAGE_LAYOUT_UNDEFINED)
            barrier.hazard = Hazard::first_use;
        else if (tail.written)
            barrier.hazard = next.needs ? Hazard::read_after_write : Hazard::write_after_write;
        else
            barrier.hazard = next.written ? Hazard::write_after_read : Hazard::layout;
        const bool needed = barrier.src_stages != 0 || layout_changes;
        tail = {next.state, next.pass, next.written, kNone};
        if (!needed) return;
        if (!next.written) tail.barrier = static_cast<std::uint32_t>(plan_.barriers.size());
        plan_.barriers.push_back(barrier);
    }

    /// A read after reads in the same layout: waits for the same write as they did.
    void join_reads(ResourceId id, Tail& tail, const Next& next) {
        if (tail.barrier != kNone) {
            plan_.barriers[tail.barrier].dst_stages |= next.state.stages;
            plan_.barriers[tail.barrier].dst_access |= next.state.access;
        } else {
            const bool covered = (next.state.stages & ~tail.state.stages) == 0 &&
                                 (next.state.access & ~tail.state.access) == 0;
            if (!covered && tail.entry_stages != 0) {
                // Reads before this execution saw the write; this one waits through them.
                Barrier barrier = barrier_to(id, tail, next);
                barrier.from = kNone;
                barrier.src_stages = tail.entry_stages;
                if (next.pass == kNone) barrier.hazard = Hazard::exit;
                tail.barrier = static_cast<std::uint32_t>(plan_.barriers.size());
                plan_.barriers.push_back(barrier);
            }
        }
        tail.state.stages |= next.state.stages;
        tail.state.access |= next.state.access;
        tail.pass = next.pass;
    }

    Barrier barrier_to(ResourceId id, const Tail& tail, const Next& next) const {
        Barrier barrier;
        barrier.resource = id;
        barrier.part = part_of(declaration_, Use{.resource = id});
        barrier.from = tail.pass;
        barrier.to = next.pass;
        barrier.src_stages = tail.state.stages;
        barrier.src_access = tail.written ? tail.state.access & kWriteAccess : 0;
        barrier.dst_stages = next.state.stages;
        barrier.dst_access = next.state.access;
        const bool changes = tail.state.layout != next.state.layout;
        // What is replaced anyway need not survive the transition.
        barrier.old_layout =
            changes && next.replaces ? VK_IMAGE_LAYOUT_UNDEFINED : tail.state.layout;
        barrier.new_layout = next.state.layout;
        return barrier;
    }

    /// External resources go into the state that was promised.
    void leave() {
        plan_.first_exit_barrier = static_cast<std::uint32_t>(plan_.barriers.size());
        for (ResourceId id = 0; id < tails_.size(); ++id) {
            const ResourceDecl& resource = declaration_.resources[id];
            if (resource.lifetime != Lifetime::external || !started_[id]) continue;
            AccessState exit = resource.exit;
            if (resource.kind == ResourceKind::buffer || exit.layout == VK_IMAGE_LAYOUT_UNDEFINED)
                exit.layout = tails_[id].state.layout;
            if (exit.stages == 0 && exit.layout == tails_[id].state.layout) continue;
            advance(id, {exit, kNone, (exit.access & kWriteAccess) != 0, false, true});
            plan_.final_states[id] = exit;
        }
        plan_.exit_barrier_count =
            static_cast<std::uint32_t>(plan_.barriers.size()) - plan_.first_exit_barrier;
    }

    const Declaration& declaration_;
    Plan& plan_;
    std::vector<Tail> tails_; ///< per resource, as the walk has left it so far
    std::vector<std::uint8_t> started_;
    std::vector<Hazard> first_hazards_; ///< of transient resources
};

} // namespace

void synchronize(const Declaration& declaration, const Pieces&, Plan& plan) {
    Synchronizer(declaration, plan).run();
}

} // namespace ockham
