// SPDX-License-Identifier: Apache-2.0
// Measures anti-aliasing methods on one view, each over its knob: samples, times and error against
// all m x m samples. Settings that stand beside each other are executed in turns with the
// reference, so that a noisy machine hurts all alike. Called by aa_curve; charts share the settings
// and the judgement.
#pragma once

#include "framework/app/report.hpp"
#include "passes/pipelines/adaptive_aa.hpp"

#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace ockham {

/// A method at one position of its knob.
struct AaSetting {
    std::string method; ///< as in the table
    double knob = 0;    ///< k, scale of the constants, lambda; 0 where there is none
    AdaptiveAaParams params;
};

/// One row of the table; NaN: not known.
struct AaPoint {
    static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
    std::string method;
    double knob = 0;
    std::uint32_t m = 1;
    double samples_percent = 0; ///< shaded samples, of m x m per pixel
    double shading_gpu_ms = kUnknown, total_gpu_ms = kUnknown;
    /// The reference's, executed in turns with this one.
    double reference_shading_gpu_ms = kUnknown, reference_total_gpu_ms = kUnknown;
    double mse = 0, psnr = 0; ///< displayed, against the reference
    double ssim = kUnknown, flip = kUnknown;
};

/// Where the knobs are put.
struct AaKnobs {
    std::vector<std::uint32_t> counts; ///< uniform; empty: 1 ... n - 1
    std::vector<double> scales{0.125, 0.25, 0.5, 1, 2, 4};
    std::vector<double> lambdas; ///< empty: 1e-6 ... 0.02, two a decade
};

/// What there is to compare at the window width of `base`, whose other parameters all share:
/// no, filtered and multisampled, uniform, adaptive and full supersampling. TAA is not there: what
/// it shades depends on the frames before.
std::vector<AaSetting> aa_settings(const AdaptiveAaParams& base, AaKnobs knobs = {});

/// Samples and error of a picture that `aa` made, of whose m x m samples `reference` has all.
AaPoint judge_aa(const AaSetting& setting, AdaptiveAa& aa, const Image& picture,
    const Image& reference, std::uint32_t m);

/// All samples of all pixels, m times as wide and high: one sample in each pixel of a larger
/// picture.
Image all_samples(
    gpu::Device& device, const LitScene& scene, const Camera& camera, AdaptiveAaParams params);

class AaSweep {
public:
    /// `repeats`: executions of each setting after one that warms up, >= 1. What is passed must
    /// outlive this object.
    AaSweep(gpu::Device& device, const LitScene& scene, const Camera& camera,
        const AdaptiveAaParams& base, int repeats);

    const Image& reference() const { return reference_; }
    /// Measures each setting and shows it with its picture. Stops early where `visit` returns
    /// false.
    void measure(const std::vector<AaSetting>& settings,
        const std::function<bool(const AaSetting&, const AaPoint&, const Image&)>& visit);

private:
    gpu::Device& device_;
    const LitScene& scene_;
    Camera camera_;
    AdaptiveAaParams reference_params_;
    int repeats_;
    Image reference_;
};

/// A heading and one row per point; what is not known stays empty.
std::string aa_csv(const std::vector<AaPoint>& points);

} // namespace ockham
