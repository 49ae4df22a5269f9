// SPDX-License-Identifier: Apache-2.0
// Walks the elements of a DICOM file to see whether each lies within the file and the pixels are
// all there, because GDCM ends the program where they are not. Reads no values but those that
// sizes follow from. Private to io/volume.
#pragma once

#include <filesystem>

namespace ockham {

/// True for files with the mark of DICOM's file format (PS3.10, 7.1); others are no slices.
bool is_dicom(const std::filesystem::path& path);

/// Throws Error(input) that says at which byte the file breaks off. `path` is_dicom().
void check_dicom(const std::filesystem::path& path);

} // namespace ockham
