// SPDX-License-Identifier: Apache-2.0
// Chooses a way to render a volume, and how many steps of it, for an error or a time that is asked
// for, from curves that `chart --suite volume` has measured on classes of scenes. Which class a
// scene is of, what the program knows of it tells; how fast this machine is and how hard the view,
// a few steps of path tracing. Called by volume_gi and by charts.
#pragma once

#include "framework/app/volume_source.hpp"
#include "passes/pipelines/volume_gi.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace ockham {

/// What the program knows of a scene before it renders it.
struct VolumeFeatures {
    bool surface = false;     ///< has an isosurface
    bool sun = false;         ///< has a directional light
    double optical_depth = 0; ///< mean extinction times the box's mean extent
    double albedo = 0;        ///< of what extinguishes, mean over colours
};
VolumeFeatures features_of(const VolumeSource& source);

/// A way to find light.
struct VolumeTechnique {
    VolumeMode mode = VolumeMode::path;
    bool gather = true;
    bool operator==(const VolumeTechnique&) const = default;
};
/// All of them: path, noncaching, a cache gathered from and a cache composed.
inline constexpr VolumeTechnique kVolumeTechniques[] = {{VolumeMode::path, true},
    {VolumeMode::noncaching, true}, {VolumeMode::caching, true}, {VolumeMode::caching, false}};
std::string name_of(const VolumeTechnique& technique); ///< "composed cache"

/// A class of scenes: how each technique gets on with time.
struct VolumeClass {
    struct Entry {
        double steps = 0; ///< since the picture began
        double gpu_ms = 0;
        double psnr = 0; ///< decibels, peak 1, against converged path tracing
    };
    struct Curve {
        VolumeTechnique technique;
        std::vector<Entry> entries; ///< by rising steps and time, two or more
    };
    std::string name;
    VolumeFeatures features;
    std::vector<Curve> curves; ///< one of them of path, which reaches kProbeSteps
};

struct VolumeChart {
    std::string device; ///< that the times are of
    std::vector<VolumeClass> classes;
};

/// Throws Error(input) naming file, key and what was found.
VolumeChart load_volume_chart(const std::filesystem::path& path);
/// The one that comes with the program, of its built-in scenes.
VolumeChart builtin_volume_chart();
std::string to_json(const VolumeChart& chart);

/// Steps of path tracing that a probe takes: two halves with seeds of their own, whose difference
/// tells how far their mean is from what it converges to.
inline constexpr int kProbeSteps = 8;

/// Path tracing of the scene that a choice is wanted for, after kProbeSteps.
struct VolumeProbe {
    VolumeFeatures features;
    double gpu_ms = 0;
    double psnr = 0; ///< estimated
};
/// As a class's own path tracing would have given it.
VolumeProbe probe_of(const VolumeClass& scenes);

struct VolumeChoice {
    std::string class_name;
    VolumeTechnique technique;
    double steps = 1;
    double psnr = 0, gpu_ms = 0; ///< predicted
    bool reached = true;         ///< false: the curves end before what was asked for
};

/// The class whose features are nearest.
const VolumeClass& class_of(const VolumeChart& chart, const VolumeFeatures& features);
/// What is predicted of a technique after so many steps, with times and errors in the proportion
/// of the probe's to the class's. The class must have a curve of it.
VolumeChoice predict(const VolumeClass& scenes, const VolumeProbe& probe,
    const VolumeTechnique& technique, double steps);
/// What is predicted to keep `decibels` soonest.
VolumeChoice choose_by_psnr(const VolumeChart& chart, const VolumeProbe& probe, double decibels);
/// What is predicted to be best after `milliseconds` of GPU time.
VolumeChoice choose_by_time(
    const VolumeChart& chart, const VolumeProbe& probe, double milliseconds);

} // namespace ockham
