// SPDX-License-Identifier: Apache-2.0
// What accesses find: layout, content, owner, and that they wait for what went before.
#include "framework/graph/explain/words.hpp"
#include "framework/graph/verify/verify_execution.hpp"

#include <fmt/format.h>

namespace ockham::verifier {

void Execution::access(const Accessor& accessor, ResourceId id, std::uint32_t index, Point point) {
    Piece& piece = pieces_[index];
    const Meaning& meaning = accessor.meaning;
    if (is_image(id) && piece.layout != meaning.layout)
        say(Kind::layout, index, kNone, accessor.pass, [&] {
            return fmt::format("{}, which expects layout {}, but it is in {}",
                text_of(accessor, id, index), layout_text(meaning.layout),
                layout_text(piece.layout));
        });
    use_content(accessor, id, index);
    expect_synchronized(accessor, piece, id, index);
    if (declaration_.resources[id].lifetime == Lifetime::transient && piece.taken != execution_) {
        for (const ResourceId owner : tenants_[id].under)
            for (const Piece& below : pieces_of(owner)) expect_gone(accessor, below, id, index);
        if (meaning.writes && accessor.guard == kNone) piece.taken = execution_;
    }
    const Event event{Event::What::access, accessor.pass, execution_, point, meaning.stages,
        meaning.writes ? writes_of(meaning.accesses) : meaning.accesses, accessor.guard};
    if (!meaning.writes)
        add_read(piece, event);
    else
        add_write(piece, event);
}

void Execution::use_content(const Accessor& accessor, ResourceId id, std::uint32_t index) {
    Piece& piece = pieces_[index];
    const Meaning& meaning = accessor.meaning;
    const std::uint32_t family = family_of(accessor.queue);
    const bool has_content = piece.content || !piece.writers.empty();
    // Without a transfer, a buffer may be replaced; an image must come anew from UNDEFINED.
    const bool keeps = is_image(id) || meaning.needs ||
                       (has_content && !(meaning.replaces && accessor.guard == kNone));
    if (!plan_.concurrent[id] && keeps) {
        if (piece.transfer.pending)
            say(Kind::ownership, index, kNone, accessor.pass, [&] {
                return fmt::format("{} on family {}, but it is being moved from family {} to {}",
                    text_of(accessor, id, index), family, piece.transfer.from, piece.transfer.to);
            });
        else if (piece.owner != kNobody && piece.owner != family)
            say(Kind::ownership, index, kNone, accessor.pass, [&] {
                return fmt::format("{} on family {}, but family {} owns it",
                    text_of(accessor, id, index), family, piece.owner);
            });
    }
    piece.owner = family;
    piece.transfer = {};
    if (meaning.needs && declaration_.resources[id].history_age && !rotates(id))
        say(Kind::content, index, kNone, accessor.pass, [&] {
            return fmt::format("{}, but not all ages of its history have memory, so that they "
                               "never change places",
                text_of(accessor, id, index));
        });
    if (meaning.needs && !piece.content && !guards_.cover(piece.writers, accessor.guard))
        say(Kind::content, index, kNone, accessor.pass, [&] {
            return fmt::format("{}, but {}", text_of(accessor, id, index),
                piece.lost ? "a transition from layout undefined has lost the content"
                           : "nothing has written it");
        });
    if (!meaning.writes || piece.content) return;
    if (accessor.guard == kNone) {
        piece.content = true;
        piece.lost = false;
        piece.writers.clear();
    } else {
        piece.writers.push_back(accessor.guard);
        if (guards_.cover(piece.writers, kNone)) {
            piece.content = true;
            piece.lost = false;
            piece.writers.clear();
        }
    }
}

void Execution::expect_synchronized(
    const Accessor& accessor, const Piece& piece, ResourceId id, std::uint32_t index) {
    const Meaning& meaning = accessor.meaning;
    for (const Write& write : piece.writes) {
        if (!can_meet(write.guard, accessor.guard)) continue;
        each_bit(meaning.stages, [&](std::uint32_t stage) {
            const auto bit = static_cast<Stages>(1u << stage);
            if (!waits(accessor.queue, stage, write)) {
                say(Kind::execution, index, write.pass, accessor.pass, [&] {
                    return fmt::format("{}, but nothing makes its {} wait for {}",
                        text_of(accessor, id, index), stages_text(flags_of(bit)), text_of(write));
                });
                return;
            }
            // A write after a write needs it available, only a read needs it visible:
            // "location- ordered" in
            // https://docs.vulkan.org/spec/latest/appendices/memorymodel.html
            if (meaning.writes && !is_available(accessor.queue, stage, write))
                say(Kind::memory, index, write.pass, accessor.pass, [&] {
                    return fmt::format("{}, but nothing makes {} available before",
                        text_of(accessor, id, index), text_of(write));
                });
            if (!meaning.needs || clocks_.is_seen(accessor.queue, stage, write.at)) return;
            const Accesses visible =
                write.queue == accessor.queue ? write.visible[stage] : Accesses{0};
            const Accesses blind =
                meaning.accesses & ~writes_of(meaning.accesses) & possible_in(bit) & ~visible;
            if (blind)
                say(Kind::memory, index, write.pass, accessor.pass, [&] {
                    return fmt::format("{}, but nothing makes {} visible to {}",
                        text_of(accessor, id, index), text_of(write), at(bit, blind));
                });
        });
    }
    if (!meaning.writes) return;
    for (const Event& read : piece.reads) {
        if (!can_meet(read.guard, accessor.guard)) continue;
        each_bit(meaning.stages, [&](std::uint32_t stage) {
            if (!waits(accessor.queue, stage, read))
                say(Kind::execution, index, read.pass, accessor.pass, [&] {
                    return fmt::format("{}, but nothing makes it wait for {}",
                        text_of(accessor, id, index), text_of(read));
                });
        });
    }
}

void Execution::add_read(Piece& piece, const Event& event) {
    for (Event& read : piece.reads)
        if (read.at.queue == event.at.queue && read.stages == event.stages &&
            read.guard == event.guard && read.what == event.what) {
            read = event; // who waits for the later one has waited for both
            return;
        }
    piece.reads.push_back(event);
}

void Execution::add_write(Piece& piece, const Event& event) {
    if (event.guard == kNone) {
        piece.writes.clear();
        piece.reads.clear();
    } else {
        std::erase_if(piece.writes, [&](const Write& write) {
            return write.guard != kNone && write.guard != kMaybe &&
                   guards_.implies(write.guard, event.guard);
        });
    }
    static_cast<Event&>(piece.writes.emplace_back()) = event;
    piece.writes.back().queue = event.at.queue;
}

} // namespace ockham::verifier
