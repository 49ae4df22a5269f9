// SPDX-License-Identifier: Apache-2.0
// Volumes out of files: medical and scientific formats, sparse grids made dense, raw voxels beside
// a JSON file. Looks at names only to choose the reader. Called by app and tests.
#pragma once

#include "framework/scene/volume.hpp"

#include <string>

namespace ockham {

/// Loads, by the end of its name, a file; a folder, or a file .dcm, as DICOM; or `builtin:NAME`,
/// `builtin:NAME:SIDE` (voxels of the longest side).
/// `PATH#NAME` chooses a grid of a .vdb or .nvdb file, or a series of a DICOM folder by its UID.
/// What had to be inferred or converted is in Volume::notes, each a sentence without the file's
/// name. Throws Error(input) that names the file, also for more than 2^31 voxels, and for what
/// validate() refuses.
Volume load_volume(const std::string& source);

/// What load_volume() reads, and what this build leaves out, in one line: for --help and messages.
std::string volume_formats();

} // namespace ockham
