// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/compile/checks.hpp"
#include "framework/graph/describe.hpp"

#include <algorithm>
#include <utility>

namespace ockham {

namespace {

/// What every device accepts as the offset of a buffer in a shader: the largest of the required
/// limits of minStorageBufferOffsetAlignment and minUniformBufferOffsetAlignment.
constexpr std::uint64_t kBindingAlignment = 256;

bool is_depth(VkFormat format) {
    return format == VK_FORMAT_D32_SFLOAT || format == VK_FORMAT_S8_UINT;
}
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

/// "mips 1 to 2 of layers 0 to 5", "bytes 256 to 511"
std::string text_of(const ResourceDecl& resource, const Part& part) {
    const auto text = [](const char* what, std::uint64_t first, std::uint64_t count,
                          std::uint64_t rest) {
        if (count == rest && first == 0) return fmt::format("all {}s", what);
        if (count == rest) return fmt::format("{}s from {} on", what, first);
        if (count == 0) return fmt::format("no {}s", what);
        return count == 1 ? fmt::format("{} {}", what, first)
                          : fmt::format("{}s {} to {}", what, first, first + count - 1);
    };
    if (resource.kind == ResourceKind::buffer) return text("byte", part.offset, part.bytes, kRest);
    return text("mip", part.first_mip, part.mips, kRestOfMips) + " of " +
           text("layer", part.first_layer, part.layers, kRestOfLayers);
}

/// Whether [first, first + count) is a part, not empty, of `size`.
bool is_inside(std::uint64_t first, std::uint64_t count, std::uint64_t rest, std::uint64_t size) {
    return first < size && count > 0 && (count == rest || count <= size - first);
}

class PassChecker {
public:
    PassChecker(const Declaration& declaration, const Capabilities& capabilities)
        : declaration_(declaration), max_extent_(capabilities.max_attachment_extent),
          last_use_(declaration.resources.size(), kNone),
          last_bound_(declaration.bindings.size(), kNone) {
        shapes_.reserve(declaration.resources.size());
        for (const ResourceDecl& resource : declaration.resources)
            shapes_.push_back({resource.kind, resource.image.format});
    }

    void check(PassId id) {
        const PassDecl& pass = declaration_.passes[id];
        const std::span uses = declaration_.uses_of(id);
        check_queue(pass);
        for (const Use& use : uses) {
            check_kind(pass, use);
            if (use.part != kNone) check_part(pass, use);
            check_binding(pass, use);
            if (is_image(use)) check_format(pass, use);
            check_twice(pass, use, uses);
        }
        if (pass.kind == PassKind::raster) check_attachments(pass, uses);
    }

private:
    template <class... Args>
    [[noreturn]] void fail(
        const char* code, fmt::format_string<Args...> text, Args&&... args) const {
        fail_misuse(declaration_, code, text, std::forward<Args>(args)...);
    }

    void check_queue(const PassDecl& pass) const {
        const bool fits =
            pass.queue == QueueWish::main ||
            (pass.queue == QueueWish::async_compute && pass.kind != PassKind::raster) ||
            (pass.queue == QueueWish::transfer && pass.kind == PassKind::transfer);
        if (!fits)
            fail("wrong-queue",
                "{} is a {} pass and wishes for the {} queue, which cannot run it; "
                "leave it on the main queue",
                describe(pass), name_of(pass.kind), name_of(pass.queue));
    }

    bool is_image(const Use& use) const {
        return shapes_[use.resource].kind == ResourceKind::image;
    }
    std::uint32_t index_of(const Use& use) const {
        return static_cast<std::uint32_t>(&use - declaration_.uses.data());
    }
    const ResourceDecl& resource_of(const Use& use) const {
        return declaration_.resources[use.resource];
    }

    /// Whether a pass of this kind can make this access, in this stage, of this kind of resource.
    void check_kind(const PassDecl& pass, const Use& use) const {
        const bool image = is_image(use);
        if (image ? image_usage(use.access) == 0 : buffer_usage(use.access) == 0)
            fail("wrong-access", "{} uses {} as {}, which {} cannot be", describe(pass),
                describe(resource_of(use)), name_of(use.access), image ? "an image" : "a buffer");
        if (!may_access(pass.kind, use.access))
            fail("wrong-access", "{} is a {} pass and uses {} as {}; move that to another pass",
                describe(pass), name_of(pass.kind), describe(resource_of(use)),
                name_of(use.access));
        if (!in_shader(use.access)) return;
        const bool raster = pass.kind == PassKind::raster;
        const bool fits = raster ? use.stage == Stage::vertex || use.stage == Stage::fragment
                                 : use.stage == Stage::compute;
        if (!fits)
            fail("wrong-stage", "{} is a {} pass and uses {} in the {} stage; name {}",
                describe(pass), name_of(pass.kind), describe(resource_of(use)), name_of(use.stage),
                raster ? "Stage::vertex or Stage::fragment" : "Stage::compute");
    }

    void check_part(const PassDecl& pass, const Use& use) const {
        const ResourceDecl& resource = resource_of(use);
        const Part& part = declaration_.parts[use.part];
        const bool buffer = resource.kind == ResourceKind::buffer;
        const bool inside =
            buffer ? is_inside(part.offset, part.bytes, kRest, resource.buffer.bytes)
                   : is_inside(part.first_mip, part.mips, kRestOfMips, resource.image.mips) &&
                         is_inside(
                             part.first_layer, part.layers, kRestOfLayers, resource.image.layers);
        if (!inside)
            fail("bad-part", "{} uses {} of {}, which has {}", describe(pass),
                text_of(resource, part), describe(resource),
                buffer ? fmt::format("{} bytes", resource.buffer.bytes)
                       : fmt::format(
                             "{} mips and {} layers", resource.image.mips, resource.image.layers));
        if (buffer && in_shader(use.access) && part.offset % kBindingAlignment != 0)
            fail("misaligned-part",
                "{} binds {} from byte {} on, which is no multiple of {}; portable offsets are",
                describe(pass), describe(resource), part.offset, kBindingAlignment);
        if (buffer && !in_shader(use.access) && part.offset % 4 != 0)
            fail("misaligned-part",
                "{} uses {} from byte {} on, which is no multiple of 4; indices, arguments and "
                "copies start at one",
                describe(pass), describe(resource), part.offset);
    }

    void check_binding(const PassDecl& pass, const Use& use) {
        if (!in_shader(use.access)) return;
        if (use.binding == kNone)
            fail("missing-binding", "{} uses {} as {} without a name in its shader; give one",
                describe(pass), describe(resource_of(use)), name_of(use.access));
        const std::uint32_t previous = std::exchange(last_bound_[use.binding], index_of(use));
        if (previous == kNone || previous < pass.first_use) return;
        const Use& other = declaration_.uses[previous];
        if (other.resource != use.resource ||
            part_of(declaration_, other) != part_of(declaration_, use))
            fail("duplicate-binding", "{} binds both {} and {} to '{}'; rename one", describe(pass),
                what_of(other), what_of(use), declaration_.binding_of(use));
    }

    std::string what_of(const Use& use) const {
        const ResourceDecl& resource = declaration_.resources[use.resource];
        if (use.part == kNone) return describe(resource);
        return fmt::format(
            "{} of {}", text_of(resource, declaration_.parts[use.part]), describe(resource));
    }

    void check_format(const PassDecl& pass, const Use& use) const {
        const VkFormat format = shapes_[use.resource].format;
        const bool storage = image_usage(use.access) == VK_IMAGE_USAGE_STORAGE_BIT;
        const bool bad =
            (storage && (is_depth(format) || is_srgb(format) || is_sampled_only(format))) ||
            (use.access == Access::color_attachment &&
                (is_depth(format) || is_sampled_only(format))) ||
            (use.access == Access::depth_attachment && !is_depth(format));
        if (bad)
            fail("bad-format", "{} uses {} as {}, which its format {} does not allow; choose {}",
                describe(pass), describe(resource_of(use)), name_of(use.access),
                format_text(format),
                use.access == Access::depth_attachment ? "D32_SFLOAT, or S8_UINT for stencil"
                                                       : "a linear colour format");
    }

    /// A pass may use the same part of a resource several times only to read it, an image in one
    /// layout.
    void check_twice(const PassDecl& pass, const Use& use, std::span<const Use> uses) {
        const std::uint32_t previous = std::exchange(last_use_[use.resource], index_of(use));
        if (previous == kNone || previous < pass.first_use) return;
        for (const Use& other : uses) {
            if (&other == &use) break;
            if (other.resource != use.resource || !overlap(other, use)) continue;
            const bool same_layout =
                !is_image(use) || state_of(use.access, use.stage).layout ==
                                      state_of(other.access, other.stage).layout;
            if (writes(use.access) || writes(other.access) || !same_layout)
                fail("used-twice",
                    "{} uses {} as {} and as {}; use read_write once, or split the pass",
                    describe(pass), describe(resource_of(use)), name_of(other.access),
                    name_of(use.access));
        }
    }

    bool overlap(const Use& a, const Use& b) const {
        if (a.part == kNone || b.part == kNone) return true;
        const Part p = part_of(declaration_, a), q = part_of(declaration_, b);
        if (declaration_.resources[a.resource].kind == ResourceKind::buffer)
            return p.offset < q.offset + q.bytes && q.offset < p.offset + p.bytes;
        return p.first_mip < q.first_mip + q.mips && q.first_mip < p.first_mip + p.mips &&
               p.first_layer < q.first_layer + q.layers && q.first_layer < p.first_layer + p.layers;
    }

    /// Attachments are one mip of one layer of 2D images, all of one size.
    void check_attachments(const PassDecl& pass, std::span<const Use> uses) const {
        const ResourceDecl* first = nullptr;
        const ResourceDecl* depth = nullptr;
        std::uint32_t first_width = 0, first_height = 0;
        for (const Use& use : uses) {
            if (!is_attachment(use.access)) continue;
            const ResourceDecl& resource = declaration_.resources[use.resource];
            const ImageDesc& image = resource.image;
            const Part part = part_of(declaration_, use);
            if (image.depth != 1 || part.layers != 1 || part.mips != 1)
                fail("attachment-shape",
                    "{} draws to {} mips and {} layers of {}, which has depth {}; an attachment is "
                    "one mip of one layer of depth 1: say which by mip() and layer()",
                    describe(pass), part.mips, part.layers, describe(resource), image.depth);
            if (use.access == Access::depth_attachment) {
                if (depth)
                    fail("attachment-shape", "{} has two depth attachments, {} and {}; keep one",
                        describe(pass), describe(*depth), describe(resource));
                depth = &resource;
            }
            const std::uint32_t width = std::max(image.width >> part.first_mip, 1u);
            const std::uint32_t height = std::max(image.height >> part.first_mip, 1u);
            if (std::max(width, height) > max_extent_)
                fail("bad-size",
                    "{} draws to {} of {}x{}, the device allows attachments of {} per axis; draw "
                    "in parts",
                    describe(pass), describe(resource), width, height, max_extent_);
            if (!first) {
                first = &resource;
                first_width = width;
                first_height = height;
            }
            if (width != first_width || height != first_height)
                fail("attachment-extent",
                    "{} draws to {} of {}x{} and {} of {}x{}; make them equal", describe(pass),
                    describe(*first), first_width, first_height, describe(resource), width, height);
        }
        if (!first)
            fail("no-attachment", "{} is a raster pass without color() or depth(); add one",
                describe(pass));
    }

    /// What the checks of every use ask of its resource, close together.
    struct Shape {
        ResourceKind kind;
        VkFormat format;
    };

    const Declaration& declaration_;
    std::vector<Shape> shapes_;             ///< per resource
    std::uint32_t max_extent_;              ///< of attachments
    std::vector<std::uint32_t> last_use_;   ///< per resource: index of its latest use so far
    std::vector<std::uint32_t> last_bound_; ///< per name of a binding: index of its latest use
};

} // namespace

void check_passes(const Declaration& declaration, const Capabilities& capabilities) {
    PassChecker checker(declaration, capabilities);
    for (PassId id = 0; id < declaration.passes.size(); ++id) checker.check(id);
}

} // namespace ockham
