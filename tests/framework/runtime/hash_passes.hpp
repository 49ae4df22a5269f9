// SPDX-License-Identifier: Apache-2.0
// Real kernels for the passes of any declaration: each hashes all that its pass declared to read
// into all that it declared to write, so that what a wrong order, binding, part or age changes,
// changes results. What they compute is stated once, for the device and for sequential_model.hpp.
#pragma once

#include "framework/graph/graph.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace ockham::test {

/// Shader inputs are named r0, r1, r2, storage targets w0, w1 or, in raster passes, w. Images are
/// R32_SFLOAT or D32_SFLOAT and hold multiples of 2^-24 in [0, 1); buffers hold words. What vertex
/// and index uses name stays unread.
class HashPasses {
public:
    explicit HashPasses(Declaration declaration);

    const Declaration& declaration() const { return declaration_; }
    /// What the pass records in this execution (from 0); different executions give different
    /// content.
    void record(PassId pass, std::uint32_t execution, Commands& commands) const;

    // What a pass does, for whoever computes it elsewhere.

    /// Of what the `output`-th use of the pass writes.
    static std::uint32_t seed_of(PassId pass, std::uint32_t output, std::uint32_t execution);
    /// Words of this resource are 1, 2 or 3, since some pass takes them for numbers of workgroups.
    bool holds_group_counts(ResourceId resource) const { return counts_[resource] != 0; }
    /// The use that gives the pass's numbers of workgroups; null: 1 x 1 x 1.
    const Use* group_counts(PassId pass) const;
    /// Whether fragments with an odd hash are discarded.
    bool discards(PassId pass) const;
    /// Copies `from` to the beginning of `to` and fills the rest of `to`, as far as `to` goes.
    struct Transfer {
        const Use* to = nullptr;
        const Use* from = nullptr;
        std::uint64_t copied_bytes = 0; ///< images: all or nothing
        std::uint64_t filled_bytes = 0;
        Part cleared; ///< of an image that is not copied to
        std::uint32_t output = 0;
    };
    std::vector<Transfer> transfers(PassId pass) const;
    bool clears_images(PassId pass) const;
    /// Whether each declared read is really made in every execution: no guards, no copy that finds
    /// no target, no vertex or index buffer.
    bool makes_all_reads() const;

private:
    bool makes(PassId pass, const Use& read) const;
    std::string shader(const char* file, PassId pass, Stage stage, const Use* target) const;
    void record_compute(PassId pass, std::uint32_t execution, Commands& commands) const;
    void record_raster(PassId pass, std::uint32_t execution, Commands& commands) const;
    void record_transfers(PassId pass, std::uint32_t execution, Commands& commands) const;
    bool is_copyable(const Use& from, const Use& to) const;

    Declaration declaration_;
    std::vector<std::uint8_t> counts_;
};

/// Written by shaders through storage, in compute or raster passes.
inline bool is_storage_target(const Use& use) {
    return in_shader(use.access) && writes(use.access);
}
/// Read by shaders only.
inline bool is_shader_input(const Use& use) { return in_shader(use.access) && !writes(use.access); }

inline std::uint32_t hash_word(std::uint32_t x) {
    x = (x ^ (x >> 16)) * 0x7feb352du;
    x = (x ^ (x >> 15)) * 0x846ca68bu;
    return x ^ (x >> 16);
}
inline float texel_of(std::uint32_t hash) { return static_cast<float>(hash >> 8) * 0x1p-24f; }

} // namespace ockham::test
