// SPDX-License-Identifier: Apache-2.0
// Whether a small plan is sound, by definition: every operation of several executions is written
// down, and every conflicting pair must be ordered as Vulkan's memory model demands. The slow twin
// of verify(), which it shares no code with. Called by tests, for plans of about ten passes.
#pragma once

#include "framework/core/error.hpp"
#include "framework/graph/compile.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bitset>
#include <set>
#include <string>
#include <vector>

namespace ockham::reference {

using Flags = std::uint64_t; ///< of stages or accesses, one bit each

/// Accesses that some of the stages can perform.
inline Flags accesses_in(Flags stages) {
    constexpr Flags shaders = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT |
                              VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT |
                              VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT;
    Flags accesses = 0;
    for (const AccessRow& row : kAccessRows)
        if ((row.stages ? row.stages : shaders) & stages) accesses |= row.access;
    return accesses;
}

class HappensBefore {
public:
    HappensBefore(
        const Declaration& declaration, const Plan& plan, const Capabilities& capabilities)
        : declaration_(declaration), plan_(plan), capabilities_(capabilities) {
        cut();
        placements_.assign(declaration.resources.size(), nullptr);
        for (const Placement& placement : plan.placements)
            placements_[placement.resource] = &placement;
        first_queues_.assign(declaration.resources.size(), kNone);
        for (const Submission& submission : plan.submissions)
            for (std::uint32_t i = 0; i < submission.step_count; ++i)
                for (const Use& use :
                    declaration.uses_of(plan.steps[submission.first_step + i].pass))
                    if (first_queues_[use.resource] == kNone)
                        first_queues_[use.resource] = submission.queue;
    }

    /// Empty where the plan is sound, else the first thing found wrong. Call it once.
    std::string find() {
        // Answers change content and owners, never the barriers, so each set of answers is tried;
        // what is synchronized is written down once, with all passes.
        const std::size_t answers = std::size_t{1} << declaration_.conditions.size();
        for (answers_ = 0; answers_ < answers && wrong_.empty(); ++answers_) {
            writes_down_ = answers_ == 0;
            walk();
        }
        if (wrong_.empty()) compare();
        return wrong_;
    }

private:
    static constexpr std::size_t kMost = 512; ///< barriers and waits, of all executions
    using Set = std::bitset<kMost>;
    static constexpr Flags kWrites =
        VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT |
        VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT |
        VK_ACCESS_2_HOST_WRITE_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;

    /// A barrier, or a wait of one submission for another.
    struct Sync {
        std::uint32_t order = 0; ///< in submission order; barriers of a batch share it
        std::uint32_t until = 0; ///< the first scope is what was submitted before
        std::uint32_t queue_before = 0, queue_after = 0;
        Flags first = 0, second = 0; ///< execution scopes
        Flags src = 0, dst = 0, src_access = 0, dst_access = 0;
        bool semaphore = false;               ///< of all memory
        std::vector<std::uint32_t> locations; ///< else
    };

    /// What one stage of a pass does to one location, or a layout transition or acquisition.
    struct Operation {
        std::uint32_t order = 0, queue = 0, execution = 0;
        Flags stage = 0, access = 0;
        bool writes = false, needs = false;
        bool releases = false;       ///< the acquire is compared with what follows
        PassId pass = kNone;         ///< kNone: the caller
        std::uint32_t sync = kNone;  ///< of transitions: the barrier
        ResourceId resource = kNone; ///< as named there
        // Filled by compare().
        Set before;    ///< what it happens before
        Set available; ///< what its writes are available to
        Set after;     ///< what happens before it
    };

    struct Transfer {
        bool pending = false, by_caller = false;
        std::uint32_t from = 0, to = 0;
        std::uint32_t release = 0; ///< of syncs_
        VkImageLayout old_layout{}, new_layout{};
    };

    /// A smallest part of a resource. Histories exchange them.
    struct Atom {
        std::uint32_t location = 0; ///< of Operations; new whenever the past does not matter
        VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;
        std::uint32_t owner = VK_QUEUE_FAMILY_IGNORED;
        Transfer transfer;
        std::uint32_t changed = 0; ///< order of the latest transition
        bool content = false, lost = false;
        bool touched = false; ///< in this execution
    };

    // ---- Parts ----------------------------------------------------------------------------------

    struct Grid {
        std::set<std::uint64_t> columns, rows; ///< where cells begin, and the end
    };

    ResourceId ring_of(ResourceId id) const { return id - declaration_.resources[id].history_age; }
    bool is_image(ResourceId id) const {
        return declaration_.resources[id].kind == ResourceKind::image;
    }

    void cut() {
        grids_.resize(declaration_.resources.size());
        for (const PassDecl& pass : declaration_.passes)
            for (const Use& use :
                declaration_.uses_of(static_cast<PassId>(&pass - declaration_.passes.data())))
                cut(use.resource, part_of(declaration_, use));
        for (const Barrier& barrier : plan_.barriers) cut(barrier.resource, barrier.part);
        for (ResourceId id = 0; id < grids_.size(); ++id) {
            const ResourceDecl& resource = declaration_.resources[id];
            Part whole{0, resource.buffer.bytes, 0, resource.image.mips, 0, resource.image.layers};
            cut(id, whole);
        }
    }
    void cut(ResourceId id, const Part& part) {
        Grid& grid = grids_[ring_of(id)];
        const bool image = is_image(id);
        grid.columns.insert(image ? part.first_mip : part.offset);
        grid.columns.insert(image ? part.first_mip + part.mips : part.offset + part.bytes);
        grid.rows.insert(image ? part.first_layer : 0);
        grid.rows.insert(image ? part.first_layer + part.layers : 1);
    }

    template <class Visit>
    void each(ResourceId id, const Part& part, Visit visit) {
        const Grid& grid = grids_[ring_of(id)];
        const bool image = is_image(id);
        const std::uint64_t column = image ? part.first_mip : part.offset;
        const std::uint64_t column_end = column + (image ? part.mips : part.bytes);
        const std::uint64_t row = image ? part.first_layer : 0;
        const std::uint64_t row_end = image ? row + part.layers : 1;
        std::size_t index = 0;
        for (auto y = grid.rows.begin(); y != std::prev(grid.rows.end()); ++y)
            for (auto x = grid.columns.begin(); x != std::prev(grid.columns.end()); ++x, ++index)
                if (*x >= column && *x < column_end && *y >= row && *y < row_end)
                    visit(atoms_[id][index]);
    }

    // ---- Scopes ---------------------------------------------------------------------------------

    static constexpr Flags kGraphics[] = {VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT,
        VK_PIPELINE_STAGE_2_INDEX_INPUT_BIT, VK_PIPELINE_STAGE_2_VERTEX_ATTRIBUTE_INPUT_BIT,
        VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT, VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT,
        VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT,
        VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT};

    static Flags expanded(Flags stages) {
        Flags all = 0;
        for (const Flags stage : kGraphics) all |= stage;
        if (stages & VK_PIPELINE_STAGE_2_ALL_GRAPHICS_BIT) stages |= all;
        if (stages & VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT)
            stages |=
                all | VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT;
        constexpr Flags names =
            VK_PIPELINE_STAGE_2_ALL_GRAPHICS_BIT | VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
        return stages & ~names;
    }
    static Flags expanded_access(Flags access) {
        Flags all = 0;
        for (const AccessRow& row : kAccessRows) all |= row.access;
        if (access & VK_ACCESS_2_MEMORY_READ_BIT) access |= all & ~kWrites;
        if (access & VK_ACCESS_2_MEMORY_WRITE_BIT) access |= all & kWrites;
        constexpr Flags names = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
        return access & ~names;
    }
    /// The graphics pipeline in its order, and indirect arguments before compute.
    static Flags with_earlier(Flags stages) {
        Flags before = 0, result = stages;
        for (const Flags stage : kGraphics) {
            if (stages & stage) result |= before;
            before |= stage;
        }
        if (stages & VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT)
            result |= VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT;
        return result;
    }
    static Flags with_later(Flags stages) {
        Flags result = stages;
        for (Flags rest = expanded(VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT); rest; rest &= rest - 1)
            if (with_earlier(rest & (~rest + 1)) & stages) result |= rest & (~rest + 1);
        return result;
    }

    // ---- Walking over the executions ------------------------------------------------------------

    bool consents(PassId pass) const {
        for (GuardId guard = declaration_.passes[pass].guard; guard != kNone;
             guard = declaration_.guards[guard].parent) {
            const Guard& one = declaration_.guards[guard];
            if (((answers_ >> one.condition & 1) != 0) != one.wanted) return false;
        }
        return true;
    }
    bool can_meet(PassId a, PassId b) {
        const std::size_t kept = answers_;
        bool both = false;
        for (answers_ = 0; answers_ >> declaration_.conditions.size() == 0; ++answers_)
            both |= consents(a) && consents(b);
        answers_ = kept;
        return both;
    }

    void fail(std::string text) {
        if (wrong_.empty()) wrong_ = fmt::format("execution {}: {}", execution_, text);
    }
    std::string name(PassId pass) const {
        return pass == kNone ? "the outside" : declaration_.passes[pass].name;
    }
    std::uint32_t family(std::uint32_t queue) const { return plan_.queues[queue].family; }
    Flags stages_on(std::uint32_t queue) const {
        const QueueFamily all;
        const QueueFamily& one =
            capabilities_.families.empty() ? all : capabilities_.families[family(queue)];
        Flags stages = VK_PIPELINE_STAGE_2_HOST_BIT | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT;
        if (one.compute)
            stages |=
                VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT;
        if (one.graphics)
            for (const Flags stage : kGraphics) stages |= stage;
        return stages;
    }
    bool rotates(ResourceId id) const {
        const ResourceId ring = ring_of(id);
        for (ResourceId age = 0; age <= declaration_.resources[ring].history_depth; ++age)
            if (!placements_[ring + age]) return false;
        return declaration_.resources[ring].history_depth != 0;
    }

    void walk() {
        now_ = 0;
        locations_ = 0;
        atoms_.assign(grids_.size(), {});
        begun_.assign(grids_.size(), 0);
        std::uint32_t executions = 2;
        for (ResourceId id = 0; id < grids_.size(); ++id) {
            const ResourceDecl& resource = declaration_.resources[id];
            executions = std::max(executions, 2 + resource.history_depth);
            const Grid& grid = grids_[ring_of(id)];
            atoms_[id].resize((grid.columns.size() - 1) * (grid.rows.size() - 1));
            ResourceId left = id;
            if (rotates(id)) left = resource.history_age ? id - 1 : id + resource.history_depth;
            for (Atom& atom : atoms_[id]) {
                atom.location = locations_++;
                if (resource.lifetime != Lifetime::persistent) continue;
                atom.content = true;
                if (is_image(id)) atom.layout = plan_.final_states[left].layout;
            }
        }
        last_signals_.assign(plan_.queues.size(), 0);
        for (execution_ = 1; execution_ <= executions; ++execution_) {
            enter();
            for (const Submission& submission : plan_.submissions) submit(submission);
            leave();
            last_signals_.assign(plan_.queues.size(), 0);
            for (std::size_t queue = 0; queue < signals_.size(); ++queue)
                if (!signals_[queue].empty()) last_signals_[queue] = signals_[queue].back();
        }
    }

    void enter() {
        signals_.assign(plan_.queues.size(), {});
        for (ResourceId id = 0; id < atoms_.size(); ++id) {
            const ResourceDecl& resource = declaration_.resources[id];
            for (Atom& atom : atoms_[id]) atom.touched = false;
            const std::uint32_t queue = first_queues_[id];
            if (resource.lifetime != Lifetime::external || queue == kNone) continue;
            const AccessState& entry = resource.entry;
            const bool elsewhere = entry.queue_family != VK_QUEUE_FAMILY_IGNORED &&
                                   entry.queue_family != family(queue);
            Sync sync; // what the caller's last reads have waited for
            sync.order = ++now_;
            sync.queue_after = queue;
            sync.second = sync.dst = expanded(entry.stages) & stages_on(queue);
            sync.dst_access = expanded_access(entry.access);
            for (Atom& atom : atoms_[id]) {
                atom = {};
                atom.location = locations_++;
                if (is_image(id)) atom.layout = entry.layout;
                atom.content = !is_image(id) || entry.layout != VK_IMAGE_LAYOUT_UNDEFINED;
                // All of it comes to the family that uses any of it first.
                atom.owner = entry.queue_family != VK_QUEUE_FAMILY_IGNORED ? entry.queue_family
                                                                           : family(queue);
                if (elsewhere)
                    atom.transfer = {true, true, entry.queue_family, family(queue), 0, entry.layout,
                        VK_IMAGE_LAYOUT_UNDEFINED};
                sync.locations.push_back(atom.location);
            }
            if (!sync.dst || elsewhere || !writes_down_) continue;
            const bool writes = (sync.dst_access & kWrites) != 0;
            for (const Atom& atom : atoms_[id]) {
                const std::uint32_t order = sync.order;
                if (!writes) {
                    Operation operation;
                    operation.order = order;
                    operation.queue = queue;
                    operation.writes = true;
                    operation.sync = static_cast<std::uint32_t>(syncs_.size());
                    operation.resource = id;
                    operation.execution = execution_;
                    write_down(atom, operation);
                }
                add_operations(atom, id, {order, queue, sync.dst, sync.dst_access, kNone, false});
            }
            if (!writes) syncs_.push_back(sync);
        }
    }

    void submit(const Submission& submission) {
        const std::uint32_t queue = submission.queue;
        std::vector<std::uint32_t>& signals = signals_[queue];
        const auto wait = [&](std::uint32_t other, std::uint32_t until, Flags stages) {
            if (!until || !writes_down_) return;
            Sync sync;
            sync.order = now_;
            sync.until = until;
            sync.queue_before = other;
            sync.queue_after = queue;
            sync.first = sync.src = sync.src_access = sync.dst_access = ~Flags{0};
            sync.dst = expanded(stages);
            sync.second = with_later(sync.dst);
            sync.semaphore = true;
            syncs_.push_back(sync);
        };
        ++now_;
        if (signals.empty())
            for (std::uint32_t other = 0; other < plan_.queues.size(); ++other)
                if (other != queue)
                    wait(other, last_signals_[other], VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT);
        for (std::uint32_t i = 0; i < submission.wait_count; ++i) {
            const Wait& one = plan_.waits[submission.first_wait + i];
            wait(one.queue, signals_[one.queue][one.value - 1], one.stages);
        }
        for (std::uint32_t i = 0; i < submission.step_count; ++i) {
            const Step& step = plan_.steps[submission.first_step + i];
            batch(plan_.barriers_before(step), queue);
            execute(step.pass, queue);
            batch(plan_.releases_after(step), queue);
        }
        if (&submission == &plan_.submissions.back()) batch(plan_.exit_barriers(), queue);
        signals.push_back(++now_);
    }

    void execute(PassId pass, std::uint32_t queue) {
        ++now_;
        if (!can_meet(pass, pass)) return; // its guard contradicts itself
        for (const Use& use : declaration_.uses_of(pass)) {
            const AccessState state = state_of(use.access, use.stage);
            begin(use.resource);
            each(use.resource, part_of(declaration_, use), [&](Atom& atom) {
                if (is_image(use.resource) && atom.layout != state.layout)
                    fail(fmt::format("{} finds {} in layout {}", name(pass),
                        declaration_.resources[use.resource].name, atom.layout));
                if (consents(pass)) use_content(atom, use, pass, queue);
                add_operations(atom, use.resource,
                    {now_, queue, expanded(state.stages), state.access, pass, needs_content(use)});
                atom.touched = true;
            });
        }
    }

    void use_content(Atom& atom, const Use& use, PassId pass, std::uint32_t queue) {
        const bool foreign = atom.transfer.pending ||
                             (atom.owner != VK_QUEUE_FAMILY_IGNORED && atom.owner != family(queue));
        const bool keeps = is_image(use.resource) || needs_content(use) ||
                           (atom.content && !replaces_content(use));
        if (foreign && keeps && !plan_.concurrent[use.resource])
            fail(fmt::format("{} uses what its family does not own", name(pass)));
        if (needs_content(use) && !atom.content)
            fail(fmt::format("{} reads {}, which has no content", name(pass),
                declaration_.resources[use.resource].name));
        atom.owner = family(queue);
        atom.transfer = {};
        if (writes(use.access)) {
            atom.content = true;
            atom.lost = false;
        }
    }

    // ---- Shared memory --------------------------------------------------------------------------

    bool overlap(ResourceId a, ResourceId b) const {
        const Placement* const x = placements_[a];
        const Placement* const y = placements_[b];
        if (a == b || !x || !y || x->heap != y->heap) return false;
        // Buffers and images on one page of the granularity count as one memory.
        const std::uint64_t page =
            is_image(a) == is_image(b)
                ? 1
                : std::max<std::uint64_t>(capabilities_.buffer_image_granularity, 1);
        const auto down = [&](std::uint64_t n) { return n / page * page; };
        const auto up = [&](std::uint64_t n) { return (n + page - 1) / page * page; };
        return down(x->offset) < up(y->offset + y->bytes) &&
               down(y->offset) < up(x->offset + x->bytes);
    }

    /// Transient content begins anew in each execution, and ends where others take the bytes.
    void begin(ResourceId id) {
        if (declaration_.resources[id].lifetime != Lifetime::transient) return;
        if (begun_[id] == execution_) return;
        begun_[id] = execution_;
        for (Atom& atom : atoms_[id]) {
            atom.content = atom.lost = false;
            atom.owner = VK_QUEUE_FAMILY_IGNORED;
            atom.transfer = {};
        }
        for (ResourceId other = 0; other < atoms_.size(); ++other)
            if (overlap(id, other))
                for (Atom& atom : atoms_[other]) atom.layout = VK_IMAGE_LAYOUT_UNDEFINED;
    }

    // ---- Barriers -------------------------------------------------------------------------------

    void batch(std::span<const Barrier> barriers, std::uint32_t queue) {
        ++now_;
        for (const Barrier& barrier : barriers) {
            Sync sync;
            sync.order = sync.until = now_;
            sync.queue_before = sync.queue_after = queue;
            sync.src = expanded(barrier.src_stages);
            sync.dst = expanded(barrier.dst_stages);
            sync.first = with_earlier(sync.src);
            sync.second = with_later(sync.dst);
            sync.src_access = expanded_access(barrier.src_access);
            sync.dst_access = expanded_access(barrier.dst_access);
            const Flags wrong = (sync.src | sync.dst) & ~stages_on(queue);
            if (wrong || (sync.src_access & ~accesses_in(sync.src)) ||
                (sync.dst_access & ~accesses_in(sync.dst)))
                fail("a barrier names a stage or access that does not exist there");
            apply(barrier, queue, sync);
            if (writes_down_) syncs_.push_back(sync);
        }
    }

    void apply(const Barrier& barrier, std::uint32_t queue, Sync& sync) {
        const ResourceId id = barrier.resource;
        const bool moves = barrier.src_family != barrier.dst_family;
        const bool releases = moves && barrier.src_family == family(queue);
        const bool acquires = moves && barrier.dst_family == family(queue);
        const bool changes = is_image(id) && barrier.old_layout != barrier.new_layout;
        if (moves && ((!releases && !acquires) || plan_.concurrent[id]))
            fail("a transfer between families that have nothing to do with it");
        if (changes && barrier.new_layout == VK_IMAGE_LAYOUT_UNDEFINED)
            fail("a transition to no layout");
        const bool anew = is_image(id)
                              ? barrier.old_layout == VK_IMAGE_LAYOUT_UNDEFINED
                              : declaration_.resources[id].lifetime == Lifetime::transient &&
                                    begun_[id] != execution_;
        if (changes || moves) begin(id);
        // Recorded as a global barrier, but a plan may lean on it only for what is taken over.
        if (barrier.hazard == Hazard::alias)
            for (ResourceId other = 0; other < atoms_.size(); ++other)
                if (overlap(id, other))
                    for (const Atom& atom : atoms_[other]) sync.locations.push_back(atom.location);
        each(id, barrier.part, [&](Atom& atom) {
            sync.locations.push_back(atom.location);
            const bool foreign = atom.transfer.pending || (atom.owner != VK_QUEUE_FAMILY_IGNORED &&
                                                              atom.owner != family(queue));
            if (foreign && !acquires && !anew && !plan_.concurrent[id])
                fail("a barrier on what its family does not own");
            if (is_image(id) && !acquires && (changes || releases || moves) &&
                barrier.old_layout != VK_IMAGE_LAYOUT_UNDEFINED &&
                barrier.old_layout != atom.layout)
                fail("a barrier from another layout");
            if (is_image(id) && !changes && !moves &&
                barrier.old_layout != VK_IMAGE_LAYOUT_UNDEFINED &&
                barrier.old_layout != atom.layout)
                fail("a barrier in another layout");
            if (acquires) acquire(barrier, atom);
            if (!releases && !changes && !acquires) return;
            Operation operation;
            operation.order = now_;
            operation.queue = queue;
            operation.execution = execution_;
            operation.writes = true;
            operation.releases = releases;
            operation.pass = barrier.to;
            operation.sync = static_cast<std::uint32_t>(syncs_.size());
            operation.resource = id;
            write_down(atom, operation);
            atom.touched = true;
            if (releases) {
                atom.transfer = {true, false, barrier.src_family, barrier.dst_family,
                    static_cast<std::uint32_t>(syncs_.size()), barrier.old_layout,
                    barrier.new_layout};
                return;
            }
            if (atom.changed == now_) fail("two transitions in one batch");
            atom.changed = now_;
            atom.owner = family(queue);
            atom.transfer = {};
            if (!is_image(id)) return;
            atom.layout = barrier.new_layout;
            if (barrier.old_layout != VK_IMAGE_LAYOUT_UNDEFINED) return;
            atom.lost |= atom.content;
            atom.content = false;
        });
    }

    void acquire(const Barrier& barrier, const Atom& atom) {
        const Transfer& transfer = atom.transfer;
        const bool image = is_image(barrier.resource);
        if (!transfer.pending || transfer.from != barrier.src_family ||
            transfer.to != barrier.dst_family ||
            (image && transfer.old_layout != barrier.old_layout) ||
            (image && !transfer.by_caller && transfer.new_layout != barrier.new_layout))
            return fail("an acquire without its release");
        if (!transfer.by_caller && writes_down_)
            acquires_.push_back({transfer.release, static_cast<std::uint32_t>(syncs_.size())});
    }

    // ---- The end --------------------------------------------------------------------------------

    void leave() {
        ++now_;
        for (ResourceId id = 0; id < atoms_.size(); ++id) {
            const ResourceDecl& resource = declaration_.resources[id];
            const bool external = resource.lifetime == Lifetime::external;
            if (first_queues_[id] == kNone ||
                (resource.lifetime == Lifetime::transient && !resource.exported))
                continue;
            for (Atom& atom : atoms_[id]) {
                const Transfer& transfer = atom.transfer;
                const VkImageLayout layout = transfer.pending ? transfer.new_layout : atom.layout;
                const bool never =
                    resource.lifetime == Lifetime::transient && layout == VK_IMAGE_LAYOUT_UNDEFINED;
                if (is_image(id) && layout != plan_.final_states[id].layout && !never)
                    fail(fmt::format("{} is left in another layout", resource.name));
                if (atom.lost) fail(fmt::format("{} has lost its content", resource.name));
                if (!external) continue;
                const AccessState& exit = resource.exit;
                if (is_image(id) && exit.layout != VK_IMAGE_LAYOUT_UNDEFINED &&
                    exit.layout != layout)
                    fail(fmt::format("{} is promised in another layout", resource.name));
                const bool promised = exit.queue_family != VK_QUEUE_FAMILY_IGNORED;
                const bool released = transfer.pending && transfer.to == exit.queue_family;
                if (promised && !released && (transfer.pending || atom.owner != exit.queue_family))
                    fail(fmt::format("{} is promised to another family", resource.name));
                if (!released && atom.touched)
                    add_operations(atom, id,
                        {now_, 0, expanded(exit.stages), expanded_access(exit.access), kNone,
                            true});
            }
        }
        for (ResourceId id = 0; id < atoms_.size(); ++id) {
            const std::uint32_t depth = declaration_.resources[id].history_depth;
            if (!rotates(id) || declaration_.resources[id].history_age) continue;
            for (ResourceId age = depth; age-- > 0;)
                std::swap(atoms_[id + age + 1], atoms_[id + age]);
        }
    }

    // ---- What was written down ------------------------------------------------------------------

    struct Doing {
        std::uint32_t order, queue;
        Flags stages, access;
        PassId pass;
        bool needs;
    };
    /// One operation for each stage.
    void add_operations(const Atom& atom, ResourceId id, const Doing& doing) {
        const bool writes = (doing.access & kWrites) != 0;
        for (Flags rest = doing.stages; rest; rest &= rest - 1) {
            Operation operation;
            operation.order = doing.order;
            operation.queue = doing.queue;
            operation.execution = execution_;
            operation.stage = rest & (~rest + 1);
            operation.access = doing.access & accesses_in(operation.stage);
            operation.writes = writes;
            operation.needs = doing.needs;
            operation.pass = doing.pass;
            operation.resource = id;
            write_down(atom, operation);
        }
    }
    void write_down(const Atom& atom, const Operation& operation) {
        if (!writes_down_) return;
        if (operations_.size() <= atom.location) operations_.resize(atom.location + 1);
        operations_[atom.location].push_back(operation);
    }

    bool names(const Sync& sync, std::uint32_t location) const {
        return sync.semaphore || std::find(sync.locations.begin(), sync.locations.end(),
                                     location) != sync.locations.end();
    }

    void compare() {
        check(syncs_.size() <= kMost, "the plan has too many barriers to compare all");
        // From each to all that it happens before: through a stage that is in both scopes. A signal
        // waits for all that was submitted before, barriers without a second scope included.
        reach_.assign(syncs_.size(), {});
        for (std::size_t x = syncs_.size(); x-- > 0;) {
            reach_[x].set(x);
            for (std::size_t y = x + 1; y < syncs_.size(); ++y)
                if (syncs_[x].order < syncs_[y].until &&
                    syncs_[x].queue_after == syncs_[y].queue_before &&
                    (syncs_[y].semaphore || (syncs_[x].second & syncs_[y].first)))
                    reach_[x] |= reach_[y];
        }
        for (const Acquire& acquire : acquires_)
            if (!reach_[acquire.release].test(acquire.sync))
                fail("an acquire does not wait for its release");
        for (std::uint32_t location = 0; location < operations_.size(); ++location)
            for (Operation& operation : operations_[location]) relate(operation, location);
        for (std::uint32_t location = 0; location < operations_.size(); ++location) {
            const auto& operations = operations_[location];
            for (std::size_t y = 0; y < operations.size(); ++y)
                for (std::size_t x = 0; x < y; ++x)
                    compare(operations[x], operations[y], location, true);
        }
        compare_shared();
    }

    void relate(Operation& operation, std::uint32_t location) {
        if (operation.sync != kNone) {
            operation.before = operation.available = reach_[operation.sync];
            operation.after.set(operation.sync);
            return;
        }
        const Flags written = operation.access & kWrites;
        for (std::size_t i = 0; i < syncs_.size(); ++i) {
            const Sync& sync = syncs_[i];
            if (sync.queue_before == operation.queue && operation.order < sync.until &&
                (sync.first & operation.stage)) {
                operation.before |= reach_[i];
                if ((sync.src & operation.stage) && (written & ~sync.src_access) == 0 &&
                    names(sync, location)) {
                    operation.available |= reach_[i];
                }
            }
            if (sync.queue_after == operation.queue && sync.order < operation.order &&
                (sync.second & operation.stage))
                operation.after.set(i);
        }
    }

    /// "Location-ordered" of https://docs.vulkan.org/spec/latest/appendices/memorymodel.html
    void compare(const Operation& x, const Operation& y, std::uint32_t location, bool same) {
        if (x.order == y.order || (!x.writes && !y.writes)) return;
        const bool passes =
            x.sync == kNone && y.sync == kNone && x.pass != kNone && y.pass != kNone;
        if (passes && x.execution == y.execution && !can_meet(x.pass, y.pass)) return;
        const auto complain = [&](const char* what) {
            fail(fmt::format("{} of {}: {} and {} (executions {} and {})", what,
                declaration_.resources[y.resource].name, name(x.pass), name(y.pass), x.execution,
                y.execution));
        };
        if (x.releases) return;
        if ((x.before & y.after).none()) return complain("no order");
        if (!x.writes) return;
        const bool available = (x.available & y.after).any();
        if (!available && y.writes) return complain("not available");
        if (!same || !y.needs || y.sync != kNone) return;
        for (Flags rest = y.access & ~kWrites; rest; rest &= rest - 1) {
            bool visible = false;
            for (std::size_t i = 0; i < syncs_.size(); ++i)
                visible |= x.available.test(i) && y.after.test(i) && (syncs_[i].dst & y.stage) &&
                           (syncs_[i].dst_access & rest & (~rest + 1)) &&
                           names(syncs_[i], location);
            if (!visible) return complain("not visible");
        }
    }

    /// Operations through different resources on the same bytes.
    void compare_shared() {
        std::vector<std::vector<const Operation*>> by_resource(atoms_.size());
        for (const auto& operations : operations_)
            for (const Operation& operation : operations)
                by_resource[operation.resource].push_back(&operation);
        for (ResourceId a = 0; a < atoms_.size(); ++a)
            for (ResourceId b = 0; b < atoms_.size(); ++b) {
                if (!overlap(a, b)) continue;
                for (const Operation* y : by_resource[b]) {
                    bool before = false, after = false;
                    for (const Operation* x : by_resource[a]) {
                        if (x->order < y->order) compare(*x, *y, 0, false);
                        before |= x->execution == y->execution && x->order <= y->order;
                        after |= x->execution == y->execution && x->order >= y->order;
                    }
                    if (before && after)
                        fail(fmt::format("{} is used while {} has its memory",
                            declaration_.resources[a].name, declaration_.resources[b].name));
                }
            }
    }

    struct Acquire {
        std::uint32_t release, sync; ///< of syncs_
    };

    const Declaration& declaration_;
    const Plan& plan_;
    const Capabilities& capabilities_;
    std::vector<Grid> grids_; ///< one per ring
    std::vector<const Placement*> placements_;
    std::vector<std::uint32_t> first_queues_;
    std::vector<std::vector<Atom>> atoms_; ///< per resource
    std::vector<std::uint32_t> begun_;     ///< per resource, the execution
    std::size_t answers_ = 0;              ///< one bit per condition
    bool writes_down_ = false;
    std::uint32_t now_ = 0, execution_ = 0, locations_ = 0;
    std::vector<std::vector<std::uint32_t>> signals_; ///< per queue, of this execution
    std::vector<std::uint32_t> last_signals_;         ///< per queue; 0: none
    std::vector<Sync> syncs_;
    std::vector<Acquire> acquires_;
    std::vector<std::vector<Operation>> operations_; ///< per location, in order
    std::vector<Set> reach_;
    std::string wrong_;
};

} // namespace ockham::reference
