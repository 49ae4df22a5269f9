// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/explain/dependencies.hpp"

#include <algorithm>
#include <functional>

namespace ockham {

namespace {

/// What two ranges [first, first + count) have in common; count 0 where nothing.
template <class T>
void intersect(T& first, T& count, T other_first, T other_count) {
    const T end = std::min(first + count, other_first + other_count);
    first = std::max(first, other_first);
    count = end > first ? end - first : 0;
}

/// False where the two parts of one resource have nothing in common.
bool intersect(ResourceKind kind, Part& part, const Part& other) {
    if (kind == ResourceKind::buffer) {
        intersect(part.offset, part.bytes, other.offset, other.bytes);
        return part.bytes > 0;
    }
    intersect(part.first_mip, part.mips, other.first_mip, other.mips);
    intersect(part.first_layer, part.layers, other.first_layer, other.layers);
    return part.mips > 0 && part.layers > 0;
}

struct Touch {
    PassId pass = kNone;
    const Use* use = nullptr;
    Part part;
};

/// The dependencies of one use on those before it, back to the writes that hide what was earlier.
void depend(ResourceKind kind, const Touch& now, const std::vector<Touch>& before,
    std::vector<Dependency>& out) {
    for (auto old = before.rbegin(); old != before.rend(); ++old) {
        const bool writes_now = writes(now.use->access), wrote = writes(old->use->access);
        Part part = now.part;
        if (old->pass == now.pass || (!writes_now && !wrote) || !intersect(kind, part, old->part))
            continue;
        out.push_back({old->pass, now.pass, now.use->resource, part,
            !wrote                    ? Hazard::write_after_read
            : needs_content(*now.use) ? Hazard::read_after_write
                                      : Hazard::write_after_write});
        if (wrote && part == now.part) return;
    }
}

/// Which passes come before which, directly or not: a bit per pair.
class Reach {
public:
    explicit Reach(std::size_t passes) : words_((passes + 63) / 64), bits_(passes * words_, 0) {}
    bool has(PassId pass, PassId before) const {
        return bits_[pass * words_ + before / 64] >> (before % 64) & 1;
    }
    void add(PassId pass, PassId before) {
        std::uint64_t* const to = &bits_[pass * words_];
        const std::uint64_t* const from = &bits_[before * words_];
        std::transform(to, to + words_, from, to, std::bit_or<>());
        to[before / 64] |= std::uint64_t{1} << (before % 64);
    }

private:
    std::size_t words_;
    std::vector<std::uint64_t> bits_;
};

} // namespace

std::vector<Dependency> direct_dependencies(const Declaration& declaration, const Plan& plan) {
    std::vector<std::vector<Touch>> touches(declaration.resources.size());
    std::vector<Dependency> direct, all;
    Reach reach(plan.passes.size());
    for (PassId pass = 0; pass < plan.passes.size(); ++pass) {
        if (plan.passes[pass].culled) continue;
        all.clear();
        for (const Use& use : declaration.uses_of(pass)) {
            const Touch now{pass, &use, part_of(declaration, use)};
            depend(declaration.resources[use.resource].kind, now, touches[use.resource], all);
            touches[use.resource].push_back(now);
        }
        // From the latest: what an earlier one adds to `reach` only then is direct.
        std::stable_sort(all.begin(), all.end(),
            [](const Dependency& a, const Dependency& b) { return a.before > b.before; });
        for (std::size_t i = 0; i < all.size();) {
            const PassId before = all[i].before;
            const bool known = reach.has(pass, before);
            for (; i < all.size() && all[i].before == before; ++i)
                if (!known) direct.push_back(all[i]);
            reach.add(pass, before);
        }
    }
    return direct;
}

std::vector<std::span<const Dependency>> dependencies_of(
    std::span<const Dependency> direct, PassId after) {
    std::vector<std::span<const Dependency>> pairs;
    const auto own = std::ranges::equal_range(direct, after, {}, &Dependency::after);
    for (auto from = own.begin(); from != own.end();) {
        const auto to = std::find_if(
            from, own.end(), [&](const Dependency& one) { return one.before != from->before; });
        pairs.emplace_back(from, to);
        from = to;
    }
    return pairs;
}

} // namespace ockham
