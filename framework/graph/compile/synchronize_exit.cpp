// SPDX-License-Identifier: Apache-2.0
// In which state an execution leaves what lives on.
#include "framework/graph/compile/synchronizer.hpp"

#include <algorithm>

namespace ockham::sync {

void Synchronizer::leave(std::uint8_t which) {
    const bool some = !pieces_.whole();
    for (ResourceId id = 0; id < flags_.size(); ++id) {
        if (!contains(flags_[id], which)) continue;
        if (flags_[id] & kExternal)
            exit(id);
        else if (some && (flags_[id] & kImage) && (flags_[id] & (kPersistent | kExported)) &&
                 pieces_.count(id) > 1)
            unify(id);
    }
}

Next Synchronizer::at_exit(const AccessState& state) const {
    Next next;
    next.state = state;
    next.step = static_cast<std::uint32_t>(plan_.steps.size());
    if (!plan_.submissions.empty())
        next.submission = static_cast<std::uint32_t>(plan_.submissions.size() - 1);
    next.written = (state.access & kWriteAccess) != 0;
    next.needs = true;
    return next;
}

void Synchronizer::exit(ResourceId id) {
    if (!(flags_[id] & kMet)) return;
    const ResourceDecl& resource = declaration_.resources[id];
    const bool image = flags_[id] & kImage;
    const bool stays = resource.exit.layout == VK_IMAGE_LAYOUT_UNDEFINED || !image;
    const std::uint32_t to = resource.exit.queue_family;
    if (stays && image && pieces_.count(id) > 1) unify(id);
    if (stays && resource.exit.stages == 0 && to == VK_QUEUE_FAMILY_IGNORED) return;
    const PieceId first = pieces_.first(id);
    for (PieceId piece = first; piece < first + pieces_.count(id); ++piece) {
        Tail& tail = tails_[piece];
        Next next = at_exit(resource.exit);
        if (stays) next.state.layout = tail.used.layout;
        const bool changes = tail.used.layout != next.state.layout;
        if (to != VK_QUEUE_FAMILY_IGNORED && to != tail.family)
            give_back(piece, id, tail, next, to);
        else if (tail.family != family_of(0))
            settle_there(piece, id, tail, next); // semaphores do the rest
        else if (changes || (tail.started && resource.exit.stages))
            touch(piece, id, next);
        tail.used = next.state;
    }
}

void Synchronizer::give_back(
    PieceId piece, ResourceId id, Tail& tail, const Next& next, std::uint32_t family) {
    const bool here = tail.family == family_of(0); // with the other exit barriers
    if (here) {
        tail.submission = next.submission;
        tail.last_queue = 0;
    }
    release(piece, id, tail, next, family);
    if (here) {
        drafts_.back().step = next.step;
        drafts_.back().release = false;
    }
    tail.family = family;
}

void Synchronizer::settle_there(PieceId piece, ResourceId id, const Tail& tail, const Next& next) {
    if (tail.used.layout == next.state.layout) return;
    release(piece, id, tail, next, tail.family);
    Barrier& barrier = plan_.barriers.back();
    barrier.hazard = Hazard::exit;
    barrier.src_family = barrier.dst_family = VK_QUEUE_FAMILY_IGNORED;
}

VkImageLayout Synchronizer::most_common_layout(ResourceId id) const {
    const PieceId first = pieces_.first(id), end = first + pieces_.count(id);
    VkImageLayout best = VK_IMAGE_LAYOUT_UNDEFINED;
    std::ptrdiff_t most = 0;
    for (PieceId piece = first; piece < end; ++piece) {
        if (!tails_[piece].started) continue; // whatever the execution finds, it leaves the same
        const VkImageLayout layout = tails_[piece].used.layout;
        const std::ptrdiff_t count = std::count_if(tails_.begin() + first, tails_.begin() + end,
            [&](const Tail& tail) { return tail.started && tail.used.layout == layout; });
        if (count > most) {
            most = count;
            best = layout;
        }
    }
    return best;
}

void Synchronizer::unify(ResourceId id) {
    const PieceId first = pieces_.first(id), end = first + pieces_.count(id);
    const VkImageLayout layout = most_common_layout(id);
    if (layout == VK_IMAGE_LAYOUT_UNDEFINED) return;
    AccessState state; // as the others in that layout were used
    for (PieceId piece = first; piece < end; ++piece)
        if (tails_[piece].started && tails_[piece].used.layout == layout) {
            state.stages |= tails_[piece].used.stages;
            state.access |= tails_[piece].used.access & ~kWriteAccess;
        }
    state.layout = layout;
    const Next next = at_exit(state);
    // What is never used comes in the layout in which the resource is left, or another age.
    const bool all = (flags_[id] & kExternal) || source_of(id) != id;
    for (PieceId piece = first; piece < end; ++piece)
        if (tails_[piece].used.layout != layout && (tails_[piece].known || all))
            touch(piece, id, next);
}

void Synchronizer::set_final_states() {
    plan_.final_states.assign(flags_.size(), {});
    for (ResourceId id = 0; id < flags_.size(); ++id) {
        AccessState& state = plan_.final_states[id];
        bool used = false;
        for (PieceId piece = pieces_.first(id), end = piece + pieces_.count(id); piece < end;
             ++piece) {
            const Tail& tail = tails_[piece];
            if (!tail.known) continue;
            used = true;
            state.stages |= tail.used.stages;
            state.access |= tail.used.access;
            state.layout = tail.used.layout;
            state.queue_family = tail.used.queue_family;
        }
        if (!used) continue;
        const bool image = flags_[id] & kImage;
        const auto both = [&](VkFlags of_image, VkFlags of_buffer) {
            plan_.usages[id] |= image ? of_image : of_buffer;
        };
        if (flags_[id] & (kExported | kPersistent))
            both(VK_IMAGE_USAGE_TRANSFER_SRC_BIT, VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
        if (flags_[id] & kPersistent)
            both(VK_IMAGE_USAGE_TRANSFER_DST_BIT, VK_BUFFER_USAGE_TRANSFER_DST_BIT);
    }
    for (ResourceId id = 0; id < flags_.size(); ++id)
        if ((flags_[id] & kPersistent) && source_of(id) != id) {
            // Ages change places, so they are created alike.
            const ResourceId first = id - declaration_.resources[id].history_age;
            plan_.usages[first] |= plan_.usages[id];
            plan_.usages[id] |= plan_.usages[first];
        }
    for (ResourceId id = 0; id < flags_.size(); ++id)
        if ((flags_[id] & kPersistent) && source_of(id) != id)
            plan_.usages[id] = plan_.usages[id - declaration_.resources[id].history_age];
}

} // namespace ockham::sync
