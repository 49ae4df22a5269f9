// SPDX-License-Identifier: Apache-2.0
// A small volume with an inside, a fuzzy rim and empty corners.
#pragma once

#include "framework/scene/volume.hpp"

#include <algorithm>
#include <cmath>

namespace ockham::test {

/// 12^3 values from 0 to 255, full up to a fifth of the radius and falling evenly outwards.
inline Volume ball() {
    Volume volume;
    volume.name = "ball";
    volume.dims = glm::uvec3(12);
    for (int z = 0; z < 12; ++z)
        for (int y = 0; y < 12; ++y)
            for (int x = 0; x < 12; ++x) {
                const double r = std::hypot(x - 5.5, y - 5.5, z - 5.5) / 5.5;
                volume.voxels.push_back(
                    std::byte(std::lround(255 * std::clamp(1.2 - r, 0.0, 1.0))));
            }
    return volume;
}

} // namespace ockham::test
