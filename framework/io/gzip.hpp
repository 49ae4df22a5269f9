// SPDX-License-Identifier: Apache-2.0
// Inflates gzip and zlib streams in memory, never beyond what the caller made room for. Does not
// write. Private to io/volume.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace ockham {

/// Inflates `packed` (gzip, also of several members, or zlib; told apart by their first bytes) into
/// `bytes`. Returns how many bytes the stream holds, or bytes.size() + 1 if it holds more; then,
/// and if it holds fewer, `bytes` has what fits. Throws Error(input) that says in a few words,
/// without a file, what is damaged.
std::uint64_t inflate(std::span<const std::byte> packed, std::span<std::byte> bytes);

/// The same without keeping the bytes: at most `at_most` + 1. Proves a stream sound to those who
/// let a library unpack it that takes what it gets.
std::uint64_t inflated_size(std::span<const std::byte> packed, std::uint64_t at_most);

} // namespace ockham
