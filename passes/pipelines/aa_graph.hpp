// SPDX-License-Identifier: Apache-2.0
// The graph of adaptive supersampling for deferred shading (Hollaender, Boubekeur, Eisemann, JCGT
// 2013) and of its reference methods; adaptive_aa.hpp executes it:
//   gbuffer -> [clusters] -> first_sample -> metrics -> buckets -> shade -> resolve
// Passes that the method, m or the scene does not need are not declared, and the plan says why.
#pragma once

#include "passes/pipelines/screen_tiles.hpp"
#include "passes/schedule/dispatch.hpp"
#include "passes/surface/allocate.hpp"
#include "passes/surface/metrics.hpp"
#include "passes/surface/sample_order.hpp"
#include "passes/surface/shading_inputs.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ockham {

enum class AaMethod {
    none,     ///< one sample per pixel, whatever m
    fxaa,     ///< the same, smoothed along the edges that the picture shows
    smaa,     ///< likewise
    sraa,     ///< one sample per pixel, spread over m x m geometry
    taa,      ///< one sample per pixel and frame, gathered over the frames
    msaa,     ///< 4 samples (m = 2): all where a pixel sees several surfaces, else one
    cluster,  ///< one sample of each surface that a pixel sees, weighed by coverage
    uniform,  ///< the same k everywhere
    ssaa,     ///< all m x m samples
    adaptive, ///< k by the metrics
};

enum class MetricKind {
    paper,  ///< depth, normals and S by three weights
    ockham, ///< expected variance, by one lambda
};

enum class Resolve {
    prefix,     ///< the mean of the first k samples in order
    stratified, ///< k is shared out among the window's surfaces, whose means weigh by coverage
};

struct AdaptiveAaParams {
    std::uint32_t width = 1024, height = 768; ///< pixels
    std::uint32_t m = 4;                      ///< window width in samples, 1 ... 8
    AaMethod method = AaMethod::adaptive;
    std::uint32_t k = 1; ///< uniform only, 1 ... m * m
    Dispatch dispatch = Dispatch::buckets;
    bool powers_of_two = false;    ///< counts are rounded up to powers of two, n stays
    std::uint32_t count_block = 1; ///< pixels per block and axis that share the largest count
    SampleOrder order_kind = SampleOrder::paper;
    std::vector<std::uint32_t> order; ///< samples by rank; empty: sample_order(order_kind, m)
    Resolve resolve = Resolve::prefix;
    bool demodulate = false;        ///< stratified only: samples have the mean albedo of theirs
    bool filter_highlights = false; ///< stratified only: and lobes that hold the normals of theirs
    MetricKind metric = MetricKind::paper;
    MetricsParams metrics;         ///< paper only; its size is set from here
    float lambda = kDefaultLambda; ///< ockham only: price of a sample, 0 ... infinity
    bool history = false;          ///< ockham only, the camera moves: counts fall little by little
    float budget = -1; ///< ockham only: percent of all samples, 100 / n ... 100; < 0: by lambda
    std::optional<GbufferLayout> gbuffer; ///< empty: packed if it fits, else visibility
    glm::uvec2 tile{0};                   ///< largest screen tile, pixels; 0: as much as fits
    const ScreenTile* view = nullptr;     ///< of the G-buffer; AdaptiveAa's own
    glm::uvec2 part_of{0};                ///< the picture is a part of one of that size; 0: of none
    std::uint32_t stall = 0;              ///< dependent FMAs per shaded sample
    std::uint32_t anisotropy = 16;        ///< 1 ... 16
    float bloom = 0;                      ///< share of the light that a lens scatters, 0 ... 1
    float bloom_width = 2;                ///< standard deviation of that, percent of the height
    bool aov = false;                     ///< export k, winner, S, depth, normal, material too
    bool export_counts = false;           ///< export k
    std::vector<std::string> captures;    ///< names of further images to export
    std::string no_medium; ///< where there could be a medium, why there is none: for explain
};

/// The parameters with everything derived: m = 1 and "none" are the same picture. Throws
/// Error(input) for what is out of range.
AdaptiveAaParams settled(AdaptiveAaParams params);
/// Methods that filter pictures of one sample per pixel.
bool filters_picture(AaMethod method);
/// True where pixels differ in their counts, or in how these are shared out among surfaces.
bool needs_counts(const AdaptiveAaParams& params);

/// True for the passes that shading_gpu_ms adds up: first_sample, metrics, buckets, shade, resolve.
bool is_shading_pass(std::string_view pass);

/// What the graph holds after an execution; empty handles: not needed or not asked for.
struct AdaptiveAaOutputs {
    ImageHandle radiance; ///< rgba32f: linear radiance, share of samples that hit
    ImageHandle first_sample, sample_count, winner, aov_surface, aov_material;
    Gbuffer gbuffer;
    ImageHandle labels;                ///< of Clusters; with a medium always there, but at m = 1
    std::vector<ImageHandle> captures; ///< as in the parameters
};

/// Declares the graph. `in.gbuffer` is filled here. With `in.medium` the picture is that of the
/// surfaces alone, part of another, and is not exported.
AdaptiveAaOutputs add_adaptive_aa(
    Graph& graph, ShadingInputs in, const AdaptiveAaParams& params, std::uint32_t max_extent);

} // namespace ockham
