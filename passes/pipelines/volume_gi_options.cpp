// SPDX-License-Identifier: Apache-2.0
#include "passes/pipelines/volume_gi_options.hpp"

#include <limits>

namespace ockham {

void add_volume_gi_options(Params& params, VolumeGiOptions& o) {
    const auto add = [&](const char* name, Param::Target target, const char* help) -> Param& {
        return params.add(name, target, help).group("Method");
    };
    add("mode", &o.mode, "how light is found; auto says what it picks")
        .choices({"path", "noncaching", "caching", "auto"});
    add("sampler", &o.sampler, "random numbers").choices({"independent", "sobol"});
    add("majorant", &o.majorant, "bounds of the extinction, for free flights")
        .choices({"global", "grid"});
    add("nee", &o.nee,
        "samples an environment map at collisions; off: it is met by chance (the sun is always "
        "sampled)")
        .on_off();
    add("max-bounces", &o.max_bounces, "most scatterings of a path; -1: no bound")
        .range(-1, 1 << 30);
    add("gather", &o.gather,
        "mode caching: paths to an exact collision, then the cache; off: composes from the cache")
        .on_off();
    add("cache-scale", &o.cache_scale, "mode caching: voxels along a side of a cell")
        .choices({"1", "2", "4"});
    add("cache-format", &o.cache_format, "mode caching: how a cell's light is kept")
        .choices({"fp32", "fp16", "rgb9e5"});
    add("iso-occlusion", &o.iso_occlusion, "mode caching: surfaces keep light out of the cache")
        .on_off();
    add("surface-search", &o.surface_search,
        "how a composition (--gather off) finds surfaces; paths meet them exactly")
        .choices({"stochastic", "march", "exact"});
    add("seed", &o.seed, "of all random numbers: equal seeds, equal pictures")
        .range(0, std::numeric_limits<int>::max());
}

std::optional<VolumeMode> volume_mode(const VolumeGiOptions& o) {
    for (const VolumeMode mode : {VolumeMode::path, VolumeMode::noncaching, VolumeMode::caching})
        if (o.mode == name_of(mode)) return mode;
    return {};
}

VolumeGiParams volume_gi_params(const VolumeGiOptions& o, VolumeMode mode) {
    VolumeGiParams p;
    p.mode = mode;
    p.sobol = o.sampler == "sobol";
    p.majorant_grid = o.majorant == "grid";
    p.nee = o.nee;
    p.gather = o.gather;
    p.cache_scale = static_cast<std::uint32_t>(o.cache_scale);
    p.cache_format = o.cache_format == "fp32"   ? CacheFormat::fp32
                     : o.cache_format == "fp16" ? CacheFormat::fp16
                                                : CacheFormat::rgb9e5;
    p.iso_occlusion = o.iso_occlusion;
    p.search = o.surface_search == "stochastic" ? SurfaceSearch::stochastic
               : o.surface_search == "march"    ? SurfaceSearch::march
                                                : SurfaceSearch::exact;
    return p;
}

void apply(const VolumeGiOptions& o, VolumeView& view) {
    view.seed = static_cast<std::uint32_t>(o.seed);
    if (o.max_bounces >= 0) view.max_bounces = static_cast<std::uint32_t>(o.max_bounces);
}

} // namespace ockham
