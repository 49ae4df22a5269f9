// SPDX-License-Identifier: Apache-2.0
// A volume from the command line: the field, what its values look like, what is cut away, the light
// around it. Says what was inferred. Shared by the samples that render volumes.
#pragma once

#include "framework/app/cli.hpp"
#include "framework/core/image.hpp"
#include "framework/scene/transfer_function.hpp"
#include "framework/scene/volume.hpp"
#include "framework/scene/volume_view.hpp"

#include <nlohmann/json_fwd.hpp>

#include <string>
#include <vector>

namespace ockham {

/// As on the command line; docs/cli.md says what each may be.
struct VolumeOptions {
    std::vector<std::string> volume; ///< at most one; none: builtin:cloud
    std::string transfer, window;
    std::string light, environment;
    std::string crop;
    std::vector<std::string> clip_planes;
    std::string iso, iso_material;
    std::string shading = "lambert";
    float density_scale = 100, albedo = 1, phase_g = 0;
    float surface_gain = 1, volume_gain = 1;
};

void add_volume_options(Params& params, VolumeOptions& options);
/// The same for programs that name volume and environment themselves.
void add_volume_flags(Params& params, VolumeOptions& options);

struct VolumeSource {
    Volume volume;
    TransferFunction transfer;
    Image environment; ///< linear R, G, B, equirectangular; empty: one colour, in the view
    VolumeView view;   ///< without seed and bounces
};

/// Of what the files hold, whatever they are called: {"volume", "transfer function", "environment",
/// "materials"}, a fingerprint each. What decides a picture besides flags that name no file.
nlohmann::ordered_json fingerprints_of(const VolumeSource& source);

/// Loads, and logs what it is and what was inferred. Throws Error(input) naming the file or the
/// flag, what was found there and what is expected.
VolumeSource load_volume_source(const VolumeOptions& options);

/// Of a source that is there, after options have changed: all but volume and transfer function anew,
/// or the transfer function. Seed and bounces of the view are lost. Throw as load_volume_source().
void update_view(const VolumeOptions& options, VolumeSource& source);
void update_transfer(const VolumeOptions& options, VolumeSource& source);

} // namespace ockham
