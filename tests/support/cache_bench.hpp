// SPDX-License-Identifier: Apache-2.0
// A VolumeBench with a light cache in it, whose cells come back decoded. The frame may change
// between executions.
#pragma once

#include "framework/gpu/transfer.hpp"
#include "framework/runtime/commands.hpp"
#include "passes/volume/cache.hpp"
#include "tests/support/volume_bench.hpp"

#include <cmath>
#include <optional>
#include <utility>

namespace ockham::test {

struct CachedCell {
    std::uint32_t word = CACHE_NONE;
    std::optional<glm::dvec3> phi; ///< none: no slot, or no value yet
    glm::dvec3 flow{0.0};          ///< F over the luminance of phi
};

inline double half_of(std::uint32_t bits) {
    const std::uint32_t exponent = bits >> 10 & 31, mantissa = bits & 1023;
    const double magnitude = exponent == 0
                                 ? std::ldexp(mantissa, -24)
                                 : std::ldexp(1024 + mantissa, static_cast<int>(exponent) - 25);
    return (bits >> 15 & 1) != 0 ? -magnitude : magnitude;
}

/// As the formats are defined, in double precision.
inline std::vector<CachedCell> decode_cache(
    const std::vector<std::uint32_t>& index, const std::vector<std::uint32_t>& stored) {
    shader::CacheHeader header;
    std::memcpy(&header, index.data(), sizeof(header));
    std::vector<CachedCell> cells;
    for (std::size_t i = sizeof(header) / 4; i < index.size(); ++i) {
        CachedCell cell;
        cell.word = index[i];
        const std::size_t at = std::size_t{cell.word & CACHE_SLOT_MASK} * header.words;
        if (cell.word != CACHE_NONE && stored[at] != CACHE_UNREFINED) {
            const std::uint32_t* word = &stored[at];
            if (header.format == CACHE_FP32) {
                float rgb[3];
                std::memcpy(rgb, word, sizeof(rgb));
                cell.phi = glm::dvec3(rgb[0], rgb[1], rgb[2]);
            } else if (header.format == CACHE_FP16) {
                cell.phi = glm::dvec3(
                    half_of(word[0] & 0xffff), half_of(word[0] >> 16), half_of(word[1] & 0xffff));
            } else {
                cell.phi = std::ldexp(1.0, static_cast<int>(word[0] >> 27) - 24) *
                           glm::dvec3(word[0] & 511, word[0] >> 9 & 511, word[0] >> 18 & 511);
            }
            word += header.words - 2;
            if (header.directional != 0)
                cell.flow = {
                    half_of(word[0] & 0xffff), half_of(word[0] >> 16), half_of(word[1] & 0xffff)};
        }
        cells.push_back(cell);
    }
    return cells;
}

class CacheBench {
public:
    /// `places`: points (unit coordinates) and directions at which the cache is read.
    CacheBench(gpu::Device& device, const Volume& volume, const TransferFunction& transfer,
        const VolumeView& view, CacheParams params, const std::vector<glm::vec3>& places = {})
        : device_(device), volume_(volume), bench(device, volume, transfer, {.view = view}) {
        frame_.emplace(device,
            gpu::BufferInfo{.bytes = sizeof(shader::VolumeFrame),
                .usage = VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                .name = "cache_frame"});
        set_view(view);
        size = count_cache_cells(device, bench.gpu, *frame_, params);
        params.capacity = std::max(size.slots, 1u);
        bench.inputs.frame =
            bench.graph.import_buffer("cache_frame", {sizeof(shader::VolumeFrame)}, {});
        bench.on_bind([this](Executor& executor) { executor.bind(bench.inputs.frame, *frame_); });
        cache = add_cache(bench.graph, bench.inputs, params);
        counts_ = bench.keep(cache.counts);
        if (!places.empty()) add_reader(places);
    }

    /// For the executions from now on.
    void set_view(const VolumeView& view) {
        bench.frame =
            make_volume_frame(place_of(volume_), bench.gpu, volume_camera(), 64, 64, view);
        gpu::upload(device_, *frame_, std::as_bytes(std::span(&bench.frame, 1)));
    }
    void execute(std::uint32_t times = 1) {
        for (std::uint32_t i = 0; i < times; ++i) {
            bench.execute();
            change(CacheChange::none);
        }
    }
    void change(CacheChange what) { set_cache_change(bench.executor(), cache, what); }
    /// Until every cell has reached the target; false after `most` executions.
    bool converge(std::uint32_t most) {
        for (std::uint32_t i = 0; i < most; ++i) {
            execute();
            if (control().suspended != 0) return true;
        }
        return false;
    }

    std::vector<CachedCell> cells() { return decode_cache(words(cache.index), words(cache.cells)); }
    std::vector<std::uint32_t> words(BufferHandle buffer) {
        return bench.read<std::uint32_t>(buffer);
    }
    shader::CacheControl control() { return bench.read<shader::CacheControl>(cache.control)[0]; }
    std::vector<shader::CacheSum> sums() { return bench.read<shader::CacheSum>(cache.sums); }
    std::vector<std::uint8_t> counts() { return bench.texels<std::uint8_t>(counts_); }
    std::vector<glm::vec3> light() { return bench.read<glm::vec3>(light_); }

private:
    gpu::Device& device_;
    const Volume volume_;
    std::optional<gpu::Buffer> frame_;
    ImageHandle counts_;
    BufferHandle light_;

    void add_reader(const std::vector<glm::vec3>& places) {
        const auto points = static_cast<std::uint32_t>(places.size() / 2);
        const BufferHandle where = bench.buffer("places", places);
        light_ = bench.graph.create_buffer("light", {points * sizeof(glm::vec3)});
        PassBuilder pass = bench.graph.add_compute_pass("read_cache");
        read_medium(pass, bench.inputs, {.tracking = false, .light = false, .surfaces = false});
        pass.read("places", where)
            .read("cache_index", cache.index)
            .read("cache_cells", cache.cells);
        light_ = pass.write("light", light_);
        pass.record([points](Commands& commands) {
            commands.dispatch_over({.shader = "test/read_cache.comp"}, {points, 1, 1});
        });
        bench.graph.export_resource(light_, "test");
    }

public:
    VolumeBench bench;
    Cache cache;
    CacheSize size;
};

} // namespace ockham::test
