// SPDX-License-Identifier: Apache-2.0
// Chooses lambda of the default metric for an error or a time that is asked for, from curves that
// `chart --suite aa` has measured on classes of scenes. Which class a view is of, and how fast this
// machine is, one frame at a known lambda tells. Called by adaptive_aa and by charts.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace ockham {

/// A class of scenes: what each lambda costs and gives there.
struct AaClass {
    struct Entry {
        double lambda = 0;
        double samples_percent = 0;
        double psnr = 0; ///< decibels, peak 1, against all samples
        double total_gpu_ms = 0;
    };
    std::string name;
    std::vector<Entry> entries; ///< by rising lambda, two or more
};

struct AaChart {
    std::uint32_t m = 4;
    std::string device; ///< that the times are of
    std::vector<AaClass> classes;
};

/// Throws Error(input) naming file, key and what was found.
AaChart load_aa_chart(const std::filesystem::path& path);
/// The one that comes with the program, of its built-in scenes.
AaChart builtin_aa_chart();
std::string to_json(const AaChart& chart);

/// A measured frame of the view that a choice is wanted for.
struct AaProbe {
    double lambda = 0;
    double samples_percent = 0;
    double total_gpu_ms = 0;
};

struct AaChoice {
    std::string class_name;
    double lambda = 0;
    double psnr = 0;         ///< predicted
    double total_gpu_ms = 0; ///< predicted: the probe's, in proportion to the class's
    bool reached = true;     ///< false: the curve ends before what was asked for
};

/// The class whose share of samples at the probe's lambda is nearest, as a ratio.
const AaClass& class_of(const AaChart& chart, const AaProbe& probe);
/// What a class says of another lambda than the probe's.
AaChoice predict(const AaClass& scenes, const AaProbe& probe, double lambda);
/// The largest lambda that is predicted to keep `decibels`. Values between entries are interpolated
/// over log lambda, as if neither error nor time ever rose with it against the trend.
AaChoice choose_by_psnr(const AaChart& chart, const AaProbe& probe, double decibels);
/// The smallest lambda that is predicted to take `milliseconds` at most.
AaChoice choose_by_time(const AaChart& chart, const AaProbe& probe, double milliseconds);

} // namespace ockham
