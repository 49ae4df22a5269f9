// SPDX-License-Identifier: Apache-2.0
// Damages the plans of random graphs, one thing at a time. What is harmful by definition must be
// found each time: transitions that are missing or lead elsewhere, halves of ownership transfers,
// waits of acquires. Of the rest, the share that is found says how minimal plans are.
#include "framework/graph/verify.hpp"
#include "tests/framework/graph/random_declaration.hpp"

#include <gtest/gtest.h>

#include <map>

namespace ockham {
namespace {

constexpr std::uint64_t kGraphs = 1000;

struct Count {
    std::size_t tried = 0, found = 0;
};

class Mutations {
public:
    Mutations(std::uint64_t seed, const Declaration& declaration, const Plan& plan,
        const Capabilities& capabilities, std::map<std::string, Count>& counts)
        : seed_(seed), declaration_(declaration), plan_(plan), capabilities_(capabilities),
          counts_(counts) {}

    void run() {
        for (std::size_t i = 0; i < plan_.barriers.size(); ++i) mutate_barrier(i);
        for (std::size_t i = 0; i < plan_.waits.size(); ++i) mutate_wait(i);
    }

private:
    /// Whether verify() finds the damage that `change` does to the element.
    template <class T, class Change>
    bool attempt(const char* what, std::vector<T> Plan::*list, std::size_t i, Change change) {
        Plan worse = plan_;
        change((worse.*list)[i]);
        if (worse == plan_) return true;
        const bool found = !verify(declaration_, worse, capabilities_).empty();
        Count& count = counts_[what];
        ++count.tried;
        count.found += found;
        return found;
    }

    template <class Change>
    void must_find(const char* what, std::size_t i, Change change) {
        EXPECT_TRUE(attempt(what, &Plan::barriers, i, change))
            << "seed " << seed_ << ": " << what << ", barrier " << i;
    }

    template <class Flags, class Barrier>
    void drop_each(const char* what, std::size_t i, Flags Barrier::*flags) {
        for (Flags rest = plan_.barriers[i].*flags; rest; rest &= rest - 1)
            attempt(
                what, &Plan::barriers, i, [&](Barrier& b) { b.*flags &= ~(rest & (~rest + 1)); });
    }

    static void remove(Barrier& b) {
        b.src_stages = b.dst_stages = b.src_access = b.dst_access = 0;
        b.new_layout = b.old_layout;
        b.src_family = b.dst_family = VK_QUEUE_FAMILY_IGNORED;
    }

    void mutate_barrier(std::size_t i) {
        const Barrier& barrier = plan_.barriers[i];
        const bool transfer = barrier.src_family != barrier.dst_family;
        const bool image = declaration_.resources[barrier.resource].kind == ResourceKind::image;
        const bool transition = image && barrier.old_layout != barrier.new_layout;
        if (transition || transfer)
            must_find("transition or transfer removed", i, remove);
        else
            attempt("other barrier removed", &Plan::barriers, i, remove);
        if (transition) {
            must_find("other new layout", i,
                [](Barrier& b) { b.new_layout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL; });
            if (barrier.old_layout != VK_IMAGE_LAYOUT_UNDEFINED)
                must_find("other old layout", i,
                    [](Barrier& b) { b.old_layout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL; });
        }
        if (transfer)
            must_find("other family", i, [](Barrier& b) { std::swap(b.src_family, b.dst_family); });
        drop_each("source stage dropped", i, &Barrier::src_stages);
        drop_each("destination stage dropped", i, &Barrier::dst_stages);
        drop_each("source access dropped", i, &Barrier::src_access);
        drop_each("destination access dropped", i, &Barrier::dst_access);
        const Part& part = barrier.part;
        if (transition && part.mips > 1)
            must_find("part shrunk", i, [](Barrier& b) { --b.part.mips; });
        if (transition && part.layers > 1)
            must_find("part shrunk", i, [](Barrier& b) { --b.part.layers; });
        if (!image && part.bytes > 1)
            attempt("buffer part shrunk", &Plan::barriers, i, [](Barrier& b) { --b.part.bytes; });
    }

    void mutate_wait(std::size_t i) {
        attempt("wait for one submission less", &Plan::waits, i, [](Wait& wait) { --wait.value; });
        attempt("wait with one stage only", &Plan::waits, i,
            [](Wait& wait) { wait.stages = VK_PIPELINE_STAGE_2_HOST_BIT; });
    }

    std::uint64_t seed_;
    const Declaration& declaration_;
    const Plan& plan_;
    const Capabilities& capabilities_;
    std::map<std::string, Count>& counts_;
};

TEST(Mutations, HarmIsFound) {
    std::map<std::string, Count> counts;
    for (std::uint64_t seed = 0; seed < kGraphs; ++seed) {
        const RandomSetting setting(seed);
        RandomOptions options;
        options.max_passes = 12;
        const RandomDeclaration random(seed, options, setting.capabilities);
        const Plan plan = compile(random.declaration(), setting.capabilities, setting.policy);
        // Soundness of the undamaged is the fuzzer's to check.
        if (!verify(random.declaration(), plan, setting.capabilities).empty()) continue;
        Mutations(seed, random.declaration(), plan, setting.capabilities, counts).run();
        if (HasFailure()) break;
    }
    std::string text;
    for (const auto& [what, count] : counts)
        text +=
            fmt::format("mutations: {:<32} {:>7} of {:>7} found\n", what, count.found, count.tried);
    fmt::print("{}", text);
    EXPECT_GT(counts["transition or transfer removed"].tried, kGraphs);
    EXPECT_GT(counts["other barrier removed"].tried, kGraphs);
}

} // namespace
} // namespace ockham
