// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/compile/drafts.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace ockham {

namespace {

/// Makes `a` the union of both if that is one part.
bool unite(Part& a, const Part& b, bool image) {
    if (!image) {
        if (a.offset + a.bytes == b.offset)
            a.bytes += b.bytes;
        else if (b.offset + b.bytes == a.offset)
            a = {.offset = b.offset, .bytes = a.bytes + b.bytes};
        else
            return false;
        return true;
    }
    if (a.first_layer == b.first_layer && a.layers == b.layers &&
        a.first_mip + a.mips == b.first_mip) {
        a.mips += b.mips;
        return true;
    }
    if (a.first_mip == b.first_mip && a.mips == b.mips &&
        a.first_layer + a.layers == b.first_layer) {
        a.layers += b.layers;
        return true;
    }
    return false;
}

bool same_batch(const Draft& a, const Draft& b) {
    return a.step == b.step && a.release == b.release;
}

} // namespace

void sort(Plan& plan, std::vector<Draft>& drafts) {
    std::vector<std::uint32_t> order(drafts.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return std::pair{drafts[a].step, drafts[a].release} <
               std::pair{drafts[b].step, drafts[b].release};
    });
    std::vector<Barrier> sorted_barriers;
    std::vector<Draft> sorted_drafts;
    for (const std::uint32_t i : order) {
        sorted_barriers.push_back(plan.barriers[i]);
        sorted_drafts.push_back(drafts[i]);
    }
    plan.barriers = std::move(sorted_barriers);
    drafts = std::move(sorted_drafts);
}

namespace {

class Merger {
public:
    Merger(const Declaration& declaration, Plan& plan, std::vector<Draft>& drafts,
        std::vector<Past>& pasts)
        : declaration_(declaration), plan_(plan), drafts_(drafts), pasts_(pasts) {}

    /// Those of one batch, until no two are left that make one.
    void merge(std::size_t first, std::size_t end) {
        for (bool again = true; again;) {
            again = false;
            for (std::size_t i = first; i < end; ++i)
                for (std::size_t k = first; k < i; ++k) again |= join(k, i);
        }
    }

private:
    /// Makes the barrier at `other` part of that at `into`, if they differ in their parts only.
    bool join(std::size_t into, std::size_t other) {
        Barrier &a = plan_.barriers[into], &b = plan_.barriers[other];
        Draft &x = drafts_[into], &y = drafts_[other];
        if (a.resource != b.resource || x.dead || y.dead || x.light != y.light) return false;
        Barrier alike = b;
        alike.part = a.part;
        alike.from = a.from;
        const bool image = declaration_.resources[a.resource].kind == ResourceKind::image;
        if (alike != a || !unite(a.part, b.part, image)) return false;
        if (y.from_when > x.from_when) {
            x.from_when = y.from_when;
            a.from = b.from;
        }
        append_pasts(x, y);
        y.dead = true;
        return true;
    }

    void append_pasts(Draft& x, const Draft& y) {
        if (x.first_past + x.past_count != y.first_past && y.past_count) { // copies at the end
            const auto first = static_cast<std::uint32_t>(pasts_.size());
            for (std::uint32_t i = 0; i < x.past_count; ++i)
                pasts_.push_back(Past(pasts_[x.first_past + i]));
            for (std::uint32_t i = 0; i < y.past_count; ++i)
                pasts_.push_back(Past(pasts_[y.first_past + i]));
            x.first_past = first;
        }
        x.past_count += y.past_count;
    }

    const Declaration& declaration_;
    Plan& plan_;
    std::vector<Draft>& drafts_;
    std::vector<Past>& pasts_;
};

} // namespace

void merge(const Declaration& declaration, Plan& plan, std::vector<Draft>& drafts,
    std::vector<Past>& pasts) {
    Merger merger(declaration, plan, drafts, pasts);
    for (std::size_t first = 0, end = 0; first < drafts.size(); first = end) {
        for (end = first; end < drafts.size() && same_batch(drafts[end], drafts[first]); ++end) {
        }
        merger.merge(first, end);
    }
}

} // namespace ockham
