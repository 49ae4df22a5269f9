// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/compile/phases.hpp"

#include <algorithm>
#include <bit>
#include <limits>
#include <span>
#include <utility>

namespace ockham {

namespace {

/// Candidates that may exceed the memory limit before a batch is closed without looking at the
/// rest: keeps the whole in little more than n log n.
constexpr int kRefusals = 16;

/// What each step waits for. Steps are numbered in the declared order throughout this file.
class Dependences {
public:
    Dependences(const Declaration& declaration, const Pieces& pieces, const Plan& plan)
        : last_(pieces.count()) {
        begin_.reserve(plan.steps.size() + 1);
        begin_.push_back(0);
        for (std::uint32_t step = 0; step < plan.steps.size(); ++step) {
            const auto uses = declaration.uses_of(plan.steps[step].pass);
            for (const Use& use : uses)
                pieces.each(use, [&](PieceId piece) { add_edges(piece, use); });
            for (const Use& use : uses)
                pieces.each(use, [&](PieceId piece) { remember(step, piece, use); });
            begin_.push_back(static_cast<std::uint32_t>(before_.size()));
        }
    }
    /// Each is smaller than `step`; may repeat.
    std::span<const std::uint32_t> before(std::uint32_t step) const {
        return {before_.data() + begin_[step], begin_[step + 1] - begin_[step]};
    }

private:
    struct Last {
        std::uint32_t write = kNone;
        std::uint32_t reads = kNone; ///< since then: head of a list in reads_
    };
    struct Read {
        std::uint32_t step, next;
    };
    void add_edges(PieceId piece, const Use& use) {
        const Last& last = last_[piece];
        if (last.write != kNone) before_.push_back(last.write);
        if (!writes(use.access)) return;
        for (std::uint32_t read = last.reads; read != kNone; read = reads_[read].next)
            before_.push_back(reads_[read].step);
    }
    void remember(std::uint32_t step, PieceId piece, const Use& use) {
        Last& last = last_[piece];
        if (writes(use.access)) {
            last = {step, kNone};
        } else if (last.write != step) {
            reads_.push_back({step, last.reads});
            last.reads = static_cast<std::uint32_t>(reads_.size() - 1);
        }
    }

    std::vector<Last> last_; ///< per piece
    std::vector<Read> reads_;
    std::vector<std::uint32_t> begin_, before_;
};

/// Values at positions 0 ... count - 1: adds to ranges and finds the largest of a range, in
/// logarithmic time.
class Profile {
public:
    explicit Profile(const std::vector<std::int64_t>& values)
        : leaves_(std::bit_ceil(std::max<std::size_t>(values.size(), 1))),
          largest_(2 * leaves_, std::numeric_limits<std::int64_t>::min() / 4),
          added_(2 * leaves_, 0) {
        std::copy(
            values.begin(), values.end(), largest_.begin() + static_cast<std::ptrdiff_t>(leaves_));
        for (std::size_t node = leaves_; node-- > 1;)
            largest_[node] = std::max(largest_[2 * node], largest_[2 * node + 1]);
    }
    /// To all of [begin, end).
    void add(std::uint32_t begin, std::uint32_t end, std::int64_t value) {
        if (begin < end && value != 0) add(1, 0, leaves_, begin, end, value);
    }
    std::int64_t largest(std::uint32_t begin, std::uint32_t end) const {
        return largest(1, 0, leaves_, begin, end);
    }

private:
    void add(std::size_t node, std::size_t low, std::size_t high, std::size_t begin,
        std::size_t end, std::int64_t value) {
        if (end <= low || high <= begin) return;
        if (begin <= low && high <= end) {
            largest_[node] += value;
            added_[node] += value;
            return;
        }
        const std::size_t middle = (low + high) / 2;
        add(2 * node, low, middle, begin, end, value);
        add(2 * node + 1, middle, high, begin, end, value);
        largest_[node] = added_[node] + std::max(largest_[2 * node], largest_[2 * node + 1]);
    }
    std::int64_t largest(std::size_t node, std::size_t low, std::size_t high, std::size_t begin,
        std::size_t end) const {
        if (end <= low || high <= begin) return std::numeric_limits<std::int64_t>::min() / 4;
        if (begin <= low && high <= end) return largest_[node];
        const std::size_t middle = (low + high) / 2;
        return added_[node] + std::max(largest(2 * node, low, middle, begin, end),
                                  largest(2 * node + 1, middle, high, begin, end));
    }

    std::size_t leaves_;
    std::vector<std::int64_t> largest_, added_;
};

/// Bytes that live when some steps have been moved forward, in front of all that remain, which keep
/// their declared order. A move that would exceed the limit at any step is refused; so the declared
/// order of the rest always stays possible.
class LiveBytes {
public:
    LiveBytes(const Declaration& declaration, const Plan& plan, double batch_memory)
        : users_(declaration.resources.size()), done_(plan.steps.size(), 0),
          profile_(intervals(declaration, plan, batch_memory)) {}

    /// First step that has not been done.
    std::uint32_t head() const { return head_; }

    /// Does `step` next; false, and nothing is changed, if too many bytes would live.
    bool try_step(std::uint32_t step) {
        if (step != head_ && !fits(step)) return false;
        done_[step] = 1;
        profile_.add(step, step + 1, std::numeric_limits<std::int64_t>::min() / 4);
        for (std::uint32_t at = first_[step]; at < first_[step + 1]; ++at) {
            Users& users = users_[resources_[at]];
            if (!users.born) live_ += users.bytes;
            users.born = true;
            if (--users.left == 0) live_ -= users.bytes;
            while (users.left && done_[steps_[users.first]]) ++users.first;
            while (users.left && done_[steps_[users.last]]) --users.last;
        }
        while (head_ < done_.size() && done_[head_]) ++head_;
        return true;
    }

private:
    /// Who uses a resource; only resources that share memory.
    struct Users {
        std::int64_t bytes = 0;
        std::uint32_t first = 0, last = 0; ///< of those left: into steps_
        std::uint32_t left = 0;
        bool born = false;
    };

    /// Lists users both ways; returns the bytes that live at each step in the declared order.
    std::vector<std::int64_t> intervals(
        const Declaration& declaration, const Plan& plan, double batch_memory) {
        std::vector<std::uint32_t> seen(users_.size(), kNone);
        for (std::uint32_t step = 0; step < plan.steps.size(); ++step) {
            first_.push_back(static_cast<std::uint32_t>(resources_.size()));
            for (const Use& use : declaration.uses_of(plan.steps[step].pass)) {
                const ResourceDecl& resource = declaration.resources[use.resource];
                if (!shares_memory(resource)) continue;
                if (std::exchange(seen[use.resource], step) == step) continue;
                resources_.push_back(use.resource);
                ++users_[use.resource].left;
            }
        }
        first_.push_back(static_cast<std::uint32_t>(resources_.size()));

        std::uint32_t begin = 0;
        std::int64_t kept = 0;
        for (ResourceId id = 0; id < users_.size(); ++id) {
            const ResourceDecl& resource = declaration.resources[id];
            Users& users = users_[id];
            if (!plan.resources[id].culled && resource.lifetime != Lifetime::external)
                (users.left ? users.bytes : kept) +=
                    static_cast<std::int64_t>(memory_need(resource).bytes);
            users.first = users.last = begin;
            begin += users.left;
        }
        steps_.resize(begin);
        std::vector<std::int64_t> live(plan.steps.size() + 1, 0);
        for (std::uint32_t step = 0; step < plan.steps.size(); ++step)
            for (std::uint32_t at = first_[step]; at < first_[step + 1]; ++at)
                steps_[users_[resources_[at]].last++] = step;
        for (Users& users : users_) {
            if (users.left == 0) continue;
            --users.last;
            live[steps_[users.first]] += users.bytes;
            live[steps_[users.last] + 1] -= users.bytes;
        }
        std::int64_t peak = 0, sum = 0;
        for (std::int64_t& value : live) peak = std::max(peak, value = sum += value);
        const double limit = (1 + batch_memory) * static_cast<double>(peak + kept);
        limit_ = limit < 0x1p62 ? std::max(static_cast<std::int64_t>(limit) - kept, peak)
                                : std::numeric_limits<std::int64_t>::max() / 2;
        return live;
    }

    bool fits(std::uint32_t step) {
        std::int64_t born = 0;
        for (std::uint32_t at = first_[step]; at < first_[step + 1]; ++at)
            if (const Users& users = users_[resources_[at]]; !users.born) born += users.bytes;
        if (live_ + born > limit_) return false;
        move(step, 1);
        if (profile_.largest(head_, step) <= limit_) return true;
        move(step, -1);
        return false;
    }

    /// What moving `step` in front of the head changes for the steps between; or takes it back.
    void move(std::uint32_t step, std::int64_t sign) {
        for (std::uint32_t at = first_[step]; at < first_[step + 1]; ++at) {
            const Users& users = users_[resources_[at]];
            const std::int64_t bytes = sign * users.bytes;
            if (users.left == 1) {
                if (users.born) profile_.add(head_, step, -bytes);
                continue;
            }
            if (!users.born) profile_.add(head_, steps_[users.first], bytes);
            if (steps_[users.last] != step) continue;
            std::uint32_t before = users.last - 1;
            while (done_[steps_[before]]) --before;
            profile_.add(steps_[before] + 1, step, -bytes);
        }
    }

    std::vector<Users> users_; ///< per resource
    std::vector<std::uint8_t> done_;
    std::vector<std::uint32_t> steps_;  ///< users of each resource, ascending
    std::vector<std::uint32_t> first_;  ///< per step: into resources_
    std::vector<ResourceId> resources_; ///< of each step, each once
    std::int64_t limit_ = 0, live_ = 0;
    std::uint32_t head_ = 0;
    Profile profile_; ///< of the steps that are left
};

/// Collects, again and again, all steps that wait for nothing in the present batch.
std::vector<std::uint32_t> batched_order(const Declaration& declaration, const Plan& plan,
    const Dependences& dependences, double batch_memory) {
    const auto count = static_cast<std::uint32_t>(plan.steps.size());
    // Steps with side effects stay in their order, but need no barrier for that.
    std::vector<std::uint32_t> effect_before(count, kNone);
    std::vector<std::uint32_t> waits(count, 0), begin(count + 2, 0), behind;
    std::uint32_t last_effect = kNone;
    const auto each_edge = [&](auto visit) {
        for (std::uint32_t step = 0; step < count; ++step) {
            for (const std::uint32_t before : dependences.before(step)) visit(before, step);
            if (effect_before[step] != kNone) visit(effect_before[step], step);
        }
    };
    for (std::uint32_t step = 0; step < count; ++step)
        if (!declaration.passes[plan.steps[step].pass].side_effect.empty())
            effect_before[step] = std::exchange(last_effect, step);
    each_edge([&](std::uint32_t before, std::uint32_t step) {
        ++waits[step];
        ++begin[before + 2];
    });
    for (std::uint32_t step = 0; step < count; ++step) begin[step + 2] += begin[step + 1];
    behind.resize(begin.back());
    each_edge(
        [&](std::uint32_t before, std::uint32_t step) { behind[begin[before + 1]++] = step; });

    LiveBytes live(declaration, plan, batch_memory);
    std::vector<std::uint32_t> batch_of(count, kNone);
    std::vector<std::uint32_t> order, ready, later; // the back of `ready` comes first
    order.reserve(count);
    for (std::uint32_t step = count; step-- > 0;)
        if (waits[step] == 0) ready.push_back(step);
    const auto descending = std::greater<>();
    for (std::uint32_t batch = 0; order.size() < count; ++batch) {
        const auto joins = [&](std::uint32_t step) {
            const auto before = dependences.before(step);
            return std::none_of(before.begin(), before.end(),
                [&](std::uint32_t other) { return batch_of[other] == batch; });
        };
        int refusals = 0;
        later.clear();
        while (!ready.empty() && refusals < kRefusals) {
            const std::uint32_t step = ready.back();
            ready.pop_back();
            if (!live.try_step(step)) {
                later.push_back(step);
                ++refusals;
                continue;
            }
            batch_of[step] = batch;
            order.push_back(step);
            for (std::uint32_t at = begin[step]; at < begin[step + 1]; ++at) {
                const std::uint32_t waiting = behind[at];
                if (--waits[waiting] != 0) continue;
                if (joins(waiting))
                    ready.insert(
                        std::upper_bound(ready.begin(), ready.end(), waiting, descending), waiting);
                else
                    later.push_back(waiting);
            }
        }
        std::sort(later.begin(), later.end(), descending);
        const auto middle = ready.insert(ready.end(), later.begin(), later.end());
        std::inplace_merge(ready.begin(), middle, ready.end(), descending);
    }
    return order;
}

/// Batches of barriers that the order needs, each as early as another one is: a step needs a new
/// one where it waits for something since the last.
std::uint32_t count_batches(
    const std::vector<std::uint32_t>& order, const Dependences& dependences) {
    std::vector<std::uint32_t> position(order.size());
    std::uint32_t batches = 0, last = 0;
    for (std::uint32_t at = 0; at < order.size(); ++at) {
        position[order[at]] = at;
        const auto before = dependences.before(order[at]);
        if (!std::any_of(before.begin(), before.end(),
                [&](std::uint32_t step) { return position[step] >= last; }))
            continue;
        ++batches;
        last = at;
    }
    return batches;
}

} // namespace

void order(const Declaration& declaration, const Pieces& pieces, const Policy& policy, Plan& plan) {
    if (policy.order == Order::declared || plan.steps.empty()) return;
    const Dependences dependences(declaration, pieces, plan);
    std::vector<std::uint32_t> declared(plan.steps.size());
    for (std::uint32_t step = 0; step < declared.size(); ++step) declared[step] = step;
    const std::vector<std::uint32_t> batched =
        batched_order(declaration, plan, dependences, policy.batch_memory);
    if (count_batches(batched, dependences) >= count_batches(declared, dependences)) return;
    std::vector<Step> steps;
    steps.reserve(batched.size());
    for (const std::uint32_t step : batched) steps.push_back(plan.steps[step]);
    plan.steps = std::move(steps);
}

} // namespace ockham
