// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/compile/owners.hpp"

#include <algorithm>
#include <map>
#include <memory_resource>

namespace ockham {

namespace {

/// Bytes [begin, end) of one heap; the map's key is `begin`.
struct Segment {
    std::uint64_t end = 0;
    ResourceId owner = kNone;
};
using Segments = std::pmr::map<std::uint64_t, Segment>;

/// The first segment that ends behind `begin`.
Segments::iterator find(Segments& segments, std::uint64_t begin) {
    auto segment = segments.upper_bound(begin);
    if (segment != segments.begin() && std::prev(segment)->second.end > begin) --segment;
    return segment;
}

struct Found {
    ResourceId resource = kNone;
    Owner owner;
};

/// Bytes that nobody had used in this execution when `resource` took them.
struct Gap {
    std::uint32_t heap = 0;
    std::uint64_t begin = 0, end = 0;
    ResourceId resource = kNone;
};

void take(const Placement& placement, Segments& segments, std::vector<Found>& found,
    std::vector<Gap>& gaps) {
    const std::uint64_t begin = placement.offset, end = begin + placement.bytes;
    std::uint64_t at = begin;
    bool placed = false;
    auto segment = find(segments, begin);
    while (segment != segments.end() && segment->first < end) {
        const auto [first, rest] = *segment;
        found.push_back({placement.resource, {rest.owner, false}});
        if (first > at) gaps.push_back({placement.heap, at, first, placement.resource});
        at = rest.end;
        if (first > begin) {
            segment = segments.erase(segment);
        } else { // its node stays
            placed = first == begin;
            segment->second =
                placed ? Segment{end, placement.resource} : Segment{begin, rest.owner};
            ++segment;
        }
        if (rest.end > end) segment = segments.emplace_hint(segment, end, rest);
    }
    if (at < end) gaps.push_back({placement.heap, at, end, placement.resource});
    if (!placed) segments.emplace_hint(segment, begin, Segment{end, placement.resource});
}

} // namespace

Owners::Owners(const Plan& plan) : first_(plan.resources.size() + 1, 0) {
    std::pmr::monotonic_buffer_resource memory;
    std::pmr::vector<Segments> heaps(plan.heaps.size(), &memory);
    std::vector<Found> found;
    std::vector<Gap> gaps;
    found.reserve(2 * plan.placements.size());
    for (const Placement& placement : plan.placements)
        take(placement, heaps[placement.heap], found, gaps);
    // The execution before left the segments as this one does.
    for (const Gap& gap : gaps) {
        Segments& segments = heaps[gap.heap];
        for (auto segment = find(segments, gap.begin);
             segment != segments.end() && segment->first < gap.end; ++segment)
            found.push_back({gap.resource, {segment->second.owner, true}});
    }

    for (const Found& one : found) ++first_[one.resource + 1];
    for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
    owners_.resize(found.size());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (const Found& one : found) owners_[next[one.resource]++] = one.owner;
}

} // namespace ockham
