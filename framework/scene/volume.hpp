// SPDX-License-Identifier: Apache-2.0
// A scalar field on a regular grid, as loaders give it and scene_gpu uploads it. Voxels stay in the
// type of their file, and stand for data units (HU for CT) by a scale and an offset. CPU only; what
// the values look like is said by transfer_function.hpp.
#pragma once

#include <glm/glm.hpp>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace ockham {

enum class VoxelType : std::uint8_t { uint8, uint16, int16, float32 };
std::size_t bytes_of(VoxelType type);
const char* name_of(VoxelType type); ///< as sidecar files write it

struct Volume {
    std::string name; ///< file or builtin: name, for messages
    glm::uvec3 dims{0};
    VoxelType type = VoxelType::uint8;
    /// dims.x * dims.y * dims.z voxels, x fastest, in the byte order of the host.
    std::vector<std::byte> voxels;
    double value_scale = 1;         ///< > 0; data value = voxel * value_scale + value_offset
    double value_offset = 0;        ///< data units
    glm::dvec3 spacing_mm{1};       ///< > 0, between voxel centres along the data axes
    glm::dmat3 direction{1.0};      ///< columns: unit vectors of the data axes, any handedness
    glm::dvec3 origin_mm{0};        ///< centre of the first voxel
    std::vector<std::string> notes; ///< what a loader inferred, a line each

    std::size_t voxel_count() const { return std::size_t{dims.x} * dims.y * dims.z; }
    /// In data units; coordinates beyond the grid are clamped to it.
    double at(glm::ivec3 voxel) const;
    /// In data units, trilinear between voxel centres, which lie at (i + 1/2) / dims; clamped to
    /// the outermost centres. `unit`: 0 to 1 over the box, any finite value allowed.
    double sample(glm::dvec3 unit) const;
};

/// Throws Error(input) naming the volume unless each of dims is 1 to 65536, there are as many bytes
/// as dims and type say, scale and offset, spacing, direction and origin are finite and as above,
/// and every voxel is finite (the first that is not is named). All else here takes this for
/// granted.
void validate(const Volume& volume);

/// The least and the greatest value that occur, in data units.
struct ValueRange {
    double lowest = 0, highest = 0;
};
ValueRange value_range(const Volume& volume);

/// Where a volume stands in the world: its box of dims * spacing scaled to a longest side of 1 and
/// centred at the origin, axes along the data axes. origin_mm does not matter.
struct VolumePlace {
    glm::dvec3 corner{0};    ///< world position of unit coordinates 0
    glm::dmat3 edges{1.0};   ///< columns: world = corner + edges * unit
    double world_per_mm = 1; ///< > 0
};
VolumePlace place_of(const Volume& volume);

} // namespace ockham
