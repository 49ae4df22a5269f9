// SPDX-License-Identifier: Apache-2.0
// What barriers must be, and what they do.
#include "framework/graph/explain/words.hpp"
#include "framework/graph/verify/verify_execution.hpp"

#include <fmt/format.h>

namespace ockham::verifier {

void Execution::check_barriers() {
    for (std::size_t i = 0; i < plan_.barriers.size(); ++i) {
        const Barrier& barrier = plan_.barriers[i];
        const Scopes& scopes = scopes_[i];
        const std::uint32_t piece = grids_.first(barrier.resource);
        pass_ = barrier.to;
        if ((scopes.src_access & ~possible_in(scopes.src)) ||
            (scopes.dst_access & ~possible_in(scopes.dst)))
            say(Kind::malformed, piece, barrier.from, barrier.to, [&] {
                return fmt::format("{} names an access that none of its stages performs: {} -> {}",
                    text_of(barrier), at(scopes.src, scopes.src_access),
                    at(scopes.dst, scopes.dst_access));
            });
        if ((barrier.src_family == kNobody) != (barrier.dst_family == kNobody))
            say(Kind::malformed, piece, barrier.from, barrier.to, [&] {
                return fmt::format("{} names one queue family, not both", text_of(barrier));
            });
        if (barrier.new_layout == VK_IMAGE_LAYOUT_UNDEFINED &&
            barrier.old_layout != barrier.new_layout)
            say(Kind::malformed, piece, barrier.from, barrier.to,
                [&] { return fmt::format("{} leads to layout undefined", text_of(barrier)); });
    }
}

void Execution::batch(std::uint32_t first, std::uint32_t count, std::uint32_t queue) {
    if (count == 0) return;
    const Point point = clocks_.advance(queue);
    first_scopes_.clear();
    for (std::uint32_t i = first; i < first + count; ++i)
        first_scopes_.push_back(clocks_.first_scope(point, scopes_[i]));
    for (std::uint32_t i = 0; i < count; ++i)
        clocks_.let_wait(queue, first_scopes_[i], scopes_[first + i]);
    for (std::uint32_t i = 0; i < count; ++i)
        apply(plan_.barriers[first + i], first + i, point, first_scopes_[i]);
}

void Execution::apply(const Barrier& barrier, std::uint32_t index, Point point, const Row& scope) {
    const ResourceId id = barrier.resource;
    const Scopes& scopes = scopes_[index];
    const std::uint32_t first = grids_.first(id);
    if ((scopes.src | scopes.dst) & ~stages_[point.queue])
        say(Kind::malformed, first, barrier.from, pass_, [&] {
            return fmt::format("{} is on queue {}, whose family has no stage {}", text_of(barrier),
                point.queue,
                stages_text(flags_of((scopes.src | scopes.dst) & ~stages_[point.queue])));
        });
    const bool transfers = barrier.src_family != barrier.dst_family;
    const bool releases = transfers && barrier.src_family == family_of(point.queue);
    const bool acquires = transfers && barrier.dst_family == family_of(point.queue);
    if (transfers && !releases && !acquires)
        say(Kind::ownership, first, barrier.from, pass_, [&] {
            return fmt::format("{} moves it from family {} to {}, but is executed on family {}",
                text_of(barrier), barrier.src_family, barrier.dst_family, family_of(point.queue));
        });
    const bool changes = is_image(id) && barrier.old_layout != barrier.new_layout;
    if (changes || transfers) begin(id, first, pass_);
    if (barrier.hazard == Hazard::alias)
        for (const ResourceId owner :
            tenants_[id].begun == execution_ ? tenants_[id].under : owners_below(id))
            for (Piece& piece : pieces_of(owner)) pass_on(piece, scopes, point, scope);
    grids_.each(id, grids_.of_barrier(index), [&](std::uint32_t piece) {
        pass_on(pieces_[piece], scopes, point, scope);
        expect_owner(barrier, piece, point, acquires);
        if (releases)
            release(barrier, scopes, piece, point, scope);
        else if (changes || acquires)
            transition(barrier, scopes, piece, point, scope, acquires);
    });
}

/// Whether a barrier at that point has the write in its first access scope.
static bool names(const Scopes& scopes, const Write& write, Point point) {
    return !write.any && write.at.queue == point.queue && (write.stages & ~scopes.src) == 0 &&
           (write.accesses & ~scopes.src_access) == 0;
}

void Execution::pass_on(Piece& piece, const Scopes& scopes, Point point, const Row& scope) {
    for (Write& write : piece.writes) {
        const bool named = names(scopes, write, point);
        if (!named && !is_available(scope, point.queue, write)) continue;
        if (named) write.available.push_back({point, scopes.second});
        write.add_visible(point.queue, scopes.dst, scopes.dst_access);
    }
}

void Execution::expect_owner(
    const Barrier& barrier, std::uint32_t index, Point point, bool acquires) {
    const ResourceId id = barrier.resource;
    Piece& piece = pieces_[index];
    if (plan_.concurrent[id]) {
        if (barrier.src_family != barrier.dst_family)
            say(Kind::ownership, index, barrier.from, pass_, [&] {
                return fmt::format(
                    "{} moves a resource between families that all own it", text_of(barrier));
            });
        return;
    }
    // What has no content worth keeping need not change owners.
    const bool anew = is_image(id) ? barrier.old_layout == VK_IMAGE_LAYOUT_UNDEFINED
                                   : declaration_.resources[id].lifetime == Lifetime::transient &&
                                         tenants_[id].begun != execution_;
    if (acquires || anew) return;
    if (piece.transfer.pending)
        say(Kind::ownership, index, barrier.from, pass_, [&] {
            return fmt::format("{} comes between its release to family {} and the acquire",
                text_of(barrier), piece.transfer.to);
        });
    else if (piece.owner != kNobody && piece.owner != family_of(point.queue))
        say(Kind::ownership, index, barrier.from, pass_, [&] {
            return fmt::format("{} is executed on family {}, but family {} owns it",
                text_of(barrier), family_of(point.queue), piece.owner);
        });
}

void Execution::expect_done(const Barrier& barrier, const Scopes& scopes, const Piece& piece,
    std::uint32_t index, Point point, const Row& scope) {
    // Memory that was written through other resources is covered by the global half of `alias`.
    const bool covered = &piece == &pieces_[index] || barrier.hazard == Hazard::alias;
    const auto waits_for = [&](const Event& event) {
        if (covers(scope, point.queue, event)) return true;
        say(Kind::execution, index, event.pass, pass_, [&] {
            return fmt::format("{} changes it from {} to {}, but does not wait for {}",
                text_of(barrier), layout_text(barrier.old_layout), layout_text(barrier.new_layout),
                text_of(event));
        });
        return false;
    };
    for (const Write& write : piece.writes) {
        if (!waits_for(write)) continue;
        // Barriers of a batch are not ordered among themselves: this one must name the write.
        if (!(covered && names(scopes, write, point)) && !is_available(scope, point.queue, write))
            say(Kind::memory, index, write.pass, pass_, [&] {
                return fmt::format(
                    "{} changes it before {} is available", text_of(barrier), text_of(write));
            });
    }
    for (const Event& read : piece.reads) waits_for(read);
}

void Execution::expect_layout(const Barrier& barrier, std::uint32_t index) {
    const Piece& piece = pieces_[index];
    if (!is_image(barrier.resource) || barrier.old_layout == VK_IMAGE_LAYOUT_UNDEFINED ||
        barrier.old_layout == piece.layout)
        return;
    say(Kind::layout, index, barrier.from, pass_, [&] {
        return fmt::format("{} expects layout {}, but it is in {}", text_of(barrier),
            layout_text(barrier.old_layout), layout_text(piece.layout));
    });
}

void Execution::release(const Barrier& barrier, const Scopes& scopes, std::uint32_t index,
    Point point, const Row& scope) {
    Piece& piece = pieces_[index];
    expect_layout(barrier, index);
    expect_done(barrier, scopes, piece, index, point, scope);
    piece.transfer = {true, false, barrier.src_family, barrier.dst_family, barrier.old_layout,
        barrier.new_layout, point};
}

void Execution::transition(const Barrier& barrier, const Scopes& scopes, std::uint32_t index,
    Point point, const Row& scope, bool acquires) {
    Piece& piece = pieces_[index];
    if (piece.transition.queue == point.queue && piece.transition.index == point.index)
        say(Kind::layout, index, barrier.from, pass_,
            [&] { return fmt::format("{} is not the only one in its batch", text_of(barrier)); });
    piece.transition = point;
    if (acquires)
        acquire(barrier, index, scope);
    else
        expect_layout(barrier, index);
    if (!acquires || piece.transfer.by_caller)
        expect_done(barrier, scopes, piece, index, point, scope);
    if (declaration_.resources[barrier.resource].lifetime == Lifetime::transient &&
        piece.taken != execution_) {
        for (const ResourceId owner : tenants_[barrier.resource].under)
            for (const Piece& below : pieces_of(owner))
                expect_done(barrier, scopes, below, index, point, scope);
        piece.taken = execution_;
    }
    if (is_image(barrier.resource)) {
        if (barrier.old_layout == VK_IMAGE_LAYOUT_UNDEFINED) {
            piece.lost |= piece.content || !piece.writers.empty();
            piece.content = false;
            piece.writers.clear();
        }
        piece.layout = barrier.new_layout;
    }
    piece.owner = family_of(point.queue);
    piece.transfer = {};
    piece.reads.clear();
    piece.writes.clear();
    Write& write = piece.writes.emplace_back();
    write.what = Event::What::barrier;
    write.any = true;
    write.pass = pass_;
    write.execution = execution_;
    write.at = point;
    write.stages = scopes.second;
    write.available.push_back({point, scopes.second});
    write.add_visible(point.queue, scopes.dst, scopes.dst_access);
}

void Execution::acquire(const Barrier& barrier, std::uint32_t index, const Row& scope) {
    const Transfer& transfer = pieces_[index].transfer;
    const auto complain = [&](std::string text) {
        say(Kind::ownership, index, barrier.from, pass_, [&] {
            return fmt::format("{} acquires it from family {}, but {}", text_of(barrier),
                barrier.src_family, text);
        });
    };
    if (!transfer.pending) return complain("nothing has released it");
    if (transfer.from != barrier.src_family || transfer.to != barrier.dst_family)
        return complain(fmt::format("family {} released it to {}", transfer.from, transfer.to));
    if (!is_image(barrier.resource) && transfer.by_caller) return;
    if (transfer.by_caller ? transfer.old_layout != barrier.old_layout
                           : transfer.old_layout != barrier.old_layout ||
                                 transfer.new_layout != barrier.new_layout)
        return complain(fmt::format("in layouts {} -> {}, while the release says {} -> {}",
            layout_text(barrier.old_layout), layout_text(barrier.new_layout),
            layout_text(transfer.old_layout), layout_text(transfer.new_layout)));
    if (!transfer.by_caller && scope[kStageCount + transfer.at.queue] < transfer.at.index)
        complain("does not wait for the release");
}

} // namespace ockham::verifier
