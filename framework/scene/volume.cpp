// SPDX-License-Identifier: Apache-2.0
#include "framework/scene/volume.hpp"

#include "framework/core/error.hpp"
#include "framework/scene/voxels.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ockham {

namespace {

constexpr std::uint32_t kMaxSide = 65536;

bool is_finite(glm::dvec3 v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

void validate_shape(const Volume& volume) {
    const glm::uvec3 dims = volume.dims;
    for (int axis = 0; axis < 3; ++axis)
        if (dims[axis] < 1 || dims[axis] > kMaxSide)
            fail_input("volume '{}': {} x {} x {} voxels, expected 1 to {} along each axis",
                volume.name, dims.x, dims.y, dims.z, kMaxSide);
    const std::size_t bytes = volume.voxel_count() * bytes_of(volume.type);
    if (volume.voxels.size() != bytes)
        fail_input("volume '{}': {} bytes of voxels, but {} x {} x {} of {} are {}", volume.name,
            volume.voxels.size(), dims.x, dims.y, dims.z, name_of(volume.type), bytes);
}

void validate_place(const Volume& volume) {
    const glm::dvec3 spacing = volume.spacing_mm;
    if (!is_finite(spacing) || !(spacing.x > 0 && spacing.y > 0 && spacing.z > 0))
        fail_input("volume '{}': spacing {} x {} x {} mm, expected lengths above 0", volume.name,
            spacing.x, spacing.y, spacing.z);
    if (!is_finite(volume.origin_mm))
        fail_input("volume '{}': the origin is not finite", volume.name);
    for (int axis = 0; axis < 3; ++axis) {
        const glm::dvec3 column = volume.direction[axis];
        if (!(std::abs(glm::length(column) - 1.0) < 1e-3))
            fail_input("volume '{}': direction of axis {} is ({}, {}, {}), expected a unit vector",
                volume.name, axis, column.x, column.y, column.z);
    }
    if (!(std::abs(glm::determinant(volume.direction)) > 1e-3))
        fail_input("volume '{}': the directions of its axes lie in a plane", volume.name);
}

void validate_values(const Volume& volume) {
    if (!(volume.value_scale > 0) || !std::isfinite(volume.value_scale) ||
        !std::isfinite(volume.value_offset))
        fail_input("volume '{}': values are voxel * {} + {}, expected a finite scale above 0 and a "
                   "finite offset",
            volume.name, volume.value_scale, volume.value_offset);
    if (volume.type != VoxelType::float32) return;
    const auto values = voxels_as<float>(volume);
    const auto bad = std::find_if_not(
        values.begin(), values.end(), [](float value) { return std::isfinite(value); });
    if (bad == values.end()) return;
    const auto index = static_cast<std::size_t>(bad - values.begin());
    fail_input("volume '{}': voxel ({}, {}, {}) is {}, expected a finite number", volume.name,
        index % volume.dims.x, index / volume.dims.x % volume.dims.y,
        index / volume.dims.x / volume.dims.y, *bad);
}

} // namespace

std::size_t bytes_of(VoxelType type) {
    switch (type) {
    case VoxelType::uint8:
        return 1;
    case VoxelType::uint16:
    case VoxelType::int16:
        return 2;
    case VoxelType::float32:
        break;
    }
    return 4;
}

const char* name_of(VoxelType type) {
    switch (type) {
    case VoxelType::uint8:
        return "uint8";
    case VoxelType::uint16:
        return "uint16";
    case VoxelType::int16:
        return "int16";
    case VoxelType::float32:
        break;
    }
    return "float32";
}

double Volume::at(glm::ivec3 voxel) const {
    const glm::ivec3 last = glm::ivec3(dims) - 1;
    const auto place = glm::u64vec3(glm::clamp(voxel, glm::ivec3(0), last));
    const std::size_t index = (place.z * dims.y + place.y) * dims.x + place.x;
    return value_offset + value_scale * with_voxels(*this, [index](auto values) {
        return static_cast<double>(values[index]);
    });
}

double Volume::sample(glm::dvec3 unit) const {
    const glm::dvec3 last = glm::dvec3(dims) - 1.0;
    const glm::dvec3 p = glm::clamp(unit * glm::dvec3(dims) - 0.5, glm::dvec3(0.0), last);
    const glm::ivec3 low(p); // not negative: truncation is floor
    const glm::dvec3 f = p - glm::dvec3(low);
    double result = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::ivec3 step(corner & 1, corner >> 1 & 1, corner >> 2);
        const glm::dvec3 weight = glm::mix(1.0 - f, f, glm::dvec3(step));
        result += weight.x * weight.y * weight.z * at(low + step);
    }
    return result;
}

void validate(const Volume& volume) {
    validate_shape(volume);
    validate_place(volume);
    validate_values(volume);
}

ValueRange value_range(const Volume& volume) {
    return with_voxels(volume, [&volume](auto values) {
        const auto [least, greatest] = std::minmax_element(values.begin(), values.end());
        return ValueRange{volume.value_offset + volume.value_scale * double(*least),
            volume.value_offset + volume.value_scale * double(*greatest)};
    });
}

VolumePlace place_of(const Volume& volume) {
    const glm::dvec3 sides = glm::dvec3(volume.dims) * volume.spacing_mm;
    VolumePlace place;
    place.world_per_mm = 1.0 / std::max({sides.x, sides.y, sides.z});
    for (int axis = 0; axis < 3; ++axis)
        place.edges[axis] = volume.direction[axis] * (sides[axis] * place.world_per_mm);
    place.corner = -0.5 * (place.edges[0] + place.edges[1] + place.edges[2]);
    return place;
}

} // namespace ockham
