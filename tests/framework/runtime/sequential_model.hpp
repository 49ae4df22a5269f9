// SPDX-License-Identifier: Apache-2.0
// Executes a declaration with the kernels of hash_passes.hpp on arrays: pass after pass, as
// declared. Knows no plan, barrier, memory or device; says what every right plan must leave.
#pragma once

#include "tests/framework/runtime/hash_passes.hpp"

#include <cstdint>
#include <vector>

namespace ockham::test {

class SequentialModel {
public:
    /// Words of a buffer; bits of an image's texels by mip, layer, row.
    struct Content {
        std::vector<std::uint32_t> words;
        std::vector<std::uint8_t> defined; ///< per word
    };
    /// Mistakes that a comparison must find.
    enum class Fault { none, swapped_inputs, ignored_guards, still_histories, reversed_histories };

    /// Persistent content is zero, all else undefined. `passes` must outlive this object.
    explicit SequentialModel(const HashPasses& passes, Fault fault = Fault::none);

    /// Gives an external resource its first content, as many words as it has.
    void set(ResourceId resource, const std::vector<std::uint32_t>& words);
    /// `answers` by ConditionId.
    void execute(const std::vector<bool>& answers);
    const Content& content(ResourceId resource) const { return contents_[resource]; }
    /// Words that passes read although nothing defined them; no valid declaration does.
    std::uint64_t undefined_reads() const { return undefined_reads_; }

private:
    using Words = std::vector<std::uint32_t>;
    void begin_execution();
    void rotate_histories();
    bool consents(GuardId guard, const std::vector<bool>& answers) const;
    std::vector<std::size_t> places_of(const Use& use, const Part& part) const;
    std::vector<std::size_t> places_of(const Use& use) const;
    Words read(const Use& use);
    std::vector<Words> read_inputs(PassId pass, Stage stage);
    void write(ResourceId resource, std::size_t place, std::uint32_t word);
    void write_target(const Use& target, std::size_t place, std::uint32_t hash);
    void run_compute(PassId pass);
    void run_raster(PassId pass);
    void draw(const Use& attachment, const std::vector<std::size_t>& places, const Words& hashes,
        bool discards);
    void run_transfers(PassId pass);

    const HashPasses& passes_;
    const Declaration& declaration_;
    Fault fault_;
    std::uint32_t execution_ = 0;
    std::vector<Content> contents_;
    std::uint64_t undefined_reads_ = 0;
};

} // namespace ockham::test
