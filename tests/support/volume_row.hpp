// SPDX-License-Identifier: Apache-2.0
// A volume of one row of voxels, for tests of what only asks for their values.
#pragma once

#include "framework/scene/volume.hpp"

#include <cstring>
#include <vector>

namespace ockham::test {

/// values.size() x 1 x 1 voxels; T must be what `type` says.
template <class T>
Volume row_of(VoxelType type, const std::vector<T>& values) {
    Volume volume;
    volume.dims = {values.size(), 1, 1};
    volume.type = type;
    volume.voxels.resize(values.size() * sizeof(T));
    std::memcpy(volume.voxels.data(), values.data(), volume.voxels.size());
    return volume;
}

} // namespace ockham::test
