// SPDX-License-Identifier: Apache-2.0
#include "passes/pipelines/adaptive_aa.hpp"

#include "framework/core/error.hpp"
#include "framework/core/log.hpp"
#include "framework/runtime/planning.hpp"
#include "passes/post/taa.hpp"
#include "passes/schedule/dispatch.hpp"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <optional>

namespace ockham {
namespace {

/// Pixels around each pixel that decide about it: their samples, and what variance the neighbours
/// expect of theirs.
std::uint32_t reach_of(const AdaptiveAaParams& params) {
    return params.method == AaMethod::adaptive && params.metric == MetricKind::ockham ? 2 : 1;
}

/// Pixels that stay in one tile: the blocks of --k-filter, and the quads of 2 x 2 samples over
/// which alpha tests take derivatives.
std::uint32_t block_of(const AdaptiveAaParams& params) {
    return std::lcm(params.count_block, params.m % 2 == 0 ? 1u : 2u);
}

std::uint32_t apron_of(const AdaptiveAaParams& params) {
    const std::uint32_t block = block_of(params);
    return (reach_of(params) + block - 1) / block * block;
}

bool keeps_history(const AdaptiveAaParams& params) {
    return params.history && params.method == AaMethod::adaptive &&
           params.metric == MetricKind::ockham;
}

/// Why the picture cannot be put together of tiles; empty: it can.
std::string whole_picture_reason(const AdaptiveAaParams& params) {
    if (params.method == AaMethod::taa) return "--method taa keeps pictures of earlier frames";
    if (filters_picture(params.method)) return "its --method looks farther around than one pixel";
    if (params.bloom > 0) return "--bloom gathers light from far around";
    if (keeps_history(params)) return "--history keeps variances of earlier frames";
    if (params.budget >= 0)
        return "--budget shares samples out over all pixels at once; use --lambda";
    if (!params.captures.empty()) return "--capture would show one tile";
    return "";
}

double mib(std::uint64_t bytes) { return static_cast<double>(bytes) / (1 << 20); }

} // namespace

AdaptiveAa::AdaptiveAa(
    gpu::Device& device, const LitScene& lit, const Camera& camera, const AdaptiveAaParams& params)
    : lit_(&lit), params_(settled(params)), max_extent_(device.limits().attachment_extent) {
    if (needs_counts(params_) && params_.dispatch == Dispatch::stencil &&
        !device.exports_stencil()) {
        fail_device("--dispatch stencil needs VK_EXT_shader_stencil_export, which '{}' lacks; "
                    "--dispatch depth does the same without it",
            device.info().name);
    }
    if (params_.part_of.x > 0) params_.gbuffer = GbufferLayout::visibility; // as screen tiles
    fit_ = choose_fit(device);
    const glm::uvec2 picture(params_.width, params_.height);
    tiles_ = place_tiles(picture, fit_.tile, apron_of(params_), block_of(params_));
    if (tiles_.size() > 1 || params_.part_of.x > 0) view_ = std::make_unique<ScreenTile>();
    if (!fit_.reason.empty()) {
        log::warning("{}: {}", fit_.reason,
            tiles_.size() > 1
                ? fmt::format("drawn in {} tiles of {} x {} pixels, --gbuffer visibility",
                      tiles_.size(), fit_.tile.x, fit_.tile.y)
                : "--gbuffer visibility instead");
    }
    constexpr std::uint64_t kBytes = sizeof(shader::FrameData);
    frame_ = std::make_unique<gpu::Buffer>(device, gpu::BufferInfo{.bytes = kBytes,
                                                       .usage = VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT,
                                                       .name = "frame",
                                                       .memory = gpu::MemoryUse::upload});
    set_camera(camera);
    if (keeps_history(params_)) {
        frame_before_ =
            std::make_unique<gpu::Buffer>(device, gpu::BufferInfo{.bytes = kBytes,
                                                      .usage = VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT,
                                                      .name = "frame_before",
                                                      .memory = gpu::MemoryUse::upload});
        std::memcpy(frame_before_->mapped().data(), frame_->mapped().data(), kBytes);
    }
    Declared declared = declare(fit_);
    outputs_ = declared.outputs;
    kept_ = {outputs_.radiance};
    if (params_.aov || params_.export_counts) kept_.push_back(outputs_.sample_count);
    if (params_.aov) {
        kept_.insert(kept_.end(),
            {outputs_.first_sample, outputs_.winner, outputs_.aov_surface, outputs_.aov_material});
    }
    std::erase_if(kept_, [](ImageHandle image) { return !image; });
    executor_ = std::make_unique<Executor>(device, std::move(declared.graph));
    lit.gpu().bind(*executor_, declared.in.scene.handles);
    executor_->bind(declared.in.scene.frame, *frame_);
    if (frame_before_) executor_->bind(declared.in.frame_before, *frame_before_);
    if (declared.in.shadow_map) executor_->bind(declared.in.shadow_map, *lit.shadow_map());
}

AdaptiveAa::Declared AdaptiveAa::declare(const Fit& fit) const {
    Declared out;
    out.in.scene.scene = &lit_->gpu();
    out.in.scene.handles = lit_->gpu().import(out.graph);
    out.in.scene.frame = out.graph.import_buffer("frame", {sizeof(shader::FrameData)}, {});
    if (keeps_history(params_))
        out.in.frame_before =
            out.graph.import_buffer("frame_before", {sizeof(shader::FrameData)}, {});
    if (const gpu::Image* map = lit_->shadow_map()) {
        out.in.shadow_map = out.graph.import_image("shadow_map",
            {.format = map->info().format,
                .width = map->info().width,
                .height = map->info().height},
            state_of(Access::sampled, Stage::compute));
    }
    AdaptiveAaParams part = params_;
    part.width = fit.tile.x;
    part.height = fit.tile.y;
    part.gbuffer = fit.layout;
    part.view = view_.get();
    out.outputs = add_adaptive_aa(out.graph, out.in, part, max_extent_);
    return out;
}

AdaptiveAa::Fit AdaptiveAa::choose_fit(gpu::Device& device) const {
    const glm::uvec2 picture(params_.width, params_.height);
    if (params_.gbuffer == GbufferLayout::packed) return {GbufferLayout::packed, picture, {}};
    const bool cut = params_.tile.x > 0; // on request
    std::string reason;
    std::optional<Fit> tried; // what did not fit last
    if (!params_.gbuffer && !cut) {
        tried = Fit{GbufferLayout::packed, picture, {}};
        reason = obstacle(device, *tried);
        if (reason.empty()) return *tried;
    }
    glm::uvec2 most = cut ? params_.tile : picture;
    most = glm::min(most, glm::uvec2(max_extent_ / params_.m));
    for (;;) {
        Fit fit{GbufferLayout::visibility, {}, reason};
        for (int axis = 0; axis < 2; ++axis) {
            fit.tile[axis] =
                tile_extent(picture[axis], most[axis], apron_of(params_), block_of(params_));
        }
        const std::string whole = whole_picture_reason(params_);
        if (fit.tile != picture && !whole.empty())
            fail_device("{}: screen tiles cannot help, for {}{}", cut ? "--tile" : reason, whole,
                refusal(device, tried));
        if (fit.tile.x == 0 || fit.tile.y == 0)
            fail_device("{}: not even {} x {} pixels fit{}", reason, most.x, most.y,
                refusal(device, tried));
        const std::string why = obstacle(device, fit);
        if (why.empty()) return fit;
        tried = fit;
        if (reason.empty()) reason = why;
        const int longer = fit.tile.x >= fit.tile.y ? 0 : 1;
        most = fit.tile;
        most[longer] = (most[longer] + 1) / 2;
    }
}

/// Why the G-buffer does not fit so; empty: it does.
std::string AdaptiveAa::obstacle(gpu::Device& device, const Fit& fit) const {
    const glm::uvec2 samples = params_.m * fit.tile;
    if (samples.x > max_extent_ || samples.y > max_extent_) {
        return fmt::format("{} x {} samples exceed the {} a side of this device", samples.x,
            samples.y, max_extent_);
    }
    const std::uint64_t budget = device.allocator().budget_bytes();
    const std::uint64_t used = device.allocator().bytes_used();
    const std::uint64_t free = budget > used ? budget - used : 0;
    Declared declared = declare(fit);
    const Plan plan = make_plan(device, declared.graph);
    const char* layout = fit.layout == GbufferLayout::packed ? "packed" : "visibility";
    if (budget > 0 && plan.bytes_peak > free) {
        return fmt::format("--gbuffer {}: {} x {} samples need {:.1f} MiB, of the memory budget "
                           "{:.1f} MiB are free",
            layout, samples.x, samples.y, mib(plan.bytes_peak), mib(free));
    }
    const std::uint64_t most = device.limits().allocation_bytes;
    for (const Heap& heap : plan.heaps) {
        if (heap.bytes > most) {
            return fmt::format("--gbuffer {}: {} x {} samples need {:.1f} MiB in one piece, this "
                               "device gives {:.1f}",
                layout, samples.x, samples.y, mib(heap.bytes), mib(most));
        }
    }
    return "";
}

/// What is said where memory is asked for: who holds it, and what the graph needs.
std::string AdaptiveAa::refusal(gpu::Device& device, const std::optional<Fit>& fit) const {
    if (!fit) return "";
    const glm::uvec2 samples = params_.m * fit->tile;
    if (samples.x > max_extent_ || samples.y > max_extent_) return "";
    try {
        const Executor executor(device, declare(*fit).graph);
        return "";
    } catch (const Error& error) {
        return fmt::format("; {} x {}: {}", fit->tile.x, fit->tile.y, error.what());
    }
}

void AdaptiveAa::set_camera(const Camera& camera) {
    const glm::uvec2 all =
        params_.part_of.x > 0 ? params_.part_of : glm::uvec2(params_.width, params_.height);
    whole_ = make_frame(lit_->scene(), lit_->gpu().bounds(), camera, static_cast<int>(all.x),
        static_cast<int>(all.y), static_cast<int>(params_.m), params_.order,
        LitScene::kShadowMapSize);
    aim(tiles_.front());
}

void AdaptiveAa::set_origin(glm::uvec2 origin) {
    check(params_.part_of.x >= origin.x + params_.width &&
              params_.part_of.y >= origin.y + params_.height,
        "a part lies inside its picture");
    origin_ = origin;
}

void AdaptiveAa::aim(const TilePlacement& tile) {
    shader::FrameData frame = whole_;
    if (params_.method == AaMethod::taa) set_jitter(frame, taa_jitter(executed_));
    if (view_) {
        frame.size = fit_.tile;
        frame.origin = origin_ + tile.origin;
        *view_ = {frame.origin, frame.picture};
        // Viewports have limits too. Past them, the tile alone is projected; no driver can render
        // such a picture whole, so that nothing need equal it.
        if (std::max(frame.picture.x, frame.picture.y) * params_.m > max_extent_) {
            const glm::vec2 picture(frame.picture), size(frame.size), origin(frame.origin);
            glm::mat4 window(1.0f);
            for (int axis = 0; axis < 2; ++axis) {
                window[axis][axis] = picture[axis] / size[axis];
                window[3][axis] = (picture[axis] - 2.0f * origin[axis] - size[axis]) / size[axis];
            }
            frame.view_projection = window * frame.view_projection;
            *view_ = {{}, frame.size};
        }
    }
    std::memcpy(frame_->mapped().data(), &frame, sizeof(frame));
}

void AdaptiveAa::execute() {
    if (!view_) {
        aim(tiles_.front());
        executor_->execute();
        ++executed_;
        if (frame_before_) std::memcpy(frame_before_->mapped().data(), &whole_, sizeof(whole_));
        return;
    }
    times_.clear();
    for (const TilePlacement& tile : tiles_) {
        aim(tile);
        executor_->execute();
        const std::vector<PassTime>& times = executor_->times();
        if (times_.empty()) {
            times_ = times;
        } else {
            for (std::size_t i = 0; i < times.size(); ++i)
                times_[i].milliseconds += times[i].milliseconds;
        }
        for (const ImageHandle image : kept_) {
            paste_tile(pictures_[image.resource], executor_->read(image), tile,
                {params_.width, params_.height}, 1);
        }
    }
}

Image AdaptiveAa::read(ImageHandle image) {
    if (!view_) return executor_->read(image);
    const auto found = pictures_.find(image.resource);
    check(found != pictures_.end(), "only outputs are put together of tiles");
    return found->second;
}

AdaptiveAa::SampleCounts AdaptiveAa::sample_counts(std::uint32_t lanes) {
    const std::uint32_t n = params_.m * params_.m;
    const std::uint64_t pixels = std::uint64_t{params_.width} * params_.height;
    SampleCounts counts;
    counts.histogram.assign(n, 0);
    if (!needs_counts(params_)) {
        const bool counted =
            params_.method == AaMethod::uniform || params_.method == AaMethod::ssaa;
        const std::uint32_t k = counted ? params_.k : 1;
        counts.histogram[k - 1] = pixels;
        counts.mean = k;
        counts.percent = counts.shaded_percent = 100.0 * k / n;
        return counts;
    }
    check(bool(outputs_.sample_count) && (params_.export_counts || params_.aov),
        "counts were not exported");
    const Image map = read(outputs_.sample_count);
    const std::span<const float> k = map.plane(0);
    std::uint64_t sum = 0;
    for (const float value : k) {
        const auto count = static_cast<std::uint32_t>(value);
        check(count >= 1 && count <= n, "a pixel has 1 to n samples");
        ++counts.histogram[count - 1];
        sum += count;
    }
    const double all = static_cast<double>(pixels) * n;
    counts.percent = 100.0 * static_cast<double>(sum) / all;
    counts.mean = static_cast<double>(sum) / static_cast<double>(pixels);
    counts.lane_efficiency =
        ockham::lane_efficiency(k, params_.width, params_.height, params_.dispatch, lanes);
    counts.shaded_percent =
        counts.percent + 100.0 * static_cast<double>(counts.histogram[n - 1]) / all;
    return counts;
}

} // namespace ockham
