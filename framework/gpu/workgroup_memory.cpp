// SPDX-License-Identifier: Apache-2.0
#include "framework/gpu/workgroup_memory.hpp"

#include <map>

namespace ockham::gpu {

namespace {

/// Opcodes and the storage class, by the numbers of the SPIR-V specification, section 3.
enum Op : std::uint32_t {
    type_bool = 20,
    type_int = 21,
    type_float = 22,
    type_vector = 23,
    type_matrix = 24,
    type_array = 28,
    type_struct = 30,
    type_pointer = 32,
    constant = 43,
    spec_constant = 50,
    variable = 59,
};
constexpr std::uint32_t kWorkgroup = 4;
constexpr std::size_t kHeaderWords = 5;

} // namespace

std::uint64_t workgroup_bytes(std::span<const std::uint32_t> words) {
    std::map<std::uint32_t, std::uint64_t> bytes;     // of types; pointers: of what they point to
    std::map<std::uint32_t, std::uint64_t> constants; // low words
    std::uint64_t sum = 0;
    for (std::size_t at = kHeaderWords; at < words.size();) {
        const std::uint32_t count = words[at] >> 16;
        if (count == 0 || count > words.size() - at) break; // not SPIR-V; reflection says so
        const std::span<const std::uint32_t> in = words.subspan(at, count);
        const auto has = [&](std::size_t operands) { return in.size() > operands; };
        switch (in[0] & 0xffff) {
        case type_bool:
            if (has(1)) bytes[in[1]] = 4;
            break;
        case type_int:
        case type_float:
            if (has(2)) bytes[in[1]] = in[2] / 8;
            break;
        case type_vector:
        case type_matrix:
            if (has(3)) bytes[in[1]] = bytes[in[2]] * in[3];
            break;
        case type_array:
            if (has(3)) bytes[in[1]] = bytes[in[2]] * constants[in[3]];
            break;
        case type_struct:
            if (has(1)) bytes[in[1]] = 0;
            for (std::size_t member = 2; member < in.size(); ++member)
                bytes[in[1]] += bytes[in[member]];
            break;
        case type_pointer:
            if (has(3)) bytes[in[1]] = bytes[in[3]];
            break;
        case constant:
        case spec_constant:
            if (has(3)) constants[in[2]] = in[3];
            break;
        case variable:
            if (has(3) && in[3] == kWorkgroup) sum += bytes[in[1]];
            break;
        default:
            break;
        }
        at += count;
    }
    return sum;
}

} // namespace ockham::gpu
