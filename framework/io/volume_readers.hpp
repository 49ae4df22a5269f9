// SPDX-License-Identifier: Apache-2.0
// The readers behind load_volume(), one source for each third-party library, and what they share.
// A reader may be left out of the build; only volume_file.cpp calls them. Private to io/volume.
#pragma once

#include "framework/core/error.hpp"
#include "framework/scene/volume.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace ockham {

/// Nothing larger is read: 2 GiB of bytes, 8 GiB of floats.
constexpr std::uint64_t kMaxVoxels = std::uint64_t{1} << 31;

/// Deflate packs at most 1032 bytes into one (zlib's manual): what claims more is damaged.
constexpr std::uint64_t kMaxDeflateRatio = 1032;

/// Sizes as a file states them, to be trusted only after checked_dims().
using StatedDims = std::array<std::uint64_t, 3>;

/// Throws Error(input) unless each is at least 1 and their product at most kMaxVoxels.
glm::uvec3 checked_dims(const std::string& file, const StatedDims& dims);

/// Bytes that the voxels of `volume` take.
std::size_t bytes_of_voxels(const Volume& volume);

/// The place of a name that a file refers to. Throws Error(input), with `owner` as who refers to
/// it, for names that leave the folder of `owner`.
std::filesystem::path path_beside(const std::filesystem::path& owner, const std::string& name);

/// Picks "density" or else the first, or what the user asked for. Adds a note that names the
/// others; throws Error(input) if there is none of that name, or none at all. `what` is a word
/// ("grid").
std::size_t choose_part(const std::string& file, const char* what,
    const std::vector<std::string>& names, const std::string& wanted,
    std::vector<std::string>& notes);

/// Zeros for the voxels `first` to `last` (of indices, inclusive) of a sparse grid and a border of
/// one around them, so that interpolation ends as it does in the grid; with a note. Throws
/// Error(input) if last < first, which is how empty grids say so.
Volume sparse_box(const std::string& file, glm::ivec3 first, glm::ivec3 last, float background);
/// Spacing and directions from the columns; `origin` is the centre of the first voxel.
void place_sparse(Volume& volume, const glm::dmat3& world_from_index, glm::dvec3 origin);

Volume load_raw_volume(const std::filesystem::path& sidecar);
Volume load_itk_volume(const std::filesystem::path& path);
/// `path` is a folder or a single file; `series` a UID, or empty for the largest.
Volume load_dicom_volume(const std::filesystem::path& path, const std::string& series);
/// `grid` is a name, or empty.
Volume load_openvdb_volume(const std::filesystem::path& path, const std::string& grid);
Volume load_nanovdb_volume(const std::filesystem::path& path, const std::string& grid);

} // namespace ockham
