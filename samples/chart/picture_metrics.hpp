// SPDX-License-Identifier: Apache-2.0
// Metrics that somebody else's program or network computes, of pictures that a chart has kept:
// VMAF, and LPIPS or whatever an ONNX file holds. Each pair of pictures is measured once; what was
// found stands in metrics.json. Made by main.cpp, called by what draws.
#pragma once

#include "framework/core/image.hpp"
#include "samples/chart/page.hpp"

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace ockham::chart {

struct ChartOptions;

class PictureMetrics {
public:
    struct Metric {
        std::string name;  ///< of files and columns: "vmaf"
        std::string title; ///< with what made it: "VMAF (vmaf_v0.6.1.pkl, libvmaf 1.3.7)"
        Better better;
        std::function<double(const Image& test, const Image& reference)> measure;
    };

    /// Those that there are. Throws Error(input) for what the options name and is no such thing.
    explicit PictureMetrics(const ChartOptions& options);

    const std::vector<Metric>& all() const { return metrics_; }
    /// A line for each: what made it, or why there is none.
    const Manifest& manifest() const { return manifest_; }

    /// Of two PNG files, relative to the options' folder; nothing, with a warning, where it cannot
    /// be measured.
    std::optional<double> of(const Metric& metric, const std::filesystem::path& test,
        const std::filesystem::path& reference);

    /// A row for each picture under the wipes that has a reference; none: no table.
    std::optional<Table> table(const std::string& suite, const std::vector<Wipe>& wipes);

private:
    std::filesystem::path folder_;
    std::vector<Metric> metrics_;
    Manifest manifest_;
    std::map<std::string, double> known_; ///< by metric and content of both files
};

} // namespace ockham::chart
