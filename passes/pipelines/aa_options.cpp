// SPDX-License-Identifier: Apache-2.0
#include "passes/pipelines/aa_options.hpp"

#include "framework/core/error.hpp"

#include <charconv>
#include <limits>

namespace ockham {
namespace {

/// Block size of "max:N"; empty: 1.
std::uint32_t parse_k_filter(const std::string& text) {
    if (text.empty()) return 1;
    std::uint32_t block = 0;
    const char* end = text.data() + text.size();
    if (!text.starts_with("max:") ||
        std::from_chars(text.data() + 4, end, block) != std::from_chars_result{end, std::errc{}} ||
        block < 1 || block > 64)
        fail_input("--k-filter: expected max:N with N from 1 to 64, found '{}'", text);
    return block;
}

/// `choice`, or what the preset says.
std::string choose(
    const AaOptions& o, const std::string& choice, const char* ockham, const char* paper) {
    if (choice != AaOptions::kByPreset) return choice;
    return o.preset == "paper" ? paper : ockham;
}

} // namespace

void add_aa_options(Params& params, AaOptions& o) {
    constexpr const char* kByPreset = AaOptions::kByPreset;
    const char* kMethod = "Method";
    const auto add = [&](const char* name, Param::Target target, const char* help) -> Param& {
        return params.add(name, target, help).group(kMethod);
    };
    add("m", &o.m, "window width: m x m samples per pixel").range(1, 8);
    add("method", &o.method, "anti-aliasing")
        .choices({"none", "fxaa", "smaa", "sraa", "taa", "msaa", "cluster", "uniform", "ssaa",
            "adaptive"});
    add("k", &o.k, "samples per pixel of --method uniform").range(1, 64);
    add("preset", &o.preset,
        "metric, order, resolve, filter-highlights at once: ockham is ockham, optimal, stratified, "
        "on; paper is paper, paper, prefix, off")
        .choices({"ockham", "paper"});
    add("metric", &o.metric, "what decides the samples per pixel")
        .choices({kByPreset, "paper", "ockham"});
    add("lambda", &o.lambda,
        "metric ockham: squared error that a sample must remove; 0: all samples, inf: one")
        .range(0, std::numeric_limits<double>::infinity());
    add("history", &o.history, "metric ockham, moving cameras: counts fall little by little")
        .on_off();
    add("c-depth", &o.depth_weight,
        "metric paper: weight of the depth variance; -1: 15 m (60 at 4 x 4)")
        .range(-1, 1e9)
        .unit("samples per squared scene unit");
    add("c-normal", &o.normal_weight,
        "metric paper: weight of the normal cone; -1: 3 m (12 at 4 x 4)")
        .range(-1, 1e9)
        .unit("samples");
    add("c-shading", &o.shading_weight,
        "metric paper: weight of the luma range; -1: 10 m (40 at 4 x 4)")
        .range(-1, 1e9)
        .unit("samples");
    add("t-min", &o.metrics.range_min, "metric paper: luma ranges below count as flat").range(0, 1);
    add("t-edge", &o.metrics.range_edge,
        "metric paper: so do ranges below this share of the brightest")
        .range(0, 1);
    add("budget", &o.budget,
        "metric ockham: samples to spend in place of --lambda, at least one a pixel; -1: by lambda")
        .range(-1, 100)
        .unit("percent of all samples");
    add("order", &o.order,
        "order of a window's samples: printed, or of least rms or least worst coverage error")
        .choices({kByPreset, "paper", "optimal", "worst"});
    add("dispatch", &o.dispatch, "how pixels of unequal counts meet the lanes of the device")
        .choices({"loop", "buckets", "repack", "stencil", "depth", "sort"});
    add("k-levels", &o.k_levels, "counts: all, or rounded up to powers of two and m x m")
        .choices({"all", "pow2"});
    add("k-filter", &o.k_filter,
        "max:N, N 1 to 64: N x N pixels share the largest of their counts");
    add("resolve", &o.resolve,
        "which samples make a pixel: the first k in order, or k shared out among its surfaces")
        .choices({kByPreset, "prefix", "stratified"});
    add("demodulate", &o.demodulate,
        "resolve stratified: light is averaged apart from albedo, whose mean is exact")
        .on_off();
    add("filter-highlights", &o.filter_highlights,
        "resolve stratified: highlights as wide as the normals that a sample stands for")
        .choices({kByPreset, "on", "off"});
    add("gbuffer", &o.gbuffer, "layout of the G-buffer; auto: packed where it fits")
        .choices({"auto", "packed", "visibility"});
    add("tile", &o.tile, "side of the largest screen tile; 0: the picture, or as much as fits")
        .range(0, 16384)
        .unit("pixels");
    add("anisotropy", &o.anisotropy, "most texture taps per lookup").range(1, 16);
    add("stall", &o.stall,
        "dependent multiply-adds per shaded sample, in sixteens: stands in for costly shading")
        .range(0, 500000);
    add("bloom", &o.bloom, "share of the light that a lens scatters around; 0: no bloom")
        .range(0, 1);
    add("bloom-width", &o.bloom_width, "standard deviation of where bloom goes")
        .range(0.1, 10)
        .unit("percent of the height");
}

AdaptiveAaParams aa_params(const AaOptions& o) {
    AdaptiveAaParams p;
    p.m = static_cast<std::uint32_t>(o.m);
    p.method = o.method == "none"      ? AaMethod::none
               : o.method == "fxaa"    ? AaMethod::fxaa
               : o.method == "smaa"    ? AaMethod::smaa
               : o.method == "sraa"    ? AaMethod::sraa
               : o.method == "taa"     ? AaMethod::taa
               : o.method == "msaa"    ? AaMethod::msaa
               : o.method == "cluster" ? AaMethod::cluster
               : o.method == "uniform" ? AaMethod::uniform
               : o.method == "ssaa"    ? AaMethod::ssaa
                                       : AaMethod::adaptive;
    p.k = static_cast<std::uint32_t>(o.k);
    for (const Dispatch dispatch : kDispatches) {
        if (o.dispatch == name_of(dispatch)) p.dispatch = dispatch;
    }
    p.powers_of_two = o.k_levels == "pow2";
    p.count_block = parse_k_filter(o.k_filter);
    if (o.gbuffer == "packed") p.gbuffer = GbufferLayout::packed;
    if (o.gbuffer == "visibility") p.gbuffer = GbufferLayout::visibility;
    p.tile = glm::uvec2(static_cast<std::uint32_t>(o.tile));
    p.metric =
        choose(o, o.metric, "ockham", "paper") == "ockham" ? MetricKind::ockham : MetricKind::paper;
    const std::string order = choose(o, o.order, "optimal", "paper");
    p.order_kind = order == "optimal" ? SampleOrder::optimal
                   : order == "worst" ? SampleOrder::worst
                                      : SampleOrder::paper;
    p.resolve = choose(o, o.resolve, "stratified", "prefix") == "stratified" ? Resolve::stratified
                                                                             : Resolve::prefix;
    p.demodulate = o.demodulate;
    p.filter_highlights = choose(o, o.filter_highlights, "on", "off") == "on";
    p.lambda = o.lambda;
    p.history = o.history;
    p.budget = o.budget;
    p.metrics = default_metrics(p.m);
    if (o.depth_weight >= 0) p.metrics.depth_weight = o.depth_weight;
    if (o.normal_weight >= 0) p.metrics.normal_weight = o.normal_weight;
    if (o.shading_weight >= 0) p.metrics.shading_weight = o.shading_weight;
    p.metrics.range_min = o.metrics.range_min;
    p.metrics.range_edge = o.metrics.range_edge;
    p.stall = static_cast<std::uint32_t>(o.stall);
    p.anisotropy = static_cast<std::uint32_t>(o.anisotropy);
    p.bloom = o.bloom;
    p.bloom_width = o.bloom_width;
    return p;
}

} // namespace ockham
