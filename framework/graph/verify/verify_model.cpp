// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/verify/verify_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <span>

namespace ockham::verifier {

namespace {

// Indices of stages, in an order in which no stage is logically earlier than one before it.
enum : std::uint32_t {
    kIndirect,
    kIndexInput,
    kVertexInput,
    kVertex,
    kEarlyTests,
    kFragment,
    kLateTests,
    kColorOutput,
    kCompute,
    kTransfer,
    kHost,
    kOtherStage, ///< whatever plans do not use
};

constexpr Stages bit(std::uint32_t index) { return 1u << index; }

constexpr Stages kGraphics = bit(kIndirect) | bit(kIndexInput) | bit(kVertexInput) | bit(kVertex) |
                             bit(kEarlyTests) | bit(kFragment) | bit(kLateTests) |
                             bit(kColorOutput);
constexpr Stages kShaders = bit(kVertex) | bit(kFragment) | bit(kCompute);
constexpr Stages kDepthTests = bit(kEarlyTests) | bit(kLateTests);
constexpr Stages kCommands = kGraphics | bit(kCompute) | bit(kTransfer) | bit(kOtherStage);

struct StageRow {
    VkPipelineStageFlags2 flags;
    Stages stages;
};
constexpr StageRow kStages[] = {
    {VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT, bit(kIndirect)},
    {VK_PIPELINE_STAGE_2_INDEX_INPUT_BIT, bit(kIndexInput)},
    {VK_PIPELINE_STAGE_2_VERTEX_ATTRIBUTE_INPUT_BIT, bit(kVertexInput)},
    {VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT, bit(kVertex)},
    {VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT, bit(kEarlyTests)},
    {VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, bit(kFragment)},
    {VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT, bit(kLateTests)},
    {VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT, bit(kColorOutput)},
    {VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, bit(kCompute)},
    {VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, bit(kTransfer)},
    {VK_PIPELINE_STAGE_2_HOST_BIT, bit(kHost)},
    {VK_PIPELINE_STAGE_2_COPY_BIT | VK_PIPELINE_STAGE_2_BLIT_BIT | VK_PIPELINE_STAGE_2_RESOLVE_BIT |
            VK_PIPELINE_STAGE_2_CLEAR_BIT,
        bit(kTransfer)},
    {VK_PIPELINE_STAGE_2_VERTEX_INPUT_BIT, bit(kIndexInput) | bit(kVertexInput)},
    {VK_PIPELINE_STAGE_2_PRE_RASTERIZATION_SHADERS_BIT, bit(kVertex)},
    {VK_PIPELINE_STAGE_2_ALL_GRAPHICS_BIT, kGraphics},
    {VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, kCommands},
};

struct AccessRow {
    VkAccessFlags2 flag;
    Stages stages; ///< that can perform it
    bool writes;
};
/// One for each bit of Accesses.
constexpr AccessRow kAccesses[] = {
    {VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT, bit(kIndirect), false},
    {VK_ACCESS_2_INDEX_READ_BIT, bit(kIndexInput), false},
    {VK_ACCESS_2_VERTEX_ATTRIBUTE_READ_BIT, bit(kVertexInput), false},
    {VK_ACCESS_2_UNIFORM_READ_BIT, kShaders, false},
    {VK_ACCESS_2_SHADER_SAMPLED_READ_BIT, kShaders, false},
    {VK_ACCESS_2_SHADER_STORAGE_READ_BIT, kShaders, false},
    {VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT, kShaders, true},
    {VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT, bit(kColorOutput), false},
    {VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT, bit(kColorOutput), true},
    {VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT, kDepthTests, false},
    {VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT, kDepthTests, true},
    {VK_ACCESS_2_TRANSFER_READ_BIT, bit(kTransfer), false},
    {VK_ACCESS_2_TRANSFER_WRITE_BIT, bit(kTransfer), true},
    {VK_ACCESS_2_HOST_READ_BIT, bit(kHost), false},
    {VK_ACCESS_2_HOST_WRITE_BIT, bit(kHost), true},
};
constexpr Accesses kAllAccesses = (1u << std::size(kAccesses)) - 1;

constexpr Accesses all_that_write() {
    Accesses set = 0;
    for (std::size_t i = 0; i < std::size(kAccesses); ++i)
        if (kAccesses[i].writes) set |= 1u << i;
    return set;
}

/// Every stage with what is logically earlier than it: of the graphics pipeline the order above,
/// and the arguments of an indirect dispatch come before it.
constexpr std::array<Stages, kStageCount> earlier_stages() {
    std::array<Stages, kStageCount> sets{};
    for (std::uint32_t i = 0; i < kStageCount; ++i) sets[i] = bit(i);
    for (std::uint32_t i = kVertex; i <= kColorOutput; ++i)
        for (std::uint32_t k = 0; k < i; ++k) sets[i] |= bit(k);
    sets[kIndexInput] |= bit(kIndirect);
    sets[kVertexInput] |= bit(kIndirect) | bit(kIndexInput);
    sets[kCompute] |= bit(kIndirect);
    return sets;
}
constexpr std::array<Stages, kStageCount> kEarlier = earlier_stages();

constexpr std::array<Stages, kStageCount> later_stages() {
    std::array<Stages, kStageCount> sets{};
    for (std::uint32_t i = 0; i < kStageCount; ++i)
        for (std::uint32_t k = 0; k < kStageCount; ++k)
            if (kEarlier[k] & bit(i)) sets[i] |= bit(k);
    return sets;
}
constexpr std::array<Stages, kStageCount> kLater = later_stages();

Stages shader_stage(Stage stage) {
    constexpr std::array<Stages, 4> stages{bit(kCompute), bit(kVertex), bit(kFragment), 0};
    return stages[static_cast<std::size_t>(stage)];
}

/// From flags to what a use does, apart from what its load operation says.
Meaning meaning(VkPipelineStageFlags2 stages, VkAccessFlags2 access, VkImageLayout layout) {
    Meaning result;
    result.stages = stages_of(stages);
    result.accesses = accesses_of(access);
    result.writes = writes_of(result.accesses) != 0;
    result.layout = layout;
    return result;
}

Meaning attachment(const Use& use, Meaning result) {
    result.needs = use.load == LoadOp::load;
    result.replaces = !result.needs;
    return result;
}

} // namespace

Stages stages_of(VkPipelineStageFlags2 flags) {
    Stages stages = 0;
    for (const StageRow& row : kStages)
        if (flags & row.flags) {
            stages |= row.stages;
            flags &= ~row.flags;
        }
    // TOP_OF_PIPE and BOTTOM_OF_PIPE are no stages; what else is left is none that plans use.
    flags &= ~(VK_PIPELINE_STAGE_2_TOP_OF_PIPE_BIT | VK_PIPELINE_STAGE_2_BOTTOM_OF_PIPE_BIT);
    return flags ? stages | bit(kOtherStage) : stages;
}

Accesses accesses_of(VkAccessFlags2 flags) {
    constexpr VkAccessFlags2 shader_reads = VK_ACCESS_2_UNIFORM_READ_BIT |
                                            VK_ACCESS_2_SHADER_SAMPLED_READ_BIT |
                                            VK_ACCESS_2_SHADER_STORAGE_READ_BIT;
    if (flags & VK_ACCESS_2_SHADER_READ_BIT) flags |= shader_reads;
    if (flags & VK_ACCESS_2_SHADER_WRITE_BIT) flags |= VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT;
    Accesses accesses = 0;
    for (std::size_t i = 0; i < std::size(kAccesses); ++i)
        if (flags & kAccesses[i].flag) accesses |= 1u << i;
    if (flags & VK_ACCESS_2_MEMORY_READ_BIT) accesses |= kAllAccesses & ~all_that_write();
    if (flags & VK_ACCESS_2_MEMORY_WRITE_BIT) accesses |= all_that_write();
    return accesses;
}

Accesses writes_of(Accesses accesses) {
    constexpr Accesses writes = all_that_write();
    return accesses & writes;
}

VkPipelineStageFlags2 flags_of(Stages stages) {
    VkPipelineStageFlags2 flags = 0;
    each_bit(
        stages & ~bit(kOtherStage), [&](std::uint32_t index) { flags |= kStages[index].flags; });
    return flags;
}

VkAccessFlags2 access_flags_of(Accesses accesses) {
    VkAccessFlags2 flags = 0;
    each_bit(accesses, [&](std::uint32_t index) { flags |= kAccesses[index].flag; });
    return flags;
}

Stages with_earlier(Stages stages) {
    Stages set = 0;
    each_bit(stages, [&](std::uint32_t index) { set |= kEarlier[index]; });
    return set;
}

Stages with_later(Stages stages) {
    Stages set = 0;
    each_bit(stages, [&](std::uint32_t index) { set |= kLater[index]; });
    return set;
}

Accesses possible_in(Stages stages) {
    Accesses set = 0;
    for (std::size_t i = 0; i < std::size(kAccesses); ++i)
        if (kAccesses[i].stages & stages) set |= 1u << i;
    return set;
}

Stages stages_on(const QueueFamily& family) {
    Stages stages = bit(kTransfer) | bit(kHost); // graphics and compute families copy, too
    if (family.graphics) stages |= kGraphics;
    if (family.compute) stages |= bit(kCompute) | bit(kIndirect);
    return stages;
}

Meaning meaning_of(const Use& use, ResourceKind kind) {
    const bool image = kind == ResourceKind::image;
    const Stages shader = shader_stage(use.stage);
    const VkPipelineStageFlags2 stage = flags_of(shader);
    const auto usage = [&](VkImageUsageFlags of_image, VkBufferUsageFlags of_buffer) {
        return image ? of_image : of_buffer;
    };
    const VkImageLayout general = image ? VK_IMAGE_LAYOUT_GENERAL : VK_IMAGE_LAYOUT_UNDEFINED;
    Meaning m;
    switch (use.access) {
    case Access::sampled:
        m = meaning(
            stage, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
        m.needs = true;
        m.usage = VK_IMAGE_USAGE_SAMPLED_BIT;
        break;
    case Access::storage_read:
        m = meaning(stage, VK_ACCESS_2_SHADER_STORAGE_READ_BIT, general);
        m.needs = true;
        m.usage = usage(VK_IMAGE_USAGE_STORAGE_BIT, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
        break;
    case Access::storage_write:
        m = meaning(stage, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT, general);
        m.replaces = true;
        m.usage = usage(VK_IMAGE_USAGE_STORAGE_BIT, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
        break;
    case Access::storage_read_write:
        m = meaning(stage,
            VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT, general);
        m.needs = true;
        m.usage = usage(VK_IMAGE_USAGE_STORAGE_BIT, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
        break;
    case Access::uniform:
        m = meaning(stage, VK_ACCESS_2_UNIFORM_READ_BIT, VK_IMAGE_LAYOUT_UNDEFINED);
        m.needs = true;
        m.usage = VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT;
        break;
    case Access::indirect:
        m = meaning(VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT, VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT,
            VK_IMAGE_LAYOUT_UNDEFINED);
        m.needs = true;
        m.usage = VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT;
        break;
    case Access::vertex:
        m = meaning(VK_PIPELINE_STAGE_2_VERTEX_ATTRIBUTE_INPUT_BIT,
            VK_ACCESS_2_VERTEX_ATTRIBUTE_READ_BIT, VK_IMAGE_LAYOUT_UNDEFINED);
        m.needs = true;
        m.usage = VK_BUFFER_USAGE_VERTEX_BUFFER_BIT;
        break;
    case Access::index:
        m = meaning(VK_PIPELINE_STAGE_2_INDEX_INPUT_BIT, VK_ACCESS_2_INDEX_READ_BIT,
            VK_IMAGE_LAYOUT_UNDEFINED);
        m.needs = true;
        m.usage = VK_BUFFER_USAGE_INDEX_BUFFER_BIT;
        break;
    case Access::color_attachment:
        m = attachment(
            use, meaning(VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
                     VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT,
                     VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL));
        m.usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
        break;
    case Access::depth_attachment:
        m = attachment(use, meaning(VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT |
                                        VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT,
                                VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT |
                                    VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT,
                                VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL));
        m.usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
        break;
    case Access::transfer_read:
        m = meaning(VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_READ_BIT,
            VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
        m.needs = true;
        m.usage = usage(VK_IMAGE_USAGE_TRANSFER_SRC_BIT, VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
        break;
    case Access::transfer_write: // may be partial, so it neither needs nor replaces
        m = meaning(VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
            VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
        m.usage = usage(VK_IMAGE_USAGE_TRANSFER_DST_BIT, VK_BUFFER_USAGE_TRANSFER_DST_BIT);
        break;
    case Access::host_read:
        m = meaning(
            VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT, VK_IMAGE_LAYOUT_GENERAL);
        m.needs = true;
        break;
    }
    return m;
}

bool is_inside(const ResourceDecl& resource, const Part& part) {
    if (resource.kind == ResourceKind::buffer)
        return part.bytes > 0 && part.offset < resource.buffer.bytes &&
               part.bytes <= resource.buffer.bytes - part.offset;
    const ImageDesc& image = resource.image;
    return part.mips > 0 && part.layers > 0 && part.first_mip < image.mips &&
           part.mips <= image.mips - part.first_mip && part.first_layer < image.layers &&
           part.layers <= image.layers - part.first_layer;
}

namespace {

Part resolved(const ResourceDecl& resource, Part part) {
    if (part.bytes == kRest) part.bytes = resource.buffer.bytes - part.offset;
    if (part.mips == kRestOfMips) part.mips = resource.image.mips - part.first_mip;
    if (part.layers == kRestOfLayers) part.layers = resource.image.layers - part.first_layer;
    return part;
}

struct Interval {
    std::uint64_t begin = 0, end = 1;
};
Interval columns_of(const ResourceDecl& resource, const Part& part) {
    if (resource.kind == ResourceKind::buffer) return {part.offset, part.offset + part.bytes};
    return {part.first_mip, std::uint64_t{part.first_mip} + part.mips};
}
Interval rows_of(const ResourceDecl& resource, const Part& part) {
    if (resource.kind == ResourceKind::buffer) return {};
    return {part.first_layer, std::uint64_t{part.first_layer} + part.layers};
}

bool is_whole(const ResourceDecl& resource, const Part& part) {
    const Part whole = resolved(resource, {});
    const Interval columns = columns_of(resource, part), all_columns = columns_of(resource, whole);
    const Interval rows = rows_of(resource, part), all_rows = rows_of(resource, whole);
    return columns.begin == 0 && columns.end == all_columns.end && rows.begin == 0 &&
           rows.end == all_rows.end;
}

} // namespace

Part part_of_use(const Declaration& declaration, const Use& use) {
    return resolved(declaration.resources[use.resource],
        use.part == kNone ? Part{} : declaration.parts[use.part]);
}

Grids::Grids(const Declaration& declaration, const Plan& plan)
    : declaration_(declaration), grids_(declaration.resources.size()),
      uses_(declaration.uses.size()), barriers_(plan.barriers.size()) {
    // Where to cut: resource (of a history the present one), axis, position.
    struct Cut {
        ResourceId resource;
        bool row;
        std::uint64_t at;
        auto operator<=>(const Cut&) const = default;
    };
    std::vector<Cut> cuts;
    const auto cut_at = [&](ResourceId id, const Part& part) {
        const ResourceDecl& resource = declaration.resources[id];
        if (!is_inside(resource, part) || is_whole(resource, part)) return;
        const ResourceId first = id - resource.history_age;
        for (const Part& one : {part, resolved(resource, {})}) {
            const Interval columns = columns_of(resource, one), rows = rows_of(resource, one);
            cuts.insert(cuts.end(), {{first, false, columns.begin}, {first, false, columns.end},
                                        {first, true, rows.begin}, {first, true, rows.end}});
        }
    };
    for (const Use& use : declaration.uses)
        if (use.part != kNone) cut_at(use.resource, part_of_use(declaration, use));
    for (const Barrier& barrier : plan.barriers) cut_at(barrier.resource, barrier.part);
    std::sort(cuts.begin(), cuts.end());
    cuts.erase(std::unique(cuts.begin(), cuts.end()), cuts.end());

    std::size_t next = 0;
    for (ResourceId id = 0; id < grids_.size(); ++id) {
        Grid& grid = grids_[id];
        if (const std::uint32_t age = declaration.resources[id].history_age) {
            grid = grids_[id - age];
        } else if (next < cuts.size() && cuts[next].resource == id) {
            grid.cut = static_cast<std::uint32_t>(cuts_.size());
            std::uint32_t counts[2] = {0, 0};
            for (; next < cuts.size() && cuts[next].resource == id; ++next) {
                ++counts[cuts[next].row];
                cuts_.push_back(cuts[next].at);
            }
            grid.columns = counts[0] - 1;
            grid.rows = counts[1] - 1;
        }
        grid.first = pieces_;
        pieces_ += grid.columns * grid.rows;
        resources_.resize(pieces_, id);
    }
    for (std::size_t i = 0; i < uses_.size(); ++i)
        uses_[i] =
            cells_of(declaration.uses[i].resource, part_of_use(declaration, declaration.uses[i]));
    for (std::size_t i = 0; i < barriers_.size(); ++i)
        barriers_[i] = cells_of(plan.barriers[i].resource, plan.barriers[i].part);
}

Cells Grids::cells_of(ResourceId id, const Part& part) const {
    const ResourceDecl& resource = declaration_.resources[id];
    const Grid& grid = grids_[id];
    if (!is_inside(resource, part)) return {0, 0, 0, 0};
    if (grid.cut == kNone) return {};
    const auto index = [](std::span<const std::uint64_t> cuts, std::uint64_t at) {
        return static_cast<std::uint32_t>(
            std::lower_bound(cuts.begin(), cuts.end(), at) - cuts.begin());
    };
    const std::span columns(cuts_.data() + grid.cut, grid.columns + 1);
    const std::span rows(columns.data() + columns.size(), grid.rows + 1);
    const Interval c = columns_of(resource, part), r = rows_of(resource, part);
    return {
        index(columns, c.begin), index(columns, c.end), index(rows, r.begin), index(rows, r.end)};
}

Part Grids::part_of(std::uint32_t piece) const {
    const ResourceId id = resources_[piece];
    const ResourceDecl& resource = declaration_.resources[id];
    const Grid& grid = grids_[id];
    Part part = resolved(resource, {});
    if (grid.cut == kNone) return part;
    const std::uint32_t cell = piece - grid.first;
    const std::uint64_t* const columns = cuts_.data() + grid.cut + cell % grid.columns;
    const std::uint64_t* const rows =
        cuts_.data() + grid.cut + grid.columns + 1 + cell / grid.columns;
    if (resource.kind == ResourceKind::buffer) {
        part.offset = columns[0];
        part.bytes = columns[1] - columns[0];
    } else {
        part.first_mip = static_cast<std::uint32_t>(columns[0]);
        part.mips = static_cast<std::uint32_t>(columns[1] - columns[0]);
        part.first_layer = static_cast<std::uint32_t>(rows[0]);
        part.layers = static_cast<std::uint32_t>(rows[1] - rows[0]);
    }
    return part;
}

Guards::Guards(const Declaration& declaration) {
    literals_.reserve(declaration.guards.size());
    for (const Guard& guard : declaration.guards) { // parents come first
        Literals chain = guard.parent == kNone ? Literals{} : literals_[guard.parent];
        chain.push_back(2 * guard.condition + guard.wanted);
        std::sort(chain.begin(), chain.end());
        chain.erase(std::unique(chain.begin(), chain.end()), chain.end());
        literals_.push_back(std::move(chain));
    }
}

bool Guards::contradict(const Literals& a, const Literals& b) {
    return std::any_of(a.begin(), a.end(),
        [&](std::uint32_t literal) { return std::binary_search(b.begin(), b.end(), literal ^ 1); });
}

bool Guards::exclude(GuardId a, GuardId b) const {
    return a != kNone && b != kNone && contradict(literals_[a], literals_[b]);
}

bool Guards::implies(GuardId a, GuardId b) const {
    const Literals &from = literals(a), &to = literals(b);
    return contradict(from, from) || std::includes(from.begin(), from.end(), to.begin(), to.end());
}

bool Guards::cover(const std::vector<GuardId>& writers, GuardId reader) const {
    return cover(writers, literals(reader));
}

bool Guards::cover(const std::vector<GuardId>& writers, const Literals& known) const {
    if (contradict(known, known)) return true;
    for (const GuardId writer : writers) {
        const Literals& wanted = literals(writer);
        if (std::includes(known.begin(), known.end(), wanted.begin(), wanted.end())) return true;
    }
    // Ask the first question that a writer still possible depends on, and try both answers.
    for (const GuardId writer : writers) {
        const Literals& wanted = literals(writer);
        if (contradict(wanted, known)) continue;
        const auto open = std::find_if(wanted.begin(), wanted.end(), [&](std::uint32_t literal) {
            return !std::binary_search(known.begin(), known.end(), literal);
        });
        for (const std::uint32_t answer : {*open, *open ^ 1}) {
            Literals more = known;
            more.insert(std::upper_bound(more.begin(), more.end(), answer), answer);
            if (!cover(writers, more)) return false;
        }
        return true;
    }
    return false;
}

bool Report::wants(const Violation& violation) const {
    constexpr std::size_t most = 64;
    if (out_.size() >= most) return false;
    return std::none_of(out_.begin(), out_.end(), [&](const Violation& other) {
        return other.kind == violation.kind && other.resource == violation.resource &&
               other.earlier == violation.earlier && other.later == violation.later;
    });
}

std::string Report::pass(PassId id, const char* otherwise) const {
    return id < declaration_.passes.size() ? fmt::format("'{}'", declaration_.passes[id].name)
                                           : otherwise;
}

std::string Report::resource(ResourceId id) const {
    return id < declaration_.resources.size() ? fmt::format("'{}'", declaration_.resources[id].name)
                                              : fmt::format("resource {}", id);
}

std::string Report::resource(ResourceId id, const Part& part) const {
    const ResourceDecl& decl = declaration_.resources[id];
    if (is_whole(decl, part)) return resource(id);
    if (decl.kind == ResourceKind::buffer)
        return fmt::format(
            "bytes {}-{} of {}", part.offset, part.offset + part.bytes - 1, resource(id));
    const auto range = [](const char* what, std::uint32_t first, std::uint32_t count) {
        return count == 1 ? fmt::format("{} {}", what, first)
                          : fmt::format("{}s {}-{}", what, first, first + count - 1);
    };
    std::string text;
    if (part.first_mip != 0 || part.mips != decl.image.mips)
        text = range("mip", part.first_mip, part.mips);
    if (part.first_layer != 0 || part.layers != decl.image.layers)
        text += (text.empty() ? "" : ", ") + range("layer", part.first_layer, part.layers);
    return fmt::format("{} of {}", text, resource(id));
}

} // namespace ockham::verifier
