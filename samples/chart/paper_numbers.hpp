// SPDX-License-Identifier: Apache-2.0
// What the two papers report, number by number, for tables that show it beside what is measured
// here. Their pictures and curves have no numbers in print and are not here. Called by the papers
// suite.
//   [1] Hollaender, Boubekeur, Eisemann: Adaptive Supersampling for Deferred Anti-Aliasing,
//       JCGT 2(1), 2013
//   [2] Smajdek, Lesar, Marolt, Bohak: Combined volume and surface rendering with global
//       illumination caching, The Visual Computer, 2023
#pragma once

#include <limits>

namespace ockham::chart::paper {

inline constexpr double kNotGiven = std::numeric_limits<double>::quiet_NaN();

/// [1] table 1: Sponza with 280 K triangles, 1024 x 768, GeForce GTX 480. Whole frames.
struct AaRow {
    unsigned m;
    const char* method;
    double ms, stalled_ms;
    double mse_1e5;  ///< times 1e-5, peak 1
    double psnr_255; ///< as printed: of that MSE with a peak of 255
    double samples_percent;
};
inline constexpr AaRow kAaTable[] = {
    {1, "Default", 12.91, 28.91, kNotGiven, kNotGiven, kNotGiven},
    {1, "FXAA", 13.28, 29.24, kNotGiven, kNotGiven, kNotGiven},
    {2, "Reference", 26.0, 78.7, kNotGiven, kNotGiven, 100},
    {2, "Ours", 22.9, 72.2, 5.0, 91.14, 57.8},
    {3, "Reference", 34.9, 158.36, kNotGiven, kNotGiven, 100},
    {3, "Ours", 30.69, 143.77, 3.08, 93.24, 53.40},
    {4, "Reference", 57.48, 317.76, kNotGiven, kNotGiven, 100},
    {4, "Ours", 51.68, 268.35, 3.79, 92.34, 53.14},
};
/// 20 log10(255): what the printed decibels have more than those of a peak of 1.
inline constexpr double kDecibelsOf255 = 48.13080361;

/// [1] section 4.2: time over that of a loop in the shader.
inline constexpr double kDepthDispatch = 1.2; ///< "roughly 20% slower"
inline constexpr double kSortDispatch = 3.0;  ///< "three times slower"

/// [2] table 1: pictures from smaller or less exact caches, against a cache of a cell per voxel
/// in 32-bit floats.
struct CacheRow {
    const char* volume;
    unsigned scale; ///< voxels along a side of a cell
    unsigned bits;  ///< per float
    double psnr, ssim;
};
inline constexpr CacheRow kCacheTable[] = {
    {"Backpack, 512 x 280 x 374", 1, 16, 49.663, 0.997},
    {"Backpack, 512 x 280 x 374", 2, 32, 46.925, 0.995},
    {"Backpack, 512 x 280 x 374", 4, 32, 43.761, 0.994},
    {"Wrasse, 198 x 470 x 432", 1, 16, 53.545, 0.998},
    {"Wrasse, 198 x 470 x 432", 2, 32, 54.574, 0.999},
    {"Wrasse, 198 x 470 x 432", 4, 32, 53.581, 0.999},
};

/// [2] section 4: 1024 x 1024, Nvidia Titan Xp, frames per second.
inline constexpr const char* kFrameRate = "10 to 30";
inline constexpr const char* kSuspendedFrameRate = "up to 100";
/// [2] section 4, floats of 4 bytes.
inline constexpr double kPathFloatsPerPixel = 14;
inline constexpr double kNoncachingFloatsPerPixel = 14 + 4;
inline constexpr double kCachingFloatsPerVoxel = 14;

/// [2] figures 3, 4 and 7: seconds of rendering, of 30.
inline constexpr double kMoments[] = {0.5, 1, 2, 4, 8, 15, 30};
inline constexpr double kAllSeconds = 30;

} // namespace ockham::chart::paper
