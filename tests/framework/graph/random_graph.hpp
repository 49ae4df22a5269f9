// SPDX-License-Identifier: Apache-2.0
// Random valid graphs for property tests: equal seeds, equal graphs.
#pragma once

#include "framework/core/rng.hpp"
#include "framework/graph/graph.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace ockham {

class RandomGraph {
public:
    explicit RandomGraph(std::uint64_t seed, std::uint32_t max_passes = 40)
        : rng_(seed), graph_(fmt::format("random {}", seed)) {
        add_resources_from_outside();
        const std::uint32_t passes = 1 + rng_.below(max_passes);
        for (std::uint32_t i = 0; i < passes; ++i) {
            const std::uint32_t kind = rng_.below(10);
            if (kind < 6)
                add_compute(i);
            else if (kind < 8)
                add_raster(i);
            else
                add_transfer(i);
        }
        for (const BufferHandle buffer : buffers_)
            if (rng_.below(8) == 0) graph_.export_resource(buffer, "wanted");
        if (!images_.empty()) graph_.export_resource(images_.back(), "the picture");
    }
    Graph& graph() { return graph_; }

private:
    bool chance(std::uint32_t one_in) { return rng_.below(one_in) == 0; }

    std::uint64_t some_bytes() {
        return 1 + static_cast<std::uint64_t>(std::exp2(rng_.uniform(2.0f, 24.0f)));
    }
    ImageDesc some_image() {
        constexpr VkFormat formats[] = {VK_FORMAT_R8_UNORM, VK_FORMAT_R16G16_SFLOAT,
            VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_R32G32B32A32_SFLOAT};
        const std::uint32_t size = 1u << rng_.below(10);
        return {formats[rng_.below(4)], size, size};
    }

    AccessState some_entry(bool image) {
        const Access choices[] = {
            Access::storage_write, Access::storage_read, Access::transfer_write};
        AccessState state = state_of(choices[rng_.below(3)], Stage::compute);
        if (!image) state.layout = VK_IMAGE_LAYOUT_UNDEFINED;
        return state;
    }

    void add_resources_from_outside() {
        for (std::uint32_t i = 0; i < rng_.below(3); ++i)
            buffers_.push_back(
                graph_.create_persistent_buffer(fmt::format("pb{}", i), {some_bytes()}));
        for (std::uint32_t i = 0; i < rng_.below(3); ++i)
            images_.push_back(graph_.create_persistent_image(fmt::format("pi{}", i), some_image()));
        for (std::uint32_t i = 0; i < rng_.below(2); ++i)
            buffers_.push_back(graph_.import_buffer(fmt::format("xb{}", i), {some_bytes()},
                some_entry(false), chance(2) ? some_entry(false) : AccessState{}));
        for (std::uint32_t i = 0; i < rng_.below(2); ++i)
            images_.push_back(graph_.import_image(fmt::format("xi{}", i), some_image(),
                some_entry(true), chance(2) ? some_entry(true) : AccessState{}));
    }

    /// An element that is mostly recent and that this pass has not touched.
    template <class T>
    T* pick(std::vector<T>& from, std::size_t end) {
        if (end == 0) return nullptr;
        const auto back = static_cast<std::size_t>(
            static_cast<float>(end) * rng_.uniform() * (chance(4) ? 1.0f : 0.3f));
        T* const found = &from[end - 1 - std::min(back, end - 1)];
        if (std::find(touched_.begin(), touched_.end(), found->resource) != touched_.end())
            return nullptr;
        touched_.push_back(found->resource);
        return found;
    }

    BufferHandle new_buffer() {
        const BufferHandle handle =
            graph_.create_buffer(fmt::format("b{}", count_++), {some_bytes()});
        touched_.push_back(handle.resource);
        return handle;
    }
    ImageHandle new_image() {
        const ImageHandle handle = graph_.create_image(fmt::format("i{}", count_++), some_image());
        touched_.push_back(handle.resource);
        return handle;
    }

    void add_reads(PassBuilder& pass, Stage stage) {
        // Only what existed before this pass.
        for (std::uint32_t i = 0; i < 1 + rng_.below(3); ++i) {
            const std::string name = fmt::format("r{}", i);
            if (chance(2)) {
                if (BufferHandle* buffer = pick(buffers_, buffers_.size())) {
                    const std::uint32_t how = rng_.below(6);
                    if (how == 0)
                        pass.indirect(*buffer);
                    else if (how == 1)
                        pass.uniform(name, *buffer, stage);
                    else
                        pass.read(name, *buffer, stage);
                }
            } else if (ImageHandle* image = pick(images_, images_.size())) {
                if (chance(4))
                    pass.read(name, *image, stage);
                else
                    pass.sample(name, *image, stage);
            }
        }
    }

    void add_compute(std::uint32_t index) {
        touched_.clear();
        auto pass = graph_.add_compute_pass(fmt::format("compute{}", index));
        if (chance(20)) pass.side_effect("by chance");
        add_reads(pass, Stage::compute);
        for (std::uint32_t i = 0; i < 1 + rng_.below(2); ++i) {
            const std::string name = fmt::format("w{}", i);
            if (chance(2)) {
                BufferHandle* old = chance(3) ? pick(buffers_, buffers_.size()) : nullptr;
                if (old)
                    *old = chance(2) ? pass.read_write(name, *old) : pass.write(name, *old);
                else
                    buffers_.push_back(pass.write(name, new_buffer()));
            } else {
                ImageHandle* old = chance(3) ? pick(images_, images_.size()) : nullptr;
                if (old)
                    *old = chance(2) ? pass.read_write(name, *old) : pass.write(name, *old);
                else
                    images_.push_back(pass.write(name, new_image()));
            }
        }
    }

    void add_raster(std::uint32_t index) {
        touched_.clear();
        auto pass = graph_.add_raster_pass(fmt::format("raster{}", index));
        add_reads(pass, chance(3) ? Stage::vertex : Stage::fragment);
        ImageHandle* old = chance(3) ? pick(images_, images_.size()) : nullptr;
        ImageDesc desc;
        if (old) {
            desc = graph_.desc(*old);
            *old = pass.color(*old, static_cast<LoadOp>(rng_.below(3)));
        } else {
            const ImageHandle image = new_image();
            desc = graph_.desc(image);
            images_.push_back(pass.color(image, chance(2) ? LoadOp::clear : LoadOp::discard));
        }
        if (chance(2)) {
            const ImageHandle depth = graph_.create_image(
                fmt::format("z{}", count_++), {VK_FORMAT_D32_SFLOAT, desc.width, desc.height});
            const ImageHandle written = pass.depth(depth, 0);
            // Depth may only be sampled later, so it stays out of the pool half the time.
            if (chance(2)) depths_.push_back(written);
        }
    }

    void add_transfer(std::uint32_t index) {
        touched_.clear();
        auto pass = graph_.add_transfer_pass(fmt::format("transfer{}", index));
        if (BufferHandle* from = pick(buffers_, buffers_.size())) pass.copy_from(*from);
        if (ImageHandle* from = pick(images_, images_.size())) pass.copy_from(*from);
        if (BufferHandle* to = chance(2) ? pick(buffers_, buffers_.size()) : nullptr)
            *to = pass.copy_to(*to);
        else
            buffers_.push_back(pass.copy_to(new_buffer()));
        if (!depths_.empty() && chance(2)) {
            auto look = graph_.add_compute_pass(fmt::format("look{}", index));
            look.sample("z", depths_.back());
            touched_.clear();
            buffers_.push_back(look.write("w", new_buffer()));
        }
    }

    Pcg32 rng_;
    Graph graph_;
    std::vector<BufferHandle> buffers_;
    std::vector<ImageHandle> images_, depths_;
    std::vector<ResourceId> touched_;
    std::uint32_t count_ = 0;
};

} // namespace ockham
