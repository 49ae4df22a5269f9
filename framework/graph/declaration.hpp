// SPDX-License-Identifier: Apache-2.0
// What a graph declares, as plain data: passes, resources, and who uses which how. Input of
// compile(); built by Graph (graph.hpp), never by hand except in tests. Knows no device.
#pragma once

#include "framework/graph/access.hpp"

#include <array>
#include <cstdint>
#include <functional>
#include <source_location>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace ockham {

using ResourceId = std::uint32_t;  ///< index into Declaration::resources
using PassId = std::uint32_t;      ///< index into Declaration::passes
using ConditionId = std::uint32_t; ///< index into Declaration::conditions
using GuardId = std::uint32_t;     ///< index into Declaration::guards
inline constexpr std::uint32_t kNone = ~std::uint32_t{0};

enum class ResourceKind : std::uint8_t { buffer, image };

/// How long content lives.
enum class Lifetime : std::uint8_t {
    transient,  ///< inside one execution; memory is shared with others that are dead by then
    persistent, ///< owned by the graph, content survives from one execution to the next
    external,   ///< owned by the caller, who says in which state it comes and must be left
};

struct BufferDesc {
    std::uint64_t bytes = 0; ///< >= 1

    bool operator==(const BufferDesc&) const = default;
};

struct ImageDesc {
    VkFormat format = VK_FORMAT_UNDEFINED;
    std::uint32_t width = 1;
    std::uint32_t height = 1;
    std::uint32_t depth = 1;  ///< > 1: a 3D image
    std::uint32_t layers = 1; ///< > 1: an array
    std::uint32_t mips = 1;

    bool operator==(const ImageDesc&) const = default;
};

/// A part of a buffer in bytes, or of an image in mips and layers. `kRest`: up to the end.
inline constexpr std::uint64_t kRest = ~std::uint64_t{0};
inline constexpr std::uint32_t kRestOfMips = ~std::uint32_t{0};
inline constexpr std::uint32_t kRestOfLayers = ~std::uint32_t{0};
struct Part {
    std::uint64_t offset = 0; ///< buffers: bytes
    std::uint64_t bytes = kRest;
    std::uint32_t first_mip = 0, mips = kRestOfMips; ///< images
    std::uint32_t first_layer = 0, layers = kRestOfLayers;

    bool operator==(const Part&) const = default;
};

/// Memory that a resource takes. Filled by the runtime from the device, else estimated from the
/// description (estimate_memory in compile.hpp), so that plans can be made without a device.
struct MemoryNeed {
    std::uint64_t bytes = 0;
    std::uint64_t alignment = 1;
    std::uint32_t type_bits = ~std::uint32_t{0};
};

struct ResourceDecl {
    std::string name;
    ResourceKind kind = ResourceKind::buffer;
    Lifetime lifetime = Lifetime::transient;
    BufferDesc buffer;
    ImageDesc image;
    MemoryNeed memory;
    /// Content is wanted after the execution: keeps its producers alive and its memory unshared.
    bool exported = false;
    std::string export_reason;
    /// External only: state on entry and the state to leave it in (layout UNDEFINED = as last
    /// used).
    AccessState entry;
    AccessState exit;
    /// Histories: a ring of persistent resources with consecutive ids, the present one first. After
    /// each execution what was `age` becomes `age + 1`, and the oldest is written next.
    std::uint32_t history_depth = 0; ///< previous contents kept; 0: no history
    std::uint32_t history_age = 0;   ///< 0: the present one
    std::source_location where;
};

/// How a sampled image is filtered. `texel`: nearest and clamped, for texelFetch.
enum class Filter : std::uint8_t { texel, linear_clamp, linear_repeat };

enum class LoadOp : std::uint8_t { discard, clear, load };

/// One pass touches one resource, or part of it, once.
struct Use {
    ResourceId resource = kNone;
    Access access = Access::sampled;
    Stage stage = Stage::compute;
    LoadOp load = LoadOp::discard; ///< attachments only
    Filter filter = Filter::texel; ///< sampled images only; linear is trilinear across mips
    /// Version seen (the content before this pass) and, for writes, version made.
    std::uint32_t version = 0;
    std::uint32_t version_written = kNone;
    std::uint32_t part = kNone; ///< index into Declaration::parts; kNone: all of the resource
    /// Name in the shader that this use is bound to: index into Declaration::bindings; kNone: no
    /// shader names it.
    std::uint32_t binding = kNone;
};

/// Clear value of an attachment: four floats, or depth in [0].
using ClearValue = std::array<float, 4>;

/// Texts, each kept once and told from others by its index.
class Names {
public:
    /// Index of the text, which is new or was added before.
    std::uint32_t add(std::string_view text);
    const std::string& operator[](std::uint32_t index) const { return texts_[index]; }
    std::size_t size() const { return texts_.size(); }

private:
    struct Hash : std::hash<std::string_view> {
        using is_transparent = void;
    };
    std::vector<std::string> texts_;
    std::unordered_map<std::string, std::uint32_t, Hash, std::equal_to<>> index_;
};

/// Whether the pass depends on the content before it; an attachment does only when loaded.
inline bool needs_content(const Use& use) {
    if (use.access == Access::color_attachment || use.access == Access::depth_attachment)
        return use.load == LoadOp::load;
    return reads(use.access);
}
/// Whether nothing of the content before it is left after the pass. A copy or fill may be partial.
inline bool replaces_content(const Use& use) {
    return writes(use.access) && use.access != Access::transfer_write && !needs_content(use);
}

enum class PassKind : std::uint8_t { compute, raster, transfer };

/// Which queue a pass would rather run on, beside the main one. A wish: where the device has no
/// such queue, or the policy forbids it, the pass runs on the main queue.
enum class QueueWish : std::uint8_t { main, async_compute, transfer };

/// A question that the caller answers before each execution; passes may depend on it.
struct ConditionDecl {
    std::string name;
    std::source_location where;
};

/// "Only where `condition` is `wanted`, inside of `parent`". Passes without the guard's consent
/// record nothing in that execution; what they would write keeps its content.
struct Guard {
    ConditionId condition = kNone;
    bool wanted = true;
    GuardId parent = kNone;

    bool operator==(const Guard&) const = default;
};

struct PassDecl {
    std::string name;
    PassKind kind = PassKind::compute;
    QueueWish queue = QueueWish::main;
    GuardId guard = kNone;       ///< kNone: in every execution
    std::uint32_t first_use = 0; ///< uses of a pass are contiguous in Declaration::uses
    std::uint32_t use_count = 0;
    std::string reason;      ///< why the scene needs it, in the words of who added it
    std::string side_effect; ///< non-empty: never culled, and why
    std::source_location where;
};

/// Something that was deliberately not declared, so that plans can say why it is absent.
struct Omission {
    std::string name;
    bool is_pass = true; ///< else a resource
    std::string reason;
};

/// A mistake found while declaring; compile() throws the first.
struct Misuse {
    const char* code = ""; ///< stable, e.g. "stale-handle"; docs/graph.md lists them
    std::string text;
};

struct Declaration {
    std::string name;
    std::vector<PassDecl> passes;
    std::vector<ResourceDecl> resources;
    std::vector<Use> uses;
    std::vector<ClearValue> clears; ///< one per use, of those that clear
    std::vector<Part> parts;        ///< of the uses that name one
    Names bindings;                 ///< what shaders call what the uses bind
    std::vector<ConditionDecl> conditions;
    std::vector<Guard> guards;
    std::vector<Omission> omissions;
    std::vector<Misuse> misuses;

    std::span<const Use> uses_of(PassId pass) const {
        return {uses.data() + passes[pass].first_use, passes[pass].use_count};
    }
    /// Empty where no shader names it.
    std::string_view binding_of(const Use& use) const {
        return use.binding == kNone ? std::string_view{} : bindings[use.binding];
    }
    /// `use` must be an element of `uses`.
    const ClearValue& clear_of(const Use& use) const {
        return clears[static_cast<std::size_t>(&use - uses.data())];
    }
};

/// The part of a resource that a use touches, with its ends resolved.
Part part_of(const Declaration& declaration, const Use& use);

} // namespace ockham
