// SPDX-License-Identifier: Apache-2.0
#include "passes/pipelines/mesh_background.hpp"

#include "framework/core/error.hpp"
#include "framework/gpu/device.hpp"
#include "framework/gpu/transfer.hpp"
#include "framework/scene/mesh_tree.hpp"
#include "passes/surface/frame.hpp"
#include "passes/volume/meshes.hpp"

#include <algorithm>
#include <cstring>

namespace ockham {
namespace {

/// Those that add up samples: the medium changes their mean.
AdaptiveAaParams checked(const AdaptiveAaParams& params) {
    AdaptiveAaParams p = settled(params);
    if (filters_picture(p.method) || p.method == AaMethod::sraa || p.method == AaMethod::msaa) {
        fail_input("--method: with a medium, pictures are means of samples; use none, uniform, "
                   "cluster, ssaa or adaptive");
    }
    if (needs_counts(p) && p.resolve != Resolve::stratified)
        fail_input("--resolve prefix: with a medium, samples are shared out among surfaces; use "
                   "stratified");
    if (needs_counts(p) && p.dispatch != Dispatch::buckets && p.dispatch != Dispatch::sort)
        fail_input("--dispatch: with a medium, pixels come in lists; use buckets or sort");
    if (p.gbuffer == GbufferLayout::visibility || p.tile.x > 0)
        fail_input("--gbuffer, --tile: with a medium, samples are packed and the picture is whole; "
                   "make it smaller, or --m");
    if (p.bloom > 0)
        fail_input("--bloom: with a medium, meshes are not the whole picture; leave it out");
    p.gbuffer = GbufferLayout::packed;
    p.history = false; // views are rendered once, and not one after the other
    return p;
}

} // namespace

MeshBackground::MeshBackground(
    gpu::Device& device, const LitScene& lit, const AdaptiveAaParams& params)
    : device_(device), lit_(lit), params_(checked(params)),
      max_extent_(device.limits().attachment_extent),
      frame_buffer_(device, gpu::BufferInfo{.bytes = sizeof(shader::FrameData),
                                .usage = VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT,
                                .name = "mesh_frame",
                                .memory = gpu::MemoryUse::upload}) {}

void MeshBackground::show(
    const Camera& camera, glm::uvec2 size, glm::uvec2 origin, const Bounds& isosurfaces) {
    params_.width = size.x;
    params_.height = size.y;
    const glm::ivec2 picture(params_.part_of.x > 0 ? params_.part_of : size);
    const glm::uvec2 samples = params_.m * glm::uvec2(picture);
    if (params_.part_of.x > 0 && std::max(samples.x, samples.y) > max_extent_)
        fail_input(
            "part of {} x {} pixels: meshes in a medium are drawn in viewports of at most {} "
            "samples per side; found {} x {}",
            picture.x, picture.y, max_extent_, samples.x, samples.y);
    shown_ = make_frame(lit_.scene(), lit_.gpu().bounds(), camera, picture.x, picture.y,
        static_cast<int>(params_.m), params_.order, LitScene::kShadowMapSize, isosurfaces);
    shown_.size = size;
    shown_.origin = origin;
    view_ = {origin, picture};
    std::memcpy(frame_buffer_.mapped().data(), &shown_, sizeof(shown_));
}

void MeshBackground::describe(shader::VolumeFrame& frame) const {
    frame.sun_projection = shown_.sun_projection;
    frame.window = shown_.m;
    std::copy(std::begin(shown_.order), std::end(shown_.order), std::begin(frame.sample_order));
}

BufferHandle MeshBackground::import_tree(Graph& graph, bool scatters) {
    if (!scatters) {
        graph.omit_resource("mesh_tree", "the medium scatters nothing");
        return {};
    }
    if (!tree_buffer_) {
        const MeshTree tree = build_mesh_tree(lit_.scene());
        const std::uint64_t limit = device_.limits().storage_bytes;
        if (tree.bytes() > limit) {
            fail_device(
                "meshes: the tree of {} triangles for what the medium scatters takes {} MiB, "
                "but the device binds {} MiB at a time; use fewer triangles, or --albedo 0",
                tree.triangles.size(), tree.bytes() >> 20, limit >> 20);
        }
        if (tree.nodes.empty()) return {};
        tree_buffer_.emplace(device_,
            gpu::BufferInfo{.bytes = tree.bytes(),
                .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                .name = "mesh_tree"});
        gpu::Uploader uploader(device_);
        const auto nodes = std::as_bytes(std::span(tree.nodes));
        uploader.add(*tree_buffer_, nodes);
        uploader.add(*tree_buffer_, std::as_bytes(std::span(tree.triangles)), nodes.size());
        uploader.finish();
    }
    return graph.import_buffer("mesh_tree", {tree_buffer_->bytes()}, {});
}

MeshInputs MeshBackground::declare(
    Graph& graph, const MediumInputs& medium, Use use, Condition new_view) {
    scene_ = lit_.gpu().import(graph);
    frame_ = graph.import_buffer("mesh_frame", {sizeof(shader::FrameData)}, {});
    tree_ = import_tree(graph, use.scatters);
    sun_map_ = {};
    if (const gpu::Image* map = lit_.shadow_map()) {
        sun_map_ = graph.import_image("shadow_map",
            {.format = map->info().format,
                .width = map->info().width,
                .height = map->info().height},
            state_of(Access::sampled, Stage::compute));
    }
    const ShadingInputs in{.scene = {.scene = &lit_.gpu(), .handles = scene_, .frame = frame_},
        .gbuffer = {},
        .shadow_map = sun_map_,
        .medium = medium};
    const GuardScope guard = graph.when(new_view);
    AdaptiveAaParams part = params_;
    part.view = params_.part_of.x > 0 ? &view_ : nullptr;
    part.export_counts = false; // what only this view writes cannot be exported, only kept
    const AdaptiveAaOutputs out = add_adaptive_aa(graph, in, part, max_extent_);
    sample_count_ = {};
    if (params_.export_counts && out.sample_count) {
        sample_count_ = add_kept(graph, out.sample_count, "sample_counts");
        graph.export_resource(sample_count_, "statistics of the sample counts");
    }
    ShadingInputs shaded = in;
    shaded.gbuffer = out.gbuffer;
    MeshInputs meshes;
    meshes.picture = add_kept(graph, out.radiance, "meshes");
    if (!use.rays) return meshes;
    const ShadingParams shading{.width = params_.width,
        .height = params_.height,
        .m = params_.m,
        .anisotropy = params_.anisotropy};
    const SceneFacts& facts = lit_.gpu().facts();
    const bool lamps = use.scatters && facts.point_lights + facts.spot_lights > 0;
    meshes = {.ends = add_mesh_ends(graph, frame_, out.gbuffer, out.labels, shading),
        .radiance = {},
        .picture = meshes.picture,
        .sun_map = sun_map_,
        .tree = tree_,
        .lamps = lamps ? scene_.lights : BufferHandle{},
        .first_lamp = facts.directional_lights,
        .points = lamps ? facts.point_lights : 0,
        .spots = lamps ? facts.spot_lights : 0};
    meshes.radiance = out.labels
                          ? add_mesh_radiance(graph, shaded, out.labels, out.radiance, shading)
                          : add_kept(graph, out.radiance, "mesh_radiance");
    return meshes;
}

void MeshBackground::bind(Executor& executor) const {
    lit_.gpu().bind(executor, scene_);
    executor.bind(frame_, frame_buffer_);
    if (tree_) executor.bind(tree_, *tree_buffer_);
    if (sun_map_) executor.bind(sun_map_, *lit_.shadow_map());
}

} // namespace ockham
