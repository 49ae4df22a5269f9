// SPDX-License-Identifier: Apache-2.0
#include "tests/framework/runtime/sequential_model.hpp"

#include "framework/core/error.hpp"

#include <algorithm>
#include <array>
#include <bit>

namespace ockham::test {

namespace {

std::uint32_t bits_of(float texel) { return std::bit_cast<std::uint32_t>(texel); }

std::size_t mip_texels(const ImageDesc& image, std::uint32_t mip) {
    return std::size_t{std::max(image.width >> mip, 1u)} * std::max(image.height >> mip, 1u);
}

std::size_t words_of(const ResourceDecl& resource) {
    if (resource.kind == ResourceKind::buffer) return resource.buffer.bytes / 4;
    std::size_t texels = 0;
    for (std::uint32_t mip = 0; mip < resource.image.mips; ++mip)
        texels += mip_texels(resource.image, mip) * resource.image.layers;
    return texels;
}

/// For element `index` of `count`, as in mix.glsl.
std::uint32_t mix_inputs(std::uint32_t seed, std::size_t index, std::size_t count,
    const std::vector<std::vector<std::uint32_t>>& inputs) {
    std::uint32_t h = hash_word(seed + static_cast<std::uint32_t>(index));
    for (const std::vector<std::uint32_t>& input : inputs)
        for (std::size_t i = index % input.size(); i < input.size(); i += count)
            h = hash_word(h + input[i]);
    return h;
}

} // namespace

SequentialModel::SequentialModel(const HashPasses& passes, Fault fault)
    : passes_(passes), declaration_(passes.declaration()), fault_(fault) {
    for (const ResourceDecl& resource : declaration_.resources) {
        const bool zero = resource.lifetime == Lifetime::persistent;
        const std::size_t words = words_of(resource);
        contents_.push_back({Words(words, 0), std::vector<std::uint8_t>(words, zero)});
    }
}

void SequentialModel::set(ResourceId resource, const std::vector<std::uint32_t>& words) {
    Content& content = contents_[resource];
    check(words.size() == content.words.size(), "set() of another number of words");
    content.words = words;
    std::ranges::fill(content.defined, std::uint8_t{1});
}

void SequentialModel::execute(const std::vector<bool>& answers) {
    begin_execution();
    for (PassId pass = 0; pass < declaration_.passes.size(); ++pass) {
        if (!consents(declaration_.passes[pass].guard, answers)) continue;
        switch (declaration_.passes[pass].kind) {
        case PassKind::compute:
            run_compute(pass);
            break;
        case PassKind::raster:
            run_raster(pass);
            break;
        case PassKind::transfer:
            run_transfers(pass);
            break;
        }
    }
    ++execution_;
}

void SequentialModel::begin_execution() {
    if (execution_ > 0 && fault_ != Fault::still_histories) rotate_histories();
    for (ResourceId id = 0; id < contents_.size(); ++id) {
        const ResourceDecl& resource = declaration_.resources[id];
        const bool lost =
            resource.lifetime == Lifetime::transient ||
            (resource.lifetime == Lifetime::external && resource.kind == ResourceKind::image &&
                resource.entry.layout == VK_IMAGE_LAYOUT_UNDEFINED);
        if (lost) std::ranges::fill(contents_[id].defined, std::uint8_t{0});
    }
}

void SequentialModel::rotate_histories() {
    for (ResourceId id = 0; id < contents_.size(); ++id) {
        const ResourceDecl& resource = declaration_.resources[id];
        if (resource.history_depth == 0 || resource.history_age != 0) continue;
        const auto first = contents_.begin() + id;
        const auto end = first + resource.history_depth + 1;
        std::rotate(first, fault_ == Fault::reversed_histories ? first + 1 : end - 1, end);
    }
}

bool SequentialModel::consents(GuardId guard, const std::vector<bool>& answers) const {
    if (fault_ == Fault::ignored_guards) return true;
    for (; guard != kNone; guard = declaration_.guards[guard].parent) {
        const Guard& link = declaration_.guards[guard];
        if (answers[link.condition] != link.wanted) return false;
    }
    return true;
}

std::vector<std::size_t> SequentialModel::places_of(const Use& use, const Part& part) const {
    std::vector<std::size_t> places;
    const ResourceDecl& resource = declaration_.resources[use.resource];
    if (resource.kind == ResourceKind::buffer) {
        for (std::size_t i = 0; i < part.bytes / 4; ++i) places.push_back(part.offset / 4 + i);
        return places;
    }
    std::size_t mip_begin = 0;
    for (std::uint32_t mip = 0; mip < part.first_mip + part.mips; ++mip) {
        const std::size_t texels = mip_texels(resource.image, mip);
        for (std::size_t i = 0; mip >= part.first_mip && i < texels * part.layers; ++i)
            places.push_back(mip_begin + texels * part.first_layer + i);
        mip_begin += texels * resource.image.layers;
    }
    return places;
}

std::vector<std::size_t> SequentialModel::places_of(const Use& use) const {
    return places_of(use, part_of(declaration_, use));
}

SequentialModel::Words SequentialModel::read(const Use& use) {
    const Content& content = contents_[use.resource];
    Words words;
    for (const std::size_t place : places_of(use)) {
        undefined_reads_ += content.defined[place] == 0;
        words.push_back(content.words[place]);
    }
    return words;
}

std::vector<SequentialModel::Words> SequentialModel::read_inputs(PassId pass, Stage stage) {
    std::vector<Words> inputs;
    for (const Use& use : declaration_.uses_of(pass))
        if (is_shader_input(use) && use.stage == stage) inputs.push_back(read(use));
    if (fault_ == Fault::swapped_inputs) std::ranges::reverse(inputs);
    return inputs;
}

void SequentialModel::write(ResourceId resource, std::size_t place, std::uint32_t word) {
    contents_[resource].words[place] = word;
    contents_[resource].defined[place] = 1;
}

void SequentialModel::write_target(const Use& target, std::size_t place, std::uint32_t hash) {
    const Content& content = contents_[target.resource];
    if (target.access == Access::storage_read_write) {
        undefined_reads_ += content.defined[place] == 0;
        hash = hash_word(hash + content.words[place]);
    }
    const bool image = declaration_.resources[target.resource].kind == ResourceKind::image;
    if (passes_.holds_group_counts(target.resource)) hash = 1 + hash % 3;
    write(target.resource, place, image ? bits_of(texel_of(hash)) : hash);
}

void SequentialModel::run_compute(PassId pass) {
    const std::vector<Words> inputs = read_inputs(pass, Stage::compute);
    Words groups{1, 1, 1};
    if (const Use* const counts = passes_.group_counts(pass)) groups = read(*counts);
    const std::span<const Use> uses = declaration_.uses_of(pass);
    for (std::uint32_t output = 0; output < uses.size(); ++output) {
        const Use& target = uses[output];
        if (!is_storage_target(target)) continue;
        const std::uint32_t seed = HashPasses::seed_of(pass, output, execution_) + groups[0] +
                                   4 * groups[1] + 16 * groups[2];
        const std::vector<std::size_t> places = places_of(target);
        for (std::size_t i = 0; i < places.size(); ++i)
            write_target(target, places[i], mix_inputs(seed, i, places.size(), inputs));
    }
}

void SequentialModel::run_raster(PassId pass) {
    const std::span<const Use> uses = declaration_.uses_of(pass);
    const auto color = std::ranges::find(uses, Access::color_attachment, &Use::access);
    const std::vector<std::size_t> pixels = places_of(*color);
    const std::uint32_t from_vertices = mix_inputs(
        HashPasses::seed_of(pass, 0, execution_), 0, 1, read_inputs(pass, Stage::vertex));
    const std::vector<Words> inputs = read_inputs(pass, Stage::fragment);
    Words hashes;
    for (std::size_t i = 0; i < pixels.size(); ++i)
        hashes.push_back(mix_inputs(from_vertices, i, pixels.size(), inputs));

    for (const Use& use : uses) {
        const std::vector<std::size_t> places = places_of(use);
        if (is_storage_target(use)) {
            for (std::size_t i = 0; i < places.size(); ++i)
                write_target(use, places[i],
                    hash_word(hashes[i % hashes.size()] + static_cast<std::uint32_t>(i)));
        } else if (writes(use.access)) {
            draw(use, places, hashes, passes_.discards(pass));
        }
    }
}

void SequentialModel::draw(const Use& attachment, const std::vector<std::size_t>& places,
    const Words& hashes, bool discards) {
    const bool depth = attachment.access == Access::depth_attachment;
    if (attachment.load == LoadOp::load) (void)read(attachment);
    for (std::size_t i = 0; i < places.size(); ++i) {
        if (attachment.load == LoadOp::clear) write(attachment.resource, places[i], bits_of(0.0f));
        if (discards && hashes[i] & 1) continue;
        const std::uint32_t hash = depth ? hash_word(hashes[i]) | 0x100 : hashes[i];
        write(attachment.resource, places[i], bits_of(texel_of(hash)));
    }
}

void SequentialModel::run_transfers(PassId pass) {
    for (const HashPasses::Transfer& transfer : passes_.transfers(pass)) {
        const Use& to = *transfer.to;
        std::uint32_t value = HashPasses::seed_of(pass, transfer.output, execution_);
        const bool image = declaration_.resources[to.resource].kind == ResourceKind::image;
        const std::vector<std::size_t> places = places_of(to);
        const Words source = transfer.from ? read(*transfer.from) : Words{};
        const std::size_t copied =
            image ? (transfer.from ? places.size() : 0) : transfer.copied_bytes / 4;
        for (std::size_t i = 0; i < copied; ++i) write(to.resource, places[i], source[i]);
        if (image) {
            if (transfer.from) continue;
            for (const std::size_t place : places_of(to, transfer.cleared))
                write(to.resource, place, bits_of(texel_of(value)));
            continue;
        }
        if (passes_.holds_group_counts(to.resource)) value = 1 + value % 3;
        for (std::size_t i = 0; i < transfer.filled_bytes / 4; ++i)
            write(to.resource, places[copied + i], value);
    }
}

} // namespace ockham::test
