// SPDX-License-Identifier: Apache-2.0
// 128 bits that stand for a sequence of values: equal sequences, equal fingerprints. Not for
// adversaries. Graph keeps one of what it declares; PlanCache finds plans by it.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace ockham {

struct Fingerprint {
    std::uint64_t low = 0x9e3779b97f4a7c15;
    std::uint64_t high = 0xd1b54a32d192ed03;

    void mix(std::uint64_t value) {
        low = std::rotl(low ^ value, 29) * 0xbf58476d1ce4e5b9;
        high = std::rotl(high + value, 37) * 0x94d049bb133111eb + low;
    }
    /// The text and its length, so that "ab", "c" differs from "a", "bc".
    void mix(std::string_view text) {
        mix(std::uint64_t{text.size()});
        for (; text.size() >= 8; text.remove_prefix(8)) mix(word(text.data(), 8));
        if (!text.empty()) mix(word(text.data(), text.size()));
    }

    bool operator==(const Fingerprint&) const = default;

private:
    static std::uint64_t word(const char* from, std::size_t bytes) {
        std::uint64_t value = 0;
        std::memcpy(&value, from, bytes);
        return value;
    }
};

} // namespace ockham
