// SPDX-License-Identifier: Apache-2.0
// Flags, sizes, parts and guards as people read them: "compute+fragment", "45.3 MiB", "mip 1 of
// 'color'". For the dumps and explanations of framework/graph only.
#pragma once

#include "framework/graph/declaration.hpp"

#include <cstdint>
#include <span>
#include <string>

namespace ockham {

std::string stages_text(VkPipelineStageFlags2 stages); ///< "compute+fragment", "none"
std::string access_text(VkAccessFlags2 access);        ///< "storage_read+storage_write"
std::string layout_text(VkImageLayout layout);         ///< "general"
std::string size_text(std::uint64_t bytes);            ///< "12 B", "1.5 KiB" or "45.3 MiB"

/// "1024x768 4 mips R32_SFLOAT" or "64 B"
std::string content_text(const ResourceDecl& resource);
/// "mip 1, layers 0-5" or "bytes 256-511"; empty where the part is all of the resource. The ends of
/// `part` are resolved.
std::string part_text(const ResourceDecl& resource, const Part& part);
/// "'color'", or "mip 1 of 'color'".
std::string part_of_text(const ResourceDecl& resource, const Part& part);
/// "only where 'fog', unless 'debug'", outermost first; empty for kNone.
std::string guard_text(const Declaration& declaration, GuardId guard);
/// "a", "a and b", "a, b and c".
std::string list_text(std::span<const std::string> items);

} // namespace ockham
