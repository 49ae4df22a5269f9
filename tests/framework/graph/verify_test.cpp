// SPDX-License-Identifier: Apache-2.0
// The verifier on plans written by hand, whose verdict is the Vulkan specification's: right ones,
// and each with one thing wrong. compile() has no part in it.
#include "framework/graph/verify.hpp"
#include "tests/framework/graph/plan_lines.hpp"

#include <gtest/gtest.h>

namespace ockham {
namespace {

using Kind = Violation::Kind;

constexpr VkPipelineStageFlags2 kCompute = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT;
constexpr VkPipelineStageFlags2 kTransfer = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT;
constexpr VkPipelineStageFlags2 kFragment = VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT;
constexpr VkPipelineStageFlags2 kAll = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
constexpr VkAccessFlags2 kRead = VK_ACCESS_2_SHADER_STORAGE_READ_BIT;
constexpr VkAccessFlags2 kWrite = VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT;
constexpr VkAccessFlags2 kSampled = VK_ACCESS_2_SHADER_SAMPLED_READ_BIT;
constexpr VkAccessFlags2 kCopyRead = VK_ACCESS_2_TRANSFER_READ_BIT;
constexpr VkAccessFlags2 kCopyWrite = VK_ACCESS_2_TRANSFER_WRITE_BIT;
constexpr VkImageLayout kUndefined = VK_IMAGE_LAYOUT_UNDEFINED;
constexpr VkImageLayout kGeneral = VK_IMAGE_LAYOUT_GENERAL;
constexpr VkImageLayout kReadOnly = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;

constexpr BufferDesc kBytes{1024};

/// A plan of one queue that executes all passes in order, each resource in memory of its own, and
/// has no barriers. Tests add those.
struct Draft {
    const Declaration* declaration;
    Plan plan;
    Capabilities capabilities;
    std::vector<std::vector<Barrier>> before, after; ///< per step
    std::vector<Barrier> exit;

    explicit Draft(const Graph& graph)
        : declaration(&graph.declaration()), before(declaration->passes.size()),
          after(declaration->passes.size()) {
        const std::size_t resources = declaration->resources.size();
        plan.queues = {{0, 0}};
        plan.submissions = {{}};
        plan.passes.resize(declaration->passes.size());
        plan.resources.resize(resources);
        plan.final_states.resize(resources);
        plan.usages.assign(resources, ~0u);
        plan.concurrent.assign(resources, 0);
        for (PassId id = 0; id < declaration->passes.size(); ++id)
            plan.steps.push_back({.pass = id});
        plan.submissions[0].step_count = static_cast<std::uint32_t>(plan.steps.size());
        for (ResourceId id = 0; id < resources; ++id) place(id);
    }

    void place(ResourceId id) {
        if (declaration->resources[id].lifetime == Lifetime::external) return;
        const std::uint64_t bytes = estimate_memory(declaration->resources[id]).bytes;
        plan.placements.push_back(
            {id, static_cast<std::uint32_t>(plan.heaps.size()), 0, bytes, kNone, 0});
        for (std::uint32_t step = 0; step < plan.steps.size(); ++step)
            for (const Use& use : declaration->uses_of(plan.steps[step].pass)) {
                Placement& placement = plan.placements.back();
                if (use.resource != id) continue;
                placement.first_step = std::min(placement.first_step, step);
                placement.last_step = step;
            }
        plan.heaps.push_back({~0u, bytes, false});
    }

    /// Two transient resources in one heap, the second on the bytes of the first.
    void share(ResourceId first, ResourceId second) {
        plan.heaps = {{~0u, plan.heaps[first].bytes, true}};
        plan.placements[first].heap = plan.placements[second].heap = 0;
    }

    /// One submission per step, on the queues given, with the waits of each.
    void submit(std::vector<std::uint32_t> queues, std::vector<std::vector<Wait>> waits) {
        plan.submissions.clear();
        for (std::uint32_t step = 0; step < queues.size(); ++step) {
            plan.submissions.push_back(
                {queues[step], step, 1, static_cast<std::uint32_t>(plan.waits.size()),
                    static_cast<std::uint32_t>(waits[step].size())});
            plan.waits.insert(plan.waits.end(), waits[step].begin(), waits[step].end());
        }
    }

    std::vector<Violation> verdict() {
        Plan finished = plan;
        const auto put = [&](const std::vector<Barrier>& barriers, std::uint32_t& first,
                             std::uint32_t& count) {
            first = static_cast<std::uint32_t>(finished.barriers.size());
            count = static_cast<std::uint32_t>(barriers.size());
            finished.barriers.insert(finished.barriers.end(), barriers.begin(), barriers.end());
        };
        for (std::size_t i = 0; i < finished.steps.size(); ++i) {
            put(before[i], finished.steps[i].first_barrier, finished.steps[i].barrier_count);
            put(after[i], finished.steps[i].first_release, finished.steps[i].release_count);
        }
        put(exit, finished.first_exit_barrier, finished.exit_barrier_count);
        finished.bytes_peak = 0;
        for (const Heap& heap : finished.heaps) finished.bytes_peak += heap.bytes;
        return verify(*declaration, finished, capabilities);
    }
};

#define EXPECT_SOUND(draft) EXPECT_EQ(violations_text((draft).verdict()), "")

/// Says that of all violations, the first is of that kind, and what its text must contain.
void expect_first(Draft& draft, Kind kind, const std::string& words, int line) {
    const auto violations = draft.verdict();
    ASSERT_FALSE(violations.empty()) << "line " << line << ": nothing found";
    EXPECT_STREQ(name_of(violations[0].kind), name_of(kind))
        << "line " << line << ": " << violations[0].text;
    EXPECT_NE(violations[0].text.find(words), std::string::npos)
        << "line " << line << ": " << violations[0].text;
}
#define EXPECT_FIRST(draft, kind, words) expect_first(draft, kind, words, __LINE__)

Part whole(const Declaration& declaration, ResourceId id) {
    return part_of(declaration, Use{.resource = id});
}

/// Memory barrier on a whole resource.
Barrier barrier(const Graph& graph, ResourceId id, VkPipelineStageFlags2 src,
    VkAccessFlags2 src_access, VkPipelineStageFlags2 dst, VkAccessFlags2 dst_access,
    VkImageLayout from = kUndefined, VkImageLayout to = kUndefined) {
    Barrier b;
    b.resource = id;
    b.part = whole(graph.declaration(), id);
    b.src_stages = src;
    b.src_access = src_access;
    b.dst_stages = dst;
    b.dst_access = dst_access;
    b.old_layout = from;
    b.new_layout = to;
    return b;
}

/// 'make' writes a buffer, 'use' reads it; both on the compute stage.
class Buffers : public testing::Test {
protected:
    Buffers() {
        auto make = graph.add_compute_pass("make");
        data = make.write("d", graph.create_buffer("data", kBytes));
        auto use = graph.add_compute_pass("use");
        use.read("d", data);
        out = use.write("o", graph.create_buffer("out", kBytes));
        graph.export_resource(out, "wanted");
    }
    Barrier raw() const { return barrier(graph, 0, kCompute, kWrite, kCompute, kRead); }
    /// The next execution writes over what this one reads and wrote.
    Barrier again(ResourceId id) const {
        return barrier(graph, id, kCompute, kWrite, kCompute, kWrite);
    }
    Draft sound() const {
        Draft draft(graph);
        draft.before[0] = {again(0)};
        draft.before[1] = {raw(), again(1)};
        return draft;
    }
    Graph graph{"g"};
    BufferHandle data, out;
};

TEST_F(Buffers, ReadAfterWrite) {
    Draft draft = sound();
    EXPECT_SOUND(draft);
    draft.before[1] = {again(1)}; // orders execution, but another buffer's memory
    EXPECT_FIRST(draft, Kind::memory,
        "'use' reads 'data' at compute/storage_read, but nothing makes the write by 'make' at "
        "compute/storage_write visible to compute/storage_read");
    draft.before[1] = {};
    EXPECT_FIRST(draft, Kind::execution, "nothing makes its compute wait for the write by 'make'");
}

TEST_F(Buffers, ExecutionAloneMakesNothingVisible) {
    Draft draft = sound();
    draft.before[1][0].src_access = 0;
    EXPECT_FIRST(draft, Kind::memory, "visible");
    draft = sound();
    draft.before[1][0].dst_access = 0;
    EXPECT_FIRST(draft, Kind::memory, "visible");
    draft = sound();
    draft.before[1][0].dst_access = VK_ACCESS_2_UNIFORM_READ_BIT;
    EXPECT_FIRST(draft, Kind::memory, "visible to compute/storage_read");
}

TEST_F(Buffers, StagesMustMeet) {
    Draft draft = sound();
    draft.before[1] = {barrier(graph, 0, kTransfer, 0, kCompute, kRead), again(1)};
    EXPECT_FIRST(draft, Kind::memory, "visible"); // `again` orders the stages
    draft.before[1] = {barrier(graph, 0, kCompute, kWrite, kTransfer, kCopyRead)};
    EXPECT_FIRST(draft, Kind::execution, "wait for the write by 'make'");
}

TEST_F(Buffers, AccessesNeedAStageThatPerformsThem) {
    Draft draft = sound();
    draft.before[1][0].src_stages = kTransfer;
    EXPECT_FIRST(draft, Kind::malformed, "none of its stages performs");
}

TEST_F(Buffers, ChainsGoThroughStages) {
    Draft draft = sound();
    // make -> transfer in one batch, transfer -> use in the next: it chains.
    draft.before[0].push_back(barrier(graph, 1, kCompute, kWrite, kTransfer, kCopyRead));
    draft.after[0] = {barrier(graph, 0, kCompute, kWrite, kTransfer, kCopyRead)};
    draft.before[1] = {barrier(graph, 0, kTransfer, 0, kCompute, kRead), again(1)};
    EXPECT_SOUND(draft);
    // The same two in one batch do not.
    draft.after[0] = {};
    draft.before[1] = {barrier(graph, 0, kCompute, kWrite, kTransfer, kCopyRead),
        barrier(graph, 0, kTransfer, 0, kCompute, kRead)};
    EXPECT_FIRST(draft, Kind::execution, "wait for the write by 'make'");
    // Nor do they where the stages in the middle differ.
    draft.after[0] = {barrier(graph, 0, kCompute, kWrite, kFragment, kSampled)};
    draft.before[1] = {barrier(graph, 0, kTransfer, 0, kCompute, kRead)};
    EXPECT_FIRST(draft, Kind::execution, "wait for the write by 'make'");
}

TEST_F(Buffers, ThePreviousExecutionCounts) {
    Draft draft = sound();
    draft.before[0] = {};
    EXPECT_FIRST(draft, Kind::execution, "in the previous execution");
    draft = sound();
    draft.before[1].pop_back(); // ordered through the barrier on 'data', but not available
    EXPECT_FIRST(draft, Kind::memory, "available");
}

TEST_F(Buffers, PassesKeepTheirOrder) {
    Draft draft = sound();
    std::swap(draft.plan.steps[0].pass, draft.plan.steps[1].pass);
    EXPECT_FIRST(draft, Kind::order, "'use' comes before 'make'");
    draft = sound();
    draft.plan.steps[1].pass = 0;
    EXPECT_FIRST(draft, Kind::order, "executed twice");
}

TEST_F(Buffers, NeededPassesLive) {
    Draft draft = sound();
    draft.plan.passes[0].culled = draft.plan.passes[1].culled = true;
    draft.plan.steps.clear();
    draft.plan.submissions[0].step_count = 0;
    draft.plan.placements.clear();
    const auto violations = draft.verdict();
    ASSERT_EQ(violations.size(), 2u);
    EXPECT_EQ(violations[0].text, "'use' is culled, but what it writes to 'out' is needed");
    EXPECT_EQ(violations[1].text, "'make' is culled, but what it writes to 'data' is needed");
}

TEST_F(Buffers, MemoryIsThereAndFits) {
    Draft draft = sound();
    draft.plan.placements.pop_back();
    EXPECT_FIRST(draft, Kind::placement, "'use' uses 'out', which has no memory");
    draft = sound();
    draft.plan.heaps[0].bytes = 512;
    EXPECT_FIRST(draft, Kind::placement, "ends at byte 1024 of heap 0, which has 512");
    draft = sound();
    draft.plan.placements[0].bytes = 512;
    EXPECT_FIRST(draft, Kind::placement, "needs 1024 bytes and is given 512");
    draft = sound();
    draft.plan.heaps[0].bytes += 128;
    draft.plan.placements[0].offset = 128;
    EXPECT_FIRST(draft, Kind::placement, "no multiple of its alignment");
    draft = sound();
    draft.plan.placements[1].heap = 0;
    EXPECT_FIRST(draft, Kind::placement, "'data' and 'out' share heap 0");
    draft = sound();
    draft.plan.heaps[1].shared = true;
    EXPECT_FIRST(draft, Kind::placement, "'out' is kept beyond the execution");
    draft = sound();
    draft.plan.placements[0].last_step = 0;
    EXPECT_FIRST(draft, Kind::placement, "used in steps 0-1, but placed for 0-0");
    draft = sound();
    draft.plan.heaps[0].type_bits = 0;
    EXPECT_FIRST(draft, Kind::placement, "memory types");
}

TEST_F(Buffers, UsagesCoverTheUses) {
    Draft draft = sound();
    draft.plan.usages[0] = VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT;
    EXPECT_FIRST(draft, Kind::usage, "'make' uses 'data'");
}

TEST_F(Buffers, IndicesAreChecked) {
    Draft draft = sound();
    draft.plan.steps[1].pass = 7;
    EXPECT_FIRST(draft, Kind::malformed, "step 1");
    draft = sound();
    draft.before[1][0].resource = 9;
    EXPECT_FIRST(draft, Kind::malformed, "names resource 9 of 2");
    draft = sound();
    draft.before[1][0].part.offset = 1000;
    EXPECT_FIRST(draft, Kind::malformed, "not inside 'data'");
    draft = sound();
    draft.plan.waits = {{.queue = 3, .value = 1}};
    EXPECT_FIRST(draft, Kind::malformed, "wait 0");
}

TEST(VerifyBuffers, WriteAfterReadWaitsButNeedsNoMemory) {
    Graph graph("g");
    BufferHandle state = graph.create_persistent_buffer("state", kBytes);
    auto look = graph.add_compute_pass("look");
    look.read("s", state);
    graph.export_resource(look.write("o", graph.create_buffer("out", kBytes)), "wanted");
    auto change = graph.add_transfer_pass("change");
    state = change.copy_to(state);

    Draft draft(graph);
    draft.before[0] = {barrier(graph, 0, kTransfer, kCopyWrite, kCompute, kRead),
        barrier(graph, 1, kCompute, kWrite, kCompute, kWrite)};
    draft.before[1] = {barrier(graph, 0, kCompute, 0, kTransfer, 0)};
    EXPECT_SOUND(draft);
    draft.before[1] = {};
    EXPECT_FIRST(draft, Kind::execution, "nothing makes it wait for the read by 'look'");
    draft.before[1] = {barrier(graph, 0, kTransfer, 0, kTransfer, 0)};
    EXPECT_FIRST(draft, Kind::execution, "nothing makes it wait for the read by 'look'");
}

TEST(VerifyBuffers, PartsAreApart) {
    Graph graph("g");
    BufferHandle data = graph.create_persistent_buffer("data", kBytes);
    auto left = graph.add_compute_pass("left");
    data = left.write("d", data.range(0, 512));
    auto right = graph.add_compute_pass("right");
    right.read("d", data.range(512, 512)).side_effect("looks");
    auto both = graph.add_compute_pass("both");
    both.read("d", data).side_effect("looks");

    Draft draft(graph);
    Barrier half = barrier(graph, 0, kCompute, kWrite, kCompute, kRead);
    half.part.bytes = 512;
    Barrier again = half;
    again.src_access = again.dst_access = 0;
    draft.before[0] = {again};
    draft.before[2] = {half};
    EXPECT_SOUND(draft);
    draft.before[2][0].part.bytes = 256;
    EXPECT_FIRST(draft, Kind::memory, "'both' reads bytes 256-511 of 'data'");
}

TEST(VerifyBuffers, SharedBytesAreHandedOver) {
    Graph graph("g");
    const BufferHandle a = graph.create_buffer("a", kBytes), b = graph.create_buffer("b", kBytes);
    auto first = graph.add_compute_pass("first");
    (void)first.side_effect("s").write("d", a);
    auto second = graph.add_transfer_pass("second");
    (void)second.side_effect("s").copy_to(b);

    Draft draft(graph);
    draft.share(0, 1);
    Barrier back = barrier(graph, 0, kTransfer, kCopyWrite, kCompute, kWrite);
    Barrier over = barrier(graph, 1, kCompute, kWrite, kTransfer, kCopyWrite);
    back.hazard = over.hazard = Hazard::alias;
    draft.before[0] = {back};
    draft.before[1] = {over};
    EXPECT_SOUND(draft);
    // A barrier on 'b' alone does not reach what was written through 'a'.
    draft.before[1][0].hazard = Hazard::first_use;
    EXPECT_FIRST(draft, Kind::alias, "nothing makes it wait for the write by 'first'");
    draft.before[1] = {};
    EXPECT_FIRST(draft, Kind::alias, "'second' writes 'b'");
}

TEST(VerifyBuffers, BytesInUseAreNotTaken) {
    Graph graph("g");
    BufferHandle a = graph.create_buffer("a", kBytes);
    const BufferHandle b = graph.create_buffer("b", kBytes);
    auto first = graph.add_compute_pass("first");
    a = first.write("d", a);
    auto second = graph.add_compute_pass("second");
    (void)second.side_effect("s").write("d", b);
    auto third = graph.add_compute_pass("third");
    third.side_effect("s").read("d", a);

    Draft draft(graph);
    draft.share(0, 1);
    Barrier all = barrier(graph, 0, kCompute, kWrite, kCompute, kWrite | kRead);
    all.hazard = Hazard::alias;
    draft.before[0] = {all};
    draft.before[2] = {all};
    all.resource = 1;
    draft.before[1] = {all};
    EXPECT_FIRST(draft, Kind::alias, "'third' uses 'a', but 'b' has taken its memory");
}

TEST(VerifyBuffers, ContentComesFromSomewhere) {
    Graph graph("g");
    const BufferHandle a = graph.create_buffer("a", kBytes);
    auto look = graph.add_compute_pass("look");
    look.side_effect("s").read("d", a);
    Draft draft(graph);
    EXPECT_FIRST(draft, Kind::content, "nothing has written it");
}

// ---- Images -------------------------------------------------------------------------------------

/// 'draw' writes an image in GENERAL, 'look' samples it.
class Images : public testing::Test {
protected:
    Images() {
        auto draw = graph.add_compute_pass("draw");
        picture = draw.write("p", graph.create_image("picture", kColor));
        auto look = graph.add_compute_pass("look");
        look.side_effect("s").sample("p", picture);
    }
    Draft sound() const {
        Draft draft(graph);
        draft.before[0] = {barrier(graph, 0, kCompute, 0, kCompute, kWrite, kUndefined, kGeneral)};
        draft.before[1] = {
            barrier(graph, 0, kCompute, kWrite, kCompute, kSampled, kGeneral, kReadOnly)};
        return draft;
    }
    Graph graph{"g"};
    ImageHandle picture;
};

TEST_F(Images, LayoutsAndTransitions) {
    Draft draft = sound();
    EXPECT_SOUND(draft);
    draft.before[1][0].new_layout = kGeneral;
    EXPECT_FIRST(draft, Kind::layout, "expects layout read_only, but it is in general");
    draft = sound();
    draft.before[1][0].old_layout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
    EXPECT_FIRST(draft, Kind::layout, "expects layout transfer_src, but it is in general");
    draft = sound();
    draft.before[1][0].old_layout = kUndefined;
    EXPECT_FIRST(draft, Kind::content, "a transition from layout undefined has lost the content");
}

TEST_F(Images, TransitionsAreWrites) {
    Draft draft = sound();
    draft.before[1][0].src_access = 0; // the transition meets a write that is not available
    EXPECT_FIRST(draft, Kind::memory, "changes it before the write by 'draw'");
    draft = sound();
    draft.before[1][0].src_stages = kTransfer;
    draft.before[1][0].src_access = 0;
    EXPECT_FIRST(draft, Kind::execution, "does not wait for the write by 'draw'");
    draft = sound();
    draft.before[1][0].dst_access = 0; // what it wrote is not visible
    EXPECT_FIRST(draft, Kind::memory, "nothing makes the transition");
    draft = sound();
    draft.before[0][0].src_stages = 0; // the previous execution still samples
    EXPECT_FIRST(draft, Kind::execution,
        "for 'draw' changes it from undefined to general, but does not wait for the transition for "
        "'look' in the previous execution");
    draft = sound();
    draft.before[1].push_back(draft.before[1][0]);
    EXPECT_FIRST(draft, Kind::layout, "");
}

TEST(VerifyImages, MipsHaveLayoutsOfTheirOwn) {
    Graph graph("g");
    ImageHandle chain = graph.create_image("chain", {VK_FORMAT_R32_SFLOAT, 64, 64, 1, 1, 2});
    auto fill = graph.add_compute_pass("fill");
    chain = fill.write("p", chain.mip(0));
    auto shrink = graph.add_compute_pass("shrink");
    shrink.sample("from", chain.mip(0)).side_effect("s");
    chain = shrink.write("to", chain.mip(1));

    Draft draft(graph);
    const auto of_mip = [](Barrier b, std::uint32_t mip) {
        b.part.first_mip = mip;
        b.part.mips = 1;
        return b;
    };
    const Barrier begin =
        barrier(graph, 0, kCompute, kWrite, kCompute, kWrite, kUndefined, kGeneral);
    const Barrier shown =
        barrier(graph, 0, kCompute, kWrite, kCompute, kSampled, kGeneral, kReadOnly);
    draft.before[0] = {of_mip(begin, 0)};
    draft.before[1] = {of_mip(shown, 0), of_mip(begin, 1)};
    EXPECT_SOUND(draft);
    draft.before[1] = {of_mip(begin, 0), of_mip(begin, 1)};
    EXPECT_FIRST(draft, Kind::layout, "'shrink' reads mip 0 of 'chain'");
    draft.before[1] = {of_mip(shown, 0)};
    EXPECT_FIRST(draft, Kind::layout, "'shrink' writes mip 1 of 'chain'");
}

TEST(VerifyImages, LogicallyEarlierStagesAreWaitedFor) {
    // A vertex shader reads; whoever waits for colour output has waited for it, too, but nothing
    // that a vertex shader wrote is available by that.
    Graph graph("g");
    BufferHandle data = graph.create_persistent_buffer("data", kBytes);
    auto draw = graph.add_raster_pass("draw");
    draw.read("d", data, Stage::vertex);
    const ImageHandle target = draw.color(graph.create_image("target", kColor), LoadOp::clear);
    auto change = graph.add_compute_pass("change");
    change.sample("t", target);
    data = change.write("d", data);

    Draft draft(graph);
    constexpr auto output = VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT;
    constexpr auto color = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
    constexpr auto color_write = VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT;
    draft.before[0] = {
        barrier(graph, 0, kCompute, kWrite, VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT, kRead),
        barrier(graph, 1, kCompute, 0, output, color_write, kUndefined, color)};
    draft.before[1] = {
        barrier(graph, 1, output, color_write, kCompute, kSampled, color, kReadOnly)};
    EXPECT_SOUND(draft);
    draft.before[1][0].src_stages = VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT;
    draft.before[1][0].src_access = 0;
    EXPECT_FIRST(draft, Kind::execution, "does not wait for the write by 'draw'");
}

// ---- The caller ---------------------------------------------------------------------------------

class Imports : public testing::Test {
protected:
    void make(AccessState entry, AccessState exit) {
        auto change = graph.add_compute_pass("change");
        (void)change.read_write("p", graph.import_image("theirs", kColor, entry, exit));
    }
    Graph graph{"g"};
};

TEST_F(Imports, EntryAndExitAreKept) {
    make(
        state_of(Access::transfer_write, Stage::fixed), state_of(Access::sampled, Stage::fragment));
    Draft draft(graph);
    draft.before[0] = {barrier(graph, 0, kTransfer, kCopyWrite, kCompute, kRead | kWrite,
        VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, kGeneral)};
    draft.exit = {barrier(graph, 0, kCompute, kWrite, kFragment, kSampled, kGeneral, kReadOnly)};
    draft.plan.final_states[0].layout = kReadOnly;
    EXPECT_SOUND(draft);
    draft.exit[0].dst_access = 0;
    EXPECT_FIRST(draft, Kind::memory, "the caller reads 'theirs' at fragment/sampled_read");
    draft.exit.clear();
    EXPECT_FIRST(draft, Kind::layout, "left in layout general, but the plan says read_only");
    draft.before[0][0].src_access = 0;
    EXPECT_FIRST(draft, Kind::memory, "what the caller did at transfer/transfer_write");
    draft.before[0][0].old_layout = kUndefined;
    draft.before[0][0].src_access = kCopyWrite;
    EXPECT_FIRST(draft, Kind::content, "has lost the content");
}

TEST_F(Imports, FamiliesOfTheCallerGiveAndTake) {
    AccessState entry = state_of(Access::storage_write, Stage::compute), exit = entry;
    entry.queue_family = exit.queue_family = 1;
    make(entry, exit);
    Draft draft(graph);
    draft.capabilities.families = {{}, {false, true, true, 1}};
    Barrier take = barrier(graph, 0, kCompute, 0, kCompute, kRead | kWrite, kGeneral, kGeneral);
    take.hazard = Hazard::acquire;
    take.src_family = 1;
    take.dst_family = 0;
    Barrier give = barrier(graph, 0, kCompute, kWrite, 0, 0, kGeneral, kGeneral);
    give.hazard = Hazard::release;
    give.src_family = 0;
    give.dst_family = 1;
    draft.before[0] = {take};
    draft.exit = {give};
    draft.plan.final_states[0].layout = kGeneral;
    EXPECT_SOUND(draft);
    draft.exit.clear();
    EXPECT_FIRST(draft, Kind::ownership, "promised to family 1, but not released to it");
    draft.before[0].clear();
    EXPECT_FIRST(draft, Kind::ownership, "being moved from family 1 to 0");
}

// ---- Queues -------------------------------------------------------------------------------------

/// 'make' on queue 0 writes what 'use' on queue 1 of another family reads.
class Queues : public testing::Test {
protected:
    void make(bool kept) {
        BufferHandle data = kept ? graph.create_persistent_buffer("data", kBytes)
                                 : graph.create_buffer("data", kBytes);
        auto make = graph.add_compute_pass("make");
        data = make.write("d", data);
        auto use = graph.add_compute_pass("use");
        use.side_effect("s").read("d", data);
    }
    Draft draft() const {
        Draft draft(graph);
        draft.capabilities.families = {{}, {false, true, true, 1}};
        draft.plan.queues = {{0, 0}, {1, 0}};
        draft.submit({0, 1}, {{}, {{0, 1, kAll}}});
        return draft;
    }
    Draft sound() const {
        Draft result = draft();
        Barrier give = barrier(graph, 0, kCompute, kWrite, 0, 0);
        give.hazard = Hazard::release;
        give.src_family = 0;
        give.dst_family = 1;
        Barrier take = barrier(graph, 0, kCompute, 0, kCompute, kRead);
        take.hazard = Hazard::acquire;
        take.src_family = 0;
        take.dst_family = 1;
        result.after[0] = {give};
        result.before[1] = {take};
        return result;
    }
    Graph graph{"g"};
};

TEST_F(Queues, OwnershipIsReleasedAndAcquired) {
    make(false);
    Draft d = sound();
    EXPECT_SOUND(d);
    d.after[0].clear();
    EXPECT_FIRST(d, Kind::ownership, "nothing has released it");
    d = sound();
    d.before[1].clear();
    EXPECT_FIRST(d, Kind::ownership, "'use' reads 'data'");
    d = draft();
    EXPECT_FIRST(d, Kind::ownership, "on family 1, but family 0 owns it");
    d = sound();
    d.after[0][0].src_access = 0;
    EXPECT_FIRST(d, Kind::memory, "before the write by 'make'");
    d = sound();
    d.before[1][0].dst_access = 0;
    EXPECT_FIRST(d, Kind::memory, "visible to compute/storage_read");
    d = sound();
    d.before[1][0].src_stages = 0; // does not chain with the wait
    EXPECT_FIRST(d, Kind::ownership, "does not wait for the release");
    d = sound();
    std::swap(d.before[1][0].src_family, d.before[1][0].dst_family);
    EXPECT_FIRST(d, Kind::ownership, "");
}

TEST_F(Queues, SemaphoresOrderQueues) {
    make(false);
    Draft d = sound();
    d.plan.submissions[1].wait_count = 0;
    EXPECT_FIRST(d, Kind::ownership, "does not wait for the release");
    d = sound();
    d.plan.waits[0].value = 2;
    EXPECT_FIRST(d, Kind::submission, "waits until queue 0 has completed 2 submissions");
    d = sound();
    d.plan.waits[0].stages = kTransfer;
    EXPECT_FIRST(d, Kind::ownership, "does not wait for the release");
    d = sound();
    d.plan.waits[0].stages = kCompute;
    EXPECT_SOUND(d);
    d = sound();
    std::swap(d.plan.submissions[0].queue, d.plan.submissions[1].queue);
    EXPECT_FALSE(d.verdict().empty());
}

TEST_F(Queues, ConcurrentResourcesStay) {
    make(true);
    Draft d = draft();
    d.plan.concurrent[0] = 1;
    EXPECT_SOUND(d); // the semaphores do it all, in both directions
    d.plan.submissions[1].wait_count = 0;
    EXPECT_FIRST(d, Kind::execution, "wait for the write by 'make'");
    d = sound();
    d.plan.concurrent[0] = 1;
    EXPECT_FIRST(d, Kind::ownership, "between families that all own it");
    d = draft();
    EXPECT_FIRST(d, Kind::ownership, "family 0 owns it");
}

TEST_F(Queues, FamiliesExecuteWhatTheyCan) {
    make(false);
    Draft d = sound();
    d.capabilities.families[1] = {false, false, true, 1};
    EXPECT_FIRST(d, Kind::submission, "'use' is on queue 1 of family 1, which cannot execute it");
    d = sound();
    d.plan.queues[1].index = 1;
    EXPECT_FIRST(d, Kind::submission, "queue 1 is number 1 of family 1, which has 1");
    d = sound();
    std::swap(d.plan.queues[0], d.plan.queues[1]);
    EXPECT_FIRST(d, Kind::submission, "lacks graphics");
    d = sound();
    d.before[1][0].src_stages |= kFragment;
    EXPECT_FIRST(d, Kind::malformed, "no stage fragment");
    d = sound();
    d.plan.submissions[1].first_step = 0;
    EXPECT_FIRST(d, Kind::submission, "begins with step 0, but step 1 comes next");
}

// ---- Histories and conditions -------------------------------------------------------------------

TEST(VerifyHistories, StatesGoRoundTheRing) {
    Graph graph("g");
    const auto ring = graph.create_history_image("ring", kColor, 1);
    auto blend = graph.add_compute_pass("blend");
    blend.sample("old", ring.previous[0]);
    (void)blend.write("new", ring.now);

    Draft draft(graph);
    draft.plan.final_states[0].layout = kGeneral;
    draft.plan.final_states[1].layout = kReadOnly;
    // What was written becomes the old, what was sampled is written next.
    draft.before[0] = {barrier(graph, 1, kCompute, kWrite, kCompute, kSampled, kGeneral, kReadOnly),
        barrier(graph, 0, kCompute, 0, kCompute, kWrite, kUndefined, kGeneral)};
    EXPECT_SOUND(draft);
    draft.before[0][0].old_layout = kReadOnly;
    EXPECT_FIRST(draft, Kind::layout, "expects layout read_only, but it is in general");
    draft.before[0][0].old_layout = kGeneral;
    draft.before[0][0].src_access = 0;
    EXPECT_FIRST(
        draft, Kind::memory, "the write by 'blend' at compute/storage_write in the previous");
    draft.before[0][0].src_access = kWrite;
    draft.before[0][1].src_stages = kTransfer;
    EXPECT_FIRST(draft, Kind::execution, "the transition for 'blend' in the previous execution");
}

TEST(VerifyHistories, OlderAgesNeedTheRing) {
    Graph graph("g");
    const auto ring = graph.create_history_buffer("ring", kBytes, 1);
    auto look = graph.add_compute_pass("look");
    look.side_effect("s").read("old", ring.previous[0]);
    Draft draft(graph);
    EXPECT_FALSE(draft.plan.placements.empty());
    draft.plan.placements.erase(draft.plan.placements.begin()); // the present age
    EXPECT_FIRST(draft, Kind::content, "not all ages of its history have memory");
}

TEST(VerifyConditions, SkippedWritesLoseNothing) {
    Graph graph("g");
    const Condition condition = graph.add_condition("c");
    ImageHandle picture = graph.create_persistent_image("picture", kColor);
    {
        const GuardScope scope = graph.when(condition);
        auto maybe = graph.add_compute_pass("maybe");
        picture = maybe.write("p", picture);
    }
    auto look = graph.add_compute_pass("look");
    look.side_effect("s").sample("p", picture);

    Draft draft(graph);
    draft.plan.final_states[0].layout = kReadOnly;
    draft.before[0] = {barrier(graph, 0, kCompute, 0, kCompute, kWrite, kReadOnly, kGeneral)};
    draft.before[1] = {
        barrier(graph, 0, kCompute, kWrite, kCompute, kSampled, kGeneral, kReadOnly)};
    EXPECT_SOUND(draft);
    draft.before[0][0].old_layout = kUndefined;
    EXPECT_FIRST(draft, Kind::content, "a transition from layout undefined has lost the content");
}

TEST(VerifyConditions, BranchesExcludeEachOther) {
    Graph graph("g");
    const Condition condition = graph.add_condition("c");
    BufferHandle data = graph.create_buffer("data", kBytes);
    {
        const GuardScope scope = graph.when(condition);
        data = graph.add_compute_pass("yes").write("d", data);
    }
    {
        const GuardScope scope = graph.unless(condition);
        data = graph.add_transfer_pass("no").copy_to(data);
    }
    auto look = graph.add_compute_pass("look");
    look.side_effect("s").read("d", data);

    Draft draft(graph);
    const Barrier from_both =
        barrier(graph, 0, kCompute | kTransfer, kWrite | kCopyWrite, kCompute, kRead);
    const Barrier again = barrier(graph, 0, kCompute | kTransfer, kWrite | kCopyWrite,
        kCompute | kTransfer, kWrite | kCopyWrite);
    draft.before[0] = {again}; // none between 'yes' and 'no'
    draft.before[2] = {from_both};
    EXPECT_SOUND(draft);
    draft.before[2][0].src_access = kWrite;
    EXPECT_FIRST(draft, Kind::memory, "the write by 'no'");
    draft.before[2][0] = from_both;
    draft.before[2][0].src_stages = kTransfer;
    draft.before[2][0].src_access = kCopyWrite;
    EXPECT_FIRST(draft, Kind::execution, "the write by 'yes'");
}

} // namespace
} // namespace ockham
