// SPDX-License-Identifier: Apache-2.0
#include "tests/framework/runtime/hash_passes.hpp"

#include "framework/core/error.hpp"
#include "framework/gpu/shader.hpp"
#include "framework/gpu/shader_compiler.hpp"
#include "framework/runtime/commands.hpp"

#include <algorithm>
#include <map>

namespace ockham::test {

namespace {

/// The push constants of mix.glsl.
struct Push {
    std::uint32_t seed = 0;
    std::uint32_t flags = 0;
    std::array<std::uint32_t, 3> uniform_words{};
    std::uint32_t width = 1, height = 1;
};
constexpr std::uint32_t kGroupCounts = 1;
constexpr std::uint32_t kDiscards = 2;

/// There are thousands of variants, of which a run needs some hundred: compiled when first used.
const std::string& compiled(const std::string& name) {
    static std::map<std::string, std::vector<std::uint32_t>> modules;
    const auto [module, fresh] = modules.try_emplace(name);
    if (fresh) {
        module->second = gpu::compile_shader(OCKHAM_TEST_SHADERS, name);
        constexpr std::uint32_t none[] = {0};
        gpu::EmbeddedShader shader("", none);
        shader.name = module->first;
        shader.words = module->second;
        const gpu::ShaderRegistration registration({&shader, 1});
    }
    return module->first;
}

const char* kind_of(Access access, ResourceKind kind) {
    switch (access) {
    case Access::uniform:
        return "uniform";
    case Access::sampled:
        return "sampled";
    default:
        return kind == ResourceKind::buffer ? "words" : "storage";
    }
}

template <ResourceKind Kind>
PartOf<Kind> handle_part(const Use& use, const Part& part) {
    return {Handle<Kind>{use.resource, use.version}, part};
}
BufferPart words(const Use& use, std::uint64_t offset, std::uint64_t bytes) {
    return handle_part<ResourceKind::buffer>(use, {.offset = offset, .bytes = bytes});
}

} // namespace

HashPasses::HashPasses(Declaration declaration)
    : declaration_(std::move(declaration)), counts_(declaration_.resources.size(), 0) {
    for (const Use& use : declaration_.uses) {
        if (use.access != Access::indirect) continue;
        const ResourceDecl& resource = declaration_.resources[use.resource];
        const auto ring = counts_.begin() + use.resource - resource.history_age;
        std::fill_n(ring, resource.history_depth + 1, std::uint8_t{1});
    }
}

std::uint32_t HashPasses::seed_of(PassId pass, std::uint32_t output, std::uint32_t execution) {
    return hash_word((execution * 1024 + pass) * 16 + output);
}

const Use* HashPasses::group_counts(PassId pass) const {
    for (const Use& use : declaration_.uses_of(pass)) {
        // Persistent ones begin as zeros, with which nothing at all would be written.
        const bool zero = declaration_.resources[use.resource].lifetime == Lifetime::persistent;
        if (use.access == Access::indirect && !zero && part_of(declaration_, use).bytes >= 12)
            return &use;
    }
    return nullptr;
}

bool HashPasses::discards(PassId pass) const {
    for (const Use& use : declaration_.uses_of(pass)) {
        if (use.access == Access::color_attachment && use.load == LoadOp::discard) return false;
    }
    return hash_word(pass) & 1;
}

bool HashPasses::is_copyable(const Use& from, const Use& to) const {
    const ResourceDecl& a = declaration_.resources[from.resource];
    const ResourceDecl& b = declaration_.resources[to.resource];
    if (a.kind != b.kind) return false;
    if (a.kind == ResourceKind::buffer)
        return !holds_group_counts(to.resource) ||
               (holds_group_counts(from.resource) && a.lifetime != Lifetime::persistent);
    const Part x = part_of(declaration_, from), y = part_of(declaration_, to);
    bool same = a.image.format == b.image.format && x.mips == y.mips && x.layers == y.layers;
    for (std::uint32_t mip = 0; same && mip < x.mips; ++mip) {
        const auto size = [mip](std::uint32_t extent, const Part& part) {
            return std::max(extent >> (part.first_mip + mip), 1u);
        };
        same = size(a.image.width, x) == size(b.image.width, y) &&
               size(a.image.height, x) == size(b.image.height, y);
    }
    return same;
}

std::vector<HashPasses::Transfer> HashPasses::transfers(PassId pass) const {
    std::vector<Transfer> all;
    const std::span<const Use> uses = declaration_.uses_of(pass);
    for (std::uint32_t i = 0; i < uses.size(); ++i) {
        const Use& to = uses[i];
        if (to.access != Access::transfer_write) continue;
        const ResourceDecl& resource = declaration_.resources[to.resource];
        const Part part = part_of(declaration_, to);
        Transfer transfer{.to = &to, .cleared = part, .output = i};
        for (const Use& from : uses) {
            if (from.access == Access::transfer_read && is_copyable(from, to))
                transfer.from = &from;
        }
        // What is defined already may be changed in part only.
        const bool partial = resource.lifetime == Lifetime::persistent && hash_word(pass + i) & 1;
        if (resource.kind == ResourceKind::buffer) {
            if (transfer.from)
                transfer.copied_bytes =
                    std::min(part.bytes, part_of(declaration_, *transfer.from).bytes);
            const std::uint64_t rest = part.bytes - transfer.copied_bytes;
            transfer.filled_bytes = partial ? rest / 8 * 4 : rest;
        } else if (partial) {
            transfer.cleared.mips = 1;
        }
        all.push_back(transfer);
    }
    return all;
}

bool HashPasses::clears_images(PassId pass) const {
    return std::ranges::any_of(transfers(pass), [&](const Transfer& transfer) {
        return declaration_.resources[transfer.to->resource].kind == ResourceKind::image &&
               !transfer.from;
    });
}

bool HashPasses::makes(PassId pass, const Use& read) const {
    const std::uint64_t bytes = part_of(declaration_, read).bytes;
    const bool image = declaration_.resources[read.resource].kind == ResourceKind::image;
    switch (read.access) {
    case Access::vertex:
    case Access::index:
        return false;
    case Access::indirect:
        return group_counts(pass) == &read && bytes == 12;
    case Access::transfer_read:
        return std::ranges::any_of(transfers(pass), [&](const Transfer& transfer) {
            return transfer.from == &read && (image || transfer.copied_bytes == bytes);
        });
    default:
        return true;
    }
}

bool HashPasses::makes_all_reads() const {
    for (PassId pass = 0; pass < declaration_.passes.size(); ++pass) {
        if (declaration_.passes[pass].guard != kNone) return false;
        for (const Use& use : declaration_.uses_of(pass))
            if (reads(use.access) && !makes(pass, use)) return false;
    }
    return true;
}

void HashPasses::record(PassId pass, std::uint32_t execution, Commands& commands) const {
    switch (declaration_.passes[pass].kind) {
    case PassKind::compute:
        return record_compute(pass, execution, commands);
    case PassKind::raster:
        return record_raster(pass, execution, commands);
    case PassKind::transfer:
        return record_transfers(pass, execution, commands);
    }
}

std::string HashPasses::shader(
    const char* file, PassId pass, Stage stage, const Use* target) const {
    std::vector<std::string> defines;
    bool depth = false;
    for (const Use& use : declaration_.uses_of(pass)) {
        depth |= use.access == Access::depth_attachment;
        if (!is_shader_input(use) || use.stage != stage) continue;
        defines.push_back(fmt::format("{}_{}", declaration_.binding_of(use),
            kind_of(use.access, declaration_.resources[use.resource].kind)));
    }
    if (target) {
        const bool image = declaration_.resources[target->resource].kind == ResourceKind::image;
        defines.emplace_back(declaration_.binding_of(*target));
        defines.push_back(image ? "to_texels" : "to_words");
        if (target->access == Access::storage_read_write) defines.push_back("old");
    }
    if (depth && stage == Stage::fragment) defines.push_back("depth");
    if (defines.empty()) return compiled(file);
    return compiled(fmt::format("{}:{}", file, fmt::join(defines, ",")));
}

void HashPasses::record_compute(PassId pass, std::uint32_t execution, Commands& commands) const {
    const std::span<const Use> uses = declaration_.uses_of(pass);
    Push push;
    for (const Use& use : uses) {
        if (use.access != Access::uniform) continue;
        const auto input = static_cast<std::size_t>(declaration_.binding_of(use)[1] - '0');
        push.uniform_words[input] =
            static_cast<std::uint32_t>(part_of(declaration_, use).bytes / 4);
    }
    const Use* const counts = group_counts(pass);
    for (std::uint32_t i = 0; i < uses.size(); ++i) {
        const Use& target = uses[i];
        if (!is_storage_target(target)) continue;
        push.seed = seed_of(pass, i, execution);
        push.flags = holds_group_counts(target.resource) ? kGroupCounts : 0;
        const std::string name = shader("test/mix.comp", pass, Stage::compute, &target);
        const ComputeCall call{.shader = name, .push = as_push(push)};
        if (counts)
            commands.dispatch_indirect(
                call, {counts->resource, counts->version}, part_of(declaration_, *counts).offset);
        else
            commands.dispatch(call, {1, 1, 1});
    }
}

void HashPasses::record_raster(PassId pass, std::uint32_t execution, Commands& commands) const {
    Push push{.seed = seed_of(pass, 0, execution), .flags = discards(pass) ? kDiscards : 0};
    const Use* target = nullptr;
    for (const Use& use : declaration_.uses_of(pass)) {
        const Part part = part_of(declaration_, use);
        if (use.access == Access::uniform) {
            const auto input = static_cast<std::size_t>(declaration_.binding_of(use)[1] - '0');
            push.uniform_words[input] = static_cast<std::uint32_t>(part.bytes / 4);
        } else if (is_storage_target(use)) {
            target = &use;
            if (holds_group_counts(use.resource)) push.flags |= kGroupCounts;
        } else if (use.access == Access::color_attachment) {
            const ImageDesc& image = declaration_.resources[use.resource].image;
            push.width = std::max(image.width >> part.first_mip, 1u);
            push.height = std::max(image.height >> part.first_mip, 1u);
        }
    }
    const std::string vertex = shader("test/mix.vert", pass, Stage::vertex, nullptr);
    const std::string fragment = shader("test/mix.frag", pass, Stage::fragment, target);
    commands.bind({.vertex_shader = vertex, .fragment_shader = fragment});
    commands.push(as_push(push));
    commands.draw(3);
}

void HashPasses::record_transfers(PassId pass, std::uint32_t execution, Commands& commands) const {
    for (const Transfer& transfer : transfers(pass)) {
        const Use& to = *transfer.to;
        const Part part = part_of(declaration_, to);
        const std::uint32_t value = seed_of(pass, transfer.output, execution);
        if (declaration_.resources[to.resource].kind == ResourceKind::image) {
            if (transfer.from)
                commands.copy(handle_part<ResourceKind::image>(
                                  *transfer.from, part_of(declaration_, *transfer.from)),
                    handle_part<ResourceKind::image>(to, part));
            else
                commands.clear(handle_part<ResourceKind::image>(to, transfer.cleared),
                    {texel_of(value), 0, 0, 0});
            continue;
        }
        if (transfer.from)
            commands.copy(words(*transfer.from, part_of(declaration_, *transfer.from).offset,
                              transfer.copied_bytes),
                words(to, part.offset, transfer.copied_bytes));
        if (transfer.filled_bytes > 0)
            commands.fill(words(to, part.offset + transfer.copied_bytes, transfer.filled_bytes),
                holds_group_counts(to.resource) ? 1 + value % 3 : value);
    }
}

} // namespace ockham::test
