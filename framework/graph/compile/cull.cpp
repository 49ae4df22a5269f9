// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/compile/phases.hpp"

#include <algorithm>

namespace ockham {

namespace {

/// Seen from one point of the program order: what comes of the content of a piece afterwards.
struct Demand {
    bool needed = false;
    PassId by = kNone;             ///< the next pass that reads it; kNone: whoever comes after
    PassId overwritten_by = kNone; ///< the next live pass that replaces it
    PassId culled_reader = kNone;  ///< the next pass that would read it, but is culled
};

/// Content that a later execution finds under another age.
constexpr std::uint8_t kFed = 2;

/// Why a write that somebody needs is needed.
Verdict kept_for(const Demand& demand, ResourceId id, const ResourceDecl& resource) {
    using enum Verdict::Cause;
    const Verdict::Cause cause = demand.by != kNone                        ? read
                                 : resource.exported                       ? exported
                                 : resource.lifetime == Lifetime::external ? external
                                                                           : persistent;
    return {false, cause, demand.by, kNone, id};
}

/// Why a write that nobody needs is worth nothing.
Verdict culled_for(const Demand& demand, ResourceId id) {
    using enum Verdict::Cause;
    if (demand.culled_reader != kNone) return {true, unread_too, demand.culled_reader, kNone, id};
    if (demand.overwritten_by != kNone)
        return {true, overwritten, demand.overwritten_by, kNone, id};
    return {true, unread, kNone, kNone, id};
}

/// Walks the passes backwards, from what the outside needs to what makes it.
class Culler {
public:
    Culler(const Declaration& declaration, const Pieces& pieces, Plan& plan)
        : declaration_(declaration), pieces_(pieces), plan_(plan),
          kept_content_(declaration.resources.size(), 0) {}

    void run() {
        bool has_rings = false;
        for (ResourceId id = 0; id < kept_content_.size(); ++id) {
            const ResourceDecl& resource = declaration_.resources[id];
            has_rings |= resource.history_depth != 0;
            kept_content_[id] = resource.exported || (resource.lifetime != Lifetime::transient &&
                                                         resource.history_depth == 0);
        }
        do walk();
        while (has_rings && feed_rings());
        collect_steps();
        judge_resources();
    }

private:
    void walk() {
        demands_.assign(pieces_.count(), {});
        for (PieceId piece = 0; piece < pieces_.count(); ++piece)
            demands_[piece].needed = kept_content_[pieces_.resource_of(piece)] != 0;
        plan_.passes.resize(declaration_.passes.size());
        for (auto id = static_cast<PassId>(declaration_.passes.size()); id-- > 0;) {
            plan_.passes[id] = judge(id);
            step_back(id);
        }
    }

    Verdict judge(PassId id) const {
        if (contradicts(declaration_.passes[id].guard))
            return {true, Verdict::Cause::contradiction, kNone, kNone, kNone};
        Verdict verdict{true, Verdict::Cause::writes_nothing, kNone, kNone, kNone};
        for (const Use& use : declaration_.uses_of(id)) {
            if (!writes(use.access)) continue;
            const Demand* wanted = nullptr;
            const Demand* unwanted = nullptr;
            pieces_.each(use, [&](PieceId piece) {
                const Demand*& found = demands_[piece].needed ? wanted : unwanted;
                if (!found) found = &demands_[piece];
            });
            if (wanted)
                return kept_for(*wanted, use.resource, declaration_.resources[use.resource]);
            if (verdict.resource == kNone) verdict = culled_for(*unwanted, use.resource);
        }
        if (!declaration_.passes[id].side_effect.empty())
            return {false, Verdict::Cause::side_effect, kNone, kNone, kNone};
        return verdict;
    }

    /// Whether a guard wants both answers to one question.
    bool contradicts(GuardId guard) const {
        for (; guard != kNone; guard = declaration_.guards[guard].parent) {
            const Guard& inner = declaration_.guards[guard];
            for (GuardId id = inner.parent; id != kNone; id = declaration_.guards[id].parent) {
                const Guard& outer = declaration_.guards[id];
                if (outer.condition == inner.condition && outer.wanted != inner.wanted) return true;
            }
        }
        return false;
    }

    /// Steps back over a pass: demands after it become demands before it. What it replaces first,
    /// then what it needs: it may do both to pieces of one resource. A guarded pass may not happen,
    /// so it replaces nothing.
    void step_back(PassId id) {
        const bool culled = plan_.passes[id].culled;
        const bool guarded = declaration_.passes[id].guard != kNone;
        if (!culled && !guarded)
            for (const Use& use : declaration_.uses_of(id))
                if (replaces_content(use))
                    pieces_.each(use, [&](PieceId piece) {
                        demands_[piece] = {false, kNone, id, kNone};
                    });
        for (const Use& use : declaration_.uses_of(id)) {
            if (!needs_content(use)) continue;
            pieces_.each(use, [&](PieceId piece) {
                if (culled)
                    demands_[piece].culled_reader = id;
                else
                    demands_[piece] = {true, id, kNone, kNone};
            });
        }
    }

    /// An age whose content an execution needs must have been kept as the age before it by the
    /// execution before. Least fixpoint: a ring that feeds only itself is dead. True if that adds
    /// anything.
    bool feed_rings() {
        bool added = false;
        for (PieceId piece = 0; piece < pieces_.count(); ++piece) {
            const ResourceId id = pieces_.resource_of(piece);
            const ResourceDecl& resource = declaration_.resources[id];
            if (resource.history_depth == 0 || !demands_[piece].needed) continue;
            const ResourceId before =
                resource.history_age == 0 ? id + resource.history_depth : id - 1;
            added |= kept_content_[before] != kFed;
            kept_content_[before] = kFed;
        }
        return added;
    }

    void collect_steps() {
        plan_.steps.reserve(plan_.passes.size());
        plan_.resources.assign(
            declaration_.resources.size(), {true, Verdict::Cause::unused, kNone, kNone, kNone});
        for (PassId id = 0; id < plan_.passes.size(); ++id) {
            if (plan_.passes[id].culled) continue;
            plan_.steps.push_back({.pass = id});
            for (const Use& use : declaration_.uses_of(id)) {
                Verdict& verdict = plan_.resources[use.resource];
                if (verdict.culled) verdict = {false, Verdict::Cause::used, id, id, kNone};
                verdict.last_pass = id;
            }
        }
    }

    /// A ring turns as a whole: where an older content is wanted or an older age is used, all ages
    /// are there.
    void judge_resources() {
        for (ResourceId first = 0; first < plan_.resources.size(); ++first) {
            const ResourceDecl& resource = declaration_.resources[first];
            if (resource.history_depth == 0 || resource.history_age != 0) continue;
            const ResourceId end = first + resource.history_depth + 1;
            bool turns = false;
            for (ResourceId id = first; id < end; ++id)
                turns |= kept_content_[id] == kFed || (id != first && !plan_.resources[id].culled);
            for (ResourceId id = first; turns && id < end; ++id)
                if (plan_.resources[id].culled)
                    plan_.resources[id] = {false, Verdict::Cause::ring, kNone, kNone, kNone};
        }
    }

    const Declaration& declaration_;
    const Pieces& pieces_;
    Plan& plan_;
    std::vector<Demand> demands_;            ///< per piece
    std::vector<std::uint8_t> kept_content_; ///< per resource: wanted after the execution, or kFed
};

} // namespace

void cull(const Declaration& declaration, const Pieces& pieces, Plan& plan) {
    Culler(declaration, pieces, plan).run();
}

} // namespace ockham
