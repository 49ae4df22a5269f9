// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/compile/pack.hpp"

#include <algorithm>
#include <array>
#include <numeric>

namespace ockham {

namespace {

constexpr std::uint64_t kUnplaced = ~std::uint64_t{0};
/// A packing this close to the bound is not improved any more: 1 / 64 of it.
constexpr std::uint64_t kCloseEnough = 64;
/// Spans that all attempts together may look at, for each range: what planning can afford.
constexpr std::size_t kVisitsPerRange = 96;
/// Up to this many live at a birth, on average, neighbours are listed; else spans are searched.
constexpr std::size_t kFewNeighbours = 8;

std::uint64_t align_up(std::uint64_t value, std::uint64_t alignment) {
    return (value + alignment - 1) / alignment * alignment;
}

/// Which bytes of an unlimited memory are free: gaps by offset, in blocks that know their largest
/// gap, so that neither searching nor inserting walks over all of them.
class FreeList {
public:
    void clear() {
        blocks_.clear();
        blocks_.emplace_back();
        insert(0, 0, {0, kEndless});
    }

    /// Lowest offset where the bytes fit; they are taken.
    std::uint64_t take(std::uint64_t bytes, std::uint64_t alignment) {
        for (std::size_t b = 0;; ++b) {
            if (blocks_[b].largest < bytes) continue;
            for (std::uint32_t i = 0; i < blocks_[b].count; ++i) {
                const Gap gap = blocks_[b].gaps[i];
                if (gap.end - gap.begin < bytes) continue;
                const std::uint64_t offset = align_up(gap.begin, alignment);
                if (offset + bytes > gap.end) continue;
                replace(b, i, {gap.begin, offset}, {offset + bytes, gap.end});
                return offset;
            }
        }
    }

    /// Frees what take() gave.
    void give(std::uint64_t begin, std::uint64_t end) {
        const auto after = std::upper_bound(blocks_.begin() + 1, blocks_.end(), begin,
            [](std::uint64_t offset, const Block& block) { return offset < block.gaps[0].begin; });
        auto b = static_cast<std::size_t>(after - blocks_.begin()) - 1;
        std::uint32_t i = 0; // of the first gap behind
        while (i < blocks_[b].count && blocks_[b].gaps[i].begin < begin) ++i;
        // The gap behind it may be the first of the next block; one in front is in this block.
        const bool in_next = i == blocks_[b].count && b + 1 < blocks_.size();
        const std::size_t next = in_next ? b + 1 : b;
        const std::uint32_t next_i = in_next ? 0 : i;
        const bool joins_next =
            next_i < blocks_[next].count && blocks_[next].gaps[next_i].begin == end;
        const bool joins_previous = i > 0 && blocks_[b].gaps[i - 1].end == begin;
        if (joins_next) end = blocks_[next].gaps[next_i].end;
        if (joins_previous) {
            grow(b, i - 1, {blocks_[b].gaps[i - 1].begin, end});
            if (joins_next) erase(next, next_i);
        } else if (joins_next) {
            grow(next, next_i, {begin, end});
        } else {
            insert(b, i, {begin, end});
        }
    }

private:
    static constexpr std::uint64_t kEndless = std::uint64_t{1} << 63;
    static constexpr std::uint32_t kGaps = 32;
    struct Gap {
        std::uint64_t begin, end;
    };
    struct Block {
        std::array<Gap, kGaps> gaps;
        std::uint32_t count = 0;
        std::uint64_t largest = 0; ///< bytes
    };

    static void find_largest(Block& block) {
        block.largest = 0;
        for (std::uint32_t i = 0; i < block.count; ++i)
            block.largest = std::max(block.largest, block.gaps[i].end - block.gaps[i].begin);
    }
    void grow(std::size_t b, std::uint32_t i, Gap gap) {
        blocks_[b].gaps[i] = gap;
        blocks_[b].largest = std::max(blocks_[b].largest, gap.end - gap.begin);
    }
    /// In place of the i-th gap, what is left of it on both sides.
    void replace(std::size_t b, std::uint32_t i, Gap before, Gap behind) {
        Block& block = blocks_[b];
        const bool was_largest = block.gaps[i].end - block.gaps[i].begin == block.largest;
        if (before.begin != before.end) {
            block.gaps[i] = before;
            if (was_largest) find_largest(block);
            if (behind.begin != behind.end) insert(b, i + 1, behind);
        } else if (behind.begin != behind.end) {
            block.gaps[i] = behind;
            if (was_largest) find_largest(block);
        } else {
            erase(b, i);
        }
    }
    void insert(std::size_t b, std::uint32_t i, Gap gap) {
        if (blocks_[b].count == kGaps) {
            blocks_.insert(blocks_.begin() + static_cast<std::ptrdiff_t>(b) + 1, Block{});
            Block &low = blocks_[b], &high = blocks_[b + 1];
            std::copy(low.gaps.begin() + kGaps / 2, low.gaps.end(), high.gaps.begin());
            low.count = high.count = kGaps / 2;
            find_largest(low);
            find_largest(high);
            if (i > kGaps / 2) {
                ++b;
                i -= kGaps / 2;
            }
        }
        Block& block = blocks_[b];
        std::copy_backward(block.gaps.begin() + i, block.gaps.begin() + block.count,
            block.gaps.begin() + block.count + 1);
        ++block.count;
        grow(b, i, gap);
    }
    void erase(std::size_t b, std::uint32_t i) {
        Block& block = blocks_[b];
        std::copy(
            block.gaps.begin() + i + 1, block.gaps.begin() + block.count, block.gaps.begin() + i);
        --block.count;
        if (block.count == 0 && blocks_.size() > 1)
            blocks_.erase(blocks_.begin() + static_cast<std::ptrdiff_t>(b));
        else
            find_largest(block);
    }

    std::vector<Block> blocks_; ///< at least one; none empty but an only one
};

class Packer {
public:
    explicit Packer(std::span<const LiveRange> ranges)
        : ranges_(ranges), by_last_(ranges.size()), bound_(live_bytes(ranges)) {
        std::uint32_t steps = 0;
        for (const LiveRange& range : ranges) steps = std::max(steps, range.last + 1);
        std::vector<std::uint32_t> begin(steps + 1, 0);
        for (const LiveRange& range : ranges) ++begin[range.last + 1];
        std::partial_sum(begin.begin(), begin.end(), begin.begin());
        for (std::uint32_t i = 0; i < ranges.size(); ++i) by_last_[begin[ranges[i].last]++] = i;
        best_.offsets.resize(ranges.size());
        best_.bytes = ~std::uint64_t{0};
        trial_.offsets.resize(ranges.size());
    }

    Packing run() {
        const std::size_t count = ranges_.size();
        if (count == 0) return {};
        if (sweep_forward() || sweep_backward()) return std::move(best_);
        few_ = pairs_ <= kFewNeighbours * count;
        if (few_)
            list_neighbours();
        else if (count > 3 * kVisitsPerRange)
            return std::move(best_);
        order_.resize(count);
        std::iota(order_.begin(), order_.end(), 0u);
        const auto steps = [](const LiveRange& r) { return std::uint64_t{r.last} - r.first + 1; };
        if (place_by([](const LiveRange& r) { return r.bytes; })) return std::move(best_);
        if (place_by([&](const LiveRange& r) { return r.bytes * steps(r); }))
            return std::move(best_);
        if (place_by(steps)) return std::move(best_);
        // Repair: what ended above the bound goes first next time.
        while (visits_ < kVisitsPerRange * count) {
            std::stable_partition(order_.begin(), order_.end(),
                [&](std::uint32_t i) { return offset_of(i) + ranges_[i].bytes > bound_; });
            if (place()) break;
        }
        return std::move(best_);
    }

private:
    /// Keeps the trial if it is the best so far; true: good enough.
    bool judge() {
        last_is_best_ = trial_.bytes < best_.bytes;
        if (last_is_best_) std::swap(best_, trial_);
        return best_.bytes <= bound_ + bound_ / kCloseEnough;
    }
    /// Of the latest attempt.
    std::uint64_t offset_of(std::uint32_t i) const {
        return (last_is_best_ ? best_ : trial_).offsets[i];
    }

    void take(std::uint32_t i) {
        const LiveRange& range = ranges_[i];
        const std::uint64_t offset = free_.take(range.bytes, range.alignment);
        trial_.offsets[i] = offset;
        trial_.bytes = std::max(trial_.bytes, offset + range.bytes);
    }
    void give(std::uint32_t i) {
        free_.give(trial_.offsets[i], trial_.offsets[i] + ranges_[i].bytes);
    }

    /// First fit in order of time, and in the opposite order.
    bool sweep_forward() {
        free_.clear();
        trial_.bytes = 0;
        std::size_t dead = 0;
        for (std::uint32_t i = 0; i < ranges_.size(); ++i) {
            for (; ranges_[by_last_[dead]].last < ranges_[i].first; ++dead) give(by_last_[dead]);
            pairs_ += i - dead;
            take(i);
        }
        return judge();
    }
    bool sweep_backward() {
        free_.clear();
        trial_.bytes = 0;
        auto dead = static_cast<std::uint32_t>(ranges_.size() - 1);
        for (auto i = by_last_.rbegin(); i != by_last_.rend(); ++i) {
            for (; ranges_[dead].first > ranges_[*i].last; --dead) give(dead);
            take(*i);
        }
        return judge();
    }

    template <class Key>
    bool place_by(Key key) {
        if (visits_ >= kVisitsPerRange * ranges_.size()) return true;
        std::stable_sort(order_.begin(), order_.end(),
            [&](std::uint32_t a, std::uint32_t b) { return key(ranges_[a]) > key(ranges_[b]); });
        return place();
    }

    struct Placed {
        std::uint64_t begin, end;
        std::uint32_t first, last;
        bool operator<(const Placed& other) const { return begin < other.begin; }
    };

    /// First fit in the order of `order_`, whatever their times.
    bool place() {
        trial_.bytes = 0;
        placed_.clear();
        if (few_) std::fill(trial_.offsets.begin(), trial_.offsets.end(), kUnplaced);
        for (const std::uint32_t i : order_) {
            const LiveRange& range = ranges_[i];
            if (few_) find_neighbours(i);
            std::uint64_t offset = 0;
            std::size_t at = 0; // `placed_` is sorted by offset
            for (; at < placed_.size(); ++at) {
                const Placed& other = placed_[at];
                if (other.first > range.last || other.last < range.first) continue;
                if (offset + range.bytes <= other.begin) break;
                if (other.end > offset) offset = align_up(other.end, range.alignment);
            }
            visits_ += at + 4;
            trial_.offsets[i] = offset;
            trial_.bytes = std::max(trial_.bytes, offset + range.bytes);
            if (few_) continue;
            const Placed placed{offset, offset + range.bytes, range.first, range.last};
            placed_.insert(std::upper_bound(placed_.begin(), placed_.end(), placed), placed);
        }
        return judge();
    }

    /// For each range, those that live when it begins; those that begin later follow it directly.
    void list_neighbours() {
        std::vector<std::uint32_t> live;
        begin_.reserve(ranges_.size() + 1);
        earlier_.reserve(pairs_);
        for (std::uint32_t i = 0; i < ranges_.size(); ++i) {
            std::erase_if(
                live, [&](std::uint32_t other) { return ranges_[other].last < ranges_[i].first; });
            begin_.push_back(earlier_.size());
            earlier_.insert(earlier_.end(), live.begin(), live.end());
            live.push_back(i);
        }
        begin_.push_back(earlier_.size());
    }

    /// Fills `placed_` with those that share a step with range i and have their place.
    void find_neighbours(std::uint32_t i) {
        placed_.clear();
        const auto add = [&](std::uint32_t other) {
            const std::uint64_t offset = trial_.offsets[other];
            const LiveRange& range = ranges_[other];
            if (offset != kUnplaced)
                placed_.push_back({offset, offset + range.bytes, range.first, range.last});
        };
        for (std::size_t k = begin_[i]; k < begin_[i + 1]; ++k) add(earlier_[k]);
        for (std::size_t k = i + 1; k < ranges_.size() && ranges_[k].first <= ranges_[i].last; ++k)
            add(static_cast<std::uint32_t>(k));
        std::sort(placed_.begin(), placed_.end());
    }

    std::span<const LiveRange> ranges_;
    std::vector<std::uint32_t> by_last_; ///< ranges in the order in which they die
    std::uint64_t bound_;
    Packing best_, trial_;
    bool last_is_best_ = false;
    FreeList free_;
    std::vector<std::uint32_t> order_;
    std::vector<Placed> placed_; ///< by offset: all that have their place, or the neighbours
    std::size_t pairs_ = 0;      ///< of ranges that share a step
    bool few_ = false;
    std::vector<std::size_t> begin_; ///< where each range's part of earlier_ begins
    std::vector<std::uint32_t> earlier_;
    std::size_t visits_ = 0;
};

} // namespace

std::uint64_t live_bytes(std::span<const LiveRange> ranges) {
    std::uint32_t steps = 0;
    for (const LiveRange& range : ranges) steps = std::max(steps, range.last + 1);
    std::vector<std::uint64_t> change(steps + 1, 0); // modulo 2^64, so it may go down
    for (const LiveRange& range : ranges) {
        change[range.first] += range.bytes;
        change[range.last + 1] -= range.bytes;
    }
    std::uint64_t live = 0, most = 0;
    for (const std::uint64_t step : change) most = std::max(most, live += step);
    return most;
}

Packing pack(std::span<const LiveRange> ranges) { return Packer(ranges).run(); }

} // namespace ockham
