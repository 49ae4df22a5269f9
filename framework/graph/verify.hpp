// SPDX-License-Identifier: Apache-2.0
// Checks a plan against its declaration under Vulkan's memory model, and says in words what is
// missing. Shares no decisions with compile(): it knows what accesses mean, and replays what the
// plan says. Called by debug builds of the executor, by tests, by the fuzzer.
#pragma once

#include "framework/graph/compile.hpp"

#include <string>
#include <vector>

namespace ockham {

struct Violation {
    enum class Kind : std::uint8_t {
        malformed,  ///< an index out of range, a stage that the queue does not have, ...
        order,      ///< a pass is missing, repeated, or before what it depends on
        culling,    ///< a culled pass makes something that is needed
        submission, ///< queues, submissions or waits that cannot be executed
        execution,  ///< nothing makes the later access wait for the earlier one
        memory,     ///< it waits, but the write is not available, or not visible to it
        layout,     ///< an image is in another layout than the access or barrier expects
        content,    ///< what is read was never written, or was lost on the way
        ownership,  ///< another queue family owns it, or the halves of a transfer do not match
        placement,  ///< memory is missing, too small, misaligned, of a wrong type or shared
        alias,      ///< bytes are taken while their owner is still in use
        usage,      ///< created without a usage bit that an access needs
    };
    Kind kind = Kind::malformed;
    ResourceId resource = kNone; ///< kNone where it is not about one
    Part part;                   ///< of the resource, ends resolved
    PassId earlier = kNone;      ///< kNone: the caller, or a barrier
    PassId later = kNone;
    /// "'blur' reads mip 2 of 'color' at compute/sampled_read, but nothing makes the write by
    /// 'draw' at color_output/color_write visible to it"
    std::string text;
};
const char* name_of(Violation::Kind kind);

/// Everything found wrong, at most one of a kind for each pair of passes and resource, and no more
/// than 64. Empty: for every combination of answers to the conditions, and however often the plan
/// is executed back to back, each pass finds what the declaration promises. `declaration` must be
/// one that compile() accepts; of the plan nothing is taken for granted, its indices included.
std::vector<Violation> verify(
    const Declaration& declaration, const Plan& plan, const Capabilities& capabilities = {});

/// One line each; empty if there are none.
std::string violations_text(const std::vector<Violation>& violations);

} // namespace ockham
