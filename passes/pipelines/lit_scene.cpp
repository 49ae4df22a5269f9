// SPDX-License-Identifier: Apache-2.0
#include "passes/pipelines/lit_scene.hpp"

#include "passes/surface/frame.hpp"
#include "passes/surface/shadow_map.hpp"

#include <cstring>

namespace ockham {

LitScene::LitScene(gpu::Device& device, Scene scene)
    : scene_(std::move(scene)), gpu_(device, scene_) {
    if (!gpu_.facts().sun_shadow) return;
    const VkFormat format = VK_FORMAT_D32_SFLOAT;
    shadow_map_.emplace(device,
        gpu::ImageInfo{.format = format,
            .width = kShadowMapSize,
            .height = kShadowMapSize,
            .usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT,
            .name = "shadow_map"});

    const shader::FrameData frame = make_frame(
        scene_, gpu_.bounds(), default_camera(gpu_.bounds()), 1, 1, 1, {0}, kShadowMapSize);
    gpu::Buffer frame_buffer(device, gpu::BufferInfo{.bytes = sizeof(frame),
                                         .usage = VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT,
                                         .name = "frame",
                                         .memory = gpu::MemoryUse::upload});
    std::memcpy(frame_buffer.mapped().data(), &frame, sizeof(frame));

    Graph graph("shadow");
    SceneInputs in{.scene = &gpu_, .handles = gpu_.import(graph), .frame = {}};
    in.frame = graph.import_buffer("frame", {sizeof(frame)}, {});
    const ImageHandle map = graph.import_image("shadow_map",
        {.format = format, .width = kShadowMapSize, .height = kShadowMapSize}, {},
        state_of(Access::sampled, Stage::compute));
    add_shadow_map(graph, in, map);
    Executor executor(device, std::move(graph));
    gpu_.bind(executor, in.handles);
    executor.bind(in.frame, frame_buffer);
    executor.bind(map, *shadow_map_);
    executor.execute();
    times_ = executor.times();
}

} // namespace ockham
