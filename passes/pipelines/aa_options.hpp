// SPDX-License-Identifier: Apache-2.0
// What a user can choose of adaptive_aa, declared once: flags, run files and the viewer's widgets
// read the same list. Names to enums, presets to parameters. Called by programs.
#pragma once

#include "framework/core/params.hpp"
#include "passes/pipelines/aa_graph.hpp"

#include <string>

namespace ockham {

/// As on the command line; docs/cli.md says what each may be.
struct AaOptions {
    static constexpr const char* kByPreset = "preset";

    int m = 4;
    std::string method = "adaptive";
    int k = 1;
    std::string preset = "ockham";
    std::string metric = kByPreset;
    float lambda = kDefaultLambda;
    bool history = true;
    float budget = -1;
    std::string order = kByPreset;
    std::string dispatch = "buckets";
    std::string k_levels = "all", k_filter;
    std::string resolve = kByPreset;
    bool demodulate = false;
    std::string filter_highlights = kByPreset;
    std::string gbuffer = "auto";
    int tile = 0;
    float depth_weight = -1, normal_weight = -1, shading_weight = -1; ///< < 0: by the window
    MetricsParams metrics;
    int stall = 0;
    int anisotropy = 16;
    float bloom = 0, bloom_width = 2;
};

/// Declares them in the group "Method"; `options` must outlive `params`.
void add_aa_options(Params& params, AaOptions& options);

/// All but the picture's size, what else to export, and history, which is on where it was not
/// switched off. Throws Error(input) naming the flag.
AdaptiveAaParams aa_params(const AaOptions& options);

} // namespace ockham
