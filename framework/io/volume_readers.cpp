// SPDX-License-Identifier: Apache-2.0
#include "framework/io/volume_readers.hpp"

#include <algorithm>

namespace ockham {

glm::uvec3 checked_dims(const std::string& file, const StatedDims& dims) {
    // By division, for a product may overflow.
    std::uint64_t room = kMaxVoxels;
    for (const std::uint64_t side : dims) room = side == 0 ? 0 : room / side;
    if (room == 0) {
        fail_input("cannot load volume '{}': it states {} x {} x {} voxels, expected at least 1 "
                   "along each axis and at most {} in all; crop or subsample it",
            file, dims[0], dims[1], dims[2], kMaxVoxels);
    }
    return glm::uvec3(dims[0], dims[1], dims[2]);
}

std::size_t bytes_of_voxels(const Volume& volume) {
    return volume.voxel_count() * bytes_of(volume.type);
}

std::filesystem::path path_beside(const std::filesystem::path& owner, const std::string& name) {
    const std::filesystem::path relative(name);
    if (name.empty() || relative.is_absolute() || name.find('\0') != std::string::npos ||
        std::find(relative.begin(), relative.end(), "..") != relative.end()) {
        fail_input("cannot load volume '{}': the file '{}' that it names is outside of its folder; "
                   "put both into one folder",
            owner.string(), name);
    }
    return owner.parent_path() / relative;
}

std::size_t choose_part(const std::string& file, const char* what,
    const std::vector<std::string>& names, const std::string& wanted,
    std::vector<std::string>& notes) {
    if (names.empty()) fail_input("cannot load volume '{}': it has no {}", file, what);
    auto chosen = std::find(names.begin(), names.end(), wanted.empty() ? "density" : wanted);
    if (chosen == names.end()) {
        if (!wanted.empty()) {
            fail_input("cannot load volume '{}': it has no {} '{}'; it has '{}'", file, what,
                wanted, fmt::join(names, "', '"));
        }
        chosen = names.begin();
    }
    if (names.size() > 1 && wanted.empty()) {
        std::vector<std::string> others(names.begin(), chosen);
        others.insert(others.end(), chosen + 1, names.end());
        notes.push_back(fmt::format("{} '{}' is read; also there: '{}' (append #NAME to the path)",
            what, *chosen, fmt::join(others, "', '")));
    }
    return static_cast<std::size_t>(chosen - names.begin());
}

Volume sparse_box(const std::string& file, glm::ivec3 first, glm::ivec3 last, float background) {
    StatedDims dims{};
    for (int axis = 0; axis < 3; ++axis) {
        // In 64 bits, and empty where nothing is active.
        const std::int64_t side = std::int64_t{last[axis]} - first[axis] + 1;
        dims[static_cast<std::size_t>(axis)] = side < 1 ? 0 : static_cast<std::uint64_t>(side) + 2;
    }
    if (std::ranges::count(dims, 0u) > 0) {
        fail_input("cannot load volume '{}': its grid has no active voxel", file);
    }
    Volume volume;
    volume.type = VoxelType::float32;
    volume.dims = checked_dims(file, dims);
    volume.voxels.resize(bytes_of_voxels(volume));
    volume.notes.push_back(fmt::format("a sparse grid made dense: {} x {} x {} voxels, which are "
                                       "its active ones, from index ({}, {}, {}), and a border of "
                                       "one voxel (outside of them it is {})",
        volume.dims.x, volume.dims.y, volume.dims.z, first.x, first.y, first.z, background));
    return volume;
}

void place_sparse(Volume& volume, const glm::dmat3& world_from_index, glm::dvec3 origin) {
    for (int axis = 0; axis < 3; ++axis) {
        volume.spacing_mm[axis] = glm::length(world_from_index[axis]);
        volume.direction[axis] = world_from_index[axis] / volume.spacing_mm[axis];
    }
    volume.origin_mm = origin;
}

} // namespace ockham
