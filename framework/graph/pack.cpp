// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/pack.hpp"

#include <algorithm>
#include <numeric>

namespace ockham {

namespace {

constexpr std::uint64_t kUnplaced = ~std::uint64_t{0};
/// Above this many pairs per range only the sweep runs.
constexpr std::size_t kPairsPerRange = 64;
/// Repairs tried when no fixed order reaches the bound.
constexpr int kRepairs = 8;

struct Span {
    std::uint64_t offset, end;
    std::uint32_t last; ///< step
};

std::uint64_t align_up(std::uint64_t value, std::uint64_t alignment) {
    return (value + alignment - 1) / alignment * alignment;
}

/// Lowest offset of a gap between `taken`, which is sorted by offset.
std::uint64_t first_fit(const std::vector<Span>& taken, const LiveRange& range) {
    std::uint64_t offset = 0;
    for (const Span& span : taken) {
        if (offset + range.bytes <= span.offset) break;
        if (span.end > offset) offset = align_up(span.end, range.alignment);
    }
    return offset;
}

bool by_offset(const Span& a, const Span& b) { return a.offset < b.offset; }

/// First fit in order of `first`, keeping only what is live: no pairs are stored.
Packing sweep(std::span<const LiveRange> ranges) {
    Packing packing;
    packing.offsets.reserve(ranges.size());
    std::vector<Span> live;
    for (const LiveRange& range : ranges) {
        std::erase_if(live, [&](const Span& span) { return span.last < range.first; });
        const std::uint64_t offset = first_fit(live, range);
        const Span span{offset, offset + range.bytes, range.last};
        live.insert(std::upper_bound(live.begin(), live.end(), span, by_offset), span);
        packing.offsets.push_back(offset);
        packing.bytes = std::max(packing.bytes, span.end);
    }
    return packing;
}

/// Places ranges in any order; remembers which of them share a step.
class Packer {
public:
    explicit Packer(std::span<const LiveRange> ranges) : ranges_(ranges) {
        begin_.reserve(ranges.size() + 1);
        end_.reserve(ranges.size());
        std::vector<std::uint32_t> live;
        for (std::uint32_t i = 0; i < ranges.size(); ++i) {
            std::erase_if(
                live, [&](std::uint32_t other) { return ranges[other].last < ranges[i].first; });
            begin_.push_back(earlier_.size());
            earlier_.insert(earlier_.end(), live.begin(), live.end());
            live.push_back(i);
            const auto after = std::upper_bound(ranges.begin() + i, ranges.end(), ranges[i].last,
                [](std::uint32_t last, const LiveRange& range) { return last < range.first; });
            end_.push_back(static_cast<std::uint32_t>(after - ranges.begin()));
            if (earlier_.size() > kPairsPerRange * ranges.size()) return;
        }
        begin_.push_back(earlier_.size());
        complete_ = true;
    }

    /// False: too many pairs, place() must not be called.
    bool complete() const { return complete_; }

    Packing place(const std::vector<std::uint32_t>& order) {
        Packing packing;
        packing.offsets.assign(ranges_.size(), kUnplaced);
        for (const std::uint32_t i : order) {
            taken_.clear();
            const auto take = [&](std::uint32_t other) {
                const std::uint64_t offset = packing.offsets[other];
                if (offset != kUnplaced)
                    taken_.push_back({offset, offset + ranges_[other].bytes, 0});
            };
            for (std::size_t k = begin_[i]; k < begin_[i + 1]; ++k) take(earlier_[k]);
            for (std::uint32_t other = i + 1; other < end_[i]; ++other) take(other);
            std::sort(taken_.begin(), taken_.end(), by_offset);
            packing.offsets[i] = first_fit(taken_, ranges_[i]);
            packing.bytes = std::max(packing.bytes, packing.offsets[i] + ranges_[i].bytes);
        }
        return packing;
    }

private:
    std::span<const LiveRange> ranges_;
    std::vector<std::uint32_t> earlier_; ///< per range: those before it that share a step
    std::vector<std::size_t> begin_;     ///< where each range's part of earlier_ begins
    std::vector<std::uint32_t> end_;     ///< those after it that share a step: up to here
    std::vector<Span> taken_;
    bool complete_ = false;
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

Packing pack(std::span<const LiveRange> ranges) {
    const std::uint64_t bound = live_bytes(ranges);
    Packing best = sweep(ranges);
    if (best.bytes <= bound) return best;
    Packer packer(ranges);
    if (!packer.complete()) return best;

    std::vector<std::uint32_t> order(ranges.size());
    std::iota(order.begin(), order.end(), 0u);
    const auto attempt = [&](auto key) {
        std::stable_sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return key(ranges[a]) > key(ranges[b]); });
        Packing packing = packer.place(order);
        if (packing.bytes < best.bytes) best = std::move(packing);
        return best.bytes <= bound;
    };
    const auto steps = [](const LiveRange& r) { return std::uint64_t{r.last} - r.first + 1; };
    if (attempt([](const LiveRange& r) { return r.bytes; })) return best;
    if (attempt([&](const LiveRange& r) { return r.bytes * steps(r); })) return best;
    if (attempt(steps)) return best;

    // Repair: what ended highest goes first next time.
    for (int i = 0; i < kRepairs; ++i) {
        const Packing last = packer.place(order);
        if (last.bytes < best.bytes) best = last;
        if (best.bytes <= bound) break;
        std::stable_partition(order.begin(), order.end(),
            [&](std::uint32_t range) { return last.offsets[range] + ranges[range].bytes > bound; });
    }
    return best;
}

} // namespace ockham
