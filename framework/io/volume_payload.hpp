// SPDX-License-Identifier: Apache-2.0
// Whether NRRD, NIfTI and MetaImage files hold the voxels that they state, and where: what ITK's
// readers take on trust, some of them reading zeros for what is not there. Private to io/volume.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace ockham {

/// What a header states of its voxels: `bytes` in memory, and in words for messages.
struct StatedVoxels {
    std::uint64_t count = 0, bytes = 0;
    std::string text; ///< "2 x 3 x 4 voxels of type short"
};

/// Throws Error(input) if a file that it refers to is elsewhere than in its folder or no file, or if
/// its header is of a kind that the libraries do not survive. To be called before a reader opens
/// it.
void check_references(const std::filesystem::path& path);

/// Throws Error(input) if fewer bytes are there than stated, or packed ones are damaged. To be
/// called before room is made for `bytes`. Adds a note if no spacing is stated.
void check_payload(
    const std::filesystem::path& path, const StatedVoxels& stated, std::vector<std::string>& notes);

} // namespace ockham
