// SPDX-License-Identifier: Apache-2.0
// What a user can choose of volume_gi, declared once: flags, run files and the viewer's widgets
// read the same list. Names to enums. Called by programs.
#pragma once

#include "framework/core/params.hpp"
#include "passes/pipelines/volume_gi.hpp"

#include <optional>
#include <string>

namespace ockham {

/// As on the command line; docs/cli.md says what each may be.
struct VolumeGiOptions {
    std::string mode = "auto";
    std::string sampler = "sobol";
    std::string majorant = "grid";
    bool nee = true;
    int max_bounces = -1;
    bool gather = true;
    int cache_scale = 2;
    std::string cache_format = "fp16";
    bool iso_occlusion = true;
    std::string surface_search = "exact";
    int seed = 1;
};

/// Declares them in the group "Method"; `options` must outlive `params`.
void add_volume_gi_options(Params& params, VolumeGiOptions& options);

/// --mode; nothing where it is `auto`.
std::optional<VolumeMode> volume_mode(const VolumeGiOptions& options);
/// All but the picture's size and what else to export.
VolumeGiParams volume_gi_params(const VolumeGiOptions& options, VolumeMode mode);
/// What of them is part of the view: seed and bounces.
void apply(const VolumeGiOptions& options, VolumeView& view);

} // namespace ockham
