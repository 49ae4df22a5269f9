// SPDX-License-Identifier: Apache-2.0
// How much memory the invocations of a workgroup share, read from SPIR-V: SPIRV-Cross does not say.
// For shader.cpp only.
#pragma once

#include <cstdint>
#include <span>

namespace ockham::gpu {

/// Bytes of all `shared` variables, laid out as scalars without padding, arrays whose length is a
/// specialisation constant with its default. 0 for modules that have none.
std::uint64_t workgroup_bytes(std::span<const std::uint32_t> words);

} // namespace ockham::gpu
