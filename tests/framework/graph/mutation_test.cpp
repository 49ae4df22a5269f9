// SPDX-License-Identifier: Apache-2.0
// Damages the plans of random graphs, one thing at a time: each barrier and wait is deleted,
// weakened or moved. What the definition calls harmful must be found by verify(), and nothing else.
// A barrier that may be deleted is one that the compiler need not have made; their share is
// printed.
#include "framework/graph/verify.hpp"
#include "tests/framework/graph/random_declaration.hpp"
#include "tests/reference/happens_before.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <map>

namespace ockham {
namespace {

constexpr std::uint64_t kGraphs = 1000;

struct Count {
    std::size_t tried = 0, harmful = 0, caught = 0;
};

struct Figures {
    std::size_t graphs = 0, unsound = 0;
    std::size_t barriers = 0, minimal = 0;
    std::map<std::string, Count> mutations;
    std::vector<std::string> deletable;
    std::vector<std::string> disagreements;
};

/// The barriers of a plan by batch, so that they can come and go: before and after each step, then
/// those of the exit.
class Batches {
public:
    explicit Batches(const Plan& plan) : plan_(plan) {
        for (const Step& step : plan.steps) {
            add(plan.barriers_before(step));
            add(plan.releases_after(step));
        }
        add(plan.exit_barriers());
    }

    std::size_t size() const { return batches_.size(); }
    std::vector<Barrier>& operator[](std::size_t i) { return batches_[i]; }

    Plan plan() const {
        Plan plan = plan_;
        plan.barriers.clear();
        for (std::size_t i = 0; i < batches_.size(); ++i) {
            const auto first = static_cast<std::uint32_t>(plan.barriers.size());
            const auto count = static_cast<std::uint32_t>(batches_[i].size());
            plan.barriers.insert(plan.barriers.end(), batches_[i].begin(), batches_[i].end());
            if (i + 1 == batches_.size()) {
                plan.first_exit_barrier = first;
                plan.exit_barrier_count = count;
            } else if (i % 2 == 0) {
                plan.steps[i / 2].first_barrier = first;
                plan.steps[i / 2].barrier_count = count;
            } else {
                plan.steps[i / 2].first_release = first;
                plan.steps[i / 2].release_count = count;
            }
        }
        return plan;
    }

    /// The batch of the same kind that the queue executes before or after that one; the same where
    /// there is none.
    std::size_t neighbour(std::size_t batch, bool later) const {
        const std::vector<std::uint32_t> queues = queues_of_steps();
        if (batch + 1 == size()) { // of the exit
            for (std::size_t step = queues.size(); !later && step-- > 0;)
                if (queues[step] == plan_.submissions.back().queue) return 2 * step;
            return batch;
        }
        const std::size_t step = batch / 2;
        for (std::size_t other = step; later ? ++other < queues.size() : other-- > 0;)
            if (queues[other] == queues[step]) return 2 * other + batch % 2;
        const bool exit = later && queues[step] == 0 && plan_.submissions.back().queue == 0;
        return exit ? size() - 1 : batch;
    }

private:
    void add(std::span<const Barrier> barriers) {
        batches_.emplace_back(barriers.begin(), barriers.end());
    }
    std::vector<std::uint32_t> queues_of_steps() const {
        std::vector<std::uint32_t> queues;
        for (const Submission& submission : plan_.submissions)
            queues.insert(queues.end(), submission.step_count, submission.queue);
        return queues;
    }

    const Plan& plan_;
    std::vector<std::vector<Barrier>> batches_;
};

class Mutations {
public:
    Mutations(std::uint64_t seed, const Declaration& declaration, const Plan& plan,
        const Capabilities& capabilities, Figures& figures)
        : seed_(seed), declaration_(declaration), plan_(plan), capabilities_(capabilities),
          figures_(figures) {}

    void run() {
        Batches batches(plan_);
        for (std::size_t batch = 0; batch < batches.size(); ++batch)
            for (std::size_t i = 0; i < batches[batch].size(); ++i) mutate_barrier(batch, i);
        for (std::size_t i = 0; i < plan_.waits.size(); ++i) mutate_wait(i);
    }

private:
    /// Whether it is harmful.
    bool attempt(const char* what, std::size_t where, const Plan& worse) {
        const std::string reason =
            reference::HappensBefore(declaration_, worse, capabilities_).find();
        const auto violations = verify(declaration_, worse, capabilities_);
        Count& count = figures_.mutations[what];
        ++count.tried;
        count.harmful += !reason.empty();
        count.caught += !reason.empty() && !violations.empty();
        if (reason.empty() != violations.empty())
            figures_.disagreements.push_back(fmt::format("seed {}, {} {}: by definition {}; {}",
                seed_, what, where, reason.empty() ? "sound" : reason,
                violations.empty() ? "verify() finds nothing\n" : violations_text(violations)));
        return !reason.empty();
    }

    template <class Change>
    bool change(const char* what, std::size_t batch, std::size_t i, Change change) {
        Batches batches(plan_);
        change(batches[batch][i]);
        return attempt(what, number_of(batch, i), batches.plan());
    }

    std::size_t number_of(std::size_t batch, std::size_t i) const {
        Batches batches(plan_);
        for (std::size_t k = 0; k < batch; ++k) i += batches[k].size();
        return i;
    }

    /// One bit after the other; accesses that no stage left performs go with the stage.
    template <class Flags>
    void drop_each(const char* what, std::size_t batch, std::size_t i, Flags Barrier::*flags) {
        Batches batches(plan_);
        for (Flags rest = batches[batch][i].*flags; rest; rest &= rest - 1)
            change(what, batch, i, [&](Barrier& b) {
                b.*flags &= ~(rest & (~rest + 1));
                if (!(b.src_stages & VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT))
                    b.src_access &= reference::accesses_in(b.src_stages);
                if (!(b.dst_stages & VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT))
                    b.dst_access &= reference::accesses_in(b.dst_stages);
            });
    }

    void mutate_barrier(std::size_t batch, std::size_t i) {
        const Barrier barrier = Batches(plan_)[batch][i];
        remove(batch, i);
        drop_each("source stage dropped", batch, i, &Barrier::src_stages);
        drop_each("destination stage dropped", batch, i, &Barrier::dst_stages);
        drop_each("source access dropped", batch, i, &Barrier::src_access);
        drop_each("destination access dropped", batch, i, &Barrier::dst_access);
        move("moved earlier", batch, i, false);
        move("moved later", batch, i, true);
        if (declaration_.resources[barrier.resource].kind == ResourceKind::image) {
            if (barrier.old_layout != VK_IMAGE_LAYOUT_UNDEFINED) {
                change("other old layout", batch, i,
                    [](Barrier& b) { b.old_layout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL; });
                change("old layout undefined", batch, i,
                    [](Barrier& b) { b.old_layout = VK_IMAGE_LAYOUT_UNDEFINED; });
            }
            change("other new layout", batch, i,
                [](Barrier& b) { b.new_layout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL; });
        }
        if (barrier.src_family != barrier.dst_family)
            change("families exchanged", batch, i,
                [](Barrier& b) { std::swap(b.src_family, b.dst_family); });
        if (barrier.part.mips > 1)
            change("part shrunk", batch, i, [](Barrier& b) { --b.part.mips; });
        if (barrier.part.layers > 1)
            change("part shrunk", batch, i, [](Barrier& b) { --b.part.layers; });
        if (declaration_.resources[barrier.resource].kind == ResourceKind::buffer &&
            barrier.part.bytes > 1)
            change("part shrunk", batch, i, [](Barrier& b) { b.part.bytes /= 2; });
    }

    void remove(std::size_t batch, std::size_t i) {
        Batches batches(plan_);
        batches[batch].erase(batches[batch].begin() + static_cast<std::ptrdiff_t>(i));
        const bool harmful = attempt("deleted", number_of(batch, i), batches.plan());
        ++figures_.barriers;
        figures_.minimal += harmful;
        if (harmful) return;
        const Barrier barrier = Batches(plan_)[batch][i];
        figures_.deletable.push_back(
            fmt::format("seed {}, barrier {}: {} of '{}'", seed_, number_of(batch, i),
                name_of(barrier.hazard), declaration_.resources[barrier.resource].name));
    }

    void move(const char* what, std::size_t batch, std::size_t i, bool later) {
        Batches batches(plan_);
        const std::size_t to = batches.neighbour(batch, later);
        if (to == batch) return;
        batches[to].push_back(batches[batch][i]);
        batches[batch].erase(batches[batch].begin() + static_cast<std::ptrdiff_t>(i));
        attempt(what, number_of(batch, i), batches.plan());
    }

    void mutate_wait(std::size_t i) {
        Plan worse = plan_;
        worse.waits.erase(worse.waits.begin() + static_cast<std::ptrdiff_t>(i));
        for (Submission& submission : worse.submissions)
            if (submission.first_wait > i)
                --submission.first_wait;
            else if (i < submission.first_wait + submission.wait_count)
                --submission.wait_count;
        attempt("wait deleted", i, worse);
        const auto change = [&](const char* what, auto how) {
            worse = plan_;
            how(worse.waits[i]);
            attempt(what, i, worse);
        };
        if (plan_.waits[i].value > 1)
            change("wait for one submission less", [](Wait& wait) { --wait.value; });
        change("wait of compute only",
            [](Wait& wait) { wait.stages = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT; });
        change("wait of copies only",
            [](Wait& wait) { wait.stages = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT; });
    }

    std::uint64_t seed_;
    const Declaration& declaration_;
    const Plan& plan_;
    const Capabilities& capabilities_;
    Figures& figures_;
};

std::string text_of(const Figures& figures) {
    Count all;
    std::string text;
    for (const auto& [what, count] : figures.mutations) {
        text += fmt::format("  {:<28} {:>7} tried, {:>7} harmful, {:>7} caught\n", what,
            count.tried, count.harmful, count.caught);
        all.tried += count.tried;
        all.harmful += count.harmful;
        all.caught += count.caught;
    }
    return fmt::format("mutations: {} graphs, {} mutations, {} harmful, {} caught; {} of {} "
                       "barriers ({:.2f} %) are minimal\n",
               figures.graphs, all.tried, all.harmful, all.caught, figures.minimal,
               figures.barriers,
               100.0 * static_cast<double>(figures.minimal) /
                   static_cast<double>(figures.barriers)) +
           text;
}

/// Prints them, and leaves them in the folder that OCKHAM_FIGURES names.
void publish(const Figures& figures) {
    const std::string text = text_of(figures);
    fmt::print("{}", text);
    const char* const folder = std::getenv("OCKHAM_FIGURES");
    if (!folder) return;
    std::FILE* const file = std::fopen(fmt::format("{}/mutation.txt", folder).c_str(), "w");
    ASSERT_TRUE(file) << folder << " cannot be written";
    fmt::print(file, "{}", text);
    std::fclose(file);
}

TEST(Mutations, HarmIsFoundAndNothingElse) {
    Figures figures;
    std::uint64_t first = 0, end = kGraphs;
    if (const char* const seed = std::getenv("OCKHAM_SEED")) {
        first = std::strtoull(seed, nullptr, 10);
        end = first + 1;
    }
    for (std::uint64_t seed = first; seed < end; ++seed) {
        const RandomSetting setting(seed);
        RandomOptions options;
        options.max_passes = 6;
        const RandomDeclaration random(seed, options, setting.capabilities);
        const Declaration& declaration = random.declaration();
        const Plan plan = compile(declaration, setting.capabilities, setting.policy);
        ++figures.graphs;
        const auto violations = verify(declaration, plan, setting.capabilities);
        const std::string reason =
            reference::HappensBefore(declaration, plan, setting.capabilities).find();
        if (!violations.empty() || !reason.empty()) {
            ++figures.unsound;
            fmt::print("seed {} is unsound undamaged: by definition {}; {}\n", seed,
                reason.empty() ? "sound" : reason, violations_text(violations));
            continue;
        }
        Mutations(seed, declaration, plan, setting.capabilities, figures).run();
    }
    publish(figures);
    for (std::size_t i = 0; i < std::min<std::size_t>(figures.deletable.size(), 20); ++i)
        fmt::print("deletable: {}\n", figures.deletable[i]);
    for (std::size_t i = 0; i < std::min<std::size_t>(figures.disagreements.size(), 60); ++i)
        ADD_FAILURE() << figures.disagreements[i];
    EXPECT_EQ(figures.disagreements.size(), 0u);
    // The rest is mostly what passes wait for whose guard contradicts itself.
    EXPECT_GE(figures.minimal * 1000, figures.barriers * 998);
    EXPECT_EQ(figures.unsound, 0u);
}

} // namespace
} // namespace ockham
