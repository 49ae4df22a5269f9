// SPDX-License-Identifier: Apache-2.0
// What verify() knows of Vulkan: its own table of accesses, the logical order of stages, which part
// of a resource lies where, which guards exclude each other. Included by verify*.cpp only.
#pragma once

#include "framework/graph/verify.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace ockham::verifier {

/// Sets of pipeline stages and of accesses, one bit each, so that clocks are small matrices. The
/// kinds of copies count as one stage.
using Stages = std::uint32_t;
using Accesses = std::uint32_t;
inline constexpr std::uint32_t kStageCount = 12;

Stages stages_of(VkPipelineStageFlags2 flags); ///< those named; ALL_COMMANDS and the like expanded
Accesses accesses_of(VkAccessFlags2 flags);
Accesses writes_of(Accesses accesses); ///< those of them that write
VkPipelineStageFlags2 flags_of(Stages stages);
VkAccessFlags2 access_flags_of(Accesses accesses);
/// Execution scopes reach further than the stages that a barrier names: the first takes in what is
/// logically earlier in the pipeline, the second what is logically later. Memory scopes do not.
Stages with_earlier(Stages stages);
Stages with_later(Stages stages);
/// Accesses that some of the stages can perform.
Accesses possible_in(Stages stages);
/// Stages that exist on a queue of the family, the host's included.
Stages stages_on(const QueueFamily& family);

/// Calls visit(index) for each bit.
template <class Visit>
void each_bit(std::uint32_t bits, Visit visit) {
    for (; bits; bits &= bits - 1) visit(static_cast<std::uint32_t>(__builtin_ctz(bits)));
}

/// What a use does.
struct Meaning {
    Stages stages = 0;
    Accesses accesses = 0;
    bool writes = false;
    bool needs = false;    ///< content before it
    bool replaces = false; ///< all content before it
    VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;
    std::uint32_t usage = 0;
};
Meaning meaning_of(const Use& use, ResourceKind kind);

/// Cells of a grid, [first, end): columns are mips or bytes, rows are layers.
struct Cells {
    std::uint32_t first_column = 0, end_column = 1, first_row = 0, end_row = 1;
};

/// Resources cut where uses and barriers begin and end; the ages of a history alike, for they
/// change places.
class Grids {
public:
    /// Indices must be in range. Parts that are empty or leave their resource become no cells.
    Grids(const Declaration& declaration, const Plan& plan);

    std::uint32_t pieces() const { return pieces_; }
    std::uint32_t first(ResourceId id) const { return grids_[id].first; }
    std::uint32_t count(ResourceId id) const { return grids_[id].columns * grids_[id].rows; }
    const Cells& of_use(std::size_t use) const { return uses_[use]; }
    const Cells& of_barrier(std::size_t barrier) const { return barriers_[barrier]; }
    ResourceId resource_of(std::uint32_t piece) const { return resources_[piece]; }
    Part part_of(std::uint32_t piece) const;

    /// Calls visit(piece) for each cell.
    template <class Visit>
    void each(ResourceId id, const Cells& cells, Visit visit) const {
        const Grid& grid = grids_[id];
        for (std::uint32_t row = cells.first_row; row < cells.end_row; ++row)
            for (std::uint32_t column = cells.first_column; column < cells.end_column; ++column)
                visit(grid.first + row * grid.columns + column);
    }

private:
    struct Grid {
        std::uint32_t first = 0, columns = 1, rows = 1;
        std::uint32_t cut = kNone; ///< into cuts_: columns + 1, then rows + 1; kNone: uncut
    };
    Cells cells_of(ResourceId id, const Part& part) const;

    const Declaration& declaration_;
    std::uint32_t pieces_ = 0;
    std::vector<Grid> grids_;
    std::vector<std::uint64_t> cuts_;
    std::vector<Cells> uses_, barriers_;
    std::vector<ResourceId> resources_;
};

/// Whether the part lies inside the resource and is not empty; ends resolved.
bool is_inside(const ResourceDecl& resource, const Part& part);
/// A part that a use names, ends resolved.
Part part_of_use(const Declaration& declaration, const Use& use);

/// What is known when a guard has consented.
class Guards {
public:
    explicit Guards(const Declaration& declaration);
    bool exclude(GuardId a, GuardId b) const; ///< never both in one execution
    bool implies(GuardId a, GuardId b) const; ///< whenever a consents, b does
    /// Whenever `reader` consents, one of `writers` does.
    bool cover(const std::vector<GuardId>& writers, GuardId reader) const;

private:
    /// Sorted; 2 * condition + wanted.
    using Literals = std::vector<std::uint32_t>;
    static bool contradict(const Literals& a, const Literals& b);
    bool cover(const std::vector<GuardId>& writers, const Literals& known) const;
    const Literals& literals(GuardId guard) const {
        return guard == kNone ? none_ : literals_[guard];
    }
    Literals none_;
    std::vector<Literals> literals_;
};

/// Collects violations; says each once.
class Report {
public:
    Report(const Declaration& declaration, std::vector<Violation>& out)
        : declaration_(declaration), out_(out) {}
    /// False where the same was said before, or enough.
    bool wants(const Violation& violation) const;
    void add(Violation violation) { out_.push_back(std::move(violation)); }
    bool empty() const { return out_.empty(); }

    /// "'blur'"; `otherwise` for kNone
    std::string pass(PassId id, const char* otherwise = "the caller") const;
    /// "'color'", "mip 2 of 'color'", "mips 1-3, layer 0 of 'color'", "bytes 0-255 of 'list'"
    std::string resource(ResourceId id, const Part& part) const;
    std::string resource(ResourceId id) const;

private:
    const Declaration& declaration_;
    std::vector<Violation>& out_;
};

/// Parts of verify(). The first says whether the others may index by what the plan says.
bool check_shape(const Declaration&, const Plan&, const Capabilities&, Report&);
void check_submissions(const Declaration&, const Plan&, const Capabilities&, Report&);
void check_order(const Declaration&, const Plan&, const Grids&, Report&);
void check_culling(const Declaration&, const Plan&, const Grids&, Report&);
void check_placements(const Declaration&, const Plan&, Report&);
/// Executes the plan several times in mind, access by access.
void check_execution(const Declaration&, const Plan&, const Capabilities&, const Grids&, Report&);

} // namespace ockham::verifier
