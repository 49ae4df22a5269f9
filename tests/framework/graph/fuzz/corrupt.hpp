// SPDX-License-Identifier: Apache-2.0
// Damages declarations at random, as a wrong program or file would: stale versions, parts outside
// of their resource, cycles, indices of nothing, values of no enumerator.
#pragma once

#include "framework/core/rng.hpp"
#include "framework/graph/declaration.hpp"

#include <limits>
#include <utility>

namespace ockham {

class Corruption {
public:
    Corruption(std::uint64_t seed, Declaration& declaration) : rng_(seed, 3), d_(declaration) {
        for (std::uint32_t i = 0, count = 1 + rng_.below(3); i < count; ++i) corrupt();
    }

private:
    /// Likely and unlikely numbers.
    template <class T>
    T some_number(T near) {
        switch (rng_.below(6)) {
        case 0:
            return 0;
        case 1:
            return std::numeric_limits<T>::max();
        case 2:
            return static_cast<T>(near + 1);
        case 3:
            return static_cast<T>(near - 1);
        case 4:
            return static_cast<T>(rng_.below(32));
        default:
            return static_cast<T>(near ^ (T{1} << rng_.below(8 * sizeof(T))));
        }
    }
    template <class Enum>
    Enum some_enum() {
        return static_cast<Enum>(rng_.below(rng_.below(8) ? 14 : 256));
    }
    template <class T>
    T* some(std::vector<T>& all) {
        return all.empty() ? nullptr : &all[rng_.below(static_cast<std::uint32_t>(all.size()))];
    }

    void corrupt() {
        switch (rng_.below(10)) {
        case 0:
        case 1:
        case 2:
            if (Use* use = some(d_.uses)) corrupt(*use);
            break;
        case 3:
            if (PassDecl* pass = some(d_.passes)) corrupt(*pass);
            break;
        case 4:
        case 5:
            if (ResourceDecl* resource = some(d_.resources)) corrupt(*resource);
            break;
        case 6:
            if (Part* part = some(d_.parts)) corrupt(*part);
            break;
        case 7:
            if (Guard* guard = some(d_.guards)) corrupt(*guard);
            break;
        case 8: // a cycle, where one needs the other
            if (!d_.passes.empty()) std::swap(*some(d_.passes), *some(d_.passes));
            if (!d_.uses.empty() && rng_.below(2)) std::swap(*some(d_.uses), *some(d_.uses));
            break;
        case 9:
            shorten();
            break;
        }
    }

    void corrupt(Use& use) {
        switch (rng_.below(8)) {
        case 0:
            use.resource = some_number(use.resource);
            break;
        case 1:
            use.access = some_enum<Access>();
            break;
        case 2:
            use.stage = some_enum<Stage>();
            break;
        case 3:
            use.version = some_number(use.version);
            break;
        case 4:
            use.version_written = some_number(use.version_written);
            break;
        case 5:
            use.part = some_number(use.part);
            break;
        case 6:
            use.load = some_enum<LoadOp>();
            break;
        case 7:
            use.binding = some_number(use.binding);
            break;
        }
    }

    void corrupt(PassDecl& pass) {
        switch (rng_.below(6)) {
        case 0:
            pass.kind = some_enum<PassKind>();
            break;
        case 1:
            pass.queue = some_enum<QueueWish>();
            break;
        case 2:
            pass.guard = some_number(pass.guard);
            break;
        case 3:
            pass.first_use = some_number(pass.first_use);
            break;
        case 4:
            pass.use_count = some_number(pass.use_count);
            break;
        case 5:
            pass.name = rng_.below(2) ? "" : some(d_.passes)->name;
            break;
        }
    }

    void corrupt(ResourceDecl& resource) {
        ImageDesc& image = resource.image;
        switch (rng_.below(10)) {
        case 0:
            resource.kind = some_enum<ResourceKind>();
            break;
        case 1:
            resource.lifetime = some_enum<Lifetime>();
            break;
        case 2:
            resource.buffer.bytes = some_number(resource.buffer.bytes);
            break;
        case 3:
            image.format = static_cast<VkFormat>(rng_.below(200));
            break;
        case 4:
            image.mips = some_number(image.mips);
            break;
        case 5:
            image.layers = some_number(image.layers);
            break;
        case 6:
            (rng_.below(2) ? image.width : image.depth) = some_number(image.height);
            break;
        case 7:
            resource.history_depth = some_number(resource.history_depth);
            break;
        case 8:
            resource.history_age = some_number(resource.history_age);
            break;
        case 9:
            resource.exported = !resource.exported;
            break;
        }
    }

    void corrupt(Part& part) {
        switch (rng_.below(6)) {
        case 0:
            part.offset = some_number(part.offset);
            break;
        case 1:
            part.bytes = some_number(part.bytes);
            break;
        case 2:
            part.first_mip = some_number(part.first_mip);
            break;
        case 3:
            part.mips = some_number(part.mips);
            break;
        case 4:
            part.first_layer = some_number(part.first_layer);
            break;
        case 5:
            part.layers = some_number(part.layers);
            break;
        }
    }

    void corrupt(Guard& guard) {
        if (rng_.below(2))
            guard.condition = some_number(guard.condition);
        else
            guard.parent = some_number(guard.parent);
    }

    void shorten() {
        switch (rng_.below(5)) {
        case 0:
            if (!d_.uses.empty()) d_.uses.pop_back();
            break;
        case 1:
            if (!d_.clears.empty()) d_.clears.pop_back();
            break;
        case 2:
            if (!d_.parts.empty()) d_.parts.pop_back();
            break;
        case 3:
            if (!d_.passes.empty()) d_.passes.pop_back();
            break;
        case 4:
            if (!d_.resources.empty()) d_.resources.pop_back();
            break;
        }
    }

    Pcg32 rng_;
    Declaration& d_;
};

} // namespace ockham
