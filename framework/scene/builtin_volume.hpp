// SPDX-License-Identifier: Apache-2.0
// Volumes made by formulas on integers and exactly rounded arithmetic, so that every machine gets
// the same bytes, and a sky. For the first picture, for tests and for benchmarks without data. CPU
// only.
#pragma once

#include "framework/core/image.hpp"
#include "framework/scene/volume.hpp"

#include <cstdint>
#include <string>

namespace ockham {

/// builtin:cloud|fingers|cluster|shells|slab|constant, `side` (1 to 1024) voxels along the longest side, 1 mm
/// apart. z is up.
///  - cloud: a cumulus, flat below, billowed above, empty around; uint8, its height 3/4 of its
///  side.
///  - fingers: five curved rods of value 255, 2 to 4 voxels thick, before a cushion of about 128,
///    in air of 3; uint8. Their shadows fall upon it, and are thinner than cells of a coarse cache.
///  - cluster: 4000 balls of value 128 to 255, 1 to 3 voxels across, the denser the nearer to the
///    middle, in haze of up to 10; uint8.
///  - shells: eight concentric spherical shells, from the outermost to the innermost 1, 2, ... 8
///    voxels thick where they cross half of their value of 255, and gaps of 0 between them; as many
///    as fit. uint8. Surfaces below the value 100 have no holes, even through the thinnest.
///  - slab: value 1 everywhere, in a box of 64:64:1, thin along z; float.
///  - constant: value 1 everywhere, in a cube; float.
/// Throws Error(input) that lists the names.
Volume builtin_volume(const std::string& name, std::uint32_t side = 128);

/// 128 x 64 pixels R, G, B, equirectangular, zenith at +z: a sky, grey below the horizon, with a
/// sun of 10 degrees across whose irradiance is about pi.
Image sky_with_sun();

} // namespace ockham
