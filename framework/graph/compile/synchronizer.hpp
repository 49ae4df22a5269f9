// SPDX-License-Identifier: Apache-2.0
// The walk behind synchronize(): how each piece of a resource was left, step by step, and drafts of
// the barriers that the next use needs. Spread over synchronize*.cpp, which alone include it.
#pragma once

#include "framework/graph/compile/arrivals.hpp"
#include "framework/graph/compile/drafts.hpp"
#include "framework/graph/compile/owners.hpp"
#include "framework/graph/compile/phases.hpp"

#include <vector>

namespace ockham::sync {

inline constexpr VkAccessFlags2 kWriteAccess =
    VK_ACCESS_2_SHADER_WRITE_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT |
    VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT |
    VK_ACCESS_2_TRANSFER_WRITE_BIT | VK_ACCESS_2_HOST_WRITE_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;

/// What the walk asks about a resource, in one byte.
enum : std::uint8_t {
    kImage = 1,
    kTransient = 2,
    kExternal = 4,
    kPersistent = 8,
    kConcurrent = 16,
    kExported = 32,
    kMet = 64, ///< external, and used before in this execution
};

/// How a piece was left. Its content dates from a write, or from the layout transition that let
/// readers in.
struct Tail {
    VkPipelineStageFlags2 stages = 0; ///< that made the content; of a transition: that wait for it
    VkAccessFlags2 written = 0;       ///< by which accesses; 0 for transitions
    /// Where else it is visible than through `barrier`.
    VkPipelineStageFlags2 seen_stages = 0;
    VkAccessFlags2 seen_access = 0;
    AccessState used; ///< by the write, or by all reads since
    Time when = 0;    ///< of the content
    /// The barrier that let the first readers in; a read in another stage extends it. kNone if
    /// there was none in this execution.
    std::uint32_t barrier = kNone;
    std::uint32_t reads = kNone; ///< since then: the newest
    PassId pass = kNone;         ///< the last that used it, in this execution
    std::uint32_t step = kNone;  ///< its step,
    std::uint32_t submission = 0;
    std::uint32_t family = VK_QUEUE_FAMILY_IGNORED; ///< that owns it; IGNORED: whoever comes
    std::uint8_t queue = 0, barrier_queue = 0, last_queue = 0;
    bool flushed = true;  ///< what was written is available
    bool started = false; ///< used in this execution
    bool known = false;   ///< used in any

    VkAccessFlags2 unavailable() const { return flushed ? 0 : written; }
};

/// Uses since the content was made, newest first, one for each run of equal stages.
struct Read {
    Past past;
    std::uint32_t before = kNone;
};

/// The next use of a piece, or its exit.
struct Next {
    AccessState state;
    PassId pass = kNone;
    std::uint32_t step = 0;
    std::uint32_t submission = 0;
    std::uint32_t queue = 0;
    bool written = false;
    bool needs = false;    ///< content before it
    bool discards = false; ///< all content before it, in every execution
};

inline bool contains(std::uint64_t set, std::uint64_t subset) { return (subset & ~set) == 0; }

class Synchronizer {
public:
    Synchronizer(const Declaration& declaration, const Pieces& pieces,
        const Capabilities& capabilities, const Policy& policy, Plan& plan)
        : declaration_(declaration), pieces_(pieces), policy_(policy), plan_(plan), arrivals_(plan),
          tails_(pieces.count()), flags_(declaration.resources.size()) {
        for (const PlanQueue& queue : plan.queues)
            queues_.push_back(capabilities.families.empty() ? QueueFamily{}
                                                            : capabilities.families[queue.family]);
    }

    void run() {
        plan_.barriers.reserve(2 * plan_.steps.size());
        drafts_.reserve(2 * plan_.steps.size());
        begin();
        settle_kept();
        walk(0);
        leave(0);
        set_final_states();
        hand_memory_over();
        finish();
    }

private:
    // ---- What is there before the execution (synchronize_entry.cpp)

    void begin();
    static Tail entry_of(const ResourceDecl& resource, std::uint8_t flags);
    /// The caller hands a resource over as a whole, where the first of its pieces is used.
    void meet_rest(ResourceId id, const Next& next);
    /// What the caller did is waited for where the piece is first used. For stages that this queue
    /// does not have, the caller has waited.
    void meet_caller(Tail& tail, const Next& next) const;
    /// How one execution leaves persistent resources is how the next finds them; of a history, the
    /// next age does. Found by executing them, without effect, until it is settled.
    void settle_kept();
    void turn();
    /// Whose state the resource has on entry.
    ResourceId source_of(ResourceId id) const;
    /// The same tail, seen from the next execution.
    Tail before(Tail tail, std::vector<Read>& reads) const;

    // ---- The walk (synchronize.cpp)

    /// Over uses of resources with all of these flags.
    void walk(std::uint8_t which);
    void set_use(Next& next, const Use& use, bool always) const;
    void touch(PieceId piece, ResourceId id, const Next& next);
    std::uint32_t family_of(std::uint32_t queue) const {
        return plan_.queues.empty() ? 0 : plan_.queues[queue].family;
    }
    /// Whether the content is visible to what `next` reads.
    bool sees(const Tail& tail, const Next& next, bool arrived) const;
    static bool has_stages(VkPipelineStageFlags2 mask, VkPipelineStageFlags2 stages) {
        return mask & VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT || contains(mask, stages);
    }
    void leave_tail(Tail& tail, const Next& next, std::uint32_t barrier);
    void add_read(Tail& tail, const Next& next);
    void settle(Tail& tail, const Next& next) const;

    // ---- Drafts (synchronize_drafts.cpp)

    struct Relation {
        bool changes = false; ///< the layout
        bool seen = false;    ///< the content, by what reads it next
        bool arrived = false; ///< by a semaphore
    };

    /// What must be waited for before the piece may be used otherwise: the reads, unless there are
    /// none the content too, or where it is not available. Without what the submission has seen
    /// completed.
    VkPipelineStageFlags2 add_pasts(const Tail& tail, std::uint32_t submission, std::uint32_t queue,
        bool content, Time shift = 0, std::uint32_t write = kNone);
    /// Drafts what orders `next` behind the tail; kNone if there is nothing to wait for.
    std::uint32_t draft(
        PieceId piece, ResourceId id, const Tail& tail, const Next& next, Relation relation);
    /// A stage behind the semaphores that the submission waited for.
    VkPipelineStageFlags2 after_waits(const Next& next) const;
    static Hazard hazard_of(const Tail& tail, const Next& next);
    Barrier barrier_to(ResourceId id, const Tail& tail, const Next& next) const;
    std::uint32_t add(const Barrier& barrier, const Draft& draft);
    /// The first use of what has no content yet. Whose memory it takes over is known at the end.
    void begin_anew(PieceId piece, ResourceId id, Tail& tail, const Next& next);
    /// Gets the piece, content included, from the queue family that owns it.
    void take_over(PieceId piece, ResourceId id, Tail& tail, const Next& next);
    /// Gives it up behind the last step that used it.
    void release(
        PieceId piece, ResourceId id, const Tail& tail, const Next& next, std::uint32_t family);

    // ---- The end of the execution (synchronize_exit.cpp)

    /// External resources go into the state that was promised; kept images whose pieces are in
    /// several layouts into one.
    void leave(std::uint8_t which);
    Next at_exit(const AccessState& state) const;
    void exit(ResourceId id);
    /// To the caller's queue family, who does the other half.
    void give_back(
        PieceId piece, ResourceId id, Tail& tail, const Next& next, std::uint32_t family);
    /// Into the exit layout, behind the last step that used it.
    void settle_there(PieceId piece, ResourceId id, const Tail& tail, const Next& next);
    /// Of the pieces that this execution uses; UNDEFINED if it uses none.
    VkImageLayout most_common_layout(ResourceId id) const;
    /// All pieces into one layout, so that the resource as a whole has one.
    void unify(ResourceId id);
    void set_final_states();

    /// Moves, merges and prunes the drafts; what is left becomes the plan's barriers.
    void finish(); // synchronize.cpp

    // ---- Memory handed over (synchronize_entry.cpp)

    struct First {
        std::uint32_t draft = kNone;
        std::uint32_t submission = 0, queue = 0;
    };

    /// First uses wait for those who used the memory before.
    void hand_memory_over();
    void take_memory(const Owner& owner, const First& first, Barrier& barrier, Draft& draft);

    const Declaration& declaration_;
    const Pieces& pieces_;
    const Policy& policy_;
    Plan& plan_;
    const Arrivals arrivals_;
    std::vector<QueueFamily> queues_; ///< per queue of the plan
    std::vector<Tail> tails_;         ///< per piece, as the walk has left it so far
    std::vector<std::uint8_t> flags_; ///< per resource
    std::vector<Read> reads_;
    std::vector<Draft> drafts_; ///< one per element of Plan::barriers
    std::vector<Past> pasts_;
    std::vector<First> firsts_;
    std::uint32_t rounds_ = 0; ///< until histories are settled; 0: nothing is persistent
    std::uint32_t submission_ = 0;
    bool has_releases_ = false;
};

} // namespace ockham::sync
