// SPDX-License-Identifier: Apache-2.0
// Whose memory a transient resource takes over. Called by synchronize.cpp; knows no barriers.
#pragma once

#include "framework/graph/plan.hpp"

#include <span>
#include <vector>

namespace ockham {

/// One that last used some of the bytes before.
struct Owner {
    ResourceId resource = kNone;
    bool before = false; ///< in the execution before this one; it may be the resource itself
};

/// Owners of each placed resource.
class Owners {
public:
    /// Placements must be in the order of first_step. Takes n log n time.
    explicit Owners(const Plan& plan);
    std::span<const Owner> of(ResourceId resource) const {
        return {owners_.data() + first_[resource], first_[resource + 1] - first_[resource]};
    }

private:
    std::vector<std::uint32_t> first_; ///< per resource, and the end
    std::vector<Owner> owners_;
};

} // namespace ockham
