// SPDX-License-Identifier: Apache-2.0
// What a graph declares, as plain data: passes, resources, and who uses which how. Input of
// compile(); built by Graph (graph.hpp), never by hand except in tests. Knows no device.
#pragma once

#include "framework/graph/access.hpp"

#include <cstdint>
#include <source_location>
#include <string>
#include <vector>

namespace ockham {

using ResourceId = std::uint32_t; ///< index into Declaration::resources
using PassId = std::uint32_t;     ///< index into Declaration::passes
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
};

struct ImageDesc {
    VkFormat format = VK_FORMAT_UNDEFINED;
    std::uint32_t width = 1;
    std::uint32_t height = 1;
    std::uint32_t depth = 1;  ///< > 1: a 3D image
    std::uint32_t layers = 1; ///< > 1: an array
    std::uint32_t mips = 1;
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
    std::source_location where;
};

/// How a sampled image is filtered. `texel`: nearest and clamped, for texelFetch.
enum class Filter : std::uint8_t { texel, linear_clamp, linear_repeat };

enum class LoadOp : std::uint8_t { discard, clear, load };

/// One pass touches one resource once.
struct Use {
    ResourceId resource = kNone;
    Access access = Access::sampled;
    Stage stage = Stage::compute;
    LoadOp load = LoadOp::discard; ///< attachments only
    Filter filter = Filter::texel; ///< sampled images only; linear is trilinear across mips
    /// Version seen (the content before this pass) and, for writes, version made.
    std::uint32_t version = 0;
    std::uint32_t version_written = kNone;
    /// Name in the shader that this use is bound to; empty where no shader names it.
    std::string binding;
    /// Clear value of an attachment: four floats, or depth in [0].
    float clear[4] = {0, 0, 0, 0};
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

struct PassDecl {
    std::string name;
    PassKind kind = PassKind::compute;
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
    std::vector<Omission> omissions;
    std::vector<Misuse> misuses;
};

} // namespace ockham
