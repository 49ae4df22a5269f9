// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/compile/checks.hpp"
#include "framework/graph/describe.hpp"

#include <algorithm>

namespace ockham {

namespace {

/// Walks the passes forwards and knows, for each piece, under which guards something was written.
class ContentChecker {
public:
    ContentChecker(const Declaration& declaration, const Pieces& pieces)
        : declaration_(declaration), pieces_(pieces), content_(pieces.count(), kNothing) {
        for (PieceId piece = 0; piece < pieces.count(); ++piece)
            if (has_content(declaration.resources[pieces.resource_of(piece)]))
                content_[piece] = kAlways;
    }

    void run() {
        for (PassId id = 0; id < declaration_.passes.size(); ++id) {
            for (const Use& use : declaration_.uses_of(id))
                if (needs_content(use)) check_read(id, use);
            for (const Use& use : declaration_.uses_of(id))
                if (writes(use.access)) add_write(declaration_.passes[id].guard, use);
        }
        for (ResourceId id = 0; id < declaration_.resources.size(); ++id)
            if (declaration_.resources[id].exported &&
                declaration_.resources[id].lifetime == Lifetime::transient)
                check_export(id);
    }

private:
    /// Content of a piece; other values: 2 + index into guarded_.
    static constexpr std::uint32_t kNothing = 0;
    static constexpr std::uint32_t kAlways = 1;

    template <class... Args>
    [[noreturn]] void fail(
        const char* code, fmt::format_string<Args...> text, Args&&... args) const {
        fail_misuse(declaration_, code, text, std::forward<Args>(args)...);
    }

    /// Before the first pass.
    static bool has_content(const ResourceDecl& resource) {
        if (resource.lifetime != Lifetime::external)
            return resource.lifetime == Lifetime::persistent;
        return resource.kind == ResourceKind::buffer ||
               resource.entry.layout != VK_IMAGE_LAYOUT_UNDEFINED;
    }

    void check_read(PassId id, const Use& use) const {
        const PassDecl& pass = declaration_.passes[id];
        const ResourceDecl& resource = declaration_.resources[use.resource];
        pieces_.each(use, [&](PieceId piece) {
            if (content_[piece] == kNothing) fail_unwritten(id, use);
            if (content_[piece] == kAlways || covers(guarded_[content_[piece] - 2], pass.guard))
                return;
            fail("conditional-content",
                "{} reads {}, which is written only where {}; write it in the other case too, or "
                "read it under the same condition",
                describe(pass), describe(resource), text_of(guarded_[content_[piece] - 2]));
        });
    }

    /// Nobody wrote what `use` reads. If only a later pass does, which itself waits for this one,
    /// no order of passes helps.
    [[noreturn]] void fail_unwritten(PassId id, const Use& use) const {
        const PassDecl& pass = declaration_.passes[id];
        const ResourceDecl& resource = declaration_.resources[use.resource];
        if (resource.lifetime == Lifetime::external)
            fail("import-without-layout",
                "{} reads {}, imported in layout UNDEFINED, which has no content; import it in the "
                "layout that it is in",
                describe(pass), describe(resource));
        const std::vector<PassId> needs = dependents(id);
        for (PassId later = id + 1; later < declaration_.passes.size(); ++later) {
            for (const Use& other : declaration_.uses_of(later)) {
                if (other.resource != use.resource || !writes(other.access)) continue;
                const PassDecl& writer = declaration_.passes[later];
                if (needs[later] != kNone)
                    fail("cycle",
                        "{} reads {}, which only {} writes, which itself needs what {} makes; "
                        "break the circle by a persistent resource or a history",
                        describe(pass), describe(resource), describe(writer),
                        describe(declaration_.passes[needs[later]]));
                fail("read-before-write",
                    "{} reads {}, which no earlier pass writes; add {}, which does, before it",
                    describe(pass), describe(resource), describe(writer));
            }
        }
        fail("read-before-write",
            "{} reads {}, which no earlier pass writes; write it first, or make it persistent",
            describe(pass), describe(resource));
    }

    /// For each pass, one that it reads from and that depends on `root`, or is it; kNone if none.
    std::vector<PassId> dependents(PassId root) const {
        std::vector<PassId> through(declaration_.passes.size(), kNone);
        std::vector<PassId> writer(declaration_.resources.size(), kNone);
        for (PassId id = root; id < declaration_.passes.size(); ++id) {
            for (const Use& use : declaration_.uses_of(id))
                if (id != root && needs_content(use) && writer[use.resource] != kNone)
                    through[id] = writer[use.resource];
            if (id != root && through[id] == kNone) continue;
            for (const Use& use : declaration_.uses_of(id))
                if (writes(use.access)) writer[use.resource] = id;
        }
        return through;
    }

    void check_export(ResourceId id) const {
        const ResourceDecl& resource = declaration_.resources[id];
        bool any = false;
        pieces_.each(
            Use{.resource = id}, [&](PieceId piece) { any |= content_[piece] != kNothing; });
        if (!any)
            fail("export-before-write",
                "{} is exported ({}), but no pass writes it; write it or drop the export",
                describe(resource), resource.export_reason);
        pieces_.each(Use{.resource = id}, [&](PieceId piece) {
            if (content_[piece] < 2) return;
            fail("conditional-content",
                "{} is exported ({}), but written only where {}; write it in the other case too",
                describe(resource), resource.export_reason, text_of(guarded_[content_[piece] - 2]));
        });
    }

    void add_write(GuardId guard, const Use& use) {
        pieces_.each(use, [&](PieceId piece) {
            std::uint32_t& content = content_[piece];
            if (guard == kNone) content = kAlways;
            if (content == kAlways) return;
            if (content == kNothing) {
                content = static_cast<std::uint32_t>(guarded_.size()) + 2;
                guarded_.emplace_back();
            }
            std::vector<GuardId>& guards = guarded_[content - 2];
            if (join(guards, guard)) content = kAlways;
        });
    }

    /// Adds a guard; two branches of one question make the guard around them. True: in every case.
    bool join(std::vector<GuardId>& guards, GuardId guard) const {
        if (std::find(guards.begin(), guards.end(), guard) != guards.end()) return false;
        const Guard& added = declaration_.guards[guard];
        const auto other = std::find_if(guards.begin(), guards.end(), [&](GuardId id) {
            const Guard& one = declaration_.guards[id];
            return one.condition == added.condition && one.parent == added.parent &&
                   one.wanted != added.wanted;
        });
        if (other == guards.end()) {
            guards.push_back(guard);
            return false;
        }
        guards.erase(other);
        return added.parent == kNone || join(guards, added.parent);
    }

    /// Whether a pass under `reader` runs only where one of `guards` holds.
    bool covers(const std::vector<GuardId>& guards, GuardId reader) const {
        for (GuardId id = reader; id != kNone; id = declaration_.guards[id].parent)
            if (std::find(guards.begin(), guards.end(), id) != guards.end()) return true;
        return false;
    }

    std::string text_of(const std::vector<GuardId>& guards) const {
        std::string text;
        for (const GuardId guard : guards) {
            if (!text.empty()) text += " or ";
            for (GuardId id = guard; id != kNone; id = declaration_.guards[id].parent) {
                const Guard& one = declaration_.guards[id];
                text += fmt::format("{}{} {}", id == guard ? "" : " and ",
                    describe(declaration_.conditions[one.condition]),
                    one.wanted ? "holds" : "does not hold");
            }
        }
        return text;
    }

    const Declaration& declaration_;
    const Pieces& pieces_;
    std::vector<std::uint32_t> content_; ///< per piece
    std::vector<std::vector<GuardId>> guarded_;
};

} // namespace

void check_content(const Declaration& declaration, const Pieces& pieces) {
    ContentChecker(declaration, pieces).run();
}

} // namespace ockham
