// SPDX-License-Identifier: Apache-2.0
// The part of verify() that executes the plan in mind, several times back to back. Per piece of a
// resource it keeps the layout, the owner, the last writes with whom they are visible to, and the
// reads since. Guarded passes may have happened or not: both are kept. Included by verify_*.cpp
// only.
#pragma once

#include "framework/graph/verify/verify_clocks.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace ockham::verifier {

using Kind = Violation::Kind;

inline constexpr std::uint32_t kNobody = VK_QUEUE_FAMILY_IGNORED;
/// Guard of what a former execution did: its answers are not known any more.
inline constexpr GuardId kMaybe = kNone - 1;

/// An access, or what a barrier does: a layout transition, an acquisition.
struct Event {
    enum class What : std::uint8_t { access, barrier, caller };
    What what = What::access;
    PassId pass = kNone;
    std::uint32_t execution = 0;
    Point at;
    Stages stages = 0; ///< of a barrier: its second scope
    Accesses accesses = 0;
    GuardId guard = kNone;
    /// Who comes after an access waits for all of its stages, after a barrier for any.
    bool any = false;
};

/// Of a write: it is available to whatever waits for this barrier.
struct Availability {
    Point at;
    Stages stages = 0;
};

struct Write : Event {
    std::vector<Availability> available;
    std::uint32_t queue = 0; ///< that `visible` speaks of
    std::array<Accesses, kStageCount> visible{};

    void add_visible(std::uint32_t on, Stages stages_of_barrier, Accesses accesses_of_barrier) {
        if (queue != on) visible = {};
        queue = on;
        each_bit(
            stages_of_barrier, [&](std::uint32_t stage) { visible[stage] |= accesses_of_barrier; });
    }
};

/// A release that no acquire has answered.
struct Transfer {
    bool pending = false;
    bool by_caller = false;
    std::uint32_t from = kNobody, to = kNobody;
    VkImageLayout old_layout = VK_IMAGE_LAYOUT_UNDEFINED, new_layout = VK_IMAGE_LAYOUT_UNDEFINED;
    Point at;
};

struct Piece {
    VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;
    std::uint32_t owner = kNobody;
    std::uint32_t taken = 0; ///< the execution, from 1, in which memory was surely taken over
    Point transition;        ///< the latest
    Transfer transfer;
    bool content = false;         ///< whatever was answered
    bool lost = false;            ///< content by a transition, and not surely replaced since
    std::vector<GuardId> writers; ///< that gave it content if they consented
    std::vector<Write> writes;
    std::vector<Event> reads;
};

/// Of resources in memory that others may use, too.
struct Tenant {
    const Placement* placement = nullptr;
    std::uint32_t begun = 0;       ///< the execution, from 1, in which it was last used
    ResourceId taken_by = kNone;   ///< since then
    std::vector<ResourceId> under; ///< from whom it took its bytes
};

/// One access to check: by a pass, or by the caller at the end.
struct Accessor {
    PassId pass = kNone;
    GuardId guard = kNone;
    std::uint32_t queue = 0;
    Meaning meaning;
};

class Execution {
public:
    Execution(const Declaration& declaration, const Plan& plan, const Capabilities& capabilities,
        const Grids& grids, Report& report);
    void run();

private:
    // ---- Text -----------------------------------------------------------------------------------

    /// "compute/storage_read+storage_write"
    static std::string at(Stages stages, Accesses accesses);
    std::string text_of(const Event& event) const;
    std::string text_of(const Accessor& accessor, ResourceId id, std::uint32_t piece) const;
    std::string text_of(const Barrier& barrier) const;
    /// Adds a violation about a piece; `text` is called only if it is new.
    template <class Text>
    void say(Kind kind, std::uint32_t piece, PassId earlier, PassId later, Text text) {
        Violation violation{kind, grids_.resource_of(piece), {}, earlier, later, {}};
        if (!report_.wants(violation)) return;
        violation.part = grids_.part_of(piece);
        violation.text = text();
        report_.add(std::move(violation));
    }

    // ---- What happens before what ---------------------------------------------------------------

    static bool has(const Row& row, Point point, Stages stages, bool any, std::uint32_t queue);
    /// Whether everything in the scope comes after the event.
    static bool covers(const Row& scope, std::uint32_t queue, const Event& event) {
        return has(scope, event.at, event.stages, event.any, queue);
    }
    static bool is_available(const Row& scope, std::uint32_t queue, const Write& write);
    /// The clocks of one stage as a scope: a barrier on the same queue that names the stage
    /// counts, an earlier access in the same stage does not.
    bool waits(std::uint32_t queue, std::uint32_t stage, const Event& event) const;
    bool is_available(std::uint32_t queue, std::uint32_t stage, const Write& write) const;
    bool can_meet(GuardId a, GuardId b) const {
        return a == kMaybe || b == kMaybe || !guards_.exclude(a, b);
    }

    // ---- Executions -----------------------------------------------------------------------------

    bool is_external(ResourceId id) const {
        return declaration_.resources[id].lifetime == Lifetime::external;
    }
    bool is_image(ResourceId id) const {
        return declaration_.resources[id].kind == ResourceKind::image;
    }
    std::span<Piece> pieces_of(ResourceId id) {
        return {pieces_.data() + grids_.first(id), grids_.count(id)};
    }
    std::uint32_t family_of(std::uint32_t queue) const { return plan_.queues[queue].family; }
    /// What every barrier must be, wherever it stands; the queue is known only when it executes.
    void check_barriers();
    /// Persistent resources are zero, in the state in which an execution leaves them.
    void prepare();
    /// Histories change places where all of their ages have memory.
    bool rotates(ResourceId id) const;
    /// The caller's resources come as promised; former answers are not known any more.
    void enter();
    void enter(ResourceId id, std::uint32_t queue);
    void submit(std::size_t index);
    void execute(const Step& step, std::uint32_t queue);

    // ---- Memory that resources share ------------------------------------------------------------

    /// Whose bytes the resource lies on: those that used them last. Buffers and images count as
    /// overlapping where they share a page of the granularity.
    std::vector<ResourceId> owners_below(ResourceId id) const;
    /// Transient content begins anew in each execution; other owners of the bytes lose them.
    void begin(ResourceId id, std::uint32_t piece, PassId pass);
    void occupy(const Placement& placement);

    // ---- Barriers -------------------------------------------------------------------------------

    void batch(std::uint32_t first, std::uint32_t count, std::uint32_t queue);
    void apply(const Barrier& barrier, std::uint32_t index, Point point, const Row& scope);
    /// Makes writes available and visible.
    static void pass_on(Piece& piece, const Scopes& scopes, Point point, const Row& scope);
    void expect_owner(const Barrier& barrier, std::uint32_t index, Point point, bool acquires);
    /// Waits for all that was done with the piece, and finds its writes available.
    void expect_done(const Barrier& barrier, const Scopes& scopes, const Piece& piece,
        std::uint32_t index, Point point, const Row& scope);
    void expect_layout(const Barrier& barrier, std::uint32_t index);
    void release(const Barrier& barrier, const Scopes& scopes, std::uint32_t index, Point point,
        const Row& scope);
    /// Layout transitions and acquisitions: all that was before is behind them.
    void transition(const Barrier& barrier, const Scopes& scopes, std::uint32_t index, Point point,
        const Row& scope, bool acquires);
    void acquire(const Barrier& barrier, std::uint32_t index, const Row& scope);

    // ---- Accesses -------------------------------------------------------------------------------

    void access(const Accessor& accessor, ResourceId id, std::uint32_t index, Point point);
    /// Content and ownership: both ask what is left of what was written before.
    void use_content(const Accessor& accessor, ResourceId id, std::uint32_t index);
    /// Reads wait for writes and see them; writes wait for reads, too.
    void expect_synchronized(
        const Accessor& accessor, const Piece& piece, ResourceId id, std::uint32_t index);
    /// Who had the memory before is done with it, and its writes cannot come late.
    void expect_gone(
        const Accessor& accessor, const Piece& below, ResourceId id, std::uint32_t index);
    static void add_read(Piece& piece, const Event& event);
    /// A write that may not happen hides only those that happen at most with it.
    void add_write(Piece& piece, const Event& event);

    // ---- The end --------------------------------------------------------------------------------

    void leave();
    /// A released image is in the new layout once the caller has acquired it.
    static VkImageLayout layout_left(const Piece& piece) {
        return piece.transfer.pending ? piece.transfer.new_layout : piece.layout;
    }
    /// What is kept is as the plan says, and whole.
    void check_left(ResourceId id);
    void hand_back(ResourceId id, const AccessState& exit);
    static bool is_untouched(const Piece& piece);

    /// Bytes of a heap and who used them last.
    struct Segment {
        std::uint64_t begin = 0, end = 0;
        ResourceId owner = kNone;
    };

    const Declaration& declaration_;
    const Plan& plan_;
    const Grids& grids_;
    Report& report_;
    Guards guards_;
    Clocks clocks_;
    std::vector<Piece> pieces_;
    std::vector<Tenant> tenants_;
    std::vector<std::uint32_t> first_queue_; ///< per resource; kNone: not used
    std::uint64_t granularity_;
    std::vector<std::vector<Segment>> heaps_; ///< sorted, disjoint
    std::vector<Stages> stages_;              ///< per queue
    std::vector<Meaning> meanings_;           ///< per use
    std::vector<Scopes> scopes_;              ///< per barrier
    std::vector<std::uint8_t> rotates_;       ///< per present age
    std::vector<Row> first_scopes_;           ///< of the present batch
    std::uint32_t execution_ = 0;
    PassId pass_ = kNone;                              ///< whose batch it is; kNone: the exit's
    std::vector<std::vector<Clocks::Signal>> signals_; ///< per queue, of this execution
    std::vector<Clocks::Signal> last_signals_;         ///< per queue, of the previous execution
    std::vector<bool> submitted_;
};

} // namespace ockham::verifier
