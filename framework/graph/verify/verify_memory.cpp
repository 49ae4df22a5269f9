// SPDX-License-Identifier: Apache-2.0
// Memory that resources share: whose bytes are whose, and how they change hands.
#include "framework/graph/verify/verify_execution.hpp"

#include <fmt/format.h>

namespace ockham::verifier {

std::vector<ResourceId> Execution::owners_below(ResourceId id) const {
    std::vector<ResourceId> owners;
    const Placement* const placement = tenants_[id].placement;
    if (!placement) return owners;
    const std::uint64_t begin = placement->offset, end = begin + placement->bytes;
    const std::uint64_t first_page = begin / granularity_ * granularity_;
    const std::uint64_t end_page = (end + granularity_ - 1) / granularity_ * granularity_;
    const auto& segments = heaps_[placement->heap];
    auto segment = std::lower_bound(segments.begin(), segments.end(), first_page,
        [](const Segment& s, std::uint64_t offset) { return s.end <= offset; });
    // What begins before the page may still end inside of it, in the page of another kind.
    if (segment != segments.begin()) --segment;
    for (; segment != segments.end() && segment->begin < end_page; ++segment) {
        const bool bytes = segment->begin < end && begin < segment->end;
        const bool page =
            segment->begin < end_page &&
            first_page < (segment->end + granularity_ - 1) / granularity_ * granularity_ &&
            is_image(segment->owner) != is_image(id);
        if ((bytes || page) && segment->owner != id) owners.push_back(segment->owner);
    }
    std::sort(owners.begin(), owners.end());
    owners.erase(std::unique(owners.begin(), owners.end()), owners.end());
    return owners;
}

void Execution::begin(ResourceId id, std::uint32_t piece, PassId pass) {
    if (declaration_.resources[id].lifetime != Lifetime::transient) return;
    Tenant& tenant = tenants_[id];
    if (tenant.begun == execution_) {
        if (tenant.taken_by != kNone)
            say(Kind::alias, piece, kNone, pass, [&] {
                return fmt::format("{} uses {}, but {} has taken its memory", report_.pass(pass),
                    report_.resource(id), report_.resource(tenant.taken_by));
            });
        return;
    }
    tenant.begun = execution_;
    tenant.under = owners_below(id);
    for (Piece& one : pieces_of(id)) {
        one.content = one.lost = false;
        one.owner = kNobody;
        one.transfer = {};
        if (tenant.taken_by != kNone) { // ordered before who took it
            one.layout = VK_IMAGE_LAYOUT_UNDEFINED;
            one.writes.clear();
            one.reads.clear();
        }
    }
    tenant.taken_by = kNone;
    for (const ResourceId owner : tenant.under) tenants_[owner].taken_by = id;
    if (tenant.placement) occupy(*tenant.placement);
}

void Execution::occupy(const Placement& placement) {
    auto& segments = heaps_[placement.heap];
    const std::uint64_t begin = placement.offset, end = begin + placement.bytes;
    const auto first = std::lower_bound(segments.begin(), segments.end(), begin,
        [](const Segment& s, std::uint64_t offset) { return s.end <= offset; });
    const auto last = std::lower_bound(first, segments.end(), end,
        [](const Segment& s, std::uint64_t offset) { return s.begin < offset; });
    std::array<Segment, 3> fresh;
    std::size_t count = 0;
    if (first != last && first->begin < begin) fresh[count++] = {first->begin, begin, first->owner};
    fresh[count++] = {begin, end, placement.resource};
    if (first != last && (last - 1)->end > end)
        fresh[count++] = {end, (last - 1)->end, (last - 1)->owner};
    const auto where = segments.erase(first, last);
    segments.insert(where, fresh.begin(), fresh.begin() + static_cast<std::ptrdiff_t>(count));
}

void Execution::expect_gone(
    const Accessor& accessor, const Piece& below, ResourceId id, std::uint32_t index) {
    const auto gone = [&](const Event& event, bool available) {
        if (available) return;
        say(Kind::alias, index, event.pass, accessor.pass, [&] {
            return fmt::format("{} where memory is handed over, but nothing makes it wait for {}",
                text_of(accessor, id, index), text_of(event));
        });
    };
    each_bit(accessor.meaning.stages, [&](std::uint32_t stage) {
        for (const Write& write : below.writes)
            gone(write,
                waits(accessor.queue, stage, write) && is_available(accessor.queue, stage, write));
        for (const Event& read : below.reads) gone(read, waits(accessor.queue, stage, read));
    });
}

} // namespace ockham::verifier
