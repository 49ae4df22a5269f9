// SPDX-License-Identifier: Apache-2.0
#include "framework/core/error.hpp"
#include "framework/graph/describe.hpp"
#include "framework/graph/phases.hpp"

#include <algorithm>
#include <bit>
#include <functional>
#include <span>

namespace ockham {

namespace {

/// Index of the first element whose name an earlier one has, and that earlier one; kNone if none.
template <class T>
std::pair<std::uint32_t, std::uint32_t> find_duplicate(const std::vector<T>& all) {
    const std::size_t mask = std::bit_ceil(2 * all.size() + 1) - 1;
    std::vector<std::uint32_t> table(mask + 1, kNone);
    for (std::uint32_t i = 0; i < all.size(); ++i) {
        std::size_t slot = std::hash<std::string_view>{}(all[i].name) & mask;
        for (; table[slot] != kNone; slot = (slot + 1) & mask)
            if (all[table[slot]].name == all[i].name) return {i, table[slot]};
        table[slot] = i;
    }
    return {kNone, kNone};
}

bool is_depth(VkFormat format) { return format == VK_FORMAT_D32_SFLOAT; }
bool is_sampled_only(VkFormat format) { return format == VK_FORMAT_E5B9G9R9_UFLOAT_PACK32; }
bool is_srgb(VkFormat format) {
    return format == VK_FORMAT_R8G8B8A8_SRGB || format == VK_FORMAT_B8G8R8A8_SRGB;
}
bool is_attachment(Access access) {
    return access == Access::color_attachment || access == Access::depth_attachment;
}
bool is_transfer(Access access) {
    return access == Access::transfer_read || access == Access::transfer_write;
}

/// Copies are illegal inside render passes; attachments and vertices make sense only there.
bool may_access(PassKind kind, Access access) {
    switch (kind) {
    case PassKind::compute:
        return !is_attachment(access) && access != Access::vertex && access != Access::index;
    case PassKind::raster:
        return !is_transfer(access);
    case PassKind::transfer:
        return is_transfer(access);
    }
    return false;
}

/// Checks one declaration, front to back.
class Validator {
public:
    Validator(const Declaration& declaration, const Capabilities& capabilities)
        : declaration_(declaration), capabilities_(capabilities),
          written_(declaration.resources.size(), 0),
          last_use_(declaration.resources.size(), kNone) {}

    void run() {
        for (const Misuse& misuse : declaration_.misuses)
            fail_input("[{}] {}", misuse.code, misuse.text);
        check_names();
        for (const ResourceDecl& resource : declaration_.resources) {
            if (resource.kind == ResourceKind::buffer)
                check_buffer(resource);
            else
                check_image(resource);
        }
        for (const PassDecl& pass : declaration_.passes) check_pass(pass);
        for (std::size_t i = 0; i < declaration_.resources.size(); ++i) {
            const ResourceDecl& resource = declaration_.resources[i];
            if (resource.exported && resource.lifetime == Lifetime::transient && !written_[i])
                fail("export-before-write",
                    "{} is exported ({}), but no pass writes it; write it or drop the export",
                    describe(resource), resource.export_reason);
        }
    }

private:
    template <class... Args>
    [[noreturn]] void fail(
        const char* code, fmt::format_string<Args...> text, Args&&... args) const {
        fail_input("[{}] graph '{}': {}", code, declaration_.name,
            fmt::format(text, std::forward<Args>(args)...));
    }

    void check_names() const {
        const auto nameless = [](const auto& all) {
            return std::find_if(
                all.begin(), all.end(), [](const auto& one) { return one.name.empty(); });
        };
        const auto pass = nameless(declaration_.passes);
        if (pass != declaration_.passes.end())
            fail("missing-name", "{} has no name; give it one", describe(*pass));
        const auto resource = nameless(declaration_.resources);
        if (resource != declaration_.resources.end())
            fail("missing-name", "{} has no name; give it one", describe(*resource));
        if (const auto [second, first] = find_duplicate(declaration_.passes); second != kNone)
            fail("duplicate-pass", "{} has the name of {}; rename one",
                describe(declaration_.passes[second]), describe(declaration_.passes[first]));
        if (const auto [second, first] = find_duplicate(declaration_.resources); second != kNone)
            fail("duplicate-resource", "{} has the name of {}; rename one",
                describe(declaration_.resources[second]), describe(declaration_.resources[first]));
    }

    void check_buffer(const ResourceDecl& resource) const {
        const std::uint64_t bytes = resource.buffer.bytes;
        if (bytes == 0) fail("bad-size", "{} has 0 bytes; ask for at least 1", describe(resource));
        if (bytes > capabilities_.max_buffer_bytes)
            fail("bad-size", "{} has {} bytes, the device allows {}; split it", describe(resource),
                bytes, capabilities_.max_buffer_bytes);
    }

    void check_image(const ResourceDecl& resource) const {
        const ImageDesc& image = resource.image;
        const std::uint32_t largest = std::max({image.width, image.height, image.depth});
        if (std::min({image.width, image.height, image.depth, image.layers, image.mips}) == 0)
            fail("bad-size", "{} is {}x{}x{} with {} layers and {} mips; each must be at least 1",
                describe(resource), image.width, image.height, image.depth, image.layers,
                image.mips);
        if (largest > capabilities_.max_image_extent)
            fail("bad-size", "{} is {}x{}x{}, the device allows {} per axis; make it smaller",
                describe(resource), image.width, image.height, image.depth,
                capabilities_.max_image_extent);
        if (image.depth > 1 && image.layers > 1)
            fail("bad-size", "{} has depth {} and {} layers; a 3D image has one layer",
                describe(resource), image.depth, image.layers);
        if (image.mips > static_cast<std::uint32_t>(std::bit_width(largest)))
            fail("bad-size", "{} is {}x{}x{} with {} mips; that size has at most {}",
                describe(resource), image.width, image.height, image.depth, image.mips,
                std::bit_width(largest));
        if (texel_bytes(image.format) == 0)
            fail("bad-format", "{} has format {}, which format.hpp does not know; use another",
                describe(resource), format_text(image.format));
    }

    void check_pass(const PassDecl& pass) {
        const std::span uses(declaration_.uses.data() + pass.first_use, pass.use_count);
        for (const Use& use : uses) {
            const ResourceDecl& resource = declaration_.resources[use.resource];
            check_kind(pass, use, resource);
            check_binding(pass, use, resource, uses);
            if (resource.kind == ResourceKind::image) check_format(pass, use, resource);
            check_content(pass, use, resource);
            check_once(pass, use, resource);
        }
        if (pass.kind == PassKind::raster) check_attachments(pass, uses);
    }

    /// Whether a pass of this kind can make this access, in this stage, of this kind of resource.
    void check_kind(const PassDecl& pass, const Use& use, const ResourceDecl& resource) const {
        const bool image = resource.kind == ResourceKind::image;
        if (image ? image_usage(use.access) == 0 : buffer_usage(use.access) == 0)
            fail("wrong-access", "{} uses {} as {}, which {} cannot be", describe(pass),
                describe(resource), name_of(use.access), image ? "an image" : "a buffer");
        if (!may_access(pass.kind, use.access))
            fail("wrong-access", "{} is a {} pass and uses {} as {}; move that to another pass",
                describe(pass), name_of(pass.kind), describe(resource), name_of(use.access));
        if (!in_shader(use.access)) return;
        const bool raster = pass.kind == PassKind::raster;
        const bool fits = raster ? use.stage == Stage::vertex || use.stage == Stage::fragment
                                 : use.stage == Stage::compute;
        if (!fits)
            fail("wrong-stage", "{} is a {} pass and uses {} in the {} stage; name {}",
                describe(pass), name_of(pass.kind), describe(resource), name_of(use.stage),
                raster ? "Stage::vertex or Stage::fragment" : "Stage::compute");
    }

    void check_binding(const PassDecl& pass, const Use& use, const ResourceDecl& resource,
        std::span<const Use> uses) const {
        if (!in_shader(use.access)) return;
        const std::string& binding = declaration_.detail_of(use).binding;
        if (binding.empty())
            fail("missing-binding", "{} uses {} as {} without a name in its shader; give one",
                describe(pass), describe(resource), name_of(use.access));
        for (const Use& other : uses) {
            if (&other == &use) break;
            if (other.resource != use.resource && declaration_.detail_of(other).binding == binding)
                fail("duplicate-binding", "{} binds both {} and {} to '{}'; rename one",
                    describe(pass), describe(declaration_.resources[other.resource]),
                    describe(resource), binding);
        }
    }

    void check_format(const PassDecl& pass, const Use& use, const ResourceDecl& resource) const {
        const VkFormat format = resource.image.format;
        const bool storage = image_usage(use.access) == VK_IMAGE_USAGE_STORAGE_BIT;
        const bool bad =
            (storage && (is_depth(format) || is_srgb(format) || is_sampled_only(format))) ||
            (use.access == Access::color_attachment &&
                (is_depth(format) || is_sampled_only(format))) ||
            (use.access == Access::depth_attachment && !is_depth(format));
        if (bad)
            fail("bad-format", "{} uses {} as {}, which its format {} does not allow; choose {}",
                describe(pass), describe(resource), name_of(use.access), format_text(format),
                use.access == Access::depth_attachment ? "D32_SFLOAT" : "a linear colour format");
    }

    /// The content that a use depends on must exist.
    void check_content(const PassDecl& pass, const Use& use, const ResourceDecl& resource) {
        std::uint8_t& written = written_[use.resource];
        if (!written && needs_content(use)) {
            if (resource.lifetime == Lifetime::transient)
                fail("read-before-write",
                    "{} reads {}, which no earlier pass writes; write it first, or make it "
                    "persistent",
                    describe(pass), describe(resource));
            if (resource.lifetime == Lifetime::external && resource.kind == ResourceKind::image &&
                resource.entry.layout == VK_IMAGE_LAYOUT_UNDEFINED)
                fail("import-without-layout",
                    "{} reads {}, imported in layout UNDEFINED, which has no content; import it "
                    "in the layout that it is in",
                    describe(pass), describe(resource));
        }
        if (writes(use.access)) written = 1;
    }

    /// A pass may use a resource several times only to read it, an image in one layout.
    void check_once(const PassDecl& pass, const Use& use, const ResourceDecl& resource) {
        const std::uint32_t previous = last_use_[use.resource];
        last_use_[use.resource] = static_cast<std::uint32_t>(&use - declaration_.uses.data());
        if (previous == kNone || previous < pass.first_use) return;
        const Use& other = declaration_.uses[previous];
        const bool same_layout =
            resource.kind == ResourceKind::buffer ||
            state_of(use.access, use.stage).layout == state_of(other.access, other.stage).layout;
        if (writes(use.access) || writes(other.access) || !same_layout)
            fail("used-twice", "{} uses {} as {} and as {}; use read_write once, or split the pass",
                describe(pass), describe(resource), name_of(other.access), name_of(use.access));
    }

    /// Attachments are 2D, one mip, one layer, all of one size.
    void check_attachments(const PassDecl& pass, std::span<const Use> uses) const {
        const ResourceDecl* first = nullptr;
        const ResourceDecl* depth = nullptr;
        for (const Use& use : uses) {
            if (!is_attachment(use.access)) continue;
            const ResourceDecl& resource = declaration_.resources[use.resource];
            const ImageDesc& image = resource.image;
            if (image.depth != 1 || image.layers != 1 || image.mips != 1)
                fail("attachment-shape",
                    "{} draws to {}, which has depth {}, {} layers and {} mips; an attachment "
                    "has one of each",
                    describe(pass), describe(resource), image.depth, image.layers, image.mips);
            if (use.access == Access::depth_attachment) {
                if (depth)
                    fail("attachment-shape", "{} has two depth attachments, {} and {}; keep one",
                        describe(pass), describe(*depth), describe(resource));
                depth = &resource;
            }
            if (!first) first = &resource;
            if (image.width != first->image.width || image.height != first->image.height)
                fail("attachment-extent",
                    "{} draws to {} of {}x{} and {} of {}x{}; make them equal", describe(pass),
                    describe(*first), first->image.width, first->image.height, describe(resource),
                    image.width, image.height);
        }
        if (!first)
            fail("no-attachment", "{} is a raster pass without color() or depth(); add one",
                describe(pass));
    }

    const Declaration& declaration_;
    const Capabilities& capabilities_;
    std::vector<std::uint8_t> written_;   ///< per resource: some pass so far writes it
    std::vector<std::uint32_t> last_use_; ///< per resource: index of its latest use so far
};

} // namespace

Pieces validate(const Declaration& declaration, const Capabilities& capabilities) {
    Validator(declaration, capabilities).run();
    return Pieces(declaration);
}

} // namespace ockham
