// SPDX-License-Identifier: Apache-2.0
// What the shading kernels (first_sample, shade) share: their inputs, how they are declared, and
// which variant and specialisation a scene needs.
#pragma once

#include "passes/surface/gbuffer.hpp"
#include "passes/volume/medium_inputs.hpp"

#include <optional>
#include <string>

namespace ockham::shader {
struct ShadePush;
} // namespace ockham::shader

namespace ockham {

struct ShadingInputs {
    SceneInputs scene;
    Gbuffer gbuffer;
    ImageHandle shadow_map; ///< empty: no shadow
    /// What samples take from all of their surface, surface_means.hpp; empty: nothing.
    ImageHandle means = {};
    bool demodulate = false, filter_highlights = false; ///< which of the means are used
    BufferHandle frame_before = {}; ///< FrameData of the execution before; empty: the camera stays
    std::optional<MediumInputs> medium = {}; ///< stands before what is seen, and before its lights
};

struct ShadingParams {
    std::uint32_t width = 0, height = 0; ///< pixels
    std::uint32_t m = 1;
    std::uint32_t stall = 0;       ///< dependent FMAs per shaded sample
    std::uint32_t anisotropy = 16; ///< most texture taps per lookup, 1 ... 16
};

/// Pushed to kernels that shade one sample at a time.
shader::ShadePush one_sample_push(const ShadingParams& params);

/// Declares everything that shaders/surface/shade_sample.glsl reads.
void read_shading(PassBuilder& pass, const ShadingInputs& in, Stage stage = Stage::compute);
/// `shader` with the scene's features; `mode`: an extra leading feature, or empty.
std::string shading_variant(
    std::string_view shader, std::string_view mode, const ShadingInputs& in);
/// Of such kernels: the scene's lights, what the G-buffer's layout needs, and of those that are
/// `stratified` which means are used.
Specialization shading_specialization(const ShadingInputs& in, bool stratified = false);

/// Loop iterations of one shaded sample, at most: stall, lights, texture taps and ways through a
/// medium together.
std::uint32_t iterations_per_sample(const SceneFacts& facts, const ShadingParams& params,
    const std::optional<MediumInputs>& medium = {});
/// Iterations that one invocation may spend: software drivers stop a kernel silently at 65,535.
inline constexpr std::uint32_t kIterationBudget = 50000;
/// Samples that one invocation may shade within kIterationBudget. Throws Error(input) if not one.
std::uint32_t samples_per_dispatch(const SceneFacts& facts, const ShadingParams& params,
    const std::optional<MediumInputs>& medium = {});

} // namespace ockham
