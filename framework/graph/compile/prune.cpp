// SPDX-License-Identifier: Apache-2.0
// Which barriers order nothing new. Execution dependencies chain, so a barrier may be implied by
// others on other resources. A matrix of clocks per queue says exactly what is ordered so far:
// row t, column s: everything earlier than that, in stage s, comes before what follows in stage t.
#include "framework/graph/compile/drafts.hpp"
#include "framework/graph/compile/stage_sets.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>

namespace ockham {

namespace {

constexpr Time kNever = std::numeric_limits<Time>::min() / 2;

/// What is settled for one draft.
struct Choice {
    Stages src = 0, dst = 0;
    bool dead = false;
    bool flushes = false; ///< makes writes available

    bool operator==(const Choice&) const = default;
};

/// A write is available to whatever waits for a barrier.
struct Available {
    std::uint32_t write = kNone;
    Time at = 0;
    Stages to = 0; ///< that wait for it

    bool operator==(const Available&) const = default;
};

/// What one execution leaves for the next to rely on.
struct Knowledge {
    std::vector<Time> clocks;
    std::vector<Available> available;

    bool operator==(const Knowledge&) const = default;
    bool contains(const Available& one) const {
        return std::find(available.begin(), available.end(), one) != available.end();
    }
    /// At least what the other says.
    bool covers(const Knowledge& other) const {
        return std::equal(clocks.begin(), clocks.end(), other.clocks.begin(),
                   [](Time a, Time b) { return a >= b; }) &&
               std::all_of(other.available.begin(), other.available.end(),
                   [&](const Available& one) { return contains(one); });
    }
    void intersect(const Knowledge& other) {
        std::transform(clocks.begin(), clocks.end(), other.clocks.begin(), clocks.begin(),
            [](Time a, Time b) { return std::min(a, b); });
        std::erase_if(available, [&](const Available& one) { return !other.contains(one); });
    }
};

class Pruner {
public:
    Pruner(const Plan& plan, const std::vector<Draft>& drafts, const std::vector<Past>& pasts)
        : plan_(plan), drafts_(drafts), pasts_(pasts),
          queues_(std::max(static_cast<std::uint32_t>(plan.queues.size()), 1u)),
          width_(queues_ * kStageRow), period_(period_of(plan)) {
        given_.reserve(drafts.size());
        for (std::size_t i = 0; i < drafts.size(); ++i)
            given_.push_back(
                {stages_of(plan.barriers[i].src_stages), stages_of(plan.barriers[i].dst_stages),
                    drafts[i].dead, plan.barriers[i].src_access != 0});
        for (std::size_t i = drafts.size(); i-- > 0 && end_of_looking_back_ == 0;)
            if (looks_back(drafts[i])) end_of_looking_back_ = i + 1;
        std::uint32_t writes = 0;
        for (const Past& past : pasts)
            if (past.write != kNone) writes = std::max(writes, past.write + 1);
        newest_available_.resize(writes);
    }

    /// The choices for the plan executed again and again.
    std::vector<Choice> run() {
        const Knowledge nothing{std::vector<Time>(std::size_t{width_} * width_, kNever), {}};
        if (std::none_of(drafts_.begin(), drafts_.end(),
                [&](const Draft& draft) { return draft.light && looks_back(draft); })) {
            walk(nothing, false);
            return std::move(choices_);
        }
        // What the barriers of one execution leave for the next, they must not be removed by. Start
        // from what holds without any that could be removed so.
        Knowledge entry = walk(nothing, true);
        std::vector<Choice> best;
        for (int round = 0; round < 5; ++round) {
            Knowledge end = walk(entry, false);
            if (end.covers(entry)) {
                best.swap(choices_);
                if (end == entry) break;
                entry = std::move(end);
            } else if (best.empty()) {
                entry.intersect(end);
            } else {
                break;
            }
        }
        if (best.empty()) {
            walk(nothing, false);
            best.swap(choices_);
        }
        return best;
    }

private:
    struct Link {
        Available available;
        std::uint32_t before = kNone; ///< of the same write
    };

    Time* row(std::uint32_t queue, std::uint32_t stage) {
        return &clocks_[std::size_t{queue * kStageRow + stage} * width_];
    }
    /// The row as the batch leaves it, as far as is settled.
    Time* next_row(std::uint32_t stage) { return &next_[std::size_t{stage} * width_]; }
    const Time* newest(std::uint32_t stage) {
        return touched_ >> stage & 1 ? next_row(stage) : row(queue_, stage);
    }

    std::span<const Past> pasts_of(const Draft& draft) const {
        return {pasts_.data() + draft.first_past, draft.past_count};
    }
    bool looks_back(const Draft& draft) const {
        const auto pasts = pasts_of(draft);
        return std::any_of(
            pasts.begin(), pasts.end(), [](const Past& past) { return past.when < 0; });
    }

    /// One execution. Returns the clocks that it leaves for the next.
    Knowledge walk(const Knowledge& entry, bool without_looking_back) {
        clocks_ = entry.clocks;
        next_.resize(std::size_t{kStageRow} * width_);
        choices_ = given_;
        without_looking_back_ = without_looking_back;
        available_.clear();
        std::fill(newest_available_.begin(), newest_available_.end(), kNone);
        for (const Available& one : entry.available) add_available(one);
        std::vector<std::vector<std::uint32_t>> done(queues_);
        snapshots_.resize(plan_.submissions.size() * width_);
        std::size_t draft = 0;
        const auto steps = static_cast<std::uint32_t>(plan_.steps.size());
        if (queues_ == 1) {
            queue_ = 0;
            while (draft < end_of_looking_back_) draft = batch(draft);
            // From there on all depends on what was chosen up to here.
            if (!last_choices_.empty() &&
                std::equal(choices_.begin(), choices_.begin() + static_cast<std::ptrdiff_t>(draft),
                    last_choices_.begin())) {
                choices_ = last_choices_;
                return last_end_;
            }
            while (draft < drafts_.size()) draft = batch(draft);
        } else {
            for (std::uint32_t i = 0; i < plan_.submissions.size(); ++i) {
                const Submission& submission = plan_.submissions[i];
                queue_ = submission.queue;
                wait(submission, done);
                const bool last = i + 1 == plan_.submissions.size();
                const std::uint32_t end =
                    last ? steps + 1 : submission.first_step + submission.step_count;
                while (draft < drafts_.size() && drafts_[draft].step < end) draft = batch(draft);
                done[queue_].push_back(i);
                snapshot(i, submission.first_step + submission.step_count);
            }
        }
        last_choices_ = choices_;
        return last_end_ = leave(done);
    }

    void wait(const Submission& submission, const std::vector<std::vector<std::uint32_t>>& done) {
        for (std::uint32_t w = 0; w < submission.wait_count; ++w) {
            const Wait& wait = plan_.waits[submission.first_wait + w];
            const Time* const known = &snapshots_[done[wait.queue][wait.value - 1] * width_];
            each_stage(with(kLaterStages, stages_of(wait.stages)),
                [&](std::uint32_t stage) { join(row(submission.queue, stage), known); });
        }
    }

    /// What is known to have happened when the submission is complete.
    void snapshot(std::uint32_t submission, std::uint32_t end_step) {
        Time* const known = &snapshots_[submission * width_];
        std::fill(known, known + width_, kNever);
        for (std::uint32_t stage = 0; stage < kStageRow; ++stage) join(known, row(queue_, stage));
        Time* const own = known + queue_ * kStageRow;
        std::fill(own, own + kStageRow, time_of(end_step));
    }

    Knowledge leave(const std::vector<std::vector<std::uint32_t>>& done) {
        for (std::uint32_t q = 0; q < queues_; ++q)
            for (std::uint32_t other = 0; other < queues_; ++other) {
                if (other == q || done[other].empty()) continue;
                const Time* const known = &snapshots_[done[other].back() * width_];
                for (std::uint32_t stage = 0; stage <= kOtherStage; ++stage)
                    join(row(q, stage), known);
            }
        for (std::uint32_t q = 0; q < queues_; ++q)
            for (std::uint32_t stage = 0; stage < kStageRow; ++stage) {
                Time* const clocks = row(q, stage);
                for (std::uint32_t i = 0; i < width_; ++i) {
                    // What an execution does not order anew is not relied on.
                    clocks[i] = clocks[i] < 1 ? kNever : clocks[i] - period_;
                    if (i / kStageRow != q && stage <= kOtherStage) clocks[i] = 0;
                }
            }
        Knowledge knowledge{clocks_, {}};
        for (const Link& link : available_) {
            const bool before = link.available.write & 1;
            const std::uint32_t write = link.available.write + 1; // the same, in the next execution
            if (!before && write < newest_available_.size())
                knowledge.available.push_back(
                    {write, link.available.at - period_, link.available.to});
        }
        return knowledge;
    }

    void add_available(const Available& available) {
        available_.push_back({available, newest_available_[available.write]});
        newest_available_[available.write] = static_cast<std::uint32_t>(available_.size() - 1);
    }

    /// A row's worth at a time and without references, which compilers turn into vectors.
    void join(Time* __restrict a, const Time* __restrict b) const {
        for (const Time* const end = a + width_; a != end; a += kStageRow, b += kStageRow)
            for (std::uint32_t i = 0; i < kStageRow; ++i) a[i] = a[i] < b[i] ? b[i] : a[i];
    }

    /// Whether what the past did in stage `s` comes before everything that the row stands for.
    static bool after(const Time* row, const Past& past, std::uint32_t s) {
        return row[past.queue * kStageRow + s] > past.when;
    }
    /// The same once a barrier from `src` is put in.
    bool reaches(Stages src, const Past& past, std::uint32_t s) {
        bool found = past.queue == queue_ && (with(kEarlierStages, src) >> s & 1);
        each_stage(with(kEarlierStages, src),
            [&](std::uint32_t u) { found = found || after(row(queue_, u), past, s); });
        return found;
    }

    /// Whether the write, if it is one to make available, is so for what follows in stage `t`.
    bool is_available(const Past& past, std::uint32_t t) {
        if (past.write == kNone) return true;
        for (std::uint32_t i = newest_available_[past.write]; i != kNone;
             i = available_[i].before) {
            const Available& available = available_[i].available;
            bool found = available.to >> t & 1;
            each_stage(available.to, [&](std::uint32_t d) {
                found = found || newest(t)[queue_ * kStageRow + d] > available.at;
            });
            if (found) return true;
        }
        return false;
    }

    /// Calls visit(past, s, t) for each pair of stages of the draft that is not in order yet.
    template <class Visit>
    void each_open(std::size_t index, Visit visit) {
        for (const Past& past : pasts_of(drafts_[index]))
            each_stage(stages_of(past.stages), [&](std::uint32_t s) {
                each_stage(given_[index].dst, [&](std::uint32_t t) {
                    if (!after(newest(t), past, s) || !is_available(past, t)) visit(past, s, t);
                });
            });
    }

    /// Decides over the drafts before one step or at the exit; returns the first after them.
    std::size_t batch(std::size_t first) {
        const std::uint32_t step = drafts_[first].step;
        touched_ = 0;
        light_.clear();
        std::size_t end = first;
        for (; end < drafts_.size() && drafts_[end].step == step; ++end) {
            const Draft& draft = drafts_[end];
            if (draft.dead || draft.release) continue;
            if (draft.light) {
                light_.push_back(static_cast<std::uint32_t>(end));
            } else {
                narrow_src(end);
                apply(end, time_of(step));
            }
        }
        choose_light(time_of(step));
        each_stage(touched_, [&](std::uint32_t stage) {
            std::copy(next_row(stage), next_row(stage) + width_, row(queue_, stage));
        });
        return end;
    }

    /// Of barriers that order execution only: as few as do.
    void choose_light(Time now) {
        std::erase_if(light_, [&](std::uint32_t i) {
            bool open = false;
            if (!without_looking_back_ || !looks_back(drafts_[i]))
                each_open(i, [&](const Past&, std::uint32_t, std::uint32_t) { open = true; });
            choices_[i].dead = !open;
            return !open;
        });
        for (const std::uint32_t i : light_) narrow(i);
        if (light_.size() > 1) {
            const auto size = [&](std::uint32_t i) {
                return std::popcount(choices_[i].src) * std::popcount(choices_[i].dst);
            };
            std::stable_sort(light_.begin(), light_.end(),
                [&](std::uint32_t a, std::uint32_t b) { return size(a) < size(b); });
            for (const std::uint32_t i : light_) {
                choices_[i].dead = true;
                choices_[i].dead = std::all_of(light_.begin(), light_.end(),
                    [&](std::uint32_t k) { return !choices_[k].dead || implied_by_others(k); });
            }
        }
        for (const std::uint32_t i : light_)
            if (!choices_[i].dead) apply(i, now);
    }

    bool implied_by_others(std::uint32_t index) {
        const auto any = [&](std::uint32_t t, auto does) {
            return std::any_of(light_.begin(), light_.end(), [&](std::uint32_t i) {
                return i != index && !choices_[i].dead &&
                       (with(kLaterStages, choices_[i].dst) >> t & 1) && does(i);
            });
        };
        bool implied = true;
        each_open(index, [&](const Past& past, std::uint32_t s, std::uint32_t t) {
            const bool ordered = after(newest(t), past, s) || any(t, [&](std::uint32_t i) {
                return reaches(choices_[i].src, past, s);
            });
            const bool available = is_available(past, t) || any(t, [&](std::uint32_t i) {
                const auto pasts = pasts_of(drafts_[i]);
                return choices_[i].flushes &&
                       std::any_of(pasts.begin(), pasts.end(),
                           [&](const Past& other) { return other.write == past.write; });
            });
            implied = implied && ordered && available;
        });
        return implied;
    }

    /// Takes away what is ordered already, and stages through which others are reached anyway.
    void narrow(std::uint32_t index) {
        Choice& choice = choices_[index];
        if ((choice.src | choice.dst) >> kOtherStage & 1) return;
        Stages src = 0, dst = 0;
        bool flushes = false;
        each_open(index, [&](const Past& past, std::uint32_t s, std::uint32_t t) {
            src |= static_cast<Stages>(1u << s);
            dst |= static_cast<Stages>(1u << t);
            flushes = flushes || !is_available(past, t);
        });
        if (flushes) return;
        choice.flushes = false;
        choice.src = src;
        choice.dst = dst;
        each_stage(dst, [&](std::uint32_t t) {
            const auto rest = static_cast<Stages>(choice.dst & ~(1u << t));
            if (with(kLaterStages, rest) >> t & 1) choice.dst = rest;
        });
        narrow_src(index);
    }

    /// Waits for fewer stages where the rest stands for them.
    void narrow_src(std::size_t index) {
        Choice& choice = choices_[index];
        const auto pasts = pasts_of(drafts_[index]);
        if (std::has_single_bit(choice.src) || choice.flushes || pasts.empty() ||
            choice.src >> kOtherStage & 1)
            return;
        const Stages needed = choice.src;
        each_stage(needed, [&](std::uint32_t s) {
            const auto rest = static_cast<Stages>(choice.src & ~(1u << s));
            if (!rest) return;
            for (const Past& past : pasts) {
                bool reached = true;
                each_stage(static_cast<Stages>(stages_of(past.stages) & needed),
                    [&](std::uint32_t k) { reached = reached && reaches(rest, past, k); });
                if (!reached) return;
            }
            choice.src = rest;
        });
    }

    /// Puts a barrier into the batch.
    void apply(std::size_t index, Time now) {
        const Choice& choice = choices_[index];
        if (!choice.dst || !choice.src) return;
        if (choice.flushes)
            for (const Past& past : pasts_of(drafts_[index])) {
                if (past.write == kNone) continue;
                add_available({past.write, now, with(kLaterStages, choice.dst)});
            }
        std::array<Time, 8 * kStageRow> known;
        const Stages src = with(kEarlierStages, choice.src);
        const Time* const first = row(queue_, static_cast<std::uint32_t>(std::countr_zero(src)));
        std::copy(first, first + width_, known.begin());
        each_stage(src & (src - 1u), [&](std::uint32_t s) { join(known.data(), row(queue_, s)); });
        each_stage(src, [&](std::uint32_t s) { known[queue_ * kStageRow + s] = now; });
        each_stage(with(kLaterStages, choice.dst), [&](std::uint32_t t) {
            if (!(touched_ >> t & 1))
                std::copy(row(queue_, t), row(queue_, t) + width_, next_row(t));
            touched_ |= static_cast<Stages>(1u << t);
            join(next_row(t), known.data());
        });
    }

    const Plan& plan_;
    const std::vector<Draft>& drafts_;
    const std::vector<Past>& pasts_;
    const std::uint32_t queues_, width_;
    const Time period_;
    std::vector<Choice> given_, choices_, last_choices_;
    std::vector<Time> clocks_, next_, snapshots_;
    Knowledge last_end_;
    std::size_t end_of_looking_back_ = 0; ///< after the last draft that waits for the past
    std::vector<Link> available_;
    std::vector<std::uint32_t> newest_available_; ///< per write
    std::vector<std::uint32_t> light_;            ///< of the batch: those that order execution only
    Stages touched_ = 0;                          ///< rows that the batch changes
    std::uint32_t queue_ = 0;
    bool without_looking_back_ = false;
};

} // namespace

void prune(Plan& plan, std::vector<Draft>& drafts, const std::vector<Past>& pasts) {
    const std::vector<Choice> choices = Pruner(plan, drafts, pasts).run();
    for (std::size_t i = 0; i < drafts.size(); ++i) {
        drafts[i].dead = choices[i].dead;
        Barrier& barrier = plan.barriers[i];
        if (!choices[i].flushes && barrier.src_access) barrier.src_access = barrier.dst_access = 0;
        if (choices[i].src != stages_of(barrier.src_stages))
            barrier.src_stages = flags_of(choices[i].src);
        if (choices[i].dst != stages_of(barrier.dst_stages))
            barrier.dst_stages = flags_of(choices[i].dst);
    }
}

} // namespace ockham
