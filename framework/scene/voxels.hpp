// SPDX-License-Identifier: Apache-2.0
// The voxels of a volume in their own type, for loops over all of them.
#pragma once

#include "framework/scene/volume.hpp"

#include <cstdint>
#include <span>

namespace ockham {

/// T must be the type of the volume.
template <class T>
std::span<const T> voxels_as(const Volume& volume) {
    return {reinterpret_cast<const T*>(volume.voxels.data()), volume.voxels.size() / sizeof(T)};
}

/// function(span of the volume's type), for example with_voxels(v, [](auto voxels) { ... }).
template <class Function>
auto with_voxels(const Volume& volume, Function&& function) {
    switch (volume.type) {
    case VoxelType::uint8:
        return function(voxels_as<std::uint8_t>(volume));
    case VoxelType::uint16:
        return function(voxels_as<std::uint16_t>(volume));
    case VoxelType::int16:
        return function(voxels_as<std::int16_t>(volume));
    case VoxelType::float32:
        break;
    }
    return function(voxels_as<float>(volume));
}

} // namespace ockham
